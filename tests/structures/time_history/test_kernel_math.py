"""Operations of the time-stepping kernel, each against numpy or a closed form."""

import numpy as np
import pytest

from dampyr.structures.time_history import kernel_math


@pytest.mark.parametrize(
    ("v0", "v1", "x1"), [(0.3, -0.2, 0.002), (-0.3, 0.1, -0.004), (0.5, -0.5, 0.0), (0.1, -2.0, -0.05)]
)
def test_a_turning_point_is_where_the_cubic_of_both_ends_has_no_slope(v0: float, v1: float, x1: float) -> None:
    x0, dt = 0.001, 0.04
    powers = [[1, 0, 0, 0], [1, 1, 1, 1], [0, 1, 0, 0], [0, 1, 2, 3]]  # of s: values and slopes at both ends
    cubic = np.polynomial.Polynomial(np.linalg.solve(powers, [x0, x1, v0 * dt, v1 * dt]))
    [inside] = [s.real for s in cubic.deriv().roots() if abs(s.imag) < 1e-12 and 0.0 < s.real < 1.0]
    s, x = kernel_math.turning_point(x0, x1, v0, v1, dt)
    assert s == pytest.approx(inside, rel=1e-9)
    assert x == pytest.approx(cubic(inside), rel=1e-9)


def test_a_peak_is_raised_between_the_ends_and_never_lowered() -> None:
    peaks, t = np.zeros(2), np.array([0.2, 0.3])  # around the crest of a sine of 1 Hz
    (x0, x1), (v0, v1) = np.sin(2 * np.pi * t), 2 * np.pi * np.cos(2 * np.pi * t)
    kernel_math.raise_peak(peaks, 1, -x0, -x1, -v0, -v1, 0.1)
    assert peaks[1] == pytest.approx(1.0, abs=2e-3)
    assert peaks[1] > x1
    kernel_math.raise_peak(peaks, 1, 0.0, 0.5, 1.0, 1.0, 0.1)
    assert peaks[0] == 0.0
    assert peaks[1] > 0.9


def test_a_quadratic_goes_through_its_three_values_and_keeps_a_parabola() -> None:
    def parabola(s: float) -> float:
        return 2.0 - 3.0 * s + 5.0 * s**2

    for s in (0.0, 0.3, 0.5, 0.9, 1.0):
        value = kernel_math.quadratic(parabola(0.0), parabola(0.5), parabola(1.0), s)
        assert value == pytest.approx(parabola(s), rel=1e-12)


def test_a_delayed_force_is_read_off_the_ring_where_it_was_written() -> None:
    """Nodes every half step of a parabola; the ring has room for eight of them and has gone round."""
    ring = np.zeros((2, 8))
    for node in range(14):
        ring[1, node % 8] = 0.25 * node**2
    for steps in (3.0, 4.2, 5.9):
        assert kernel_math.delayed_force(ring, 1, steps, 7.0) == pytest.approx(steps**2, rel=1e-12)
    assert kernel_math.delayed_force(ring, 1, 0.0, 7.0) == kernel_math.delayed_force(ring, 1, -2.0, 7.0) == 7.0


def test_products_and_equations_are_those_of_numpy() -> None:
    rng = np.random.default_rng(2)
    a, b = rng.normal(size=(4, 4)), rng.normal(size=6)
    a[0, 0] = 0.0  # rows must be exchanged
    out = np.zeros(5)
    kernel_math.multiply(a, b, out)
    np.testing.assert_allclose(out, [*(a @ b[:4]), 0.0], rtol=1e-13)
    x = b[:4].copy()
    kernel_math.solve(a.copy(), x)
    np.testing.assert_allclose(x, np.linalg.solve(a, b[:4]), rtol=1e-11)
    target = np.zeros(6)
    kernel_math.copy_into(x, target, 1)
    np.testing.assert_array_equal(target, [0.0, *x, 0.0])
