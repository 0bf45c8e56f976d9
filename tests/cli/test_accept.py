"""``dampyr accept``: records against a card, a published damper, or records of a reference damper."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from tests.identification.acceptance_tests.test_acceptance import THREE, ladder
from tests.identification.synthetic import sine

from dampyr.cli import cli
from dampyr.models import Damper
from dampyr.records import write

CARD = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 150.0, "dahl.rho": 3000.0})


def run(*args: str | Path) -> Result:
    return CliRunner().invoke(cli, ["accept", *map(str, args)], catch_exceptions=False)


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A card, and tests of a damper like it (offset of 120 N), of one that is 20 % stronger, and of one without cycles."""
    folder = tmp_path_factory.mktemp("lab")
    CARD.save(folder / "card.toml")
    good = sine(CARD, 0.0, "good")
    write(good, folder / "good.h5")
    again = sine(CARD, 0.0, "again", noise=0.5)
    write(again, folder / "again.h5")
    strong = good.replace(note="stronger", name="strong", force=120.0 + 1.2 * (good.force - 120.0))
    write(strong, folder / "strong.h5")
    still = good.replace(note="at rest", name="still", displacement=np.zeros(good.n), velocity=None)
    write(still, folder / "still.h5")
    return folder


def test_the_exit_code_tells_the_verdict(lab: Path) -> None:
    passed = run(lab / "card.toml", lab / "good.h5")
    assert (passed.exit_code, passed.stdout.splitlines()[0]) == (0, "1 record: 1 passed")
    failed = run(lab / "card.toml", lab / "good.h5", lab / "strong.h5", lab / "still.h5")
    assert (failed.exit_code, failed.stdout.splitlines()[0]) == (1, "3 records: 1 passed, 1 failed, 1 not judged")
    unjudged = failed.stdout.partition("What was not judged")[2]
    assert any(line.split() == ["still", "0", "No", "whole", "cycle."] for line in unjudged.splitlines())
    row = next(line for line in failed.stdout.splitlines() if line.strip().startswith("strong"))
    assert row.split()[-1] == "20"
    assert row.split()[5:8] == ["4", "of", "5"]  # the first cycle grows
    assert run(lab / "card.toml", lab / "good.h5", lab / "still.h5").exit_code == 3
    assert run(lab / "card.toml", lab / "good.h5", "--tolerance", "fifteen").exit_code == 2


def test_the_band_is_told_in_units_of_people(lab: Path) -> None:
    wide = run(
        lab / "card.toml", lab / "strong.h5", "--tolerance", "15%", "--force-slack", "12 N", "--energy-slack", "400mJ"
    )
    assert wide.exit_code == 0, wide.stdout
    assert "± 15 % and 12 N and 0.4 J" in wide.stdout
    assert run(lab / "card.toml", lab / "strong.h5", "--tolerance", "0.21").exit_code == 0
    for slack in ("12mm", "N"):
        refused = run(lab / "card.toml", lab / "strong.h5", "--force-slack", slack)
        assert (refused.exit_code, f"--force-slack {slack}: " in refused.stderr) == (2, True)


def test_json_has_every_point_in_si(lab: Path) -> None:
    output = json.loads(run(lab / "card.toml", lab / "strong.h5", "--json", "--judge", "energy").stdout)
    assert output["verdict"] == "failed"
    (one,) = output["records"]
    assert {p["quantity"] for p in one["points"]} == {"energy"}
    assert one["worst"]["deviation"] == pytest.approx(0.2, abs=1e-6)
    assert one["tolerance"] == {"relative": 0.15, "force": 0.0, "energy": 0.0}


def test_records_are_a_reference_too_and_none_judges_itself(lab: Path) -> None:
    assert run(lab / "again.h5", lab / "good.h5").exit_code == 0
    assert run(lab / "again.h5", lab / "strong.h5").exit_code == 1
    itself = run(lab / "good.h5", lab / "good.h5")
    assert (itself.exit_code, "The reference is this record itself" in itself.stdout) == (3, True)
    other = run(lab / "again.h5", lab / "good.h5", "--offset", "120N")
    assert other.exit_code == 0


def test_the_zero_of_the_load_cell_may_be_told(lab: Path) -> None:
    assert run(lab / "card.toml", lab / "good.h5", "--offset", "120 N").exit_code == 0
    assert run(lab / "card.toml", lab / "good.h5", "--offset", "0 N").exit_code == 1


def test_a_name_that_is_not_published_is_told_with_those_that_are(lab: Path) -> None:
    unknown = run("raminelli_2021", lab / "good.h5")
    assert unknown.exit_code == 2
    assert "no such file, and no published damper; give a card, records, or one of " in unknown.stderr
    assert "raminelli_2020" in unknown.stderr.partition("one of ")[2]


@pytest.mark.prove  # a page of the campaign's record; the other tests name published dampers too
def test_a_published_damper_is_a_reference(lab: Path, campaign_folder: Path) -> None:
    result = run("raminelli_2020", campaign_folder, "--role", "validation", "--report", lab / "page.html")
    assert result.exit_code == 0
    assert "ensaio.vali.1" in (lab / "page.html").read_text("utf-8")
    unknown = run("raminelli_2021", lab / "good.h5")
    assert unknown.exit_code == 2
    assert "no such file, and no published damper; give a card, records, or one of " in unknown.stderr
    assert "raminelli_2020" in unknown.stderr.partition("one of ")[2]


def test_another_input_is_not_judged(lab: Path) -> None:
    write(sine(CARD, 0.0).replace(note="told", voltage=9.0), lab / "nine.h5")
    result = run("spencer_1997", lab / "nine.h5")
    assert result.exit_code == 3
    assert "Voltage 9 V is outside the calibrated range" in result.stdout


def test_a_damper_that_is_weak_at_its_design_amplitude_does_not_pass(tmp_path: Path) -> None:
    """25/50/100 % of 8 mm, three cycles each, the force of the last level 0.6 times the published one."""
    weak = ladder(THREE, weak=0.6)
    write(weak, tmp_path / "weak.csv")
    failed = run("raminelli_2020", tmp_path / "weak.csv", "--report", tmp_path / "page.html")
    assert failed.exit_code == 1
    assert "1 record: 1 failed" in failed.stdout
    rows = [line.split() for line in failed.stdout.splitlines() if line.split()[:1] == ["weak"]]
    assert rows[0][4:10] == ["9", "9", "of", "9", "16", "16"]
    assert [row[:7] for row in rows if "failed" in row][-1] == ["weak", "3", "3", "3", "16", "1", "failed"]
    output = json.loads(run("raminelli_2020", tmp_path / "weak.csv", "--json").stdout)["records"][0]
    assert (output["run"], output["cut"], output["judged_cycles"]) == (9.0, 9, 9)
    assert output["judged_stroke_m"] == pytest.approx(0.016, rel=1e-3)
    assert output["wrong_rejection"] < 1e-3 > output["wrong_acceptance"]
    page = (tmp_path / "page.html").read_text("utf-8")
    assert "The levels" in page
    assert "wrong acceptance" in page
    write(ladder(THREE), tmp_path / "good.csv")
    assert run("raminelli_2020", tmp_path / "good.csv").exit_code == 0
    message = CliRunner().invoke(cli, ["records", str(tmp_path / "weak.csv")]).stdout
    assert "3 levels, 9 whole cycles of 9, 4 to 16 mm peak to peak" in message
    assert "smoothed" not in message
    assert "no repeating cycle" not in message
