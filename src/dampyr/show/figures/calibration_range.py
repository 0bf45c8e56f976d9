"""Where a damper was calibrated: amplitude against frequency of its records, by input, and the box that the card holds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AMPLITUDE = Axis("amplitude", "mm", 1e3)
FREQUENCY = Axis("frequency", "Hz")
MARKERS = "osD^vPX"


def calibrated(
    groups: Mapping[str, tuple[ArrayLike, ArrayLike]],
    ranges: Mapping[str, tuple[float, float]] | None = None,
    title: str = "",
    colours: Mapping[str, str] | None = None,
) -> Figure:
    """``groups`` name -> (frequencies Hz, amplitudes m, half of peak to peak) of its records, ``colours`` name -> colour.

    ``ranges`` are those of a damper: ``frequency`` (Hz) and ``displacement`` (m) make the box, ``velocity`` (m/s) the line
    on which a sine reaches the greatest speed. A record without frequency is not drawn.
    """
    with style.single_panel(2.5, title) as (fig, panel):
        if ranges:
            _box(panel, ranges)
        for look, (name, (frequencies, amplitudes)) in zip(looks(groups, colours), groups.items(), strict=True):
            panel.plot(
                FREQUENCY.of(frequencies),
                AMPLITUDE.of(amplitudes),
                ls="",
                ms=5.5,
                mfc="none",
                mew=1.3,
                label=name,
                **look,
            )
        drawn = [*(amplitudes for _, amplitudes in groups.values()), (ranges or {}).get("displacement", (0.0, 0.0))[1]]
        amplitude_values = np.concatenate([np.ravel(AMPLITUDE.of(amplitudes)) for amplitudes in drawn])
        top = max(float(np.max(amplitude_values[np.isfinite(amplitude_values)], initial=0.0)), 1e-3)
        panel.set_ylim(0.0, 1.12 * top)
        panel.margins(x=0.08)
        # records of one frequency are not drawn as if it were known to a hundredth
        left, right = panel.get_xlim()
        middle = 0.5 * (left + right)
        reach = max(0.5 * (right - left), 0.25 * abs(middle))
        panel.set_xlim(middle - reach, middle + reach)
        if ranges and "velocity" in ranges:
            _speed(panel, ranges["velocity"][1], top)
        style.name_axes(panel, FREQUENCY, AMPLITUDE)
        style.legend(fig, panel, columns=3, min_entries=1)
    return fig


def looks(names: Iterable[str], colours: Mapping[str, str] | None = None) -> Any:
    """Colour and marker of each group: told apart by the marker where colours are not seen, or come again."""
    colours = colours or style.case_colours(names)
    return [{"color": colours[name], "marker": mark} for name, mark in zip(names, cycle(MARKERS), strict=False)]


def _box(panel: Any, ranges: Mapping[str, tuple[float, float]]) -> None:
    if "frequency" not in ranges or "displacement" not in ranges:
        return
    from matplotlib.patches import Rectangle

    (left, right), (low, high) = FREQUENCY.of(ranges["frequency"]), AMPLITUDE.of(ranges["displacement"])
    box = Rectangle((left, low), right - left, high - low, facecolor=style.SKY, alpha=0.16, label="calibrated range")
    box.set(edgecolor=style.SKY, linewidth=1.0)  # one frequency makes a box without width
    panel.add_patch(box)


def _speed(panel: Any, speed: float, top: float) -> None:
    left, right = panel.get_xlim()
    f = np.linspace(max(left, 1e-3), right, 200)
    amplitude = AMPLITUDE.of(speed / (2.0 * np.pi * f))
    seen = amplitude <= 1.12 * top
    panel.set_xlim(left, right)
    if np.any(seen):
        label = f"greatest speed, {style.VELOCITY.of(speed):.3g} {style.VELOCITY.unit}"
        panel.plot(f[seen], amplitude[seen], color=style.MUTED, ls="--", lw=1, label=label)
