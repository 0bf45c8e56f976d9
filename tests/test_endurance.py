"""The page of `make endure`: each test's row is that of its last run."""

import subprocess
import sys

import pytest

from tests import endurance


def test_a_run_replaces_the_rows_of_its_own_tests(tmp_path, monkeypatch) -> None:
    here, gone = "tests/test_endurance.py::test_a", "tests/test_no_more.py::test_b"
    monkeypatch.setattr(endurance, "PAGE", tmp_path / "endurance.md")
    for made, failed in (
        ([("kills", "7", "40 kills", here), ("more", "", "9", gone)], []),
        ([("faults", "", "3 faults", f"{here}[1]")], []),
        ([("kills", "7", "400 kills", here)], [f"{here}[2]"]),
    ):
        monkeypatch.setattr(endurance, "_endured", made)
        endurance.write_page(failed)
    rows = [line.split(" | ")[:4] for line in endurance.PAGE.read_text("utf-8").splitlines() if line.startswith("| ")]
    assert rows[1:] == [
        ["| kills", "7", "400 kills", f"`{here}`"],
        ["| faults", "", "3 faults", f"`{here}[1]`"],
        ["| ", "", "**failed**", f"`{here}[2]`"],
    ]


@pytest.mark.parametrize(("full", "expected"), [(True, 400), (False, 20)])
def test_a_run_that_is_not_by_hand_does_a_twentieth(monkeypatch, full: bool, expected: int) -> None:
    monkeypatch.setattr(endurance, "FULL", full)
    assert endurance.count(400) == expected
    assert endurance.count(3) == (3 if full else 1)


def test_workers_are_refused() -> None:
    words = [sys.executable, "-m", "pytest", "--endure", "-n", "2", "--collect-only", "-q", __file__]
    done = subprocess.run(words, capture_output=True, text=True, check=False, cwd=endurance.REPOSITORY)
    assert done.returncode == pytest.ExitCode.USAGE_ERROR
    assert "--endure runs in one process; leave out -n" in done.stderr


def test_one_statistic_is_asked_for_by_name() -> None:
    words = ["make", "--dry-run", "--no-print-directory", "-C", str(endurance.REPOSITORY), "endure"]
    named = subprocess.run([*words, "NAME=kills"], capture_output=True, text=True, check=True).stdout
    assert '--endure -o faulthandler_timeout=0 -m "endure or by_hand" -k "kills"' in named
    assert "-k" not in subprocess.run(words, capture_output=True, text=True, check=True).stdout.splitlines()[-1].split()
