"""Criteria of the benchmark problems, against their sums written out, and what is refused."""

import numpy as np
import pytest
from tests.structures.begin_of_el_centro import short

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.structures import benchmark_criteria, respond, two_storey, yielding_shear_building
from dampyr.studies import raminelli_2020


@pytest.fixture(scope="module")
def responses():
    building, motion = two_storey(), short(6.0)
    return respond(building, motion), respond(building, motion, raminelli_2020.damper(), voltage=1.98), building


def test_criteria_are_ratios_of_what_they_are_called(responses) -> None:
    bare, held, building = responses
    found = benchmark_criteria(held, bare, building, height=[3.0, 2.0])
    peaks = [np.abs(r.drift / np.array([[3.0], [2.0]])).max() for r in (held, bare)]
    assert found["J1"] == pytest.approx(peaks[0] / peaks[1], rel=1e-2)  # peaks lie between samples, too
    assert found["J2"] == held.peak_acceleration.max() / bare.peak_acceleration.max()
    rms = [np.sqrt(np.mean(r.acceleration**2, axis=1)).max() for r in (held, bare)]
    assert found["J5"] == pytest.approx(rms[0] / rms[1])
    shear = [-(building.M.diagonal() @ r.acceleration) for r in (held, bare)]
    assert found["J6"] == pytest.approx(np.sqrt(np.mean(shear[0] ** 2) / np.mean(shear[1] ** 2)))
    assert found["J3"] == pytest.approx(np.abs(shear[0]).max() / np.abs(shear[1]).max(), rel=0.02)
    assert found["J11"] == pytest.approx(held.peak_force[0] / (9.80665 * np.trace(building.M)))
    assert found["J12"] == pytest.approx(np.abs(held.drift[0]).max() / bare.peak_displacement.max(), rel=1e-9)


def test_a_building_without_dampers_is_its_own_measure(responses) -> None:
    bare, _, building = responses
    found = benchmark_criteria(bare, bare, building)
    assert found == dict.fromkeys(("J1", "J2", "J3", "J4", "J5", "J6"), 1.0)


def test_storeys_that_yield_have_four_criteria_more() -> None:
    building, storeys = yielding_shear_building([2e4, 2e4], [3e7, 2e7], [0.005, 0.006], 0.03, damping_ratio=0.02)
    motion, damper = short(6.0), Damper("power_law", {"power_law.C": 1e6, "power_law.alpha": 1.0}, input="none")
    bare = respond(building, motion, storeys)
    held = respond(building, motion, storeys | {1: [storeys[1], damper]})
    found = benchmark_criteria(held, bare, building, yield_drifts=[0.005, 0.006])
    assert list(found) == [f"J{k}" for k in range(1, 13)]
    ductility = [r.peak_drift / np.array([0.005, 0.006]) for r in (held, bare)]
    assert found["J7"] == pytest.approx(ductility[0].max() / ductility[1].max())
    assert [int((each > 1).sum()) for each in ductility] == [1, 2]  # or the counts would say nothing
    assert found["J9"] == 0.5
    assert held.sites == ("storey 1", "storey 1", "storey 2")  # the element stands before the damper
    work = [max(np.trapezoid(r.force[k], r.stroke[k]) for k in at) for r, at in ((held, (0, 2)), (bare, (0, 1)))]
    assert found["J8"] == pytest.approx(work[0] / work[1], rel=0.02)
    rms = [np.sqrt(np.mean((r.drift / np.array([[0.005], [0.006]])) ** 2, axis=1)).max() for r in (held, bare)]
    assert found["J10"] == pytest.approx(rms[0] / rms[1])
    assert found["J11"] == pytest.approx(held.peak_force[1] / (9.80665 * 4e4))  # of the damper, not of the storeys
    same = benchmark_criteria(bare, bare, building, yield_drifts=[0.005, 0.006])
    assert same == dict.fromkeys([f"J{k}" for k in range(1, 11)], 1.0)
    elastic = respond(building, motion.scaled(0.01), storeys)
    assert set(benchmark_criteria(elastic, elastic, building, yield_drifts=0.005)) & {"J8", "J9"} == set()  # 0 over 0
    with pytest.raises(InputError, match="dampers none"):
        benchmark_criteria(respond(building, motion, {1: storeys[1]}), bare, building, yield_drifts=0.005)
    with pytest.raises(InputError, match="3 yield_drifts do not match 2"):
        benchmark_criteria(bare, bare, building, yield_drifts=[0.005] * 3)
    plain = respond(building, motion)
    with pytest.raises(InputError, match="no elements"):
        benchmark_criteria(plain, plain, building, yield_drifts=0.005)
    with pytest.raises(InputError, match="yield_drifts="):
        benchmark_criteria(bare, bare, building)


def test_what_does_not_fit_is_refused(responses) -> None:
    bare, held, building = responses
    with pytest.raises(InputError, match="different motions"):
        benchmark_criteria(held, respond(building, short(4.0)), building)
    with pytest.raises(InputError, match="bare has dampers"):
        benchmark_criteria(held, held, building)
    with pytest.raises(InputError, match="height = -1"):
        benchmark_criteria(held, bare, building, height=-1.0)
