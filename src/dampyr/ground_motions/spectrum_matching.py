r"""A ground motion changed until its spectrum is that of a code, by wavelets in time that leave no drift.

To the acceleration, scaled by least squares first, short wavelets are added, each where an oscillator of a period has its peak
([AlAtikAbrahamson2010]_, the improved tapered cosine):

.. math:: f_j(t) = \cos\big(\omega'_j(t - t_j + \Delta t_j)\big)\, e^{-\left((t - t_j + \Delta t_j)/\gamma_j\right)^2}, \quad
          \omega'_j = \omega_j\sqrt{1-\zeta^2}, \quad
          \Delta t_j = \frac{\arctan(\sqrt{1-\zeta^2}/\zeta)}{\omega'_j}, \quad \gamma_j = 1.178\, f_j^{-0.93}

with :math:`f_j = \omega_j/2\pi` in Hz. Their sizes b solve :math:`(C^T C + \lambda^2) b = C^T r`, C being what each wavelet
adds to each peak, relative to the code, and r what is wanted there; peaks nearly as large as the largest one of an oscillator
have a row and a wavelet of their own, so that they do not take its place. :math:`\lambda` follows Levenberg and Marquardt.
Peaks are those inside the steps. Where the spectrum between the periods is still off, those there are matched too, in another
round.

The paper itself was not read: its equations (14), (16) and (17) are those of a public program that names them.

Wavelets rise from and fall to 0 at the ends of the record, and a parabola is taken off them and off the record
(`dampyr.ground_motions.baseline`): velocity and displacement end at 0. Changing Fourier amplitudes instead is simpler, and it
spreads each change over the whole record; wavelets leave its quiet parts quiet.

What is matched is a spectrum and nothing else. A spectrum of a code is that of no earthquake: over a wide range of periods a
matched motion has more energy (`arias_ratio`) than the recorded one had, and its response scatters less.

References
----------
.. [AlAtikAbrahamson2010] L. Al Atik and N. Abrahamson, "An improved method for nonstationary spectral matching", Earthquake
   Spectra 26(3), 601-617, 2010.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.findings import Finding
from dampyr.ground_motions.baseline import corrected
from dampyr.ground_motions.design_spectra import DesignSpectrum, TableSpectrum, scaled_to_design
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.oscillator import oscillator_peaks
from dampyr.shown import Shown
from dampyr.units import in_si

Array = NDArray[np.float64]
PER_DECADE = 110  # periods that are matched: closer than a peak of 5 % damping is wide
LEAST_PERIODS = 10
CHECKED = 3  # times as many periods are checked
AIM = 0.6  # of the tolerance, at the periods that are matched: between them the spectrum is a little further off
NEAR = (0.95, 0.9, 0.95, 0.9)  # of the code: smaller peaks have no row; of one round after the other
SHORTEST = 4.0  # samples: an oscillator that is shorter does not see what is between them
EDGE, EDGE_SHARE = 1.0, 0.05  # s and share of the record over which wavelets rise and fall at its ends
DAMPED, LEAST_DAMPED, MORE, LESS, TRIES = 0.1, 1e-3, 2.5, 0.5, 10  # lambda: its start and least, and how it follows
NORM = 6  # the power of the ratios less 1 whose sum a step has to lower
RECENT = 4  # steps, below the largest sum of which it has to be, so that a single one may go up
MAX_DESIGN_DAMPING = 0.5


@dataclass(frozen=True, eq=False, repr=False)
class MatchedMotion(Shown):
    """A motion whose spectrum was matched, beside what it was.

    Attributes
    ----------
    motion
        The matched motion, at rest at its end.
    scaled
        The recorded one, its baseline corrected, scaled to the code by least squares and not matched.
    design
        The spectrum that was wanted.
    periods
        (p,) s, those that were checked, from the shortest to the longest.
    before, after, wanted
        (p,) pseudo-accelerations of ``scaled``, of ``motion`` and of the code, m/s2.
    tolerance
        How far from the code ``after`` may be, as a share of it.
    iterations
        How many steps were taken.
    """

    motion: GroundMotion
    scaled: GroundMotion
    design: DesignSpectrum | TableSpectrum
    periods: Array
    before: Array
    after: Array
    wanted: Array
    tolerance: float
    iterations: int

    @property
    def residual(self) -> float:
        """The largest deviation of the matched spectrum from the code's, a share of it."""
        return float(np.max(np.abs(self.after / self.wanted - 1.0)))

    @property
    def residual_before(self) -> float:
        """The same of the motion that was only scaled."""
        return float(np.max(np.abs(self.before / self.wanted - 1.0)))

    @property
    def mean_residual(self) -> float:
        """The mean deviation, a share of the code."""
        return float(np.mean(np.abs(self.after / self.wanted - 1.0)))

    @property
    def converged(self) -> bool:
        """Whether the residual is within the tolerance."""
        return self.residual <= self.tolerance

    @property
    def arias_ratio(self) -> float:
        """The integral of the squared acceleration over that of the motion that was only scaled."""
        own, other = (np.asarray(motion.acceleration) for motion in (self.motion, self.scaled))
        return float(own @ own / (other @ other))

    @property
    def findings(self) -> tuple[Finding, ...]:
        """That the spectrum is not matched within the tolerance, where it is not."""
        if self.converged:
            return ()
        worst = float(self.periods[np.argmax(np.abs(self.after / self.wanted - 1.0))])
        return (
            Finding(
                "doubt",
                f"the spectrum is off by up to {100 * self.residual:.3g} % of {self.design.name}, at {worst:.3g} s, and "
                f"{100 * self.tolerance:g} % were wanted; take a record whose spectrum is nearer to it, or fewer periods",
            ),
        )


