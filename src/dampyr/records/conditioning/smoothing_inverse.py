r"""A moving average undone.

With N samples in the window, of which b lie before the sample and a after it (:math:`N = b + 1 + a`),

.. math:: y_n = \frac1N \sum_{k=-b}^{a} r_{n+k}, \qquad r_{n+a} = r_{n-b-1} + N\,(y_n - y_{n-1}).

The second equation gives all raw values r from the first N of them, which the average does not tell: it is blind for whatever
repeats itself every N samples. They come from a rest at the start of the record, or else are those that make the sum of the
squared second differences of r least, weighted by a Hann window over the record so that its ends do not count.

An error e of the smoothed values that comes after the average, such as the rounding of a file, is multiplied by N and summed:
after K windows its standard deviation in r is :math:`N \sqrt{2K}\, e` (for independent errors). Where the raw values lie on the
grid of a converter, :math:`N (y_n - y_{n-1})` does too, and rounding it to that grid removes the error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dampyr.errors import InputError
from dampyr.records.conditioning.moving_average import averaged, whole_windows
from dampyr.records.record import Array
from dampyr.shown import Shown

DIGITS = 13  # decimals in SI units that are tried: 0.1 pm, and values of 1 m hold no more
MULTIPLE = 1e-3  # of a power of ten: far above the noise of doubles, far below what else a value would be off
SEPARATE = 2.0  # times the largest shift by rounding: levels of a converter's grid that far apart are distinct
LEVELS = 5  # of a grid at least
ON_GRID = 0.25  # of a step: rounding to the grid is then certain
SMALL_ERROR = 1e-3  # of a channel's standard deviation: below the steps of the converters that laboratories use
SMALL_PART = 1e-2  # of a channel's standard deviation: a fifth of what good models miss
# Parts of a record whose noise is compared: long enough for a median, and an error that grows differs in them.
EIGHTHS = 8
NORMAL = 0.6745 * np.sqrt(20.0)  # the median absolute third difference of white noise over its standard deviation


@dataclass(frozen=True, repr=False)
class Undone(Shown):
    """Raw values (n,), and how sure they are, in their unit.

    ``missing`` is the standard deviation of what repeats itself in each window, which the average has taken for good: 0 where
    the start values are known, else as much as there is next to those frequencies.
    ``noise`` is the standard deviation of their noise where it is least, ``error`` what an error of the smoothed values has
    grown to elsewhere (0 where it cannot be seen), ``growth`` how many times such an error is multiplied,
    ``grid`` the converter's step to which the differences were rounded, or None; ``start`` says where the first values come
    from.
    """

    values: Array
    noise: float
    error: float
    growth: float
    missing: float
    grid: float | None
    start: str

    @property
    def reliable(self) -> bool:
        """Whether the error stays below the raw values' own noise, or below a thousandth of their standard deviation."""
        return self.error <= max(self.noise, SMALL_ERROR * float(np.std(self.values)))

    @property
    def complete(self) -> bool:
        """Whether what is missing stays below the raw values' own noise, or below a hundredth of their standard deviation."""
        return self.missing <= max(self.noise, SMALL_PART * float(np.std(self.values)))


