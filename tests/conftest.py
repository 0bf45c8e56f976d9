"""What all tests share: where the measured data are, and what a skipped test means.

The data root is the folder named by the environment variable ``DAMPYR_DATA``, else ``../shared/data``
beside the repository. Where it is absent, tests that read it are skipped, and the summary says so loudly.
With ``CI`` set, a skip for any other reason fails the run: a proof that silently did not run is no proof.
"""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.endurance import Endurance, write_page

settings.register_profile("dampyr", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("dampyr")

DATA_ABSENT = "data absent"
CASES_ABSENT = "cases absent"
_REPOSITORY = Path(__file__).resolve().parents[1]
_skips: list[tuple[str, str]] = []
_failed: list[str] = []


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--endure",
        action="store_true",
        help="long campaigns in full length and the bench in real time, on a machine with nothing else to do; "
        "writes docs/reference/endurance.md",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Workers do not know ``--endure`` when they are started: they would do a part, and the page would call it the whole."""
    if config.getoption("--endure") and (
        getattr(config.option, "numprocesses", None) or hasattr(config, "workerinput")
    ):
        raise pytest.UsageError("--endure runs in one process; leave out -n")


@pytest.fixture
def terminal_signals() -> Iterator[None]:
    """SIGINT and SIGHUP as a command in a terminal has them: a run behind nohup, or in the background, ignores them."""
    usual = {"SIGINT": signal.default_int_handler, "SIGHUP": signal.SIG_DFL}
    before = {
        getattr(signal, name): signal.signal(getattr(signal, name), handler)
        for name, handler in usual.items()
        if hasattr(signal, name)
    }
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def endurance(request: pytest.FixtureRequest) -> Endurance:
    """The length of a long campaign."""
    return Endurance(request.node.nodeid)


def data_folder() -> Path:
    """Where measured data are looked for; it need not exist."""
    return Path(os.environ.get("DAMPYR_DATA") or _REPOSITORY.parent / "shared" / "data").resolve()


def _present(folder: Path) -> Path:
    if not folder.is_dir():
        pytest.skip(f"{DATA_ABSENT}: no folder {folder}; set DAMPYR_DATA to the folder that holds the data")
    return folder


@pytest.fixture(scope="session")
def data_root() -> Path:
    """The folder of all measured data, or a skip."""
    return _present(data_folder())


@pytest.fixture(scope="session")
def campaign_folder(data_root: Path) -> Path:
    """The folder of the published campaign: one .mat file per test and campaign.csv, or a skip."""
    return _present(data_root / "labcontrol-mr-damper")


@pytest.fixture(scope="session")
def ground_motion_folder(data_root: Path) -> Path:
    """The folder of the earthquake records, or a skip."""
    return _present(data_root / "ground-motions")


@pytest.fixture(scope="session")
def first_day_cases(data_root: Path) -> Path:
    """The folder of small files as people bring them on the first day, with their values, or a skip: tests of the same
    layouts with files of their own run in any case."""
    folder = data_root.parent / "findings" / "cases"
    if not folder.is_dir():
        pytest.skip(f"{CASES_ABSENT}: no folder {folder}")
    return folder


@pytest.fixture
def no_trials(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fit that misses much looks for nothing that is missing, in tests of other things: it compiles a dozen models."""
    monkeypatch.setattr("dampyr.identification.fits.fit.list_missing_effects", lambda *_: ())


def _note_skip(report: pytest.TestReport | pytest.CollectReport) -> None:
    if report.skipped and not hasattr(report, "wasxfail"):
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
        _skips.append((report.nodeid, reason.removeprefix("Skipped: ")))


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    _note_skip(report)
    if report.failed:
        _failed.append(report.nodeid)


def pytest_collectreport(report: pytest.CollectReport) -> None:
    _note_skip(report)


def _for_lack_of_data() -> list[str]:
    return [test for test, reason in _skips if reason.startswith(DATA_ABSENT)]


def _unexpected() -> list[tuple[str, str]]:
    """Skips that a CI run does not accept: only data that really are absent excuse a test."""
    excused = set() if data_folder().is_dir() else set(_for_lack_of_data())
    return [(test, reason) for test, reason in _skips if test not in excused and not reason.startswith(CASES_ABSENT)]


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    on_a_worker = hasattr(session.config, "workerinput")
    if session.config.getoption("--endure") and session.exitstatus in (
        pytest.ExitCode.OK,
        pytest.ExitCode.TESTS_FAILED,
    ):
        write_page(_failed)
    if os.environ.get("CI") and not on_a_worker and _unexpected():
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    say = terminalreporter
    if absent := _for_lack_of_data():
        say.section("DATA ABSENT", sep="!", red=True, bold=True)
        say.line(f"{len(absent)} tests did not run: the measured data are not in {data_folder()}")
        say.line("set DAMPYR_DATA to the folder that holds labcontrol-mr-damper/ and ground-motions/")
    if os.environ.get("CI") and (unexpected := _unexpected()):
        say.section("UNEXPECTED SKIPS FAIL A CI RUN", sep="!", red=True, bold=True)
        for test, reason in unexpected:
            say.line(f"{test}: {reason}")
