"""The loops of records that failed, with the band of each point that lies outside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.origin import NOT_STATED, Origin
from dampyr.show.figures import style
from dampyr.show.figures.style import FORCE, VELOCITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class FailedLoop:
    """A record's velocity m/s and force N ``(n,)``.

    ``outside`` (k, 4) holds the peak velocity m/s, the force N and the ends of the band N of each point outside.
    """

    velocity: ArrayLike
    force: ArrayLike
    outside: Sequence[tuple[float, float, float, float]]


def failed_loops(loops: Mapping[str, FailedLoop], record_origin: Origin = NOT_STATED) -> Figure:
    """A panel for each record: its force over the velocity, and each point outside beside the band that it should lie in."""
    with style.panels(2.5, 1, max(len(loops), 2)) as (fig, axes):
        for panel, (name, loop) in zip(axes[0], loops.items(), strict=False):
            v, force = VELOCITY.of(loop.velocity), FORCE.of(loop.force)
            style.line(panel, v, force, color=style.MEASURED, lw=0.9, label=record_origin.series)
            points: NDArray[np.float64] = np.asarray(loop.outside, dtype=float).reshape(-1, 4)
            at = VELOCITY.of(points[:, 0])
            panel.vlines(
                at,
                FORCE.of(points[:, 2]),
                FORCE.of(points[:, 3]),
                color=style.BLUE,
                lw=5.0,
                alpha=0.55,
                label="its band",
            )
            panel.plot(
                at, FORCE.of(points[:, 1]), "D", ms=4.5, mfc="none", mew=1.3, color=style.VERMILLION, label="outside"
            )
            panel.set_title(name, fontsize=9.5)
            panel.set_xlabel(VELOCITY.label)
        axes[0, 0].set_ylabel(FORCE.label)
        for empty in axes[0, len(loops) :]:
            empty.set_axis_off()
        style.legend(fig, axes[0, 0])
    return fig