def matched_to_design(
    motion: GroundMotion,
    design: DesignSpectrum | TableSpectrum,
    low: float,
    high: float,
    tolerance: float = 0.05,
    iterations: int = 100,
) -> MatchedMotion:
    """A motion whose spectrum is that of a code, or of a table, between two periods.

    Parameters
    ----------
    motion
        The record to begin with: the nearer its spectrum is to the code's, the less is changed.
    design
        The wanted spectrum, from `eurocode_8`, `asce_7` or `TableSpectrum`; its damping is the oscillators'.
    low, high
        The shortest and the longest period, s; the former four samples of the motion at least.
    tolerance
        How far off the spectrum may be, a share of the code's, 0.001 to 0.5.
    iterations
        Steps at most, 1 to 1000.

    Returns
    -------
    MatchedMotion
        ``motion`` is the matched one. Where the tolerance was not reached it is the nearest that was found, and ``converged``
        and ``findings`` say so.

    Raises
    ------
    InputError
        The periods are no range, or shorter than the samples or longer than the record allow; the motion is 0 throughout.

    Examples
    --------
    >>> import dampyr as dp
    >>> gm = dp.ground_motions
    >>> found = gm.matched_to_design(gm.el_centro(), gm.eurocode_8(ag=2.943, ground="C"), 0.1, 4.0)
    >>> found.converged, found.residual < 0.05, found.residual_before > 0.3
    (True, True, True)
    """
    low, high = in_si(low, "s", "the shortest period"), in_si(high, "s", "the longest period")
    _check(motion, design, low, high, tolerance, iterations)
    scaled = scaled_to_design(corrected(motion), design, low, high)
    matching = _Matching(scaled, design, low, high)
    best, least, steps = matching.start, math.inf, 0
    for near in NEAR:
        found, taken = matching.run(best, near, AIM * tolerance, iterations - steps)
        steps += taken
        off = np.abs(matching.ratio(found, matching.checked) - 1.0)
        if off.max() < least:
            least, best = float(off.max()), found
        if least <= tolerance or steps >= iterations:
            break
        matching.add(matching.checked[off > AIM * tolerance])
    note = (
        f"matched to {design.name} at {100 * design.damping:g} % damping from {low:g} to {high:g} s by wavelets, the largest "
        f"deviation {100 * least:.3g} %"
    )
    matched = replace(scaled.changed(best, note), name=f"{motion.name}, matched")
    T, wanted = matching.checked, design.at(matching.checked)
    before, after = (wanted * matching.ratio(a, T) for a in (np.asarray(scaled.acceleration), best))
    return MatchedMotion(matched, scaled, design, T, before, after, wanted, tolerance, steps)


