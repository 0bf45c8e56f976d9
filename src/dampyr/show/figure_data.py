"""What a figure draws, as a table: a pair of columns for each line, in the units of the axes."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Column = tuple[str, NDArray[np.float64]]
_MATH = re.compile(r"\\mathit\{(\w+)\}")  # of a symbol, see `symbols`
DIGITS = 8  # of a number: a line of a figure has no more


def figure_columns(figure: Figure) -> Iterator[Column]:
    """The lines, bands and bars of a figure, panel by panel, each as columns that say the panel, the name and the axis.

    Lines across a whole panel, such as a zero, are left out. Values are those that are drawn: long histories are thinned.
    """
    several = sum(panel.axison for panel in figure.axes) > 1
    for number, panel in enumerate((panel for panel in figure.axes if panel.axison), 1):
        x, y = _name(panel, figure, "x"), _name(panel, figure, "y")
        where = f"panel {number}, " if several else ""
        for what, columns in _drawn(panel):
            name = f"{where}{what}: " if what else where
            for axis, ending, values in columns:
                yield f"{name}{x if axis == 'x' else y}{ending}", values


def _name(panel: Any, figure: Figure, axis: str) -> str:
    """What an axis says; that of the last panel below it, or of all of them, where it says nothing."""
    own = getattr(panel, f"get_{axis}label")()
    if own:
        return str(own)
    shared = getattr(panel, f"get_shared_{axis}_axes")().get_siblings(panel)
    said = [getattr(other, f"get_{axis}label")() for other in shared]
    return next(filter(None, said), "") or getattr(figure, f"get_sup{axis}label")() or axis


def _drawn(panel: Any) -> Iterator[tuple[str, list[tuple[str, str, NDArray[np.float64]]]]]:
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.container import ErrorbarContainer
    from matplotlib.patches import Rectangle

    with_bars = {id(each[0]): _label(each) for each in panel.containers if isinstance(each, ErrorbarContainer)}
    caps = {id(cap) for each in panel.containers if isinstance(each, ErrorbarContainer) for cap in each[1]}
    for line in panel.lines:
        if line.get_transform() == panel.transData and np.size(line.get_xdata()) and id(line) not in caps:
            x, y = (np.asarray(values, dtype=float) for values in (line.get_xdata(), line.get_ydata()))
            yield with_bars.get(id(line), _label(line)), [("x", "", x), ("y", "", y)]
    for collection in panel.collections:
        if isinstance(collection, PolyCollection) and collection.get_paths():
            x, low, high = _band(np.asarray(collection.get_paths()[0].vertices, dtype=float))
            yield _label(collection), [("x", "", x), ("y", ", low", low), ("y", ", high", high)]
        elif isinstance(collection, LineCollection) and (ends := collection.get_segments()):
            table = np.array([[*each[0], *each[-1]] for each in ends if len(each)])
            if len(table):
                yield _label(collection), [
                    ("x", ", from", table[:, 0]), ("y", ", from", table[:, 1]),
                    ("x", ", to", table[:, 2]), ("y", ", to", table[:, 3]),
                ]  # fmt: skip
    bars = [patch for patch in panel.patches if isinstance(patch, Rectangle) and patch.get_transform() is not None]
    bars = [bar for bar in bars if bar.get_data_transform() == panel.transData]
    if bars:
        table = np.array(
            [[bar.get_x(), bar.get_y(), bar.get_x() + bar.get_width(), bar.get_y() + bar.get_height()] for bar in bars]
        )
        names = ("x", ", from"), ("y", ", from"), ("x", ", to"), ("y", ", to")
        yield "bars", [(axis, ending, values) for (axis, ending), values in zip(names, table.T, strict=True)]


def _band(outline: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """x, the lower and the upper edge of what ``fill_between`` has drawn: there along one edge, back along the other."""
    count = (len(outline) - 3) // 2
    there, back = outline[1 : count + 1], outline[count + 2 : 2 * count + 2][::-1]
    return there[:, 0], np.minimum(there[:, 1], back[:, 1]), np.maximum(there[:, 1], back[:, 1])


def _label(artist: Any) -> str:
    label = str(artist.get_label())
    return "" if label.startswith("_") or label == "None" else label


def _across(figure: Figure) -> list[str]:
    """The pale words across a figure: its origin (`dampyr.origin.Origin.stamp`)."""
    return [text.get_text() for text in figure.texts if (text.get_alpha() or 1.0) < 1.0]


def write_figure_data(figure: Figure, path: Path, decimal_comma: bool = False) -> Path:
    """Write the columns of `figure_columns` as CSV; with a decimal comma semicolons part them, as spreadsheets expect it.

    What stands across the figure, such as that it is of simulated records, is a first line behind ``#``.
    """
    figure.draw_without_rendering()
    columns = list(figure_columns(figure))

    def cell(value: float | None) -> str:
        if value is None or np.isnan(value):
            return ""
        text = f"{value:.{DIGITS}g}"
        return text.replace(".", ",") if decimal_comma else text

    with path.open("w", encoding="utf-8", newline="") as file:
        file.writelines(f"# {word}\r\n" for word in _across(figure))
        table = csv.writer(file, delimiter=";" if decimal_comma else ",")
        table.writerow([_MATH.sub(r"\1", name).replace("$", "") for name, _ in columns])
        table.writerows([cell(value) for value in row] for row in zip_longest(*(values for _, values in columns)))
    return path
