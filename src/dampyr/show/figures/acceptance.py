"""Forces at peak velocity in a band about a reference, and how much of its band each point uses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import FORCE, Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SPEED = Axis("peak velocity", "mm/s", 1e3)
USED = Axis("away from the reference", "halves of the band")
EDGE = 0.02  # of the greatest speed: how wide a band is drawn that was judged at one speed only
STATES: Mapping[bool | None, tuple[str, dict[str, Any]]] = {
    True: ("inside", {"marker": "o", "ms": 3.2, "color": style.BLUE, "alpha": 0.75}),
    False: ("outside", {"marker": "X", "ms": 7.0, "color": style.VERMILLION}),
    None: ("not judged", {"marker": "s", "ms": 4.0, "mfc": "none", "mec": style.MUTED, "color": style.MUTED}),
}
"""What a point looks like: its shape says as much as its colour."""
MANY = 24  # records whose rows stand closer together, so that forty of them fit a printed page
MARKS = {"extension": "^", "compression": "v", "energy": "o"}


def peak_velocity_band(
    bands: Sequence[ArrayLike],
    points: Mapping[bool | None, tuple[ArrayLike, ArrayLike]],
    title: str = "",
    share: float = 1.0,
) -> Figure:
    """``bands`` rows of (speed m/s, expected N, low N, high N) along the speed, one table for each direction.

    ``points`` whether inside (True, False, or None where not judged) -> peak speeds m/s and forces N.
    ``share``: of the page's width.
    """
    with style.single_panel(3.1, title, share) as (fig, panel):
        tables = [np.asarray(rows, dtype=float).reshape(-1, 4) for rows in bands]
        widest = max([float(np.max(x, initial=0.0)) for x, _ in points.values()] + [1e-3])
        for rows in tables:
            if len(rows):
                # wider than its tests at both ends, so that the band of tests of one speed is seen
                speed = np.concatenate([[rows[0, 0] - EDGE * widest], rows[:, 0], [rows[-1, 0] + EDGE * widest]])
                _band(panel, SPEED.of(speed), FORCE.of(np.concatenate([rows[:1, 1:], rows[:, 1:], rows[-1:, 1:]])))
        for state, (label, look) in STATES.items():
            if state in points and np.size(points[state][0]):
                x, y = points[state]
                panel.plot(SPEED.of(x), FORCE.of(y), ls="", label=label, **look)
        panel.axhline(0.0, color=style.MUTED, lw=0.7)
        panel.margins(x=0.04)
        style.name_axes(panel, SPEED, FORCE)
        style.legend(fig, panel, columns=5, min_entries=1)
    return fig


def band_used(
    records: Mapping[str, Mapping[str, ArrayLike]],
    title: str = "",
    outside: Mapping[str, Mapping[str, ArrayLike]] | None = None,
) -> Figure:
    """``records`` name -> quantity -> how far each judged cycle lies from the reference, in halves of the band.

    The edges are at -1 and 1; to the right the damper is stronger than the reference. ``outside`` says in the same way which of
    these lie outside, where noise is allowed beyond the edges; without it those beyond them do.
    """
    row_height = 0.26 if len(records) <= MANY else 0.19
    with style.single_panel(1.2 + row_height * max(len(records), 2), title) as (fig, panel):
        panel.axvspan(-1.0, 1.0, color=style.SKY, alpha=0.18, lw=0, label="band")
        for edge in (-1.0, 1.0):
            panel.axvline(edge, color=style.INK, lw=0.8, ls="--")
        for row, (name, quantities) in enumerate(records.items()):
            for quantity, values in quantities.items():
                used = np.asarray(values, dtype=float)
                beyond = np.abs(used) > 1.0 if outside is None else np.asarray(outside[name][quantity], dtype=bool)
                _used(panel, row, quantity, used, beyond)
        panel.set_yticks(range(len(records)), list(records))
        panel.set_ylim(len(records) - 0.4, -0.6)
        low, high = panel.get_xlim()
        panel.set_xlim(min(low, -1.25), max(high, 1.25))
        panel.grid(visible=False, axis="y")
        panel.set_xlabel(USED.label)
        style.legend(fig, panel, columns=3, min_entries=1)
    return fig


def _used(panel: Any, row: int, quantity: str, values: Any, outside: Any) -> None:
    shift = {"extension": -0.2, "compression": 0.0, "energy": 0.2}.get(quantity, 0.0)
    mark = MARKS.get(quantity, "o")
    for chosen, label, look in (
        (~outside, quantity, {"ms": 3.4, "color": style.BLUE, "alpha": 0.7}),
        (outside, f"{quantity}, outside", {"ms": 6.0, "mfc": "none", "mec": style.VERMILLION, "mew": 1.5}),
    ):
        shown = values[chosen]
        if shown.size:
            panel.plot(shown, np.full(shown.size, row + shift), mark, label=label, **look)


def _band(panel: Any, speed: Any, rows: Any) -> None:
    panel.fill_between(speed, rows[:, 1], rows[:, 2], color=style.SKY, alpha=0.22, lw=0, label="band")
    panel.plot(speed, rows[:, 0], color=style.INK, lw=1.1, ls="--", label="reference")
    for column in (1, 2):
        panel.plot(speed, rows[:, column], color=style.SKY, lw=1.0)