def _check(
    motion: GroundMotion, design: DesignSpectrum | TableSpectrum, low: float, high: float, tolerance: float, steps: int
) -> None:
    if not 0.0 < low < high:
        raise InputError(
            f"the periods from {low:g} to {high:g} s are no range; give the shorter one first, greater than 0"
        )
    if low < SHORTEST * motion.dt * (1 - 1e-9):
        raise InputError(
            f"the shortest period, {low:g} s, is less than {SHORTEST:g} samples of {motion.name} ({motion.dt:g} s each); give "
            f"{SHORTEST * motion.dt:g} s or more, or resample it first"
        )
    if high > motion.duration:
        raise InputError(
            f"the longest period, {high:g} s, is longer than {motion.name}, {motion.duration:g} s; give a shorter one"
        )
    if design.damping > MAX_DESIGN_DAMPING:
        raise InputError(
            f"the damping of {design.name} is {design.damping:g}; wavelets are for {MAX_DESIGN_DAMPING:g} at most"
        )
    if not 0.001 <= tolerance <= 0.5:
        raise InputError(
            f"tolerance = {tolerance!r} is not allowed; it must be from 0.001 to 0.5, a share of the spectrum"
        )
    if isinstance(steps, bool) or steps != int(steps) or not 1 <= steps <= 1000:
        raise InputError(f"iterations = {steps!r} is not allowed; it must be a whole number from 1 to 1000")


