"""A run on an actuator that is late by a fixed time: how the lag is parted, and the delay that a spring can stand."""

import math

import numpy as np
import pytest
from tests.hybrid.chapter_5 import PRINTED, SHAKES, peak, shaken

from dampyr.hybrid import Substructure, run_delayed
from dampyr.models import Damper
from dampyr.structures import Building
from dampyr.studies import raminelli_2020


@pytest.mark.parametrize("lead", [0.0, 0.004, 0.010])
@pytest.mark.parametrize("motion", SHAKES)
def test_it_does_not_matter_how_the_lag_is_parted(lead, motion):
    """What leaves its host ahead of its time and what is predicted beyond it come to the same."""
    about = shaken(0.8712, raminelli_2020.damper(), motion, lag=0.010 - lead, adaptive=False)
    run = run_delayed(about, raminelli_2020.damper(), 0.010, lead)
    assert peak(run) == pytest.approx(PRINTED[0.8712], rel=1e-4)


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
