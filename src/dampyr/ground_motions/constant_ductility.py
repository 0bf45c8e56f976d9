r"""Spectra of constant ductility: how strong an oscillator that yields has to be.

.. math:: \ddot u + 2\zeta\omega\dot u + \alpha\omega^2 u + (1-\alpha)\omega^2 s = -a_g(t), \qquad |s| \le u_y, \quad
          \dot s = \dot u \text{ or } 0, \qquad \mu = \max_t |u| / u_y

s is the elastic part of the spring, :math:`\alpha` the share of the stiffness that is left when it yields (0: elastic and
perfectly plastic), and :math:`A_y = \omega^2 u_y` the strength over the mass. The damping coefficient is that of the elastic
oscillator and stays. At a ductility of 1 :math:`A_y` is the elastic pseudo-acceleration; :math:`R_y = S_a/A_y` is how much
weaker the yielding oscillator may be ([Chopra2017]_ of `response_spectrum`, chapter 7).

The response is exact for a ground that is linear between its samples, as of `spectrum`: within a branch by the series of the
solution, and the instants of yielding and of turning are found in it. Ductility over strength is no monotone function: several
strengths may lead to the same one. The largest is taken, sought downwards from the elastic one in steps of 2 % and then by
bisection; ``several`` says where smaller ones lead to it, too, so far as they were looked at (to twice the largest ductility).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.findings import Finding
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.oscillator import oscillator_peaks
from dampyr.ground_motions.response_spectrum import STANDARD_PERIODS
from dampyr.shown import Shown
from dampyr.units import in_si

Array = NDArray[np.float64]
DOWN = 0.98  # the strengths that are tried, from one to the next
LEAST_STRENGTH = 1e-3  # of the elastic one
BEYOND = 2.0  # times the largest ductility: to there strengths are tried
BISECTIONS = 26  # of 2 %: 3e-10
STEP_LIMIT = 0.3  # of (omega + 2 zeta omega) h within a branch
SERIES = 14
MAX_DUCTILITY = 50.0


@dataclass(frozen=True, eq=False, repr=False)
class InelasticSpectrum(Shown):
    """Strengths and displacements of oscillators of given ductilities, each array (d ductilities, p periods).

    Where no strength down to a thousandth of the elastic one leads to a ductility, its numbers are NaN.
    """

    periods: Array  # (p,) s
    ductility: Array  # (d,)
    damping: float  # ratio to critical, of the elastic oscillator
    hardening: float  # stiffness after yielding over the elastic one
    strength: Array  # (d, p) A_y, m/s2: the force at which it yields over its mass
    displacement: Array  # (d, p) m, the largest, relative to the ground
    elastic: Array  # (p,) m/s2, pseudo-acceleration of the elastic oscillator
    several: NDArray[np.bool_]  # (d, p) whether smaller strengths have the same ductility
    motion: str = ""  # the name of the ground motion

    @property
    def reduction(self) -> Array:
        """R_y (d, p): the elastic pseudo-acceleration over the strength."""
        return np.asarray(self.elastic / self.strength)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Where several strengths have one ductility, and where none has it."""
        found = []
        count, size = int(self.several.sum()), self.several.size
        if count:
            found.append(
                Finding(
                    "note",
                    f"at {count} of {size} ductilities and periods weaker oscillators have the same ductility; the "
                    "strongest is taken",
                )
            )
        missing = int(np.isnan(self.strength).sum())
        if missing:
            found.append(
                Finding(
                    "doubt",
                    f"at {missing} of {size} ductilities and periods no strength down to {LEAST_STRENGTH:g} of the elastic "
                    "one has the ductility; leave out the shortest periods or lower the ductility",
                )
            )
        return tuple(found)


