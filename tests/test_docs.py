"""What the pages say is so: links lead somewhere, code runs and prints what it says, tables agree with the source."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
import tomllib
import warnings
from collections.abc import Iterator
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import click
import numpy as np
import pytest

from dampyr import registry
from dampyr.cli import cli
from dampyr.errors import DampyrWarning
from dampyr.models import Constant, Damper, Polynomial, available_parts, part
from dampyr.records.column_table import WORDS
from dampyr.records.record import CHANNELS
from dampyr.structures import available_control_laws, control_law

Array = np.ndarray
ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted(DOCS.rglob("*.md"))]
HOW_TO = [
    DOCS / "how-to" / f"{name}.md"
    for name in (
        "read-your-own-files",
        "another-laboratory",
        "ground-motions",
        "your-own-structure",
        "ensembles",
        "campaigns",
        "control",
        "rig",
        "acceptance",
        "python",
        "hybrid-benchmark",
        "hybrid-test",
        "export",
        "opensees",
        "plan-tests",
    )
]
RUN = [ROOT / "README.md", *sorted((DOCS / "tutorials").glob("*.md")), *HOW_TO]
# Pages whose code compiles or runs for long: proofs.
LONG = (
    "README", "first-damper", "your-own-structure", "ensembles", "control", "rig", "another-laboratory", "ground-motions",
    "campaigns", "acceptance", "read-your-own-files", "plan-tests",
)  # fmt: skip
FENCE = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(page: Path, language: str) -> list[str]:
    """The fenced blocks of a page in one language."""
    return [text for info, text in FENCE.findall(page.read_text(encoding="utf-8")) if info.split(" ")[0] == language]


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_somewhere(page: Path) -> None:
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    links = [link for link in re.findall(r"\]\(([^)\s]+)\)", text) if "://" not in link]
    missing = [link for link in links if not (page.parent / link.partition("#")[0]).exists()]
    assert not missing


def test_every_page_is_reached_from_the_readme() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    pages = [page for page in DOCS.rglob("*.md") if page.parent.name != "decisions"]
    assert not [name(page) for page in pages if name(page) not in readme]


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_lines_are_short_enough_to_read(page: Path) -> None:
    prose = [line for line in page.read_text(encoding="utf-8").splitlines() if line[:1] not in ("|", "$")]
    assert max(map(len, prose)) <= 145


class Desk:
    """A folder in which a reader follows a page: its commands, its Python, and what it says these print."""

    def __init__(self, folder: Path, data: Path | None) -> None:
        self.folder, self.data = folder, data
        self.names: dict[str, object] = {}

    def run(self, command: str) -> None:
        """One line of a shell, as a user types it; a data set is fetched from this machine."""
        words = shlex.split(command)
        assert words[0] == "dampyr", command
        if words[1:3] == ["datasets", "fetch"]:
            words += ["--from", str(self.data)]
        done = subprocess.run(
            [sys.executable, "-m", *words], cwd=self.folder, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"{command}\n{done.stderr}"

    def execute(self, text: str) -> None:
        """One block of Python; each ``print(...)  # so`` must print so."""
        expected = re.findall(r"^print\(.*\)\s+# (.*)$", text, re.MULTILINE)
        out = StringIO()
        with redirect_stdout(out), warnings.catch_warnings():
            warnings.simplefilter("ignore", DampyrWarning)
            exec(compile(text, "page", "exec"), self.names)
        assert out.getvalue().splitlines() == expected


def write_own_file(folder: Path, text: str) -> None:
    """The file that "read your own files" shows, with enough of it to identify a damper from."""
    header, first = text.splitlines()[:2]
    t = np.arange(0.0, 6.0, 0.002)
    x, v = 8.0 * np.sin(6.0 * t), 48.0 * np.cos(6.0 * t)
    w = Damper("dahl", {"dahl.kx": 0.0, "dahl.kw": 1.0, "dahl.rho": 20e3}).force(t, 1e-3 * x, voltage=0.0)
    rows = np.column_stack([t, x, v, 0.1 + 0.2 * w + 1e-3 * v, np.full(t.size, 0.45)])
    lines = [";".join(f"{value:.5f}".replace(".", ",") for value in row) for row in rows]
    assert first.count(";") == lines[0].count(";")
    (folder / "test.csv").write_text("\n".join([header, *lines]), encoding="utf-8")


