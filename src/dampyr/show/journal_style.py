"""A figure as a journal wants it: a column wide, in its font, in greys that tell cases apart, with a decimal comma."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from itertools import cycle
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from dampyr.errors import InputError
from dampyr.show.figures import style
from dampyr.units import parse

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INCH = 0.0254  # m
NARROWEST, WIDEST = 0.05, 0.5  # m
SMALLEST = 6.5  # points, below which text is not shrunk
LETTER = 0.62  # of the size of a bold font: the mean width of its letters
LEAST = 0.8  # of the size of text, to which it shrinks with the figure
DASHES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (6, 1.5, 1, 1.5, 1, 1.5)), (0, (3, 1.5)))
MARKERS = "osD^vP"
GREYS = ("#000000", "#4d4d4d", "#7a7a7a", "#2b2b2b", "#666666", "#999999")
HATCHES = ("", "////", "....", "\\\\\\\\", "xxxx", "||||")
NEUTRAL = {style.INK, style.MUTED, style.GRID, "#ffffff", "#000000"}  # what has no colour that tells a case
_POINT = re.compile(r"(?<=\d)\.(?=\d)")


@dataclass(frozen=True)
class JournalStyle:
    """How a figure is written to a file.

    ``width`` is its width, m or text such as ``"88 mm"``, and its text shrinks with it to four fifths; ``font`` the family of
    its text, such as ``"DejaVu Serif"``; with ``grey`` colours are greys, told apart by dashes, markers and hatching; with
    ``decimal_comma`` numbers are written 0,5.
    """

    width: float | str | None = None
    font: str | None = None
    grey: bool = False
    decimal_comma: bool = False

    def __post_init__(self) -> None:
        if self.width is not None:
            width = parse(self.width, "m") if isinstance(self.width, str) else float(self.width)
            if not NARROWEST <= width <= WIDEST:
                raise InputError(
                    f"width = {1e3 * width:g} mm is not allowed; a figure is {1e3 * NARROWEST:g} to {1e3 * WIDEST:g} mm wide"
                )
            object.__setattr__(self, "width", width)
        if self.font is not None:
            _check_font(self.font)


AS_ON_A_PAGE = JournalStyle()


def _check_font(name: str) -> None:
    from difflib import get_close_matches

    from matplotlib.font_manager import fontManager

    names = {font.name for font in fontManager.ttflist} | {"sans-serif", "serif", "monospace"}
    if name not in names:
        near = get_close_matches(name, sorted(names), 3) or sorted(names)[:5]
        raise InputError(f"the font {name!r} is not installed here; there is {', '.join(near)}")


@contextmanager
def in_style(figure: Figure, journal: JournalStyle) -> Iterator[None]:
    """Within it the figure is as ``journal`` says; afterwards it is as it was."""
    if journal == AS_ON_A_PAGE:
        yield
        return
    scale = 1.0
    with ExitStack() as undo:
        undo.callback(style.fit_legend, figure)  # the last of all, when everything else is as it was
        if journal.width is not None:
            scale = _resize(figure, float(journal.width) / INCH, undo)
        if journal.font is not None:
            _change_font(figure, journal.font, undo)
        if journal.grey:
            _without_colour(figure, undo)
        if journal.decimal_comma:
            _with_comma(figure, undo)
        style.fit_legend(figure, scale)
        _break_long_lines(figure, undo)
        yield


def _set(undo: ExitStack, thing: Any, **values: Any) -> None:
    """Set properties of an artist, and set them back in the end."""
    for name, value in values.items():
        undo.callback(getattr(thing, f"set_{name}"), getattr(thing, f"get_{name}")())
        getattr(thing, f"set_{name}")(value)


def _texts(figure: Figure) -> list[Any]:
    from matplotlib.text import Text

    figure.draw_without_rendering()  # makes the labels of ticks
    return figure.findobj(Text)


def _resize(figure: Figure, width: float, undo: ExitStack) -> float:
    """Change the width, and the size of the text with it; by how much the text has shrunk."""
    old_width, old_height = figure.get_size_inches()
    ratio = width / old_width
    # narrower figures are relatively higher, for their text does not shrink as they do
    figure.set_size_inches(width, old_height * (ratio**0.5 if ratio < 1.0 else ratio**0.75))
    undo.callback(figure.set_size_inches, old_width, old_height)
    factor = min(1.0, max(LEAST, ratio))
    for text in _texts(figure):
        _set(undo, text, fontsize=max(min(SMALLEST, float(text.get_fontsize())), factor * float(text.get_fontsize())))
    for panel in figure.axes:
        for axis in (panel.xaxis, panel.yaxis):
            size = axis.get_tick_params().get("labelsize", 9.0)
            axis.set_tick_params(labelsize=factor * size)
            undo.callback(axis.set_tick_params, labelsize=size)
    return factor


def _break_long_lines(figure: Figure, undo: ExitStack) -> None:
    """A title in several lines where it is wider than the figure, the unit of an axis on a line of its own where its name is
    longer than the axis."""
    if title := figure.get_suptitle():
        artist = next(text for text in _texts(figure) if text.get_text() == title)
        letters = int(72 * figure.get_figwidth() / (LETTER * float(artist.get_fontsize())))
        _set(undo, artist, text=fill(title, letters))
    figure.draw_without_rendering()
    for panel in figure.axes:
        box = panel.get_window_extent()
        for axis, room, side in ((panel.xaxis, box.width, "width"), (panel.yaxis, box.height, "height")):
            if getattr(axis.label.get_window_extent(), side) > room:
                _set(undo, axis.label, text=axis.label.get_text().replace(" [", "\n["))


def _change_font(figure: Figure, font: str, undo: ExitStack) -> None:
    import matplotlib

    serif = "serif" in font.lower().replace("sans-serif", "") or "times" in font.lower()
    undo.enter_context(matplotlib.rc_context({"font.family": font}))
    for text in _texts(figure):
        _set(undo, text, fontfamily=font, math_fontfamily="stix" if serif else "dejavusans")


class _Greys:
    """A grey, a dash, a marker and a hatching for each colour of a figure, in the order in which they are met."""

    def __init__(self) -> None:
        self._looks: dict[str, tuple[str, Any, str, str]] = {}
        self._fresh = cycle(zip(GREYS, DASHES, MARKERS, HATCHES, strict=True))

    def of(self, colour: Any) -> tuple[str, Any, str, str] | None:
        """The look of what has this colour; None for what is grey already, or not seen."""
        from matplotlib.colors import to_hex, to_rgba

        name = to_hex(colour)
        if name in NEUTRAL or to_rgba(colour)[3] == 0.0:
            return None
        if name not in self._looks:
            self._looks[name] = next(self._fresh)
        return self._looks[name]

    def faded(self, colour: Any) -> tuple[float, ...] | None:
        """The grey of a colour, as transparent as it is."""
        from matplotlib.colors import to_rgba

        found = self.of(colour)
        return None if found is None else (*to_rgba(found[0])[:3], float(to_rgba(colour)[3]))


def _without_colour(figure: Figure, undo: ExitStack) -> None:
    """Lines, markers, areas and text of one colour have one grey and one dash, marker or hatching, in the order of the axes."""
    from matplotlib.collections import Collection, LineCollection
    from matplotlib.patches import Rectangle
    from matplotlib.text import Text

    greys = _Greys()
    lines = [line for panel in figure.axes for line in panel.lines]
    alike = len({line.get_marker() for line in lines} & set(MARKERS)) <= 1  # else they say something and are left
    for line in lines:
        _grey_line(line, greys, alike, undo)
    patches: list[Any] = [
        each for panel in figure.axes for each in (*panel.findobj(Collection), *panel.findobj(Rectangle))
        if each is not panel.patch
    ]  # fmt: skip
    areas = [each for each in patches if not isinstance(each, LineCollection) and np.size(each.get_facecolor())]
    colours = [np.atleast_2d(area.get_facecolor())[0] for area in areas]
    several = len({greys.faded(colour) for colour in colours} - {None}) > 1  # one kind of area needs no hatching
    for area, colour in zip(areas, colours, strict=True):
        if found := greys.of(colour):
            # a hatching has the colour of the edge
            _set(undo, area, facecolor=greys.faded(colour), edgecolor=greys.faded(colour))
            if several:
                _set(undo, area, hatch=found[3], edgecolor=found[0])
    for bars in (each for each in patches if isinstance(each, LineCollection) and len(each.get_edgecolor())):
        if grey := greys.faded(bars.get_edgecolor()[0]):
            _set(undo, bars, edgecolor=grey)
    for text in figure.findobj(Text):
        if grey := greys.faded(text.get_color()):
            _set(undo, text, color=grey)


def _grey_line(line: Any, greys: _Greys, alike: bool, undo: ExitStack) -> None:
    found = greys.of(line.get_color())
    # the colour of a marker may be that of its line, and is read before that is changed
    for part in ("markerfacecolor", "markeredgecolor"):
        value = getattr(line, f"get_{part}")()
        if not (isinstance(value, str) and value.lower() in ("none", "auto")) and (marker := greys.of(value)):
            _set(undo, line, **{part: marker[0]})
    if found:
        _set(undo, line, color=found[0])
        if line.get_linestyle() == "-":
            _set(undo, line, linestyle=found[1])
        if alike and line.get_marker() in MARKERS:
            _set(undo, line, marker=found[2])


def _with_comma(figure: Figure, undo: ExitStack) -> None:
    from matplotlib.ticker import Formatter

    class CommaFormatter(Formatter):
        """What another formatter writes, with commas in the place of points."""

        def __init__(self, inner: Any) -> None:
            self.inner = inner

        def __call__(self, x: float, pos: int | None = None) -> str:
            return with_comma(self.inner(x, pos))

        def set_locs(self, locs: Any) -> None:
            self.inner.set_locs(locs)

        def format_ticks(self, values: Any) -> list[str]:
            return [with_comma(text) for text in self.inner.format_ticks(values)]

        def get_offset(self) -> str:
            return with_comma(self.inner.get_offset())

    for panel in figure.axes:
        for axis in (panel.xaxis, panel.yaxis):
            for kind in ("major", "minor"):
                before = getattr(axis, f"get_{kind}_formatter")()
                after = CommaFormatter(before)
                getattr(axis, f"set_{kind}_formatter")(after)
                before.set_axis(axis)
                undo.callback(getattr(axis, f"set_{kind}_formatter"), before)
        for handle in panel.get_legend_handles_labels()[0]:
            _set(undo, handle, label=with_comma(str(handle.get_label())))
    for text in _texts(figure):
        if _POINT.search(text.get_text()):
            _set(undo, text, text=with_comma(text.get_text()))


def with_comma(text: str) -> str:
    """A text with decimal commas, such as ``0,5`` of ``0.5``; between dollar signs in braces, so that no space follows."""
    parts = text.split("$")
    return "$".join(_POINT.sub("{,}" if k % 2 else ",", part) for k, part in enumerate(parts))
