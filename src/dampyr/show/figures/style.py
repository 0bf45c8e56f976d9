"""One style for all figures: colours that colour-blind readers tell apart, units on every axis, few points.

The colours are those of [OkabeIto2008]_. In a page they become CSS variables, so a figure follows the
reader's light or dark mode; in a file of its own it is drawn for white paper.

References
----------
.. [OkabeIto2008] M. Okabe and K. Ito, "Color universal design (CUD): how to make figures and presentations
   that are friendly to colorblind people", 2008.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.input_kinds import INPUTS
from dampyr.origin import NOT_STATED, Origin
from dampyr.show.figures.symbols import label_as_mathtext
from dampyr.units import for_people

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, MUTED, GRID = "#1b2026", "#79828c", "#d3d8dd"
BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY = (
    "#0072b2",
    "#d55e00",
    "#009e73",
    "#cc79a7",
    "#e69f00",
    "#56b4e9",
)
SERIES = (VERMILLION, BLUE, GREEN, PURPLE, ORANGE, SKY)
MEASURED = MUTED
CASES = (
    BLUE,
    VERMILLION,
    GREEN,
    PURPLE,
    ORANGE,
    SKY,
)
"""Of things that are compared; grey is what they are compared with."""
DASHES: dict[str, Any] = {
    VERMILLION: (0, (5.0, 1.6)),
    GREEN: (0, (6.0, 1.5, 1.2, 1.5)),
    PURPLE: (0, (1.2, 1.4)),
    ORANGE: (0, (9.0, 2.0)),
    SKY: (0, (6.0, 1.5, 1.2, 1.5, 1.2, 1.5)),
}
MARKERS = {BLUE: "o", VERMILLION: "s", GREEN: "^", PURPLE: "D", ORANGE: "v", SKY: "P", MUTED: "X"}
"""Of a case's line and of its points, where greys are too near to tell it from another case."""
APART = 12.0  # of lightness (CIE L*): greys that a reader of a print tells apart where the lines do not meet
SHAPES = 12  # on a line that goes back over its own way
PALE = 0.68  # opacity of what others are compared with, where that is as dark as one of them
WIDTH = 6.9  # inches: as wide as the text of a printed page
THIRD, HALF, TWO_THIRDS = 1 / 3, 1 / 2, 2 / 3  # of it: of figures that stand beside one another on a page
LOWER = 0.82  # of the height that a figure has at the full width: such figures are lower, too
ENTRY, CHARACTER = 0.55, 0.078  # inches of a legend: of an entry's mark and gaps, and of a letter in the middle
POINTS = 2400  # of a line: more than a page has pixels across

_RC: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.size": 10.0,
    "axes.titlesize": 10.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 10.0,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "axes.linewidth": 0.7,
    "lines.linewidth": 1.2,
    "lines.solid_joinstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 9.0,
    "axes.unicode_minus": True,
    "svg.fonttype": "none",
    "svg.hashsalt": "dampyr",
    "pdf.fonttype": 42,
    "path.simplify": True,
    "path.simplify_threshold": 0.12,
}


_for_pyplot: ContextVar[bool] = ContextVar("_for_pyplot", default=False)


@dataclass(frozen=True)
class Axis:
    """What an axis shows: words, the unit people read, and how many of it make one SI unit."""

    words: str
    unit: str
    per_si: float = 1.0

    @property
    def label(self) -> str:
        """Such as ``displacement [mm]``."""
        return f"{self.words} [{self.unit}]"

    def of(self, values: ArrayLike) -> NDArray[np.float64]:
        """SI values in the unit of the axis."""
        return np.asarray(values, dtype=float) * self.per_si


def parameter_axis(label: str, unit: str) -> Axis:
    """The axis of a fitted number called ``label``, SI ``unit``: its symbol, and the unit in which people read it."""
    shown, factor = for_people(unit)
    return Axis(label_as_mathtext(label), shown or "1", factor)


