"""Closed forms: sines, ramps and triangles; Arias (1970), Trifunac and Brady (1975), EPRI NP-5930 (1988)."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, el_centro, measures, spectrum
from dampyr.ground_motions.intensity_measures import (
    arias,
    cumulative_absolute_velocity,
    husid,
    pgd,
    pgv,
    sa,
    significant_duration,
)

G = 9.80665


def test_a_long_sine() -> None:
    """a = A sin(wt) over whole cycles: I = pi A^2 T/(4g), CAV = 2AT/pi, PGV = 2A/w, and the ground drifts at A/w."""
    A, f, T = 2.0, 1.25, 40.0
    w = 2 * math.pi * f
    motion = GroundMotion(A * np.sin(w * np.arange(40001) * 0.001), 0.001)
    assert arias(motion) == pytest.approx(math.pi * A**2 * T / (4 * G), rel=2e-5)
    assert cumulative_absolute_velocity(motion) == pytest.approx(2 * A * T / math.pi, rel=1e-5)
    assert pgv(motion) == pytest.approx(2 * A / w, rel=1e-5)
    assert motion.displacement[-1] == pytest.approx(A / w * T, rel=1e-5)
    assert significant_duration(motion) == pytest.approx(0.9 * T, rel=1e-3)
    assert significant_duration(motion, 0.05, 0.75) == pytest.approx(0.7 * T, rel=1e-2)


def test_a_ramp_inside_its_only_steps() -> None:
    """a = t from 0 to 1 in two samples: the Husid curve is t^3, so 5 % and 95 % stand at the cube roots."""
    ramp = GroundMotion(np.array([0.0, 1.0]), 1.0)
    assert arias(ramp) == pytest.approx(math.pi / (2 * G) / 3, rel=1e-14)
    assert significant_duration(ramp) == pytest.approx(0.95 ** (1 / 3) - 0.05 ** (1 / 3), rel=1e-13)
    assert significant_duration(ramp, 0.0, 1.0) == pytest.approx(1.0, rel=1e-13)
    assert cumulative_absolute_velocity(ramp) == 0.5
    assert ramp.velocity[-1] == 0.5
    assert ramp.displacement[-1] == pytest.approx(1 / 6, rel=1e-15)


def test_peaks_between_the_samples() -> None:
    """a = 1 - 4t/3 on [0, 3], two samples: v = t - 2t^2/3 peaks at 3/4, d = t^2/2 - 2t^3/9 turns at 3/2."""
    fall = GroundMotion(np.array([1.0, -3.0]), 3.0)
    assert fall.velocity[-1] == -3.0
    assert pgv(fall) == 3.0
    assert pgd(fall) == pytest.approx(1.5, rel=1e-15)  # at the end: 9/2 - 6 = -1.5, beyond the 3/8 at the turn
    short = GroundMotion(np.array([1.0, -1.0]), 1.0)
    assert pgv(short) == pytest.approx(0.25, rel=1e-15)
    assert pgd(GroundMotion(np.array([1.0, -2.0]), 2.0)) == pytest.approx(8 / 27, rel=1e-14)  # t = 4/3, the end is at 0


def test_integrals_agree_with_quadrature_of_a_real_record() -> None:
    motion = GroundMotion(el_centro().acceleration[:120], 0.02)
    time, a = motion.time, motion.acceleration

    def integral(of: object) -> float:
        pieces = [quad(of, t0, t1)[0] for t0, t1 in pairwise(time)]
        return float(np.sum(pieces))

    assert motion.velocity[-1] == pytest.approx(integral(lambda t: np.interp(t, time, a)), rel=1e-10)
    end = time[-1]
    assert motion.displacement[-1] == pytest.approx(integral(lambda t: (end - t) * np.interp(t, time, a)), rel=1e-10)
    assert arias(motion) == pytest.approx(math.pi / 2 / G * integral(lambda t: np.interp(t, time, a) ** 2), rel=1e-10)
    fine = np.interp(np.arange(119 * 2000 + 1) * 1e-5, time, a)
    assert cumulative_absolute_velocity(motion) == pytest.approx(np.trapezoid(np.abs(fine), dx=1e-5), rel=1e-6)
    assert pgv(motion) == pytest.approx(np.abs(np.cumsum(fine)).max() * 1e-5, rel=1e-4)


def test_el_centro_has_the_measures_that_are_known() -> None:
    """Chopra, Dynamics of Structures, figure 6.1.4: 0.319 g, 13.04 in/s, 8.40 in, after his baseline correction."""
    intensity_measures = measures(el_centro())
    assert intensity_measures.pga == pytest.approx(0.319 * G, rel=2e-3)
    assert intensity_measures.pgv == pytest.approx(13.04 * 0.0254, rel=0.1)
    assert intensity_measures.pgd == pytest.approx(8.40 * 0.0254, rel=0.01)
    assert intensity_measures.arias == pytest.approx(husid(el_centro())[-1])
    assert 24.0 > intensity_measures.duration_5_95 > intensity_measures.duration_5_75 > 0


def test_sa_is_that_of_the_spectrum() -> None:
    assert sa(el_centro(), 0.5, 0.02) == float(spectrum(el_centro(), [0.5], 0.02).pseudo_acceleration[0])


def test_rest_has_no_duration_to_speak_of() -> None:
    rest = GroundMotion(np.zeros(5), 0.1, name="rest")
    intensity_measures = measures(rest)
    assert (intensity_measures.arias, intensity_measures.duration_5_95, intensity_measures.pgd) == (0.0, 0.0, 0.0)
    with pytest.raises(InputError, match="rest: all samples are 0"):
        significant_duration(rest)
    with pytest.raises(InputError, match=r"shares 0\.9 to 0\.1 are not allowed"):
        significant_duration(el_centro(), 0.9, 0.1)
