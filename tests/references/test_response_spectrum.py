"""Nigam and Jennings (1969), by scipy's matrix exponential on a fine grid; Chopra, Dynamics of Structures: El Centro, 2 %."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, corrected, el_centro, padded, resampled, spectrum


def independent(motion: GroundMotion, period: float, damping: float, parts: int) -> np.ndarray:
    """Peaks of displacement, velocity, absolute acceleration: exact states on a grid ``parts`` times as fine."""
    w = 2 * math.pi / period
    h = motion.dt / parts
    a = np.interp(np.arange((motion.n - 1) * parts + 1) * h, motion.time, motion.acceleration)
    M = np.zeros((4, 4))
    M[0, 1], M[1, :3], M[2, 3] = 1.0, (-w * w, -2 * damping * w, -1.0), 1.0
    E = expm(M * h)
    states = np.zeros((len(a), 2))
    for i in range(len(a) - 1):
        states[i + 1] = E[:2] @ np.array([*states[i], a[i], (a[i + 1] - a[i]) / h])
    u, v = states.T
    return np.array([np.abs(u).max(), np.abs(v).max(), np.abs(w * w * u + 2 * damping * w * v).max()])


@pytest.mark.parametrize(("period", "inside", "sampled"), [(0.5, 0.06825126, 0.0679169), (2.0, 0.18964375, 0.1896102)])
def test_el_centro(period: float, inside: float, sampled: float) -> None:
    result = spectrum(el_centro(), period, 0.02)
    assert float(result.displacement) == pytest.approx(inside, abs=6e-9)
    assert float(spectrum(el_centro(), period, 0.02, sampled=True).displacement) == pytest.approx(sampled, abs=6e-8)
    w = 2 * math.pi / period
    assert float(result.pseudo_velocity) == pytest.approx(w * inside, rel=1e-7)
    assert float(result.pseudo_acceleration) == pytest.approx(w * w * inside, rel=1e-7)


@pytest.mark.parametrize(("period", "published"), [(0.5, 0.0679401), (2.0, 0.1896749)])
def test_the_published_values_are_sampled_and_use_another_g(period: float, published: float) -> None:
    result = spectrum(el_centro().scaled(9.81 / 9.80665), period, 0.02, sampled=True)
    assert float(result.displacement) == pytest.approx(published, abs=6e-8)


@pytest.mark.parametrize(
    ("period", "damping"),
    [
        pytest.param(
            period, damping, marks=[] if damping == 0.05 or (period, damping) == (0.21, 1.7) else [pytest.mark.prove]
        )
        for damping in (0.0, 0.05, 1.0, 1.7)
        for period in (0.03, 0.21, 1.0, 8.0)
    ],
)
def test_all_peaks_agree_with_an_independent_solver(period: float, damping: float) -> None:
    motion = GroundMotion(el_centro().acceleration[:500], 0.02)
    result = spectrum(motion, period, damping)
    ours = np.array([result.displacement, result.velocity, result.acceleration])
    fine = independent(motion, period, damping, 40)
    assert np.all(ours >= fine * (1 - 1e-12)), "a grid cannot exceed the peak of the motion itself"
    np.testing.assert_allclose(ours, fine, rtol=2 * (2 * math.pi / period * 0.02 / 40) ** 2 / 8 + 2e-5)


def test_a_finer_step_changes_nothing() -> None:
    """Linear between samples is what the motion says, so that its refinement has the same peaks, to the last digits."""
    periods = np.geomspace(0.01, 30.0, 60)
    coarse, fine = (spectrum(m, periods, (0.0, 0.05, 0.7)) for m in (el_centro(), resampled(el_centro(), 0.02 / 7)))
    for name in ("displacement", "velocity", "acceleration"):
        np.testing.assert_allclose(getattr(coarse, name), getattr(fine, name), rtol=1e-11)


@pytest.mark.parametrize("repeats", [30, pytest.param(160, marks=pytest.mark.prove)])
def test_nor_does_it_where_responses_turn_and_turn_back_within_a_step(repeats: int) -> None:
    rng = np.random.default_rng(0)
    for _ in range(repeats):
        motion = GroundMotion(rng.standard_normal(rng.integers(3, 80)), 0.02)
        coarse, fine = (spectrum(m, np.geomspace(0.01, 20.0, 40), (0.0, 0.02, 0.3, 1.0, 3.0)) for m in (
            motion, resampled(motion, 0.02 / 9)))  # fmt: skip
        for name in ("displacement", "velocity", "acceleration"):
            np.testing.assert_allclose(getattr(coarse, name), getattr(fine, name), rtol=1e-11)


def test_a_rigid_oscillator_feels_the_ground() -> None:
    motion = el_centro()
    result = spectrum(motion, [0.0, 5e-4, 2e-3], 0.05)
    np.testing.assert_allclose(result.pseudo_acceleration, motion.pga, rtol=2e-2)
    assert result.pseudo_acceleration[0] == result.acceleration[0] == motion.pga
    assert result.displacement[0] == 0.0
    assert result.acceleration[1] == pytest.approx(motion.pga, rel=5e-3)


def test_a_very_soft_oscillator_stays_where_it_is() -> None:
    motion = corrected(el_centro())
    result = spectrum(motion, [1e4, 1e6], 0.05)
    np.testing.assert_allclose(result.displacement[1], np.abs(resampled(motion, 0.002).displacement).max(), rtol=1e-4)
    np.testing.assert_allclose(result.velocity[1], np.abs(resampled(motion, 0.0002).velocity).max(), rtol=1e-4)


def test_an_undamped_oscillator_on_a_constant_push_has_a_closed_form() -> None:
    """a_g = -p from rest: u = p/w^2 (1 - cos wt), peaks 2p/w^2, p/w and 2p; no sample stands on a peak."""
    p, period = 1.7, 0.77
    w = 2 * math.pi / period
    result = spectrum(GroundMotion(np.full(24, -p), 0.05), period, 0.0)
    expected = [2 * p / w**2, p / w, 2 * p]
    np.testing.assert_allclose(
        [result.displacement, result.velocity, result.acceleration],
        expected,
        rtol=1e-13,
    )
    assert float(spectrum(GroundMotion(np.full(24, -p), 0.05), period, 0.0, sampled=True).displacement) < expected[0]


def test_a_slow_overdamped_oscillator_on_a_constant_push_has_a_closed_form() -> None:
    p, w, zeta, t = 0.9, 2.0, 3.0, 4.0
    r1, r2 = w * (-zeta + math.sqrt(zeta**2 - 1)), w * (-zeta - math.sqrt(zeta**2 - 1))
    u = p / w**2 * (1 - (r2 * math.exp(r1 * t) - r1 * math.exp(r2 * t)) / (r2 - r1))
    result = spectrum(GroundMotion(np.full(401, p), 0.01), 2 * math.pi / w, zeta)
    assert float(result.displacement) == pytest.approx(u, rel=1e-12)


def test_what_happens_after_the_motion_is_seen_with_a_rest() -> None:
    pulse = GroundMotion(np.array([0.0, 1.0, 0.0]), 0.02)
    period = 1.0
    w = 2 * math.pi / period
    after = spectrum(padded(pulse, 1.0), period, 0.0)
    whole = 0.02 * (math.sin(w * 0.01) / (w * 0.01)) ** 2 / w  # |Fourier transform| of the triangle over w
    assert float(after.displacement) == pytest.approx(whole, rel=1e-9)
    assert float(spectrum(pulse, period, 0.0).displacement) < 0.2 * whole


def test_shapes_and_labels() -> None:
    motion = el_centro()
    both = spectrum(motion, [0.2, 0.5, 1.0], [0.02, 0.05])
    assert both.displacement.shape == (2, 3)
    assert spectrum(motion, [0.2, 0.5, 1.0]).displacement.shape == (3,)
    assert spectrum(motion, 0.5, [0.02, 0.05]).displacement.shape == (2,)
    assert spectrum(motion, 0.5).displacement.shape == ()
    data = both.to_xarray()
    assert dict(data.sizes) == {"damping": 2, "period": 3}
    assert float(data.displacement.sel(damping=0.05, period=0.5)) == both.displacement[1, 1]
    assert data.pseudo_acceleration.attrs["units"] == "m/s^2"
    assert spectrum(motion, 0.5).to_xarray().displacement.shape == (1, 1)
    given = np.array([0.2, 0.5])
    result = spectrum(motion, given)
    given[0] = 9.0
    assert result.periods[0] == 0.2, "a result does not change with what it was made from"
    one = spectrum(motion, [0.2, 0.5, 1.0], 0.02)
    np.testing.assert_array_equal(both.displacement[0], one.displacement)


@pytest.mark.parametrize(
    ("periods", "damping", "message"),
    [
        ([0.5, -1.0], 0.05, r"periods: -1 s is not allowed"),
        ([0.5, np.nan], 0.05, r"periods: nan s"),
        ([], 0.05, r"periods has shape \(0,\)"),
        ([[0.5]], 0.05, r"periods has shape \(1, 1\)"),
        (0.5, -0.01, r"damping: -0.01 is not allowed; it must be finite and at least 0"),
        (0.5, 50.0, r"damping: 50 is not allowed; it is a ratio to critical, 0.05 for 5 %"),
        (1e-6, 0.05, r"1e-06 s is too short for samples every 0.02 s; it must be 0 \(rigid\) or at least 1.7e-05 s"),
    ],
)
def test_what_makes_no_sense_is_refused(periods: object, damping: float, message: str) -> None:
    with pytest.raises(InputError, match=message):
        spectrum(el_centro(), periods, damping)