TIME = Axis("time", "s")
DISPLACEMENT = Axis("displacement", "mm", 1e3)
VELOCITY = Axis("velocity", "mm/s", 1e3)
FORCE = Axis("force", "N")
VOLTAGE = Axis("voltage", "V")
CURRENT = Axis("current", "A")
ACCELERATION = Axis("acceleration", "m/s²")


def input_axis(kind: str) -> Axis:
    """The axis of a damper's input; :class:`~dampyr.errors.InputError` where it has none, so that nothing is drawn over it."""
    if kind not in INPUTS:
        raise InputError("there is no input, so nothing can be drawn over it; the numbers stand in the tables")
    return VOLTAGE if kind == "V" else CURRENT


@contextmanager
def style() -> Iterator[None]:
    """matplotlib with dampyr's style, restored on leaving."""
    import matplotlib

    with matplotlib.rc_context(_RC):
        yield


@contextmanager
def panels(
    height: float, rows: int = 1, columns: int = 1, title: str = "", share: float = 1.0, **subplots: Any
) -> Iterator[tuple[Figure, NDArray[Any]]]:
    """A figure, a ``share`` of the page wide, and its axes ``(rows, columns)``; drawn within, they have dampyr's style.

    ``height``: in inches, of a figure as wide as the page.
    """
    with style():
        fig = _empty((share * WIDTH, height if share == 1.0 else LOWER * height))
        fig.patch.set_alpha(0.0)
        axes = fig.subplots(rows, columns, squeeze=False, **subplots)
        for panel in axes.flat:
            panel.patch.set_alpha(0.0)
        if title:
            fig.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold", color=INK)
        yield fig, axes
        tell_apart_in_grey(fig)


@contextmanager
def single_panel(height: float, title: str = "", share: float = 1.0) -> Iterator[tuple[Figure, Any]]:
    """A figure of one panel, and its axes."""
    with panels(height, title=title, share=share) as (fig, axes):
        yield fig, axes[0, 0]


@contextmanager
def panel_grid(
    count: int, margin: float, row_height: float, title: str = "", most: int = 2, **subplots: Any
) -> Iterator[tuple[Figure, list[Any], int]]:
    """A figure of ``count`` panels, ``most`` in a row, their axes, and how many are in a row; heights in inches."""
    columns = min(most, count)
    rows = math.ceil(count / columns)
    with panels(margin + rows * row_height, rows, columns, title, **subplots) as (fig, axes):
        for empty in axes.flat[count:]:
            empty.set_axis_off()
        yield fig, list(axes.flat[:count]), columns


@contextmanager
def panel_mosaic(height: float, layout: list[list[str]], **ratios: Any) -> Iterator[tuple[Figure, dict[str, Any]]]:
    """A figure of the page's width whose axes, by name, fill the cells of ``layout`` that hold their name."""
    with style():
        fig = _empty((WIDTH, height))
        fig.patch.set_alpha(0.0)
        axes: dict[str, Any] = fig.subplot_mosaic(layout, **ratios)
        for panel in axes.values():
            panel.patch.set_alpha(0.0)
        yield fig, axes
        tell_apart_in_grey(fig)


def _empty(size: tuple[float, float]) -> Figure:
    """A figure that nothing but its caller knows, or inside of `in_pyplot` one of pyplot's."""
    if _for_pyplot.get():
        from matplotlib import pyplot

        return pyplot.figure(figsize=size, layout="constrained")
    from matplotlib.figure import Figure

    return Figure(figsize=size, layout="constrained")


def in_pyplot(draw: Callable[..., Figure], *args: Any, origin: Origin = NOT_STATED, **kwargs: Any) -> NDArray[Any]:
    """The axes of ``draw(*args, **kwargs)``, drawn into a figure of pyplot, which notebooks show by themselves.

    ``draw`` is one of the functions of `dampyr.show.figures`; the axes come in the order in which it made them, ``(k,)``.
    ``origin``: of what it shows, which stands across it where that is not measured.
    """
    token = _for_pyplot.set(True)
    try:
        fig = draw(*args, **kwargs)
    finally:
        _for_pyplot.reset(token)
    fig.patch.set_alpha(1.0)
    origin.stamp(fig)
    return np.array(fig.axes)


