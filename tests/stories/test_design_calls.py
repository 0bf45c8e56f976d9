"""The calls of the public face, from a file to a building in an earthquake, as the documentation promises them."""

from pathlib import Path

import numpy as np
import pytest

import dampyr as dp
from tests.identification.synthetic import sine

VOLTAGES = (0.0, 1.98, 3.212)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Records of the published damper at three voltages, two motions each."""
    place = tmp_path_factory.mktemp("lab")
    damper = dp.studies.raminelli_2020.damper()
    for k, (voltage, frequency) in enumerate((u, f) for u in VOLTAGES for f in (0.5, 1.0)):
        record = sine(damper, voltage, f"{voltage:g}V-{frequency:g}Hz", frequency=frequency, noise=2.0, seed=k)
        dp.records.write(record, place / f"{record.name}.csv")
    return place


@pytest.fixture(scope="module")
def fit(folder: Path) -> dp.identification.Fit:
    return dp.fit(dp.records.read_campaign(folder), "dahl")


def test_records_and_a_fit(folder: Path, fit: dp.identification.Fit, tmp_path: Path) -> None:
    record = dp.read(folder / "1.98V-1Hz.csv")
    assert dp.read(str(folder / "1.98V-1Hz.csv")).voltage == record.voltage == 1.98
    records = dp.records.read_campaign(str(folder))
    assert dp.identification.fit(records, "dahl").parameters == fit.parameters
    assert fit.converged, fit.reason
    assert fit.correlation.shape == (len(fit.parameters), len(fit.stderr))
    assert isinstance(fit.findings, tuple)
    assert fit.verdict.words
    score = dp.identification.score(fit.damper, record)
    assert all(np.isfinite(each) for each in (score.l1, score.nrmse, score.r2, score.pointwise, score.energy))
    assert score.window.start >= 2.0
    fit.damper.save(tmp_path / "rd8041.toml")
    assert dp.Damper.load(tmp_path / "rd8041.toml").range == fit.damper.range


def test_a_damper_of_numbers() -> None:
    damper = dp.models.Damper("dahl", {"kx": 1000.0, "kw": 200.0, "rho": 1000.0})
    assert dp.Damper is dp.models.Damper
    t = np.linspace(0.0, 1.0, 101)
    x = 0.01 * np.sin(2 * np.pi * t)
    f = damper.force(t, x, voltage=0.0)
    assert f.shape == (101,)
    assert np.array_equal(f, damper.force(t, x))


def test_a_building(fit: dp.identification.Fit, tmp_path: Path) -> None:
    motion, building, damper = dp.ground_motions.el_centro(), dp.structures.two_storey(), fit.damper
    np.savetxt(tmp_path / "motion.csv", motion.acceleration)
    assert dp.ground_motions.read(tmp_path / "motion.csv", units="m/s^2", dt=motion.dt).n == motion.n
    response = dp.structures.respond(building, motion, dampers={1: damper}, voltage=3.212)
    assert response.peak_displacement.shape == response.peak_drift.shape == response.peak_acceleration.shape == (2,)
    assert response.force.shape == (1, motion.n)
    assert response.to_xarray()["displacement"].dims
    assert dp.respond(building, motion, dampers={1: damper}, voltage=3.212).peak_drift[0] == response.peak_drift[0]
    published = dp.studies.raminelli_2020.damper()
    assert published.at(1.98)
    peaks = dp.structures.ensemble(
        building, [motion], [damper, published], voltage=[0.0, 1.98], scales=[0.5, 1.0], executor=None
    )
    assert peaks.origin.kind == response.origin.kind
    assert np.array_equal(motion.scaled(1.5).acceleration, 1.5 * motion.acceleration)


def test_several_inputs_and_a_control_law(fit: dp.identification.Fit) -> None:
    motion, building = dp.ground_motions.el_centro().scaled(0.15), dp.structures.two_storey()
    responses = dp.structures.respond(building, motion, dampers={1: fit.damper}, voltage=[0.0, 1.98])
    single = dp.structures.respond(building, motion, dampers={1: fit.damper}, voltage=1.98)
    assert [case for case in responses.cases.values() if np.array_equal(case.peak_drift, single.peak_drift)]
    law = dp.structures.control_law("on_off", low=0.0, high=1.98)
    assert dp.structures.respond(building, motion, dampers={1: fit.damper}, voltage=law).peak_drift.shape == (2,)


def test_a_campaign_on_a_rig(tmp_path: Path) -> None:
    step = {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz", "voltage": "1.98 V", "cycles": 2}
    campaign = dp.campaigns.campaign_of({"name": "one", "operator": "me", "step": [step]})
    with dp.rig.simulated() as rig:
        records = dp.campaigns.perform(campaign, rig, tmp_path / "one")
        again = dp.campaigns.perform(campaign, rig, str(tmp_path / "one"))  # nothing is left to do
    assert [record.name for record in records] == [record.name for record in again] == ["01-sine-8mm-1Hz-1.98V"]
    assert records.folder == tmp_path / "one"
    assert len(records) == 1
    assert records[0].origin.kind == "simulated"


def test_every_result_shows_itself(fit: dp.identification.Fit, folder: Path) -> None:
    results = [fit, fit.damper, dp.read(folder / "1.98V-1Hz.csv")]
    for result in results:
        assert str(result).startswith("<")
        assert result.as_dict()
        assert result.plot() is not None
        assert result.origin.kind
    assert not fit.to_dataframe().empty
