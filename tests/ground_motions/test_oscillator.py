"""Peaks of an oscillator on a shaking ground: closed forms, an independent integration, and what is refused."""

import numpy as np
import pytest
from scipy.signal import lsim

from dampyr.errors import InputError
from dampyr.ground_motions.oscillator import oscillator_peaks, solution, substeps


def test_under_a_constant_acceleration_it_swings_to_the_closed_form() -> None:
    """u = -(a/omega^2) (1 - exp(-zeta omega t) (cos + zeta/sqrt(1 - zeta^2) sin)): at half a damped period 1 + the decay."""
    period, zeta, a = 0.7, 0.05, 3.0
    omega = 2 * np.pi / period
    d, v, total, pseudo_v, pseudo_a = oscillator_peaks(np.full(101, a), 0.01, np.array(period), np.array(zeta))
    ratio = zeta / np.sqrt(1 - zeta**2)
    assert d == pytest.approx(a / omega**2 * (1 + np.exp(-np.pi * ratio)), rel=1e-10)
    assert v == pytest.approx(a / omega * np.exp(-ratio * np.arctan(1 / ratio)), rel=1e-10)
    assert (pseudo_v, pseudo_a) == pytest.approx((omega * d, omega**2 * d))
    assert total > pseudo_a * (1 - 1e-12)  # the force of the damper is in it
    undamped = oscillator_peaks(np.full(101, a), 0.01, np.array(period), np.array(0.0))
    assert undamped[0] == pytest.approx(2 * a / omega**2, rel=1e-10)


def test_random_shaking_agrees_with_an_integration_by_matrix_exponentials() -> None:
    """SciPy's `lsim`, first-order hold, on steps so fine that the peaks at samples are those between."""
    a, dt, parts = np.random.default_rng(8).standard_normal(200), 0.02, 60
    time = np.arange(199 * parts + 1) * dt / parts
    ground = np.interp(time, np.arange(200) * dt, a)
    periods, damping = np.array([0.2, 3.0]), np.array([0.0, 0.2, 1.5])
    d, v, total, *_ = oscillator_peaks(a, dt, periods, damping)
    for i, zeta in enumerate(damping):
        for j, period in enumerate(periods):
            omega = 2 * np.pi / period
            c, k = 2 * zeta * omega, omega**2
            system = ([[0.0, 1.0], [-k, -c]], [[0.0], [-1.0]], [[1.0, 0.0], [0.0, 1.0], [k, c]], np.zeros((3, 1)))
            peaks = np.abs(lsim(system, ground, time)[1]).max(axis=0)
            assert (d[i, j], v[i, j], total[i, j]) == pytest.approx(tuple(peaks), rel=2e-4)


def test_a_rigid_oscillator_has_the_grounds_acceleration() -> None:
    d, v, total, _, pseudo = oscillator_peaks(np.array([0.0, 2.0, -3.0]), 0.1, np.array([0.0]), np.array(0.05))
    assert [float(x[0]) for x in (d, v, total, pseudo)] == [0.0, 0.0, 3.0, 3.0]


def test_the_series_is_the_free_swing() -> None:
    u, v = solution(1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.2)
    assert (u, v) == pytest.approx((np.cos(0.4), -2.0 * np.sin(0.4)), rel=1e-15)
    assert substeps(2.0, 0.0, 0.2) == 1
    assert substeps(2.0, 0.5, 0.2) == 2


@pytest.mark.parametrize(
    ("periods", "damping", "words"),
    [
        ([-1.0], 0.05, "periods: -1 s is not allowed; it must be finite and at least 0"),
        ([], 0.05, r"periods has shape \(0,\)"),
        ([1.0], np.nan, "damping: nan is not allowed"),
        ([1.0], 50.0, "damping: 50 is not allowed; it is a ratio to critical"),
        ([1e-7], 0.05, "periods: 1e-07 s is too short for samples every 0.01 s"),
    ],
)
def test_what_makes_no_sense_is_refused(periods: list[float], damping: float, words: str) -> None:
    with pytest.raises(InputError, match=words):
        oscillator_peaks(np.zeros(5), 0.01, np.array(periods), np.array(damping))
