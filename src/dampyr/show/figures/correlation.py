"""A correlation matrix: below the diagonal a cell per pair, blue for positive, orange-red for negative, deeper for stronger."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.show.figures import style
from dampyr.show.figures.symbols import label_as_mathtext

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FEW = 10  # parameters: with more, the numbers in the cells would be too small to read
MARKED = 0.9  # of a pair with it, 81 % of the variance of one error is explained by the other
NARROWEST = 2.3  # inches that the matrix keeps beside long names
APART = 0.1  # correlations below it between the numbers of different inputs: each input has a matrix of its own
MOST_INPUTS, MOST_OF_INPUT = 4, 5  # inputs, and parameters of each, that fit beside one another with numbers to read


def correlation(matrix: ArrayLike, names: Sequence[str], title: str = "") -> Figure:
    """``matrix`` (m, m) of correlations, m at least 2, NaN where one is not known (a dash); ``names`` the m parameters.

    Up to `FEW` parameters, every cell bears its number; with more, a ring marks the pairs beyond `MARKED`. The columns are
    numbered as the rows are. Numbers of different inputs that have nothing to do with one another (`APART`) stand in a matrix
    for each input.
    """
    r = np.asarray(matrix, dtype=float)
    m = len(names)
    if r.shape != (m, m) or m < 2:
        raise InputError(f"the correlations have shape {r.shape} for {m} names; give a square matrix of two or more")
    by_input = _separate_inputs(r, names)
    if by_input:
        return _correlation_by_input(r, names, by_input, title)
    size, cell = _sizes(names)
    with style.single_panel(cell * m + 0.75, title) as (fig, panel):
        for row in range(1, m):
            for column in range(row):
                _cell(panel, row, column, r[row, column], min(27 * cell, 8.5) if m <= FEW else None)
        _dress(panel, names, size, cell)
        _legend(fig, panel, m <= FEW, bool(np.any(np.isnan(r))))
    return fig


def _separate_inputs(r: NDArray[np.float64], names: Sequence[str]) -> dict[str, list[int]]:
    """The places of the numbers of each input, such as "1.98 V"; none where one matrix has to show them all."""
    groups: dict[str, list[int]] = {}
    for place, name in enumerate(names):
        groups.setdefault(name.partition(" @ ")[2], []).append(place)
    sizes = [len(places) for places in groups.values()]
    if "" in groups or not 2 <= len(groups) <= MOST_INPUTS or min(sizes) < 2 or max(sizes) > MOST_OF_INPUT:
        return {}
    apart = np.ones_like(r, dtype=bool)
    for places in groups.values():
        apart[np.ix_(places, places)] = False
    return groups if bool(np.all(np.abs(r[apart]) < APART)) else {}


def _correlation_by_input(
    r: NDArray[np.float64], names: Sequence[str], by_input: dict[str, list[int]], title: str
) -> Figure:
    """A matrix for each input, side by side."""
    most = max(len(places) for places in by_input.values())
    with style.panels(0.2 * most + 1.05, 1, len(by_input), title) as (fig, axes):
        for panel, (at, places) in zip(axes[0], by_input.items(), strict=True):
            for row in range(1, len(places)):
                for column in range(row):
                    _cell(panel, row, column, r[places[row], places[column]], 6.5)
            _dress(panel, [names[place].partition(" @ ")[0] for place in places], 7.5, 0.2)
            panel.set_title(at)
        _legend(fig, axes[0, 0], True, bool(np.any(np.isnan(r))))
    return fig


def _cell(panel: Any, row: int, column: int, value: float, size: float | None) -> None:
    """A cell; with ``size``, in points, also its number."""
    from matplotlib.patches import Rectangle

    if np.isnan(value):
        panel.text(column, row, "–", ha="center", va="center", fontsize=7, color=style.MUTED)
        return
    colour = style.BLUE if value >= 0.0 else style.VERMILLION
    corner = (column - 0.46, row - 0.46)
    panel.add_patch(Rectangle(corner, 0.92, 0.92, facecolor=colour, alpha=_depth(value), lw=0))
    if size is not None:
        # such as −.95: a correlation needs no zero before its point, and one that rounds to nothing no point
        number = "0" if abs(value) < 0.005 else f"{value:.2f}".replace("0.", ".").replace("1.00", "1").replace("-", "−")
        panel.text(column, row, number, ha="center", va="center", fontsize=size, color=style.INK)
    elif abs(value) > MARKED:
        panel.plot(column, row, "o", ms=3.2, mfc="none", mec=style.INK, mew=0.9)


def _depth(value: float) -> float:
    """How opaque: the page shows through a weak correlation, and ink stays readable on a strong one."""
    return 0.04 + 0.66 * min(abs(value), 1.0) ** 1.5


def _sizes(names: Sequence[str]) -> tuple[float, float]:
    """Size of the letters in points, and of a cell in inches, that fill the width beside the names."""
    m, letters = len(names), max(len(name) for name in names) + 5
    width, letter = style.WIDTH - 0.55, 0.6 / 72  # of the figure without its margins, inches; of a letter, per point
    size = min(9.0 - 0.13 * max(m - FEW, 0), (width - NARROWEST) / (letter * letters))
    size = max(size, 4.0)
    return size, min(0.31 if m <= FEW else 0.19, max(width - letter * size * letters, 1.0) / m)


def _dress(panel: Any, names: Sequence[str], size: float, cell: float) -> None:
    m = len(names)
    panel.set_xlim(-0.6, m - 0.4)
    panel.set_ylim(m - 0.4, -0.6)
    label_width = 0.6 * size / 72 * (max(len(name) for name in names) + 5)
    # long names need all the room on the left
    anchor = "C" if label_width < 0.5 * (style.WIDTH - cell * m) - 0.2 else "E"
    panel.set_aspect("equal", anchor=anchor)
    panel.grid(visible=False)
    for spine in panel.spines.values():
        spine.set_visible(False)
    panel.tick_params(length=0)
    panel.set_yticks(range(m), [f"{label_as_mathtext(name)} ({k})" for k, name in enumerate(names, 1)], fontsize=size)
    panel.set_xticks(range(m - 1), [str(k) for k in range(1, m)], fontsize=min(size, 45 * cell))


def _legend(fig: Figure, panel: Any, few: bool, unknown: bool) -> None:
    from matplotlib.patches import Patch

    levels: list[tuple[float, str]] = [
        (-1.0, "−1"),
        (-0.7, "−0.7"),
        (-0.3, "−0.3"),
        (0.3, "0.3"),
        (0.7, "0.7"),
        (1.0, "1"),
    ]
    handles: list[Any] = [
        Patch(facecolor=style.BLUE if r > 0 else style.VERMILLION, alpha=_depth(r), lw=0, label=name)
        for r, name in levels
    ]
    if not few:
        (ring,) = panel.plot(
            [], [], "o", ms=3.2, mfc="none", mec=style.INK, mew=0.9, ls="", label=f"beyond ±{MARKED:g}"
        )
        handles.append(ring)
    if unknown:
        handles.append(Patch(facecolor="none", lw=0, label="–  not known"))
    fig.legend(handles=handles, loc="outside upper left", ncols=len(handles), handlelength=1.0, columnspacing=0.9)


def strong_pairs(matrix: ArrayLike, names: Sequence[str], limit: float = MARKED) -> list[tuple[str, str, float]]:
    """The pairs whose correlation is beyond ``limit`` either way, strongest first; unknown ones are none."""
    r: NDArray[np.float64] = np.asarray(matrix, dtype=float)
    pairs = [
        (names[column], names[row], float(r[row, column]))
        for row in range(len(names))
        for column in range(row)
        if abs(r[row, column]) > limit
    ]
    return sorted(pairs, key=lambda pair: -abs(pair[2]))
