"""The calls that dampyr promises to keep."""

from pathlib import Path

import numpy as np
import pytest

import dampyr as dp


def test_the_published_face(campaign_folder: Path, tmp_path: Path) -> None:
    record = dp.records.read(campaign_folder / "ensaio1.2.2.mat", voltage=0.8712)
    records = [r for r in dp.records.read_campaign(campaign_folder) if r.voltage < 1.0][::5]
    fit = dp.identification.fit(records, "dahl")
    assert fit.converged, fit.reason
    assert set(fit.parameters) == set(fit.stderr)
    assert fit.correlation.shape == (len(fit.parameters),) * 2
    score = dp.identification.score(fit.damper, record)
    assert 0 < score.l1 < 0.15
    assert score.window.start >= 2.0
    path = tmp_path / "rd8041.toml"
    fit.damper.save(path)
    damper = dp.models.Damper.load(path)
    force = damper.force(record.time, record.displacement, voltage=0.5)
    assert force.shape == record.time.shape


def test_the_building_of_the_face() -> None:
    motion = dp.ground_motions.el_centro()
    building = dp.structures.two_storey()
    damper = dp.studies.raminelli_2020.damper()
    response = dp.structures.respond(building, motion, dampers={1: damper}, voltage=3.212)
    assert response.peak_displacement.shape == (2,)
    assert response.peak_drift.shape == response.peak_acceleration.shape == (2,)
    assert response.force.shape == (1, motion.n)
    assert response.to_xarray()["displacement"].attrs["units"] == "m"
    np.testing.assert_allclose(motion.scaled(1.5).acceleration, 1.5 * motion.acceleration)


def test_a_study_that_is_not_there_is_told() -> None:
    with pytest.raises(AttributeError, match="raminelli_2020"):
        _ = dp.studies.raminelli_2021


def test_a_room_that_is_not_there_is_told() -> None:
    with pytest.raises(AttributeError, match="its packages are"):
        _ = dp.garage