def write_laboratory(folder: Path, text: str) -> None:
    """The files that "another laboratory" shows: twelve sines at four currents, and a motion like an earthquake's."""
    [header, first, *_] = text.splitlines()
    folder.mkdir()
    rng = np.random.default_rng(7)
    t = np.arange(0.0, 6.0, 0.002)
    for current in (0.0, 0.5, 1.0, 1.5):
        for amplitude, frequency in ((5.0, 1.0), (10.0, 0.5), (10.0, 1.0)):
            x = amplitude * np.sin(2.0 * np.pi * frequency * t)
            name = f"sine_{amplitude:g}mm_{frequency:g}Hz_{current:g}A.txt"
            write_test(folder / name, header, t, x, current, rng)
    t = np.arange(0.0, 12.0, 0.002)
    frequencies = np.linspace(0.2, 4.0, 40)
    waves = np.sin(2.0 * np.pi * np.outer(t, frequencies) + rng.uniform(0.0, 2.0 * np.pi, 40)) / frequencies
    x = waves.sum(axis=1) * np.minimum(1.0, t / 2.0) * np.exp(-np.maximum(0.0, t - 6.0) / 3.0)
    write_test(folder / "earthquake_1A.txt", header, t, 9.0 * x / np.abs(x).max(), 1.0, rng)
    assert first.count("\t") == header.count("\t")


def write_test(path: Path, header: str, t: Array, x: Array, current: float, rng: np.random.Generator) -> None:
    """One test of that laboratory, mm and N, with noise on the force and on the current."""
    over = (0.0, 1.5)
    laws = {"kx": (900.0, 700.0), "kw": (60.0, 420.0), "rho": (4000.0, -1200.0)}
    dahl = Damper("dahl", {f"dahl.{key}": Polynomial(c, *over) for key, c in laws.items()}, input="A")
    v = np.gradient(x, t)
    force = dahl.force(t, 1e-3 * x, velocity=1e-3 * v, current=current)
    force = force + (20.0 + 150.0 * current) * np.tanh(v / 10.0) + 35.0 + rng.normal(0.0, 2.0, t.size)
    measured = current + rng.normal(0.0, 0.004, t.size)
    rows = zip(t, x, v, force, measured, strict=True)
    lines = [f"{a:.3f}\t{b:.4f}\t{c:.3f}\t{d:.2f}\t{e:.3f}" for a, b, c, d, e in rows]
    path.write_text("\n".join([header, *lines]), encoding="utf-8")


def steps(page: Path) -> Iterator[tuple[str, str]]:
    """The blocks of a page that a reader runs, in order."""
    for info, text in FENCE.findall(page.read_text(encoding="utf-8")):
        if info in ("sh", "python", "text", "toml"):
            yield info, text


@pytest.mark.parametrize(
    "page", [pytest.param(page, marks=[pytest.mark.prove] * (page.stem in LONG)) for page in RUN], ids=name
)
def test_what_a_page_has_its_reader_do_works(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    text = page.read_text(encoding="utf-8")
    needs_data = "datasets fetch" in text or "locate(" in text
    desk = Desk(tmp_path, request.getfixturevalue("campaign_folder") if needs_data else None)
    (tmp_path / "examples").symlink_to(ROOT / "examples")  # a reader of the README has them
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("DAMPYR_DATA", "data")
    done = 0
    for kind, block in steps(page):
        if kind == "text" and "Stroke LVDT" in block:
            write_own_file(tmp_path, block)
        elif kind == "text" and "Displacement" in block:
            write_laboratory(tmp_path / "tests", block)
        elif kind == "toml" and (named := re.match(r"# (\S+\.toml)\n", block)):
            (tmp_path / named[1]).write_text(block, encoding="utf-8")
        elif kind == "toml":
            (tmp_path / "tests" / "reading.toml").write_text(block, encoding="utf-8")
        elif kind == "python":
            desk.execute(block)
            done += 1
        elif kind == "sh":
            for command in block.strip().splitlines():
                desk.run(command)
                done += 1
    assert done >= 2


def test_python_in_the_readme_that_needs_no_data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Desk(tmp_path, None).execute(blocks(ROOT / "README.md", "python")[0])


def readme_table(heading: str) -> list[list[str]]:
    """The rows of the README's table whose header starts with this text."""
    lines = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith(heading))
    rows = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            return rows
        rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return rows


def test_the_readme_tells_the_fits_as_they_are(campaign_folder: Path) -> None:
    from dampyr.identification import fit
    from dampyr.records import read_campaign

    scores: dict[str, list[float]] = {}
    for record in read_campaign(campaign_folder):
        scores.setdefault(f"{record.voltage:g} V", []).append(fit("dahl", record).scores[record.name].l1)
    computed = [[volts, str(len(l1)), f"{100 * np.mean(l1):.1f} %"] for volts, l1 in scores.items()]
    assert computed == readme_table("| coil |")


