"""Velocity and displacement of a polygon of accelerations: exact for polynomials, and peaks between samples."""

import numpy as np
import pytest

from dampyr.ground_motions.integrals import displacement, peak_displacement, peak_velocity, velocity


def test_a_constant_and_a_ramp_integrate_to_their_polynomials() -> None:
    h = 0.05
    t = h * np.arange(41)
    a = 2.0 - 3.0 * t
    np.testing.assert_allclose(velocity(a, h), 2.0 * t - 1.5 * t**2, atol=1e-14)
    np.testing.assert_allclose(displacement(a, h), t**2 - 0.5 * t**3, atol=1e-14)


def test_peaks_between_samples_are_those_of_the_polynomials() -> None:
    """a = 2 - 3 t from one sample to the next: v turns at t = 2/3, d at t = 4/3, between the samples 0, 1 and 2."""
    a = np.array([2.0, -1.0, -4.0])
    assert peak_velocity(a, 1.0) == pytest.approx(max(2.0 * 2 / 3 - 1.5 * (2 / 3) ** 2, 2.0))  # at the end it is -2
    assert peak_velocity(a[:2], 1.0) == pytest.approx(2 / 3)
    assert peak_displacement(a, 1.0) == pytest.approx((4 / 3) ** 2 - 0.5 * (4 / 3) ** 3)


def test_peaks_are_those_of_a_dense_polygon() -> None:
    a, h, parts = np.random.default_rng(3).standard_normal(60), 0.1, 400
    fine = np.interp(np.arange(59 * parts + 1) * h / parts, np.arange(60) * h, a)
    v, d = np.abs(velocity(fine, h / parts)), np.abs(displacement(fine, h / parts))
    np.testing.assert_allclose(velocity(fine, h / parts)[::parts], velocity(a, h), atol=1e-12)
    # a parabola's top lies within curvature * step^2 / 8 of the nearest sample
    assert v.max() <= peak_velocity(a, h) <= v.max() + 30.0 * (h / parts) ** 2
    assert d.max() <= peak_displacement(a, h) * (1 + 1e-12) <= d.max() + np.abs(a).max() * (h / parts) ** 2
