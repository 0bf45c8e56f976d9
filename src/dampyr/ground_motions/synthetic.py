r"""Synthetic ground motions: white noise, an envelope, the ground's filters.

Gaussian white noise, band-limited to the Nyquist frequency (variance 2 pi S0/dt), is multiplied by the envelope and *then* goes
through the filters of the ground (`soils`), by their exact transfer function on the noise's Fourier series, the noise being
followed by zeros. This way was chosen for what it keeps. The density below the Nyquist frequency is the formula's, with nothing
folded into it: a filter stepped in time and sampled folds the Kanai-Tajimi tail, which falls only as 1/omega^2, back to
frequency 0, and its displacement drifts. And as the high-pass acts on the modulated noise, the ground comes to rest where it
began when the filters have died down.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.ground_motions.envelopes import RisePlateauDecay
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.soils import FIRM, Soil
from dampyr.units import STANDARD_GRAVITY

Array = NDArray[np.float64]
Envelope = Callable[[Array, float], Array]

DECAYED = 1e-4  # of a filter's free motion: too little for a visible jump where the motion is cut
LEAD = 16  # steps before the shaking, in which what rings ahead of it fits
DEFAULT_ENVELOPE = RisePlateauDecay()
SYNTHETIC_DT = 0.01  # s: 100 samples a second, the rate of many accelerographs
SYNTHETIC_DURATION = 20.0  # s, about the strong part of El Centro 1940
SYNTHETIC_PGA = 0.3 * STANDARD_GRAVITY  # m/s2, a strong motion


def kanai_tajimi(
    duration: float,
    dt: float,
    seed: int | Sequence[int],
    *,
    intensity: float | None = None,
    pga: float | None = None,
    soil: Soil = FIRM,
    envelope: Envelope = DEFAULT_ENVELOPE,
    rest: float | None = None,
) -> GroundMotion:
    """A synthetic ground motion with the density of Kanai, Tajimi, Clough and Penzien, see `soils`.

    Parameters
    ----------
    duration
        Of the shaking, s, at least 100 steps; it starts 16 steps after t = 0.
    dt
        The step, s, greater than 0.
    seed
        A whole number, or several, such as (seed of the study, number of the motion): the noise is bit for bit that of
        numpy's PCG64 seeded so. Zeros at the end do not count there: (5, 0) is 5.
    intensity, pga
        S0 in m2/s3, two-sided, for each rad/s; or the peak in m/s2 that this motion is scaled to. Exactly one of the two.
    soil
        The filters of the ground, see `soils`; by default firm soil.
    envelope
        A function of times and duration, see `envelopes`; `stationary` for none.
    rest
        Seconds after the shaking in which the filters die down; by default until 1e-4 is left. With 0 the motion is cut
        where the shaking ends, wherever velocity and displacement are then.

    Raises
    ------
    InputError
        An argument is outside its range.

    Examples
    --------
    >>> import dampyr as dp
    >>> motion = dp.ground_motions.kanai_tajimi(10.0, 0.01, seed=(7, 1), pga=3.0)
    >>> round(motion.pga, 9), motion.dt
    (3.0, 0.01)
    """
    _check(duration, dt, intensity, pga, rest)
    n = math.floor(duration / dt * (1 + 1e-12)) + 1
    # seconds until DECAYED of the slower filter's free motion is left
    slowest = min(_decay_rate(soil.omega_g, soil.zeta_g), _decay_rate(soil.omega_f, soil.zeta_f))
    tail = math.ceil(-math.log(DECAYED) / slowest / dt)
    density = 1.0 if intensity is None else intensity
    # band-limited white noise of two-sided density S0 has the variance 2 pi S0 / dt
    noise = _generator(seed).standard_normal(n) * math.sqrt(2 * math.pi * density / dt)
    shaking: Array = noise * envelope(np.arange(n, dtype=np.float64) * dt, duration)
    acceleration = _through_soil(shaking, soil, dt, tail)
    n_samples = n + (tail if rest is None else math.ceil(rest / dt * (1 - 1e-12)))
    values = np.pad(acceleration, (0, max(n_samples - len(acceleration), 0)))[:n_samples]
    shape = getattr(envelope, "__name__", repr(envelope))
    strength = f"S0 = {intensity:g} m2/s3" if pga is None else f"scaled to a PGA of {pga:g} m/s2"
    source = f"synthetic, Kanai-Tajimi with Clough-Penzien high-pass, {soil}, {shape}, {strength}, PCG64 seed {seed}"
    motion = GroundMotion(values, dt, name=f"Kanai-Tajimi {seed}", source=source)
    return motion if pga is None else motion.changed(values * (pga / motion.pga), f"scaled by {pga / motion.pga:.12g}")


def synthetic_motions(
    count: int, seed: int = 1, duration: float = SYNTHETIC_DURATION, pga: float = SYNTHETIC_PGA
) -> list[GroundMotion]:
    """``count`` synthetic motions [s, m/s2] by Kanai and Tajimi, each by its own seed (``seed``, k), k from 1."""
    return [kanai_tajimi(duration, SYNTHETIC_DT, (seed, k), pga=pga) for k in range(1, count + 1)]


def _generator(seed: int | Sequence[int]) -> np.random.Generator:
    try:
        return np.random.Generator(np.random.PCG64(seed))
    except (ValueError, TypeError):
        raise InputError(f"seed = {seed!r} is not allowed; give a whole number, at least 0, or several") from None


def _through_soil(noise: Array, soil: Soil, dt: float, tail: int) -> Array:
    """The noise through the filters, and what follows for ``tail`` samples.

    A delay, which white noise does not notice, of about half a step makes the transfer function real at the Nyquist frequency,
    so that its Fourier series has no jump there and rings little; LEAD whole steps more keep what rings ahead in the motion.
    """
    from scipy.fft import next_fast_len

    count = 2 * next_fast_len((len(noise) + 2 * tail) // 2 + LEAD, real=True)
    omega = 2 * np.pi * np.fft.rfftfreq(count, dt)
    delay = (np.angle(soil.transfer(np.pi / dt)) / np.pi + 1 + LEAD) * dt
    filters = soil.transfer(omega) * np.exp(-1j * omega * delay)
    return np.fft.irfft(filters * np.fft.rfft(noise, count), count)[: len(noise) + tail]


def _decay_rate(omega: float, zeta: float) -> float:
    """How fast the slowest part of a filter's free motion decays [1/s]; overdamped too."""
    return omega * (zeta if zeta <= 1 else 1 / (zeta + math.sqrt(zeta**2 - 1)))


def _check(duration: float, dt: float, intensity: float | None, pga: float | None, rest: float | None) -> None:
    for name, value in (("duration", duration), ("dt", dt)):
        if not math.isfinite(value) or value <= 0:
            raise InputError(f"{name} = {value:g} s is not allowed; it must be greater than 0")
    if duration < 100 * dt:
        raise InputError(f"duration = {duration:g} s is less than 100 steps of {dt:g} s; lengthen it or shorten dt")
    if (intensity is None) == (pga is None):
        raise InputError(f"intensity = {intensity} and pga = {pga}: give exactly one of the two")
    strength = intensity if pga is None else pga
    if strength is None or not math.isfinite(strength) or strength <= 0:
        name, unit = ("intensity", "m2/s3") if pga is None else ("pga", "m/s2")
        raise InputError(f"{name} = {strength} {unit} is not allowed; it must be greater than 0")
    if rest is not None and (not math.isfinite(rest) or rest < 0):
        raise InputError(f"rest = {rest:g} s is not allowed; it must be at least 0")
