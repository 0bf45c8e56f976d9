"""The files of a laboratory that smooths what it publishes: thirty sines at five currents and an earthquake.

Forces and displacements went through a moving average, a tenth of the period on the sines and 0.3 s on the earthquake, and
nothing in the files says so. The displacement has 3 um of noise, the load cell steps of 0.5 N.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from dampyr.models import Damper
from tests.stories.laboratory import CURRENTS, MOTIONS, earthquake, sine, specimen

Array = np.ndarray
HEADER = "Time [s]\tDisplacement [mm]\tForce [N]"
READING = 'current = "*_{}A"\nvalidation = ["earthquake*"]\n'
SMOOTHED = '\n[smoothed]\n"sine*" = "0.1 periods"\n"earthquake*" = 0.3\n'
LOWPASS = '\n[lowpass]\n"sine*" = "15 f"\n"earthquake*" = 20\n'
WINDOW, PART = 0.3, 0.1  # s on the earthquake; of the period on the sines
REST = 2.0  # s before the earthquake: a recorder is started first


def test_of(damper: Damper, t: Array, x: Array, current: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """Displacement (mm) and force (N) as measured, before anybody smooths them."""
    fine = np.linspace(t[0], t[-1], 4 * (t.size - 1) + 1)
    v = np.gradient(x, t)
    force = damper.force(fine, np.interp(fine, t, x), velocity=np.interp(fine, t, v), current=current)[::4]
    return 1e3 * (x + rng.normal(0.0, 3e-6, t.size)), 0.5 * np.round((force + rng.normal(0.0, 3.0, t.size)) / 0.5)


test_of.__test__ = False  # type: ignore[attr-defined]  # no test of pytest


def moving_average(values: Array, samples: int) -> Array:
    """As a spreadsheet does it: the mean of the samples about each, of fewer at the ends."""
    ones, late = np.ones(samples), samples - 1 - samples // 2
    part = slice(late, late + values.size)
    return np.convolve(values, ones)[part] / np.convolve(np.ones(values.size), ones)[part]


def rested(t: Array, x: Array) -> tuple[Array, Array]:
    """A motion after a rest."""
    dt = t[1] - t[0]
    still = round(REST / dt)
    return dt * np.arange(t.size + still), np.r_[np.zeros(still), x]


def write_second_laboratory(
    folder: Path,
    smoothed: bool,
    damper: Damper | None = None,
    currents: Sequence[float] = CURRENTS,
    motions: Sequence[tuple[float, float]] = MOTIONS,
    decimals: tuple[int, int] = (6, 4),
) -> Path:
    """All files, smoothed or as they were measured; ``decimals`` of displacement and force in the files."""
    folder.mkdir()
    rng, tested = np.random.default_rng(17), damper or specimen()
    for current in currents:
        for amplitude, frequency in motions:
            name = f"sine_{amplitude:g}mm_{frequency:g}Hz_{current:g}A.txt"
            _write(
                folder / name, tested, *sine(amplitude, frequency), current, PART / frequency, rng, smoothed, decimals
            )
    middle = 0.7 if len(currents) > 1 else currents[0]
    name = f"earthquake_{middle:g}A.txt"
    _write(folder / name, tested, *rested(*earthquake(1)), middle, WINDOW, rng, smoothed, decimals)
    (folder / "reading.toml").write_text(READING)
    return folder


def _write(
    path: Path,
    damper: Damper,
    t: Array,
    x: Array,
    current: float,
    window: float,
    rng: np.random.Generator,
    smoothed: bool,
    decimals: tuple[int, int],
) -> None:
    displacement, force = test_of(damper, t, x, current, rng)
    if smoothed:
        samples = round(window / (t[1] - t[0]))
        displacement, force = moving_average(displacement, samples), moving_average(force, samples)
    rows = zip(t, displacement, force, strict=True)
    lines = [f"{a:.4f}\t{b:.{decimals[0]}f}\t{c:.{decimals[1]}f}" for a, b, c in rows]
    path.write_text("\n".join([HEADER, *lines, ""]))
