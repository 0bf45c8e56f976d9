"""A run on an actuator that is late by a fixed time: how the lag is parted, and the delay that a spring can stand."""

import math

import numpy as np
import pytest
from tests.hybrid.chapter_5 import PRINTED, SHAKES, peak, shaken
from tests.structures.begin_of_el_centro import short

from dampyr.hybrid import Substructure, run_delayed
from dampyr.hybrid.delayed_hybrid import delayed_result
from dampyr.models import Damper
from dampyr.structures import Building, control_law, respond, two_storey
from dampyr.studies import raminelli_2020


@pytest.mark.parametrize("lead", [0.0, 0.004, 0.010])
@pytest.mark.parametrize("motion", SHAKES)
def test_it_does_not_matter_how_the_lag_is_parted(lead, motion):
    """What leaves its host ahead of its time and what is predicted beyond it come to the same."""
    about = shaken(0.8712, raminelli_2020.damper(), motion, lag=0.010 - lead, adaptive=False)
    run = run_delayed(about, raminelli_2020.damper(), 0.010, lead)
    assert peak(run) == pytest.approx(PRINTED[0.8712], rel=1e-4)


@pytest.mark.parametrize(
    "name",
    [
        "clipped_optimal",
        *(pytest.param(k, marks=pytest.mark.prove) for k in ("inverse_tracking", "modulated_friction")),
    ],
)
def test_under_a_law_it_is_the_response_under_that_law(name):
    """On an actuator without a delay, with the model that predicts; the force is held over its steps."""
    damper, building, h = raminelli_2020.damper(), two_storey(), 5e-4
    motion, law = short(8.0), control_law(name, high=3.0, lag=0.01)
    ground = np.interp(np.arange(round(8.0 / h) + 1) * h, motion.time, motion.acceleration)
    run = run_delayed(Substructure(building, 1, ground, h, damper), damper, 0.0, 0.0, law)
    assert run.over
    expected = respond(building, motion, {1: damper}, voltage=law)
    got = np.abs(run.z[:, :2]).max(axis=0)
    assert got == pytest.approx(expected.peak_displacement, rel=1e-2)
    assert np.abs(run.force).max() == pytest.approx(expected.peak_force[0], rel=2e-2)
    off = run_delayed(Substructure(building, 1, ground, h, damper), damper, 0.0, 0.0)
    assert got[0] < 0.7 * np.abs(off.z[:, 0]).max()


def test_the_result_says_which_law_and_its_model_has_the_inputs_of_the_test():
    """The model of the result runs along the achieved path under the inputs that were decided: it is the specimen's force."""
    law = control_law("clipped_optimal", high=3.0, lag=0.01)
    result = delayed_result(two_storey(), short(4.0), raminelli_2020.damper(), 0.005, law)
    assert result.law == result.input_words == "clipped_optimal 0 to 3 V, lag 0.01 s"
    assert 0.0 < result.voltage < 3.0
    np.testing.assert_allclose(result.modelled[:-1], result.force[:-1], atol=1e-9 * np.abs(result.force).max())
    assert np.abs(result.differences).max() < 0.15
    assert result.computed.laws == ("clipped_optimal 0 to 3 V, lag 0.01 s",)


def critical_delay(m: float, c: float, k: float, spring: float) -> float:
    """The delay [s] at which m q'' + c q' + k q + spring q(t - tau) = 0 neither grows nor decays."""
    first, second = 2.0 * (k - 0.5 * c * c / m) / m, (k * k - spring * spring) / (m * m)
    w = math.sqrt(0.5 * (first + math.sqrt(first * first - 4.0 * second)))
    angle = math.atan2(c * w, m * w * w - k)
    return angle / w


@pytest.mark.parametrize(("share", "grows"), [(0.9, False), (1.1, True)])
def test_the_delay_that_a_spring_can_stand_is_the_closed_form(share, grows):
    m, c, k = 100.0, 120.0, 40000.0
    building = Building(np.array([[m]]), np.array([[c]]), np.array([[k]]))
    spring, h = 10000.0, 5e-4
    delay = share * critical_delay(m, c, k, spring)
    ground = np.zeros(int(10.0 / h))
    ground[:40] = 1.0
    about = Substructure(building, 1, ground, h, None, lag=0.0, adaptive=False, energy_limit=1e9)
    run = run_delayed(about, Damper("spring", {"spring.k0": spring}), delay, 0.0)
    early, late = (float(np.abs(part).max()) for part in (run.target[2000:6000], run.target[-4000:]))
    assert (late > 1.5 * early) == grows
    assert (late < early / 1.5) == (not grows)