def inelastic_spectrum(
    motion: GroundMotion,
    ductility: ArrayLike = (1.0, 2.0, 4.0),
    periods: ArrayLike = STANDARD_PERIODS,
    damping: float = 0.05,
    hardening: float = 0.0,
) -> InelasticSpectrum:
    """The strengths that limit the ductility of an oscillator under a ground motion.

    Parameters
    ----------
    motion
        The motion of the ground; it ends with its last sample, as for `spectrum`.
    ductility
        The largest displacement over that at yielding, a number or ``(d,)``, 1 to 50.
    periods
        Undamped natural periods of the elastic oscillator in s, a number or ``(p,)``, greater than 0.
    damping
        Ratio to critical of the elastic oscillator, less than 1.
    hardening
        The stiffness after yielding over the elastic one, from 0 to less than 1.

    Raises
    ------
    InputError
        A ductility, a period, the damping or the hardening makes no sense.

    Examples
    --------
    >>> import dampyr as dp
    >>> found = dp.ground_motions.inelastic_spectrum(dp.ground_motions.el_centro(), [1.0, 4.0], [0.5, 1.0])
    >>> found.strength.round(2).tolist()
    [[9.01, 4.46], [1.76, 1.01]]
    """
    from dampyr.models.codegen.kernels import compile_cached

    mu = np.atleast_1d(np.array(in_si(ductility, "dimensionless", "ductility"), dtype=float))
    T = np.atleast_1d(np.array(in_si(periods, "s", "periods"), dtype=float))
    damping, hardening = (
        float(in_si(damping, "dimensionless", "damping")),
        float(in_si(hardening, "dimensionless", "hardening")),
    )
    _check(mu, T, damping, hardening)
    a = np.array(motion.acceleration)
    elastic_displacement = np.atleast_1d(oscillator_peaks(a, motion.dt, T, np.array(damping))[0])
    if not np.any(a):
        raise InputError(f"{motion.name} is 0 throughout, so that no oscillator yields; take another one")
    order = np.argsort(mu)
    strength, largest = np.full((len(mu), len(T)), np.nan), np.full((len(mu), len(T)), np.nan)
    times = np.zeros((len(mu), len(T)))
    compile_cached(fill_strengths)(
        a, motion.dt, 2 * np.pi / T, damping, hardening, mu[order], elastic_displacement, strength, largest, times
    )
    back = np.argsort(order)
    omega2 = (2 * np.pi / T) ** 2
    return InelasticSpectrum(
        T, mu, damping, hardening, omega2 * strength[back], largest[back], omega2 * elastic_displacement, times[back] > 1.5,
        motion.name,
    )  # fmt: skip


def _check(mu: Array, T: Array, damping: float, hardening: float) -> None:
    if mu.ndim != 1 or not mu.size or not np.all(np.isfinite(mu) & (mu >= 1.0) & (mu <= MAX_DUCTILITY)):
        raise InputError(f"ductility = {mu.tolist()} is not allowed; give numbers from 1 to {MAX_DUCTILITY:g}")
    if T.ndim != 1 or not T.size or not np.all(np.isfinite(T) & (T > 0.0)):
        raise InputError(f"periods = {T.tolist()} are not allowed; they must be finite and greater than 0, in s")
    if not 0.0 <= damping < 1.0:
        raise InputError(f"damping = {damping:g} is not allowed; it must be from 0 to less than 1 (0.05 for 5 %)")
    if not 0.0 <= hardening < 1.0:
        raise InputError(f"hardening = {hardening:g} is not allowed; it must be from 0 to less than 1 (0.03 for 3 %)")


def motion_within(u: float, v: float, force: float, slope: float, c: float, k: float, t: float) -> tuple[float, float]:
    """Displacement and velocity ``t`` s after (u, v) of u'' + c u' + k u = force + slope t."""
    x, y = u + v * t, v
    before, last = v, force - c * v - k * u
    power, jerk = 1.0, slope
    for n in range(1, SERIES):
        power *= t / n
        y += last * power
        x += last * power * t / (n + 1)
        before, last = last, jerk - c * last - k * before
        jerk = 0.0
    return x, y


def crossing(
    u: float, v: float, force: float, slope: float, c: float, k: float, t: float, level: float, of_velocity: bool
) -> float:
    """The time in (0, t] at which the displacement, or the velocity, crosses ``level``, between which it is on either side."""
    low, high = 0.0, t
    start = (v if of_velocity else u) - level
    for _ in range(60):
        middle = 0.5 * (low + high)
        x, y = motion_within(u, v, force, slope, c, k, middle)
        if ((y if of_velocity else x) - level) * start > 0.0:
            low = middle
        else:
            high = middle
        if high - low <= 1e-12 * t:
            break
    return high


def step_map(c: float, k: float, t: float) -> tuple[float, float, float, float, float, float, float, float]:
    """Displacement and velocity after ``t`` s from a unit displacement, velocity, force and slope, for whole parts."""
    uu, vu = motion_within(1.0, 0.0, 0.0, 0.0, c, k, t)
    uv, vv = motion_within(0.0, 1.0, 0.0, 0.0, c, k, t)
    uf, vf = motion_within(0.0, 0.0, 1.0, 0.0, c, k, t)
    us, vs = motion_within(0.0, 0.0, 0.0, 1.0, c, k, t)
    return uu, vu, uv, vv, uf, vf, us, vs