def test_the_readme_tells_the_building_as_it_is() -> None:
    from dampyr.ground_motions import el_centro
    from dampyr.structures import respond, two_storey
    from dampyr.studies import raminelli_2020

    damper = raminelli_2020.damper()
    for case, *cells in readme_table("| case |"):
        dampers = {} if case == "no damper" else {1: damper}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DampyrWarning)
            response = respond(two_storey(), el_centro(), dampers, voltage=float(case.split()[0]) if dampers else None)
        peaks = [float(cell.removesuffix(" mm")) for cell in cells]
        np.testing.assert_allclose(1e3 * response.peak_displacement, peaks, atol=1e-3)


def test_the_readme_names_every_member() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    packages = ("models.parts", "campaigns.steps", "structures.control", "export.kinds", "studies")
    members = [name for package in packages for name in registry.names(f"dampyr.{package}")]
    assert not [each for each in (*members, *cli.list_commands(click.Context(cli))) if f"`{each}`" not in readme]


def test_the_card_of_the_reference_loads(tmp_path: Path) -> None:
    [text] = blocks(DOCS / "reference" / "card.md", "toml")
    path = tmp_path / "damper.toml"
    path.write_text(text, encoding="utf-8")
    damper = Damper.load(path)
    assert damper.range == (0.0, 3.0)
    assert damper.bandwidth == 15.0
    assert damper.values(1.0)[1] == pytest.approx(230.0)
    assert damper.covariance is not None
    assert damper.covariance.shape == (10, 10)
    assert tomllib.loads(damper.save(path).read_text(encoding="utf-8")) == tomllib.loads(text)


def commands() -> Iterator[tuple[str, click.Command]]:
    context = click.Context(cli)
    for each in cli.list_commands(context):
        command = cli.get_command(context, each)
        assert command is not None
        yield each, command
        for inner, sub in getattr(command, "commands", {}).items():
            yield f"{each} {inner}", sub


@pytest.mark.parametrize(("command", "what"), list(commands()), ids=[each for each, _ in commands()])
def test_the_reference_names_every_option(command: str, what: click.Command) -> None:
    text = (DOCS / "reference" / "commands.md").read_text(encoding="utf-8")
    sections = re.split(r"^## ", text, flags=re.MULTILINE)
    own = [section for section in sections if f"`dampyr {command}" in section.partition("\n")[0]]
    assert own, f"no section on dampyr {command}"
    options = [o for p in what.params if isinstance(p, click.Option) for o in p.opts if o.startswith("--")]
    missing = [o for o in options if o not in own[0] and o not in ("--json", "--help")]
    assert not missing


def test_the_reference_names_no_option_that_is_not_there() -> None:
    text = (DOCS / "reference" / "commands.md").read_text(encoding="utf-8")
    options = {o for _, c in commands() for p in c.params if isinstance(p, click.Option) for o in p.opts}
    assert set(re.findall(r"--[a-z-]+[a-z]", text)) - options == {"--help", "--version"}


def test_the_reference_of_the_models_is_what_the_parts_say() -> None:
    page = (DOCS / "reference" / "models.md").read_text(encoding="utf-8")
    for each in available_parts():
        section = re.split(rf"^## `{each}`$", page, flags=re.MULTILINE)[1].partition("\n## ")[0]
        assert "$$" in section, f"{each} shows no equation"
        assert not re.search(r":math:|\.\. math|``", section)
        for key, quantity in part(each).parameters.items():
            assert f"| `{key}` | {quantity.unit or '1'} | {quantity.range_in_words()} |" in section


