"""RotD50 and RotD100 by D. M. Boore, Bulletin of the Seismological Society of America 100(4), 1830-1835, 2010."""

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, kanai_tajimi, rotated_spectrum, spectrum

FINE = 40  # parts of a step: a sampled peak is then at most (0.2/40)^2/8 off


@pytest.fixture(scope="module")
def pair():
    """Two components of 2.5 s, one stronger."""
    return tuple(kanai_tajimi(2.5, 0.01, seed=(3, k), pga=pga, rest=0.0) for k, pga in ((1, 3.0), (2, 1.7)))


def brute_force(first, second, period, damping):
    """Every angle by itself: the oscillator as a filter with a first-order hold, and its largest fine sample."""
    omega = 2 * np.pi / period
    fine = np.arange((first.n - 1) * FINE + 1) * first.dt / FINE
    b, a, _ = cont2discrete(([-1.0], [1.0, 2 * damping * omega, omega**2]), first.dt / FINE, method="foh")
    peaks = []
    for degree in range(180):
        angle = np.deg2rad(degree)
        rotated = np.cos(angle) * first.acceleration + np.sin(angle) * second.acceleration
        peaks.append(omega**2 * np.abs(lfilter(np.ravel(b), a, np.interp(fine, first.time, rotated))).max())
    return np.array(peaks)


@pytest.mark.parametrize(("period", "damping"), [(0.3, 0.05), (1.1, 0.02)])
def test_it_is_that_of_every_angle_by_itself(pair, period, damping):
    peaks = brute_force(*pair, period, damping)
    ours = rotated_spectrum(*pair, [period], damping)
    for value, expected in ((ours.rotd00, peaks.min()), (ours.rotd50, np.median(peaks)), (ours.rotd100, peaks.max())):
        assert value[0] == pytest.approx(expected, rel=2e-5)
    assert abs(ours.angle[0] - np.argmax(peaks)) <= 1


@pytest.mark.parametrize("period", [0.03, 0.3])
def test_each_angle_is_the_spectrum_of_the_rotated_motion_to_the_last_digits(pair, period):
    """Peaks inside the steps, too, where no end of a step reaches the least peak of all angles."""
    a, b = (np.asarray(motion.acceleration) for motion in pair)
    peaks = np.array([
        float(spectrum(GroundMotion(np.cos(t) * a + np.sin(t) * b, pair[0].dt), period).pseudo_acceleration)
        for t in np.deg2rad(np.arange(180))
    ])  # fmt: skip
    ours = rotated_spectrum(*pair, [period])
    assert ours.rotd00[0] == pytest.approx(peaks.min(), rel=1e-12)
    assert ours.rotd50[0] == pytest.approx(np.median(peaks), rel=1e-12)
    assert ours.rotd100[0] == pytest.approx(peaks.max(), rel=1e-12)


def test_it_does_not_depend_on_how_the_instrument_was_turned(pair):
    c, s = np.cos(np.deg2rad(37)), np.sin(np.deg2rad(37))
    a, b = (motion.acceleration for motion in pair)
    turned = [GroundMotion(values, pair[0].dt) for values in (c * a + s * b, c * b - s * a)]
    before, after = rotated_spectrum(*pair, [0.0, 0.2, 1.0]), rotated_spectrum(*turned, [0.0, 0.2, 1.0])
    np.testing.assert_allclose(after.rotd50, before.rotd50, rtol=1e-9)
    np.testing.assert_allclose(after.rotd100, before.rotd100, rtol=1e-9)
    assert (before.angle - after.angle) % 180 == pytest.approx(37)


def test_at_period_0_it_is_the_ground(pair):
    """One sample in the first direction and one of the same size across: every angle has the larger share of the two."""
    first = GroundMotion([0.0, 2.0, 0.0, 0.0], 0.01)
    second = GroundMotion([0.0, 0.0, 2.0, 0.0], 0.01)
    ours = rotated_spectrum(first, second, 0.0)
    angles = np.deg2rad(np.arange(180))
    shares = 2.0 * np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    assert ours.rotd50[0] == pytest.approx(np.median(shares))
    assert (ours.rotd00[0], ours.rotd100[0]) == (pytest.approx(np.sqrt(2.0)), 2.0)


def test_components_of_two_recordings_are_refused(pair):
    with pytest.raises(InputError, match="give two components of one recording"):
        rotated_spectrum(pair[0], kanai_tajimi(5.0, 0.01, seed=1, pga=1.0))
    with pytest.raises(InputError, match="periods: -1 s is not allowed"):
        rotated_spectrum(*pair, [-1.0])
