"""The chain end to end through the command line, on the published campaign and on the simulated rig."""

import json
from pathlib import Path

import pytest

from dampyr.origin import NOTICES
from tests.stories.test_bad_input import dampyr

pytestmark = pytest.mark.prove


def run_json(*arguments: str | Path) -> dict:
    done = dampyr(*arguments, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_from_measured_records_to_the_building(campaign_folder: Path, tmp_path: Path) -> None:
    card, page = tmp_path / "damper.toml", tmp_path / "fit.html"
    output = run_json("identify", campaign_folder, "--model", "dahl + spring", "--save", card, "--report", page)
    assert output["converged"]
    assert len(output["records"]) == 38
    assert "ensaio.vali.1" not in output["records"]
    assert "<html" in page.read_text()

    scores = run_json("validate", card, campaign_folder, "--role", "validation")["scores"]
    assert list(scores) == ["ensaio.vali.1"]
    assert scores["ensaio.vali.1"]["fitted_on"] is False
    assert 0.05 < scores["ensaio.vali.1"]["l1"] < 0.10

    cases = run_json("simulate", card, "--voltage", "0", "--voltage", "1.98")
    peaks = [case["peak_displacement_m"][0] for case in cases.values()]
    assert peaks[0] == pytest.approx(45.5340e-3, rel=2e-4)
    assert peaks[0] > peaks[1] > peaks[2] > 0

    written = run_json("export", card, "--to", "c", "--out", tmp_path / "c")["written"]
    assert [Path(p).name for p in written] == ["damper.h", "damper.c", "damper_vectors.h", "damper_test.c", "Makefile"]


def test_the_demonstration_needs_nothing_but_the_installation_and_is_the_same_twice(tmp_path: Path) -> None:
    done, twice = (run_json("demo", "--out", tmp_path / name) for name in ("demo", "again"))
    assert done["parameters"] == twice["parameters"]
    assert done["converged"]
    assert len(list((tmp_path / "demo" / "records").glob("*.h5"))) == 22
    assert all(l1 < 0.05 for l1 in done["l1_held_out"].values())
    assert set(done["l1_held_out"]) & set(done["l1_fitted"]) == set()
    peaks = [case[0] for case in done["peak_displacement_m"].values()]
    assert peaks[0] > peaks[1] > peaks[2]
    page = (tmp_path / "demo" / "report.html").read_text()
    assert done["origin"]["kind"] == "simulated"
    assert NOTICES["simulated"] in page[: page.index("<h1>")]
    assert "http://" not in page.replace("http://www.w3.org", "")
    again = run_json("validate", done["card"], tmp_path / "demo" / "records", "--role", "validation")
    assert {k: v["l1"] for k, v in again["scores"].items()} == pytest.approx(done["l1_held_out"])


def test_predictions_of_records_that_were_not_fitted(campaign_folder: Path) -> None:
    output = run_json("identify", campaign_folder, "--model", "dahl", "--predict", "record", "--predict", "input")
    by_record, by_input = output["predictions"]
    assert by_record["split"] == "record"
    assert sum(len(fold["scores"]) for fold in by_record["folds"]) == 38
    assert all(not set(fold["scores"]) & set(fold["fitted_on"]) for fold in by_record["folds"])
    assert len(by_input["folds"]) == 2
    done = dampyr("identify", campaign_folder, "--model", "dahl", "--predict", "amplitude")
    assert "Prediction of records that it was not fitted on, 5 parts by amplitude" in done.stdout
    assert dampyr("identify", campaign_folder, "--predict", "weather").returncode == 2