def test_the_generated_lists_and_pages_are_up_to_date() -> None:
    command = [sys.executable, str(ROOT / "tools" / "make_docs.py"), "--check"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr + "run make docs"


@pytest.mark.parametrize("page", ["campaign-file", "control-laws", "formats", "studies"])
def test_the_generated_lists_are_markdown(page: str) -> None:
    assert not re.search(r":math:|\.\. math|``(?!`)", (DOCS / "reference" / f"{page}.md").read_text(encoding="utf-8"))


def test_the_refusal_of_the_how_to_is_what_is_said(tmp_path: Path) -> None:
    from dampyr.campaigns import planned

    page = DOCS / "how-to" / "campaigns.md"
    [text] = blocks(page, "text")
    (tmp_path / "too_fast.toml").write_text(blocks(page, "toml")[1], encoding="utf-8")
    [refusal] = planned(tmp_path / "too_fast.toml").refusals
    assert " ".join(text.split()) == f"dampyr: {refusal}"


def test_the_reference_names_every_control_law_and_its_settings() -> None:
    text = (DOCS / "reference" / "control-laws.md").read_text(encoding="utf-8")
    rows = {line.split("`")[1]: line for line in text.splitlines() if line.startswith("| `")}
    for law in available_control_laws():
        settings = vars(control_law(law, high=1.0)).keys() - {"low", "high", "period", "lag"}
        assert all(f"`{name}`" in rows[law] for name in settings), law


def test_the_reference_names_every_channel_of_a_file() -> None:
    record_file = (DOCS / "reference" / "record-file.md").read_text(encoding="utf-8")
    columns = (DOCS / "reference" / "csv.md").read_text(encoding="utf-8")
    assert not [channel for channel in CHANNELS if f"/calibrated/{channel}`" not in record_file]
    for channel, words in WORDS.items():
        assert f"| {channel} | {', '.join(f'`{word}`' for word in words)} | {CHANNELS[channel]} |" in columns


def test_the_reference_of_the_record_file_is_what_is_written(tmp_path: Path) -> None:
    import h5py

    from dampyr.records import Label, Record, write

    t = np.linspace(0.0, 1.0, 50)
    label = Label(0.01, 1.0, "4.2", 3)
    record = Record(
        t, t, t, velocity=t, voltage=1.0, temperature=t, label=label, provenance={"by": "hand"}, history=("a",)
    )
    path = write(record, tmp_path / "test.h5")
    text = (DOCS / "reference" / "record-file.md").read_text(encoding="utf-8")
    paths: list[str] = []
    with h5py.File(path) as file:
        file.visit(paths.append)
        attributes = [*file.attrs, *file["label"].attrs]
    assert not [each for each in paths if f"/{each}" not in text]
    assert not [each for each in attributes if f"`{each}`" not in text]
    for place in re.findall(r'h5read\("test.h5", "([^"]+)"\)', text):
        assert place[1:] in paths


def test_the_model_of_the_how_to_is_a_model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from dampyr.identification import fit
    from dampyr.models import parts
    from dampyr.records import Record

    [text] = blocks(DOCS / "how-to" / "add-a-model.md", "python")
    (tmp_path / "bent_dashpot.py").write_text(text, encoding="utf-8")
    monkeypatch.setattr(parts, "__path__", [*parts.__path__, str(tmp_path)])
    assert "bent_dashpot" in available_parts()
    t = np.linspace(0.0, 6.0, 1200)
    x, v = 0.01 * np.sin(6.0 * t), 0.06 * np.cos(6.0 * t)
    force = 20.0 + 3000.0 * v / (1 + np.abs(v) / 0.04)
    fit_result = fit("bent_dashpot", Record(t, x, force, velocity=v, voltage=0.0))
    np.testing.assert_allclose(list(fit_result.parameters.values()), [3000.0, 0.04], rtol=1e-5)
    sys.modules.pop("dampyr.models.parts.bent_dashpot")


def test_the_c_of_the_how_to_compiles_and_runs(tmp_path: Path) -> None:
    import shutil

    from dampyr.export import export

    if shutil.which("gcc") is None:
        pytest.skip("gcc is missing: the C of the how-to cannot be compiled")
    page = DOCS / "how-to" / "export.md"
    numbers = {"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": 20e3}
    damper = Damper("dahl", {each: Constant(value, 0.0, 3.0) for each, value in numbers.items()})
    export(damper, "c", tmp_path)
    [program] = blocks(page, "c")
    (tmp_path / "main.c").write_text(program, encoding="utf-8")
    [line] = [text for text in blocks(page, "text") if text.startswith("cc ")]
    subprocess.run(["gcc", *shlex.split(line)[1:]], cwd=tmp_path, check=True)
    out = subprocess.run([str(tmp_path / "a.out")], capture_output=True, text=True, check=True).stdout
    t = np.linspace(0.0, 1.0, 1001)
    expected = 800.0 * 0.005 + 50.0 * (1 - np.exp(-20e3 * 0.005))
    assert float(out) == pytest.approx(expected, rel=1e-9)
    assert damper.force(t, 0.005 * t, voltage=1.0)[-1] == pytest.approx(expected, rel=1e-9)


def test_every_bench_is_found_and_has_its_two_names(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT))
    benches = dict(registry.members("benchmarks"))
    assert len(benches) >= 5
    assert all(isinstance(bench.TITLE, str) and callable(bench.run) for bench in benches.values())
    assert "datasets fetch" in benches["campaign_fit"].run(None)


def test_the_faults_of_the_simulated_rig_are_all_listed() -> None:
    from dampyr.rig.simulation.faults import KINDS

    page = (DOCS / "reference" / "simulated-rig.md").read_text(encoding="utf-8").partition("## What may go wrong")[2]
    assert re.findall(r"^\| `([\w-]+)` \|", page, re.MULTILINE) == list(KINDS)
    for name, fault in KINDS.items():
        assert f"| `{name}` | {fault.words} |" in page
