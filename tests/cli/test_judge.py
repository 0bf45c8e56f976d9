"""``dampyr judge``: folders of campaigns by criteria; exit code, table, JSON and page."""

import hashlib
import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from tests.campaigns.specimen_folders import QUASI_STATIC, dahl, specimen_folder

from dampyr.cli import cli

DESIGN = '[[level]]\namplitude = "4 mm"\nlargest_force = "300 N"\nenergy = "4.5 J"\n'


def run(*args: str | Path) -> Result:
    return CliRunner().invoke(cli, ["judge", *map(str, args), "--criteria", "ntc_2018_viscous"], catch_exceptions=False)


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A good, a weak and an unfinished specimen, and the design."""
    lab = tmp_path_factory.mktemp("judged")
    specimen_folder(lab / "good", QUASI_STATIC, dahl(300.0, 4000.0), specimen="SN 1")
    specimen_folder(lab / "weak", QUASI_STATIC, dahl(180.0, 4000.0), specimen="SN 2")
    specimen_folder(lab / "unfinished", QUASI_STATIC, dahl(300.0, 4000.0), states={1: "stopped"})
    (lab / "design.toml").write_text(DESIGN)
    return lab


def test_the_exit_code_is_that_of_accept(lab: Path) -> None:
    design = ("--design", lab / "design.toml")
    passed = run(lab / "good", *design)
    assert (passed.exit_code, passed.stdout.splitlines()[0]) == (0, "1 specimen: 1 passed")
    failed = run(lab / "good", lab / "weak", lab / "unfinished", *design)
    assert (failed.exit_code, failed.stdout.splitlines()[0]) == (1, "3 specimens: 1 passed, 1 failed, 1 not judged")
    assert "energy of cycle 3, quasi static 4 mm at 10 mm/s, 0 V: 2.7" in failed.stdout
    assert "The test stopped: by the operator." in failed.stdout
    assert "The verdict of all is: failed, by ntc_2018_viscous." in failed.stdout
    unfinished = run(lab / "good", lab / "unfinished", *design)
    assert unfinished.exit_code == 3
    without = run(lab / "good")
    assert (without.exit_code, "the design's value is missing; give it." in without.stdout) == (3, True)


def test_a_wrong_request_is_refused_with_2(lab: Path) -> None:
    assert run(lab).exit_code == 2
    assert "no such file" in run(lab / "good", "--design", lab / "none.toml").stderr


def test_json_has_every_cycle_in_si_with_criterion_limit_value_and_verdict(lab: Path) -> None:
    answer = json.loads(run(lab / "weak", "--design", lab / "design.toml", "--json").stdout)
    assert (answer["verdict"], answer["criteria"]) == ("failed", "ntc_2018_viscous")
    [specimen] = answer["specimens"]
    [level] = specimen["levels"]
    assert (specimen["specimen"], level["asked"], level["run"]) == ("SN 2", 5, 5)
    assert [(row["quantity"], row["cycle"], row["holds"]) for row in level["cycles"]] == [
        ("largest_force", 3, False), ("energy", 3, False), *(("energy", k, True) for k in range(1, 6)),
    ]  # fmt: skip
    force, energy = level["cycles"][:2]
    assert force["value"] == pytest.approx(180.0, rel=1e-3)
    assert (force["lower"], force["upper"], force["unit"]) == (pytest.approx(255.0), pytest.approx(345.0), "N")
    assert (energy["lower"], energy["upper"]) == (pytest.approx(3.825), None)
    assert energy["source"] == "NTC 2018 Tab. 11.9.III, supply: from below only"
    assert specimen["worst"]["used"] == pytest.approx(0.4 / 0.15, rel=0.05)


def test_a_page_is_written(lab: Path, tmp_path: Path) -> None:
    done = run(lab / "good", "--design", lab / "design.toml", "--report", tmp_path / "page.html")
    assert done.stdout.splitlines()[-1] == f"page: {tmp_path / 'page.html'}"
    assert "Judged by ntc_2018_viscous" in (tmp_path / "page.html").read_text("utf-8")


def test_the_page_says_which_file_the_design_was(lab: Path, tmp_path: Path) -> None:
    run(lab / "good", "--design", lab / "design.toml", "--report", tmp_path / "page.html")
    digest = hashlib.sha256((lab / "design.toml").read_bytes()).hexdigest()
    assert digest[:12] in (tmp_path / "page.html").read_text("utf-8")