def undo(smoothed: Array, before: int, after: int, rest: int = 0) -> Undone:
    """The raw values under a moving average, see the module.

    Only samples whose window lies inside the record are used, so that it does not matter what a program does at the ends.

    Parameters
    ----------
    smoothed
        ``(n,)``, evenly sampled, in any unit.
    before, after
        How many samples of the window lie before and after the sample itself.
    rest
        How many samples at the beginning are at rest. With two windows or more of them the start values are their level, else
        (by default) those of least second differences.

    Raises
    ------
    InputError
        The record is shorter than four windows.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> from dampyr.records.conditioning.smoothing_inverse import undo
    >>> raw = np.r_[np.zeros(20), np.sin(0.3 * np.arange(100))]
    >>> smoothed = np.convolve(raw, np.ones(5) / 5, "same")
    >>> undone = undo(smoothed, 2, 2, rest=18)
    >>> bool(np.max(np.abs(undone.values - raw)[2:-2]) < 1e-12)
    True
    """
    size, n = before + 1 + after, smoothed.size
    if n < 4 * size:
        raise InputError(
            f"{n} samples are fewer than four windows of {size}, too few to undo a moving average; declare it as not undone"
        )
    part = whole_windows(n, before, after)
    steps = size * np.diff(smoothed[part])
    grid = _grid(steps, smoothed[part], size)
    if grid is not None:
        steps = grid * np.rint(steps / grid)
    raw = np.zeros(-(-n // size) * size)
    raw[size:n] = steps
    raw = np.cumsum(raw.reshape(-1, size), axis=0).ravel()[:n]
    resting = max(rest - after, 0) // size
    if resting >= 2:
        level = float(np.mean(smoothed[before : resting * size]))
        pattern = level - raw[: resting * size].reshape(resting, size).mean(axis=0)
        start = "rest at the start"
    else:
        pattern = _smoothest(raw, size)
        start = "least second differences"
    raw = raw + np.resize(pattern, n)
    again = averaged(raw, before, after)[part]
    raw = raw + float(np.mean(smoothed[part] - again))
    noise, error = _noise_and_error(raw, steps)
    missing = 0.0 if resting >= 2 else _missing(raw, size)
    return Undone(raw, noise, error, size * float(np.sqrt(2.0 * n / size)), missing, grid, start)


def _missing(raw: Array, size: int) -> float:
    """The standard deviation of the lines of 1/T and its multiples, from those two and three lines away on either side."""
    n = raw.size
    window = np.hanning(n)
    lines = np.abs(np.fft.rfft(window * (raw - np.mean(raw)))) ** 2
    at = np.rint(np.arange(1, size // 2 + 1) * n / size).astype(int)
    adjacent = np.clip(at[:, None] + np.array([-3, -2, 2, 3]), 0, lines.size - 1)
    return float(np.sqrt(2.0 * np.sum(np.median(lines[adjacent], axis=1))) / np.sum(window))


def _smoothest(raw: Array, size: int) -> Array:
    """What to add to each N-th sample so that the weighted sum of squared second differences is least, mean 0."""
    n = raw.size
    second = np.diff(raw, 2)
    at = np.arange(1, n - 1)
    weight = np.sin(np.pi * at / (n - 1)) ** 2
    total = np.bincount(at % size, weight, size)
    wanted = -np.bincount(at % size, weight * second, size) / total
    wanted += -np.sum(wanted) / np.sum(1.0 / total) / total  # the second differences of a period sum to nothing
    eigenvalues = -4.0 * np.sin(np.pi * np.arange(size // 2 + 1) / size) ** 2
    spectrum = np.fft.rfft(wanted)
    spectrum[0], eigenvalues[0] = 0.0, 1.0
    return np.fft.irfft(spectrum / eigenvalues, size)


def _rounding(values: Array) -> float | None:
    """The power of ten of which all values are multiples, as a file with so many decimals has them; None without one."""
    for digits in range(DIGITS):
        scaled = values * 10.0**digits
        if np.all(np.abs(scaled - np.rint(scaled)) < MULTIPLE):
            return float(10.0**-digits)
    return None


def _grid(steps: Array, smoothed: Array, size: int) -> float | None:
    """The converter's step on which N times the differences lie but for the rounding of the smoothed values, or None."""
    rounding = _rounding(smoothed)
    if rounding is None:
        return None
    shift = size * rounding  # at most, of a difference of two rounded values
    ordered = np.sort(steps)
    cuts = np.flatnonzero(np.diff(ordered) > SEPARATE * shift)
    low, high = ordered[np.r_[0, cuts + 1]], ordered[np.r_[cuts, ordered.size - 1]]
    if cuts.size < LEVELS or float(np.max(high - low)) > 2.0 * shift:
        return None
    apart = np.diff(0.5 * (low + high))
    step = float(np.median(apart[apart < 1.5 * float(apart.min())]))
    reach, farthest = 4.0 * step, float(np.max(np.abs(steps)))
    while reach < 4.0 * farthest:  # few multiples first, so that each round is sure of the next ones
        near = steps[np.abs(steps) <= reach]
        whole = np.rint(near / step)
        if not np.any(whole):
            return None
        step = float(whole @ near / (whole @ whole))
        reach *= 3.0
    return step if np.all(np.abs(steps / step - np.rint(steps / step)) < ON_GRID) else None


def _noise_and_error(raw: Array, steps: Array) -> tuple[float, float]:
    """The noise of the quietest eighth of the record, and what an error of the smoothed values has added to another one.

    Two signs of such an error, of which the smaller one counts: the noise differs between the eighths, and it is larger than
    that of the difference of two raw values a window apart, in which nothing has been summed, allows for.
    """
    size, eighths = raw.size - steps.size, np.array_split(np.arange(raw.size - 3), EIGHTHS)
    third = np.abs(np.diff(raw, 3)) / NORMAL
    apart = np.abs(np.diff(np.pad(steps, (size // 2, size - size // 2), mode="reflect"), 3)) / (NORMAL * np.sqrt(2.0))
    noise = np.array([np.median(third[part]) for part in eighths])
    without = np.array([np.median(apart[part]) for part in eighths])
    uneven = float(noise.max() ** 2 - noise.min() ** 2)
    summed = float(np.max(noise**2 - without**2))
    return float(noise.min()), float(np.sqrt(max(min(uneven, summed), 0.0)))