class _Matching:
    """The oscillators of the periods that are matched, and what one sample of the ground does to each of them later."""

    def __init__(self, motion: GroundMotion, design: DesignSpectrum | TableSpectrum, low: float, high: float) -> None:
        count = max(LEAST_PERIODS, math.ceil(PER_DECADE * math.log10(high / low)) + 1)
        self.start, self.dt, self.design, self.zeta = np.array(motion.acceleration), motion.dt, design, design.damping
        self.checked = np.geomspace(low, high, CHECKED * (count - 1) + 1)
        self.time = motion.time
        reach = min(EDGE, EDGE_SHARE * motion.duration)
        rise = np.clip(np.minimum(self.time, motion.duration - self.time) / reach, 0.0, 1.0)
        self.window = np.sin(0.5 * np.pi * rise) ** 2
        self._match(np.geomspace(low, high, count))

    def add(self, periods: Array) -> None:
        """Match these periods, s, too."""
        self._match(np.union1d(self.periods, periods))

    def _match(self, periods: Array) -> None:
        self.periods, self.omegas = periods, 2 * np.pi / periods
        hats = hat_responses(self.omegas, self.zeta, self.dt, len(self.start))
        self.hats = hats * (self.omegas**2 / self.design.at(periods))[:, None]

    def ratio(self, acceleration: Array, periods: Array) -> Array:
        """The spectrum of an acceleration over the code's."""
        peaks = oscillator_peaks(acceleration, self.dt, periods, np.array(self.zeta))[-1]
        return np.asarray(peaks / self.design.at(periods))

    def run(self, start: Array, near: float, aim: float, iterations: int) -> tuple[Array, int]:
        """The nearest acceleration that steps from ``start`` lead to, and how many were taken."""
        a, damped = start, DAMPED
        ratio = self.ratio(a, self.periods)
        best, least, recent = a, math.inf, [_norm(ratio)]
        for step in range(iterations):
            off = float(np.max(np.abs(ratio - 1.0)))
            if off < least:
                best, least = a, off
            if off <= aim:
                return best, step
            wavelets, effects, wanted = self._system(a, ratio, near)
            sizes = np.linalg.norm(effects, axis=0)
            C = effects / sizes
            for _ in range(TRIES):
                b = np.linalg.solve(C.T @ C + damped**2 * np.eye(len(sizes)), C.T @ wanted) / sizes
                trial = a + corrected(GroundMotion(wavelets.T @ b, self.dt)).acceleration
                trial_ratio = self.ratio(trial, self.periods)
                if _norm(trial_ratio) < max(recent):
                    break
                damped *= MORE
            else:
                return best, step
            a, ratio, damped = trial, trial_ratio, max(LESS * damped, LEAST_DAMPED)
            recent = [*recent[1 - RECENT :], _norm(ratio)]
        off = float(np.max(np.abs(ratio - 1.0)))
        return (a if off < least else best), iterations

    def _system(self, a: Array, ratio: Array, near: float) -> tuple[Array, Array, Array]:
        """Wavelets (k, n), what each adds to each peak (k, k), and what is wanted there (k,), relative to the code."""
        from scipy.signal import fftconvolve

        n = len(a)
        responses = fftconvolve(a[None], self.hats, axes=1)[:, :n]
        wavelets, rows, wanted = [], [], []
        for omega, hat, response, own in zip(self.omegas, self.hats, responses, ratio, strict=True):
            size = np.abs(response)
            largest = int(np.argmax(size))
            level = size * own / size[largest]  # at samples; the peak itself may lie between two
            turns = np.flatnonzero((size[1:-1] >= size[:-2]) & (size[1:-1] > size[2:])) + 1
            others = [int(k) for k in turns if k != largest and level[k] > near]
            for k in [largest, *others]:
                sign = np.sign(response[k])
                row = np.zeros(n)
                row[: k + 1] = sign * hat[k::-1]
                rows.append(row)
                wavelets.append(sign * wavelet(self.time, self.time[k], omega, self.zeta) * self.window)
                wanted.append(1.0 - level[k] if k == largest or level[k] > 1.0 else 0.0)
        shapes = np.array(wavelets)
        return shapes, np.array(rows) @ shapes.T, np.array(wanted)


def _norm(ratio: Array) -> float:
    return float(np.sum(np.abs(ratio - 1.0) ** NORM))


def wavelet(t: Array, peak: float, omega: float, zeta: float) -> Array:
    """The tapered cosine (n,) to which an oscillator answers most at the time ``peak``."""
    root = math.sqrt(1.0 - zeta**2)
    s = t - peak + math.atan2(root, zeta) / (omega * root)
    width = 1.178 * (omega / (2 * math.pi)) ** -0.93
    return np.asarray(np.cos(omega * root * s) * np.exp(-((s / width) ** 2)))


def hat_responses(omegas: Array, zeta: float, h: float, n: int) -> Array:
    r"""Displacements (p, n) of oscillators at samples from the time on at which one sample of the ground alone is 1.

    The ground is linear between its samples, so that it is a hat of two ramps up and one down twice as steep; of a ramp t

    .. math:: R(t) = -\frac{1}{\omega^2}\Big(t - \frac{2\zeta}{\omega} +
              e^{-\zeta\omega t}\Big[\frac{2\zeta}{\omega}\cos\omega' t + \frac{2\zeta^2 - 1}{\omega'}\sin\omega' t\Big]\Big)
    """
    t, w = h * np.arange(n + 1), omegas[:, None]
    damped = w * math.sqrt(1.0 - zeta**2)
    swing = 2 * zeta / w * np.cos(damped * t) + (2 * zeta**2 - 1) / damped * np.sin(damped * t)
    ramp = -(t - 2 * zeta / w + np.exp(-zeta * w * t) * swing) / w**2
    hats = ramp[:, 1:] - 2 * ramp[:, :-1]
    hats[:, 1:] += ramp[:, :-2]
    return np.asarray(hats / h)