def case_colours(names: Iterable[str], reference: str | None = None) -> dict[str, str]:
    """A colour for each case by its name, for all figures of a page; ``reference``, what the others are compared with, is grey.

    There are six; more cases begin with the first again.
    """
    others = [name for name in dict.fromkeys(names) if name != reference]
    grey = {} if reference is None else {reference: MUTED}
    return grey | dict(zip(others, cycle(CASES), strict=False))


def name_axes(axes: Axes, x: Axis, y: Axis) -> None:
    """Words and units on both axes."""
    axes.set_xlabel(x.label)
    axes.set_ylabel(y.label)


def logarithmic(panel: Axes) -> None:
    """Logarithmic scales on both axes, 1, 2 and 5 of each decade in plain numbers: a power law is a straight line."""
    from matplotlib.ticker import LogLocator, NullFormatter

    panel.set_xscale("log")
    panel.set_yscale("log")
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())


def legend(fig: Figure, *axes: Axes, columns: int = 3, min_entries: int = 2) -> None:
    """The names on the axes, each once, above the figure, or below where a title stands above it.

    There is none when there are fewer than ``min_entries``.
    """
    vars(fig)["dampyr_legend"] = (axes, columns, min_entries)  # for `fit_legend`
    fit_legend(fig)


def fit_legend(fig: Figure, scale: float = 1.0) -> None:
    """Make the legend of a figure anew, such as after its width or its lines have changed; text ``scale`` times as large.

    It is one line where there is room for it.
    """
    axes, columns, min_entries = vars(fig).get("dampyr_legend", ((), 1, 1))
    handles: dict[str, Any] = {}
    for panel in axes:
        for handle, name in zip(*panel.get_legend_handles_labels(), strict=True):
            handles.setdefault(name, handle)
    if not handles or len(handles) < min_entries:
        return
    for before in list(fig.legends):
        before.remove()
    loc = "outside lower left" if fig.get_suptitle() else "outside upper left"
    names = list(handles)
    width = fig.get_figwidth() / scale

    def fits(columns: int) -> bool:
        widest = [max(map(len, names[column::columns])) for column in range(columns)]
        return ENTRY * columns + CHARACTER * sum(widest) <= width

    columns = next((n for n in (len(names), *range(min(len(names), columns), 1, -1)) if fits(n)), 1)
    # matplotlib fills columns; people read lines
    names = [name for column in range(columns) for name in names[column::columns]]
    size = scale * _RC["legend.fontsize"]
    fig.legend([handles[name] for name in names], names, loc=loc, ncols=columns, fontsize=size)


def lightness(colour: Any, opacity: float | None = None) -> float:
    """CIE L* of a colour on white paper, 0 to 100."""
    from matplotlib.colors import to_rgba

    *rgb, alpha = to_rgba(colour)
    on_paper = 1.0 - alpha * (1.0 if opacity is None else opacity) * (1.0 - np.array(rgb))
    linear = np.where(on_paper <= 0.04045, on_paper / 12.92, ((on_paper + 0.055) / 1.055) ** 2.4)
    luminance = float(linear @ (0.2126, 0.7152, 0.0722))
    return float(116.0 * np.cbrt(luminance) - 16.0 if luminance > (6 / 29) ** 3 else luminance * (29 / 3) ** 3)


def alike_in_grey(lines: Iterable[Any]) -> bool:
    """Whether two of the lines, of one dash or one kind of points, have colours of which the greys are nearer than `APART`."""
    from matplotlib.colors import to_hex

    looks = {(to_hex(each.get_color()), _mark(each)): lightness(each.get_color(), each.get_alpha()) for each in lines}
    return any(
        colour != other and mark == its and abs(grey - its_grey) < APART
        for (colour, mark), grey in looks.items()
        for (other, its), its_grey in looks.items()
    )


