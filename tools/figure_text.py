"""Text of a figure that nobody can read: it overlaps other text, it is cut at an edge, or it is too small.

The boxes are those of the lines of text as they are drawn, taken from the calls of the renderer, so that labels of ticks that
matplotlib leaves out do not count. The word of an origin across a figure, which is meant to lie over it, is pale and left out.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import RendererAgg

SMALLEST = 6.0  # points
SLACK = 0.12  # of the height of a line: descenders and accents may reach so far into each other
GAP = 0.3  # of the height of a line: closer together two texts on one line are read as one
PALE = 0.5  # the opacity below which text is a watermark


@dataclass(frozen=True)
class Line:
    """A line of text as it is drawn: its box in pixels from the lower left corner, and what it is cut to."""

    text: str
    points: float
    height: float
    turned: bool  # by a right angle
    left: float
    low: float
    right: float
    high: float
    clip: tuple[float, float, float, float]  # left, low, right, high

    def overlaps(self, other: Line) -> bool:
        """Whether the boxes share more than the slack, or stand on one line without a gap."""
        height = min(self.height, other.height)
        across = min(self.right, other.right) - max(self.left, other.left)
        up = min(self.high, other.high) - max(self.low, other.low)
        along, beside = (up, across) if self.turned else (across, up)
        one_line = self.turned == other.turned and beside > height / 2 and along > -GAP * height
        return one_line or (across > SLACK * height and up > SLACK * height)

    @property
    def cut(self) -> bool:
        """Whether it reaches over an edge of the figure, or of a panel that clips it."""
        slack = SLACK * self.height
        left, low, right, high = self.clip
        return (
            self.left < left - slack or self.low < low - slack or self.right > right + slack or self.high > high + slack
        )


class _Recorder(RendererAgg):
    """A renderer that notes each line of text."""

    def __init__(self, width: float, height: float, dpi: float) -> None:
        super().__init__(width, height, dpi)
        self.lines: list[Line] = []

    def draw_text(
        self, gc: Any, x: float, y: float, s: str, prop: Any, angle: float, ismath: Any, mtext: Any = None
    ) -> None:
        if s.strip() and (gc.get_alpha() is None or gc.get_alpha() >= PALE):
            self.lines.append(self._line(gc, x, y, s, prop, angle, ismath))

    def _line(self, gc: Any, x: float, y: float, s: str, prop: Any, angle: float, ismath: Any) -> Line:
        width, height, descent = self.get_text_width_height_descent(s, prop, ismath)
        corners = np.array([(0, -descent), (width, -descent), (width, height - descent), (0, height - descent)])
        turn = np.deg2rad(angle)
        corners = corners @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        corners += np.array([x, self.height - y])
        (left, low), (right, high) = corners.min(axis=0), corners.max(axis=0)
        clip = (0.0, 0.0, float(self.width), float(self.height))
        if (box := gc.get_clip_rectangle()) is not None:
            clip = (max(clip[0], box.x0), max(clip[1], box.y0), min(clip[2], box.x1), min(clip[3], box.y1))
        return Line(s, prop.get_size_in_points(), height, abs(angle % 180.0 - 90.0) < 1.0, left, low, right, high, clip)


def lines_of_text(figure: Any) -> list[Line]:
    """The lines of text of a figure, as they are drawn."""
    figure.draw_without_rendering()  # the layout
    width, height = figure.bbox.size
    recorder = _Recorder(width, height, figure.dpi)
    figure.draw(recorder)
    return recorder.lines


def unreadable(figure: Any) -> list[str]:
    """What is wrong with the text of a figure, a sentence each; none where all of it can be read."""
    lines = lines_of_text(figure)
    return [
        *(
            f"{first.text!r} overlaps {second.text!r}"
            for first, second in itertools.combinations(lines, 2)
            if first.overlaps(second)
        ),
        *(f"{line.text!r} is cut at an edge" for line in lines if line.cut),
        *(f"{line.text!r} has {line.points:.1f} points" for line in lines if line.points < SMALLEST),
    ]