def largest_displacement(a: Array, h: float, omega: float, zeta: float, alpha: float, uy: float) -> float:
    """The largest displacement of an oscillator that yields at ``uy``, from rest through the whole motion."""
    c, k = 2 * zeta * omega, omega * omega
    parts = max(1, int(np.ceil(omega * (1 + 2 * zeta) * h / STEP_LIMIT)))
    s = h / parts
    whole, yielding = step_map(c, k, s), step_map(c, alpha * k, s)
    u = v = plastic = peak = 0.0  # s of the docstring is u - plastic
    branch = 0  # 1, -1: yielding upwards, downwards
    for n in range(len(a) - 1):
        slope = -(a[n + 1] - a[n]) / h
        for m in range(parts):
            p = -a[n] + slope * (m * s)
            left = s
            for _ in range(20):  # events in one part
                if branch == 0:
                    kk, offset = k, (1 - alpha) * k * plastic
                else:
                    kk, offset = alpha * k, -(1 - alpha) * k * uy * branch
                if left == s:
                    uu, vu, uv, vv, uf, vf, us, vs = whole if branch == 0 else yielding
                    f = p + offset
                    u1, v1 = uu * u + uv * v + uf * f + us * slope, vu * u + vv * v + vf * f + vs * slope
                else:
                    u1, v1 = motion_within(u, v, p + offset, slope, c, kk, left)
                t, event = left, 0
                if v * v1 < 0.0:  # it turns
                    t = crossing(u, v, p + offset, slope, c, kk, left, 0.0, True)
                    u1, v1 = motion_within(u, v, p + offset, slope, c, kk, t)
                    v1, event = 0.0, 1
                if branch == 0 and abs(u1 - plastic) > uy:  # on the way to there it yields
                    side = 1.0 if u1 > plastic else -1.0
                    t = crossing(u, v, p + offset, slope, c, kk, t, plastic + side * uy, False)
                    u1, v1 = motion_within(u, v, p + offset, slope, c, kk, t)
                    event = 2
                    branch = 1 if side > 0 else -1
                elif branch != 0 and (event == 1 or v1 * branch < 0.0):
                    plastic, branch = u1 - branch * uy, 0
                u, v, p, left = u1, v1, p + slope * t, left - t
                peak = max(peak, abs(u))
                if event == 0 or left <= 0.0:
                    break
    return peak


def ductility_of(a: Array, h: float, omega: float, zeta: float, alpha: float, uy: float) -> float:
    """The largest displacement over that at yielding."""
    return largest_displacement(a, h, omega, zeta, alpha, uy) / uy


def fill_strengths(
    a: Array, h: float, omegas: Array, zeta: float, alpha: float, wanted: Array, elastic: Array, strength: Array,
    largest: Array, times: Array,
) -> None:  # fmt: skip
    """Fill ``strength`` (d, p), the displacement at yielding, ``largest``, that of the motion, and ``times``, how many
    strengths have the ductility. ``wanted`` (d,) rise; ``elastic`` (p,) are displacements of oscillators that do not yield."""
    for j in range(len(omegas)):
        above, mu_above = elastic[j], 1.0
        for d in range(len(wanted)):
            if wanted[d] <= 1.0:
                strength[d, j] = largest[d, j] = elastic[j]
                times[d, j] = 1.0
        while above > LEAST_STRENGTH * elastic[j] and mu_above < BEYOND * wanted[-1]:
            below = DOWN * above
            mu_below = ductility_of(a, h, omegas[j], zeta, alpha, below)
            for d in range(len(wanted)):
                if wanted[d] > 1.0 and (mu_above - wanted[d]) * (mu_below - wanted[d]) <= 0.0 and mu_above != wanted[d]:
                    times[d, j] += 1.0
                    if times[d, j] == 1.0:
                        low, high = below, above
                        for _ in range(BISECTIONS):
                            middle = 0.5 * (low + high)
                            if ductility_of(a, h, omegas[j], zeta, alpha, middle) < wanted[d]:
                                high = middle
                            else:
                                low = middle
                        strength[d, j] = low
                        largest[d, j] = largest_displacement(a, h, omegas[j], zeta, alpha, low)
            above, mu_above = below, mu_below
