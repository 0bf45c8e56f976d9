"""The computed part of a hybrid test: models in error, the error of energy, lag and gain of a motion."""

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.hybrid.chapter_5 import HARDEST_QUICK, PRINTED, SHAKES, peak, shaken

from dampyr.errors import InputError
from dampyr.ground_motions import el_centro
from dampyr.hybrid import Substructure, run_delayed
from dampyr.hybrid.delayed_hybrid import delayed_result
from dampyr.hybrid.substructure import LagEstimator, lag_of
from dampyr.models import Damper
from dampyr.structures import two_storey
from dampyr.studies import raminelli_2020


def scaled(factor: float) -> Damper:
    """The damper of chapter 5 with its forces in error by a factor."""
    damper = raminelli_2020.damper()
    laws = {
        key: replace(law, coefficients=tuple(factor * c for c in law.coefficients)) if not key.endswith(".rho") else law
        for key, law in damper.all_laws.items()
    }
    return replace(damper, laws=laws, covariance=None)


@pytest.mark.parametrize("factor", [0.8, 1.25])
@pytest.mark.parametrize("voltage", HARDEST_QUICK)
@pytest.mark.parametrize("motion", SHAKES)
def test_a_model_in_error_by_a_fifth_is_within_2_percent(voltage, factor, motion):
    run = run_delayed(shaken(voltage, scaled(factor), motion, lag=0.010), raminelli_2020.damper(), 0.010, 0.0)
    assert run.over
    assert peak(run) == pytest.approx(PRINTED[voltage], rel=0.02)


def test_the_scaled_model_is_scaled():
    t = np.linspace(0.0, 1.0, 101)
    x = 0.01 * np.sin(2 * math.pi * t)
    own, strong = (each.force(t, x, voltage=1.0) for each in (scaled(1.0), scaled(1.25)))
    np.testing.assert_allclose(strong, 1.25 * own, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(own, raminelli_2020.damper().force(t, x, voltage=1.0))


def test_the_error_of_energy_is_the_work_of_the_force_on_the_error():
    about = shaken(0.0, raminelli_2020.damper(), adaptive=False, energy_limit=1.0)
    run = run_delayed(about, raminelli_2020.damper(), 0.010, 0.0)
    error = run.achieved - run.target
    assert run.error == pytest.approx(float(np.sum(run.force[:-1] * np.diff(error))), rel=1e-9)
    assert run.input == pytest.approx(about.input_energy, rel=0.05)


@pytest.mark.parametrize(("lag", "gain"), [(0.0, 1.0), (0.0123, 0.95), (0.040, 1.1)])
def test_lag_and_gain_of_a_motion(lag, gain):
    t = np.arange(4000) * 0.001
    u = 0.002 * np.sin(2 * math.pi * 2.0 * t) * np.minimum(t, 1.0)
    y = gain * np.interp(t - lag, t, u)
    assert lag_of(u, y, 0.001, 0.05) == (pytest.approx(lag, abs=1e-5), pytest.approx(gain, rel=1e-4))


def test_a_motion_that_stands_still_has_no_lag():
    with pytest.raises(InputError, match="stand still; move the table"):
        lag_of(np.zeros(1000), np.zeros(1000), 0.001, 0.05)


def test_a_lag_is_followed_and_where_nothing_moves_it_stays():
    lag, h = LagEstimator(0.001, 0.01, lag=0.010), 0.001
    for k in range(6000):
        u, rate = 0.01 * math.sin(12.0 * k * h), 0.12 * math.cos(12.0 * k * h)
        lag.take(u, rate, u - 0.002 * rate, 0.010)
    assert lag.lag == pytest.approx(0.012, abs=5e-4)
    for _ in range(20000):
        lag.take(1e-6, 0.0, 0.0, 0.010)
    assert lag.lag == pytest.approx(0.010, abs=5e-4)


def test_wrong_arguments_are_refused():
    with pytest.raises(InputError, match=r"delay = 0\.2 s is not allowed"):
        delayed_result(two_storey(), el_centro(), raminelli_2020.damper(), 0.2)
    with pytest.raises(InputError, match="shorter than two steps"):
        Substructure(two_storey(), 1, np.zeros(1), 0.001)
    with pytest.raises(InputError, match="h = 0 s"):
        Substructure(two_storey(), 1, np.zeros(10), 0.0)
    with pytest.raises(InputError, match=r"lead = 3 s"):
        run_delayed(shaken(0.0), raminelli_2020.damper(), 0.01, 3.0)
