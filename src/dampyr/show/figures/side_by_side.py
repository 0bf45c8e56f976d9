"""Measured and simulated records of the same drive, one pair below another: the motion, and the loops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from dampyr.show.figures import style
from dampyr.show.figures.style import DISPLACEMENT, FORCE, TIME

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike


@dataclass(frozen=True)
class MotionStretch:
    """A stretch of a record: time s, displacement m, force N, ``(n,)`` each."""

    time: ArrayLike
    displacement: ArrayLike
    force: ArrayLike


def side_by_side(pairs: Sequence[tuple[str, MotionStretch, MotionStretch]]) -> Figure:
    """Pairs of a name, what was measured and what was simulated: displacement over time, and force over displacement."""
    with style.panels(0.6 + 1.9 * len(pairs), len(pairs), 2, width_ratios=(1.6, 1.0)) as (fig, axes):
        for (left, right), (name, measured, simulated) in zip(axes, pairs, strict=True):
            for motion, colour, label in (
                (measured, style.MEASURED, "measured"),
                (simulated, style.SERIES[0], "simulated"),
            ):
                x = DISPLACEMENT.of(motion.displacement)
                style.line(left, TIME.of(motion.time), x, color=colour, lw=1.2, label=label)
                style.line(right, x, FORCE.of(motion.force), color=colour, lw=1.0, label=label)
            left.set_title(name, loc="left", fontsize=9.5)
            left.set_ylabel(DISPLACEMENT.label)
            right.set_ylabel(FORCE.label)
        axes[-1, 0].set_xlabel(TIME.label)
        axes[-1, 1].set_xlabel(DISPLACEMENT.label)
        style.legend(fig, axes[0, 0])
    return fig
