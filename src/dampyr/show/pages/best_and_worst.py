"""The best and the worst record of some scores, as loops and over time."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from dampyr.identification import Fit, Score
from dampyr.origin import NOT_STATED, Origin
from dampyr.show.figures.loops_and_history import loops_and_history
from dampyr.show.pages.blocks import FigureBlock, Section

Array = NDArray[np.float64]
SECONDS = 6.0  # s of the history: a few cycles, so that single loops can be told apart


def extremes(scores: Mapping[str, Score]) -> list[tuple[str, str]]:
    """What to call them, and the names of the best and the worst record by L1; one that has no number counts as worst."""
    ranked = sorted(scores, key=lambda name: scores[name].l1 if math.isfinite(scores[name].l1) else math.inf)
    if len(ranked) == 1:
        return [("The record", ranked[0])]
    return [("The best record", ranked[0]), ("The worst record", ranked[-1])]


def record_section(
    title: str,
    name: str,
    channels: tuple[Array, Array, Array, Array, Array],
    model: str,
    origin: Origin = NOT_STATED,
) -> Section:
    """One record: ``channels`` are time s, displacement m, velocity m/s, measured and modelled force N, each (n,),
    ``origin`` that of the record."""
    t, x, v, measured, force = channels
    figure = loops_and_history(t, x, v, measured, force, SECONDS, model, origin)
    over_time = f"the first {SECONDS:g} s that were scored" if t[-1] > t[0] + SECONDS else "over time"
    return Section(
        f"{title}: {name}",
        [FigureBlock(figure, f"{name}: loops, and {over_time} with the residual ({origin.series} minus {model}).")],
    )


def best_and_worst_sections(fit: Fit) -> list[Section]:
    """The best and the worst record of a fit, over the samples that are scored."""
    sections = []
    for title, name in extremes(fit.scores):
        k = [record.name for record in fit.records].index(name)
        piece, force = fit.problem.pieces[k], fit.forces[k]
        scored = piece.t >= fit.scores[name].window.start - 1e-9
        channels = (piece.t[scored], piece.x[scored], piece.v[scored], piece.force[scored], force[scored])
        sections.append(record_section(title, name, channels, "fit", fit.records[k].origin))
    return sections
