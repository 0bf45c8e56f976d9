"""The chain end to end through the command line, on the published campaign and on the simulated rig."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.campaigns import perform
from dampyr.cli import cli
from dampyr.ground_motions import el_centro
from dampyr.identification import fit
from dampyr.origin import NOTICES
from dampyr.records import read, read_campaign
from dampyr.rig import simulated
from dampyr.rig.specimen import original_specimen
from dampyr.structures import respond, two_storey
from dampyr.studies import demo
from tests.stories.test_bad_input import in_a_process

pytestmark = pytest.mark.prove


def run_json(*arguments: str | Path) -> dict:
    done = in_a_process(*arguments, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def here(*arguments: str | Path) -> dict:
    """The same in this process, which has loaded the kernels already."""
    done = CliRunner().invoke(cli, [*map(str, arguments), "--json"], catch_exceptions=False)
    assert done.exit_code == 0, done.stderr
    return json.loads(done.stdout)


def test_from_measured_records_to_the_building(campaign_folder: Path, tmp_path: Path) -> None:
    card, page = tmp_path / "damper.toml", tmp_path / "fit.html"
    output = here("identify", campaign_folder, "--model", "dahl + spring", "--save", card, "--report", page)
    assert output["converged"]
    assert len(output["records"]) == 38
    assert "ensaio.vali.1" not in output["records"]
    assert "<html" in page.read_text()

    scores = here("validate", card, campaign_folder, "--role", "validation")["scores"]
    assert list(scores) == ["ensaio.vali.1"]
    assert scores["ensaio.vali.1"]["fitted_on"] is False
    assert 0.05 < scores["ensaio.vali.1"]["l1"] < 0.10

    cases = here("simulate", card, "--voltage", "0", "--voltage", "1.98")
    peaks = [case["peak_displacement_m"][0] for case in cases.values()]
    assert peaks[0] == pytest.approx(45.5340e-3, rel=2e-4)
    assert peaks[0] > peaks[1] > peaks[2] > 0

    written = here("export", card, "--to", "c", "--out", tmp_path / "c")["written"]
    assert [Path(p).name for p in written] == ["damper.h", "damper.c", "damper_vectors.h", "damper_test.c", "Makefile"]


def test_the_demonstration_needs_nothing_but_the_installation_and_is_the_same_twice(tmp_path: Path) -> None:
    """The second time its first two tests alone are performed; the fit is that of all its records."""
    done = run_json("demo", "--out", tmp_path / "demo")
    assert done["converged"]
    whole, own = demo.campaign(), tmp_path / "demo" / "records"
    with simulated(demo.rig_settings(), seed=demo.SEED) as rig:
        twice = perform(replace(whole, tests=whole.tests[:2]), rig, tmp_path / "again").folder
    for again in read_campaign(twice):
        np.testing.assert_array_equal(again.force, read(own / f"{again.name}.h5").force)
    same = fit(read_campaign(own, role="fit"), demo.MODEL, laws=demo.LAWS, fixed=demo.FIXED, bandwidth=demo.BANDWIDTH)
    assert same.parameters == done["parameters"]
    assert len(list((tmp_path / "demo" / "records").glob("*.h5"))) == 22
    assert all(l1 < 0.05 for l1 in done["l1_held_out"].values())
    assert set(done["l1_held_out"]) & set(done["l1_fitted"]) == set()
    peaks = [case[0] for case in done["peak_displacement_m"].values()]
    assert peaks[0] > peaks[1] > peaks[2]
    # with the specimen itself, which is known as it is simulated: the page says what leaving the tests' range costs
    true = [case[0] for case in done["peak_displacement_with_specimen_m"].values()]
    assert true[0] == peaks[0]
    assert max(abs(a - b) / b for a, b in zip(peaks, true, strict=True)) < 0.02
    specimen = respond(two_storey(), el_centro(), {1: original_specimen()}, voltage=3.212)
    assert true[2] == pytest.approx(specimen.peak_displacement[0], rel=1e-12)
    page = (tmp_path / "demo" / "report.html").read_text()
    assert done["origin"]["kind"] == "simulated"
    assert NOTICES["simulated"] in page[: page.index("<h1>")]
    assert "http://" not in page.replace("http://www.w3.org", "")
    again = run_json("validate", done["card"], tmp_path / "demo" / "records", "--role", "validation")
    assert {k: v["l1"] for k, v in again["scores"].items()} == pytest.approx(done["l1_held_out"])


def test_predictions_of_records_that_were_not_fitted(campaign_folder: Path) -> None:
    output = here("identify", campaign_folder, "--model", "dahl", "--predict", "record", "--predict", "input")
    by_record, by_input = output["predictions"]
    assert by_record["split"] == "record"
    assert sum(len(fold["scores"]) for fold in by_record["folds"]) == 38
    assert all(not set(fold["scores"]) & set(fold["fitted_on"]) for fold in by_record["folds"])
    assert len(by_input["folds"]) == 2
    words = ["identify", str(campaign_folder), "--model", "dahl", "--predict"]
    done = CliRunner().invoke(cli, [*words, "amplitude", "--details"], catch_exceptions=False)
    assert "Prediction of records that it was not fitted on, 5 parts by amplitude" in done.stdout
    assert CliRunner().invoke(cli, [*words, "weather"], catch_exceptions=False).exit_code == 2