def _mark(each: Any) -> str:
    """What a line has beside its colour: its dash, or the shape of its points."""
    dash = each.get_linestyle()
    return each.get_marker() if dash == "None" else f"{dash} {each._dash_pattern} {each.get_marker()}"


def tell_apart_in_grey(fig: Figure) -> None:
    """Give lines of different colours that print as one grey dashes, and points shapes: what they are compared with is paler.

    A figure whose greys are apart stays as it is, and so does what was drawn with a dash or another shape.
    """
    from matplotlib.colors import to_hex

    changed = False
    for axes in fig.axes:
        drawn = [each for each in axes.lines if each.get_visible()]
        lines = [each for each in drawn if each.get_linestyle() == "-"]
        points = [each for each in drawn if each.get_linestyle() == "None" and each.get_marker() == "o"]
        if alike_in_grey(lines):
            changed = True
            for each in lines:
                if to_hex(each.get_color()) == MUTED and each.get_alpha() is None:
                    each.set_alpha(PALE)
        if alike_in_grey(lines):
            for each in lines:
                _mark_line(each, to_hex(each.get_color()))
        if alike_in_grey(points):
            changed = True
            for each in points:
                each.set_marker(MARKERS.get(to_hex(each.get_color()), "o"))
    if changed:
        fit_legend(fig)  # its samples have the dashes


def _mark_line(each: Any, colour: str) -> None:
    """A dash, or where a line goes back over its own way, as the cycles of a loop do, whose dashes would fill, shapes on it."""
    if colour not in DASHES:
        return
    x = np.asarray(each.get_xdata(), dtype=float)
    if bool(np.all(np.diff(x) >= 0.0)):
        each.set_linestyle(DASHES[colour])
    else:
        each.set(marker=MARKERS[colour], markersize=4.0, markevery=max(1, x.size // SHAPES))


def thin(x: ArrayLike, y: ArrayLike, limit: int = POINTS) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """At most ``limit`` points of a line, with the extremes of x and y of each stretch kept.

    A stretch gives the points where x and y are least and greatest, in their order, so no peak is lost. A
    missing value (NaN) does not count as an extreme.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if len(x) <= limit:
        return x, y
    edges = np.linspace(0, len(x), max(limit // 4, 1) + 1).astype(int)
    starts, stops = edges[:-1, None], edges[1:, None]
    places = starts + np.arange(int(np.max(stops - starts)))  # a row a stretch
    inside = places < stops
    keep = [np.array([0, len(x) - 1])]
    for values in (x, y):
        rows = values[np.minimum(places, len(x) - 1)]
        known = inside & ~np.isnan(rows)
        for worst, extreme in ((np.inf, np.argmin), (-np.inf, np.argmax)):
            keep.append((edges[:-1] + extreme(np.where(known, rows, worst), axis=1))[known.any(axis=1)])
    chosen = np.unique(np.concatenate(keep))
    return x[chosen], y[chosen]


def line(axes: Axes, x: ArrayLike, y: ArrayLike, **kwargs: Any) -> None:
    """A line of few points."""
    axes.plot(*thin(x, y), **kwargs)


def line_with_peak(panel: Axes, time: ArrayLike, values: ArrayLike, axis: Axis, name: str, colour: str) -> None:
    """A history of SI ``values`` over ``time`` s, a dot on its greatest magnitude, which follows its name."""
    t, y = TIME.of(time), axis.of(values)
    peak = int(np.argmax(np.abs(y)))
    line(panel, t, y, color=colour, lw=1.1, label=f"{name}: {abs(y[peak]):.3g} {axis.unit}")
    panel.plot(t[peak], y[peak], "o", ms=4, color=colour)


@contextmanager
def on_white(fig: Figure) -> Iterator[None]:
    """Within it the figure hides what is behind it, which it does not on a page."""
    before = fig.patch.get_alpha()
    fig.patch.set_alpha(1.0)
    try:
        yield
    finally:
        fig.patch.set_alpha(before)
