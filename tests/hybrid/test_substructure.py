"""The computed part of a hybrid test: against a building that is all computed, closed forms, and wrong models and lags."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.hybrid import Substructure, run_delayed
from dampyr.hybrid.delayed_hybrid import delayed_result
from dampyr.hybrid.substructure import LagEstimator, lag_of
from dampyr.models import Damper
from dampyr.structures import Building, Response, respond, two_storey
from dampyr.studies import raminelli_2020

VOLTAGES = (0.0, 0.8712, 3.212)
HARDEST_QUICK = [*(pytest.param(value, marks=pytest.mark.prove) for value in VOLTAGES[:2]), VOLTAGES[2]]
PRINTED = {0.0: 27.208, 0.8712: 16.446, 3.212: 3.3755}  # mm, first floor: `dampyr simulate`, FACTS
STRONG = 6.0  # s of El Centro that the quick tests take: the floors' peaks come by 2.64 s


def strong_part() -> GroundMotion:
    """The part of El Centro in which the building's peaks lie."""
    whole = el_centro()
    return whole.changed(whole.acceleration[: round(STRONG / whole.dt) + 1], "its strong part")


@cache
def all_computed(voltage: float) -> Response:
    """The building under the strong part, its damper at a voltage."""
    return respond(two_storey(), strong_part(), raminelli_2020.damper(), voltage=voltage)


def shaken(voltage: float, model: Damper | None = None, **changes: object) -> Substructure:
    """Chapter 5's building under the strong part of El Centro, its damper predicted by ``model``."""
    motion, h = strong_part(), 0.001
    response = all_computed(voltage)
    ground = np.interp(np.arange(int(motion.duration / h) + 1) * h, motion.time, motion.acceleration)
    about = Substructure(
        two_storey(), 1, ground, h, model, voltage, size=float(response.peak_displacement[0]),
        input_energy=float(response.energy.input[-1]),
    )  # fmt: skip
    return replace(about, **changes)


def peak(run) -> float:
    """mm of the first floor."""
    return 1e3 * float(np.abs(run.z[: run.now + 1, 0]).max())


def scaled(factor: float) -> Damper:
    """The damper of chapter 5 with its forces in error by a factor."""
    damper = raminelli_2020.damper()
    laws = {
        key: replace(law, coefficients=tuple(factor * c for c in law.coefficients)) if not key.endswith(".rho") else law
        for key, law in damper.all_laws.items()
    }
    return replace(damper, laws=laws, covariance=None)


@pytest.mark.parametrize(
    ("voltage", "motion"),
    [
        *((value, strong_part) for value in VOLTAGES),
        *(pytest.param(value, el_centro, marks=pytest.mark.prove) for value in VOLTAGES),
    ],
)
def test_chapter_5_on_an_actuator_10_ms_late_is_within_2_percent_of_the_computed_peak(voltage, motion):
    """Floor 5, aim 2 %; in fact a hundredth of a percent with the lag as it is."""
    result = delayed_result(two_storey(), motion(), raminelli_2020.damper(), 0.010, voltage)
    assert 1e3 * result.computed.peak_displacement[0] == pytest.approx(PRINTED[voltage], rel=2e-5)
    assert np.abs(result.differences).max() < 1e-4
    assert result.energy_error < 1e-4
    assert result.tracking_error < 1e-4


@pytest.mark.parametrize("wrong", [-0.003, 0.003])
@pytest.mark.parametrize("voltage", HARDEST_QUICK)
def test_a_lag_known_3_ms_wrongly_is_followed(voltage, wrong):
    result = delayed_result(two_storey(), strong_part(), raminelli_2020.damper(), 0.010, voltage, lag_error=wrong)
    assert np.abs(result.differences).max() < 5e-3
    assert abs(result.lag) < 2e-3  # of 3 ms; where little moves at the end it goes back to what it began with


@pytest.mark.parametrize("factor", [0.8, 1.25])
@pytest.mark.parametrize("voltage", HARDEST_QUICK)
def test_a_model_in_error_by_a_fifth_is_within_2_percent(voltage, factor):
    run = run_delayed(shaken(voltage, scaled(factor), lag=0.010), raminelli_2020.damper(), 0.010, 0.0)
    assert run.over
    assert peak(run) == pytest.approx(PRINTED[voltage], rel=0.02)


def test_the_scaled_model_is_scaled():
    t = np.linspace(0.0, 1.0, 101)
    x = 0.01 * np.sin(2 * math.pi * t)
    own, strong = (each.force(t, x, voltage=1.0) for each in (scaled(1.0), scaled(1.25)))
    np.testing.assert_allclose(strong, 1.25 * own, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(own, raminelli_2020.damper().force(t, x, voltage=1.0))


def test_without_compensation_it_is_stopped_with_the_reason():
    with pytest.raises(
        InputError, match=r"would be unstable on an actuator 10 ms late that is taken for 0 ms late.*after 0\.\d+ s"
    ):
        delayed_result(
            two_storey(), strong_part(), raminelli_2020.damper(), 0.010, 3.212, lag_error=0.010, adaptive=False
        )
    held = run_delayed(shaken(3.212, None, lag=0.010), raminelli_2020.damper(), 0.010, 0.0)
    assert not held.over  # a force that is held over 10 ms is not enough either
    assert run_delayed(shaken(0.0, None, lag=0.010), raminelli_2020.damper(), 0.010, 0.0).over


@pytest.mark.parametrize("lead", [0.0, 0.004, 0.010])
def test_it_does_not_matter_how_the_lag_is_parted(lead):
    """What leaves its host ahead of its time and what is predicted beyond it come to the same."""
    about = shaken(0.8712, raminelli_2020.damper(), lag=0.010 - lead, adaptive=False)
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


def test_a_short_motion_runs_to_its_end():
    motion = GroundMotion(np.zeros(5), 0.02)
    result = delayed_result(two_storey(), motion, raminelli_2020.damper(), 0.010)
    assert np.all(result.displacement == 0.0)  # nothing moved, and nothing was divided by it
