r"""Heights of roads: random ones of the classes of ISO 8608, and single bumps.

A class of road is a power spectral density of the height over the spatial frequency n [cycle/m]:

.. math:: G_d(n) = G_d(n_0) (n/n_0)^{-2}, \qquad n_0 = 0.1\ \mathrm{cycle/m}, \qquad
          G_d(n_0) = 16 \cdot 4^k \cdot 10^{-6}\ \mathrm{m^3}, \quad k = 0 \dots 7 \text{ for A to H}

the geometric means of the classes, each four times that of the class before, from 0.011 to 2.83 cycle/m. The text of the
standard was not read: these are the numbers of papers that use it and agree, such as Loprencipe and Zoccali (2017), Journal of
Modern Transportation 25, 24.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.units import in_si

Array = NDArray[np.float64]
CLASSES = "ABCDEFGH"
N_0 = 0.1  # cycle/m, at which a class states its density
LOWEST, HIGHEST = 0.011, 2.83  # cycle/m, between which the classes are defined
SHAPES = ("haversine", "trapezoid")


def road_density(road_class: str) -> float:
    """:math:`G_d(n_0)` of a class of ISO 8608 in m3, its geometric mean, such as 256e-6 of class C."""
    if road_class not in tuple(CLASSES):
        raise InputError(f"road_class = {road_class!r} is not a class of ISO 8608; choose from {', '.join(CLASSES)}")
    return float(16e-6 * 4.0 ** CLASSES.index(road_class))


def random_road(road_class: str, length: float, spacing: float = 0.05, seed: int = 0, lead: float = 10.0) -> Array:
    r"""Heights (n,) in m of a random road of a class of ISO 8608, ``spacing`` m apart, for `dampyr.structures.road`.

    .. math:: y(s) = \sum_k \sqrt{2\, G_d(n_k)\, \Delta n}\, \cos(2\pi n_k s + \varphi_k)

    with phases that ``seed`` draws, :math:`n_k` a multiple of :math:`\Delta n` = 1/length: the spectrum of the length is that
    of the class, line by line. Before it lies a ``lead`` over which the same road rises from level, as a car comes from a level
    road; take figures after it.

    Parameters
    ----------
    road_class
        "A" (very good) to "H" (very poor).
    length
        Of the road after the lead, m; waves longer than it are not in it.
    spacing
        Between heights, m; waves shorter than two of it, and than 0.35 m, are not in it.
    seed
        Whole number of at least 0: another road of the same class for each.
    lead
        m, 0 for none.

    Raises
    ------
    InputError
        A class, a length or a spacing that is none, or a length under twenty spacings.

    Examples
    --------
    >>> import dampyr as dp
    >>> heights = dp.structures.random_road("C", length=100.0, seed=3)
    >>> motion = dp.structures.road(heights, spacing=0.05, speed=20.0)
    >>> motion.n, round(motion.duration, 2)
    (2201, 5.5)
    """
    density = road_density(road_class)
    length, spacing, lead = (
        in_si(value, "m", name) for name, value in (("length", length), ("spacing", spacing), ("lead", lead))
    )
    if not (np.isfinite(spacing) and spacing > 0):
        raise InputError(f"spacing = {spacing!r} m is not allowed; it must be greater than 0")
    if not (np.isfinite(length) and length >= 20.0 * spacing):
        raise InputError(f"length = {length!r} m is not allowed; it must be at least 20 spacings, {20 * spacing:g} m")
    if not (np.isfinite(lead) and lead >= 0):
        raise InputError(f"lead = {lead!r} m is not allowed; it must be at least 0")
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise InputError(f"seed = {seed!r} is not allowed; give a whole number, at least 0")
    count = round(length / spacing)
    step = 1.0 / (count * spacing)
    number = np.arange(1, count // 2)  # below half of the samples' frequency, which has no phase
    n = number * step
    inside = (n >= LOWEST) & (n <= HIGHEST)
    if not inside.any():
        raise InputError(
            f"length = {length:g} m and spacing = {spacing:g} m leave no wave between {LOWEST:g} and {HIGHEST:g} cycle/m; give "
            "a longer road or a smaller spacing"
        )
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, number.size)
    amplitude = np.where(inside, np.sqrt(2.0 * density * (n / N_0) ** -2.0 * step), 0.0)
    spectrum = np.zeros(count // 2 + 1, dtype=complex)
    spectrum[number] = 0.5 * count * amplitude * np.exp(1j * phases)
    period = np.fft.irfft(spectrum, count)
    before = round(lead / spacing)
    s = np.arange(-before, count + 1)
    # from level over the lead: half a period of a cosine, whose slope is 0 at both ends
    rise = np.where(s < 0, 0.5 * (1.0 - np.cos(np.pi * (s + before) / max(before, 1))), 1.0)
    return np.asarray(rise * period[s % count])


def bump(height: float, length: float, spacing: float = 0.02, shape: str = "haversine", ramp: float = 0.1) -> Array:
    r"""Heights (n,) in m of a bump, or of a hole where ``height`` is negative, ``spacing`` m apart, level before and after.

    Parameters
    ----------
    height, length
        m; haversine: :math:`y = h \sin^2(\pi s/L)`; trapezoid: straight up over ``ramp``, level, and down over ``ramp``.
    spacing
        Between heights, m.
    shape
        "haversine" or "trapezoid", as a speed hump is.
    ramp
        Of a trapezoid, m, at most half of the length.

    The road is level for one length before the bump and for four after it.

    Raises
    ------
    InputError
        A length, a spacing, a ramp or a shape that is none, or a bump of fewer than eight heights.

    Examples
    --------
    >>> import dampyr as dp
    >>> heights = dp.structures.bump(0.05, length=1.0)
    >>> len(heights), float(heights.max()), float(heights[0])
    (301, 0.05, 0.0)
    """
    values = {"height": height, "length": length, "spacing": spacing, "ramp": ramp}
    height, length, spacing, ramp = (float(in_si(value, "m", name)) for name, value in values.items())
    if shape not in SHAPES:
        raise InputError(f"shape = {shape!r} is not known; choose from {', '.join(SHAPES)}")
    if not np.isfinite(height):
        raise InputError(f"height = {height!r} m is not allowed; it must be finite")
    if not (np.isfinite(spacing) and spacing > 0 and np.isfinite(length) and length >= 8.0 * spacing * (1.0 - 1e-9)):
        raise InputError(
            f"length = {length!r} m and spacing = {spacing!r} m are not allowed; a bump needs at least eight spacings"
        )
    if not 0.0 < ramp <= 0.5 * length:
        raise InputError(f"ramp = {ramp:g} m is not allowed; it must be greater than 0, and at most {0.5 * length:g} m")
    s = spacing * np.arange(-round(length / spacing), round(5.0 * length / spacing) + 1)
    inside = (s > 0.0) & (s < length)
    if shape == "haversine":
        return np.asarray(np.where(inside, height * np.sin(np.pi * s / length) ** 2, 0.0))
    return np.asarray(height * np.clip(np.minimum(s, length - s) / ramp, 0.0, 1.0))
