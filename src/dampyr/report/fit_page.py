"""The page of one fit."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from dampyr.identification import Fit
from dampyr.report.blocks import FigureBlock, Section, Text
from dampyr.report.figures.history import history
from dampyr.report.figures.loops import loops
from dampyr.report.figures.scores import scores
from dampyr.report.fitted import fit_blocks, score_table
from dampyr.report.page import page, write_page


def write_fit_page(fit: Fit, path: Path) -> Path:
    """Write the page of a fit: parameters, laws, scores, and the best and the worst record as loops and over time."""
    html = page(
        f"Identified: {fit.problem.composition}",
        [
            Section("Parameters", fit_blocks(fit)),
            Section("How well it describes the records", _scores(fit)),
            *(_record(fit, words, name) for words, name in _extremes(fit)),
        ],
        subtitle=f"{len(fit.records)} records, fitted together by least squares over their whole motion.",
        provenance={} if fit.damper is None else dict(fit.damper.provenance),
    )
    write_page(path, html)
    return path


def _scores(fit: Fit) -> list[Text | FigureBlock]:
    groups: dict[str, list[float]] = {}
    for record in fit.records:
        groups.setdefault(f"{record.input_value:g} {record.input}", []).append(fit.scores[record.name].l1)
    return [
        Text(
            "These records were fitted, so what follows is a description and no prediction. The intervals above "
            "describe the fit; where the model misses the damper's behaviour they do not hold the truth."
        ),
        FigureBlock(scores(groups), "L1 ratio of each record, by input."),
        score_table(fit.scores, "From 2 s after the motion starts, each record's own offset taken."),  # type: ignore[list-item]
    ]


def _extremes(fit: Fit) -> list[tuple[str, str]]:
    ranked = sorted(fit.scores, key=lambda name: fit.scores[name].l1)
    if len(ranked) == 1:
        return [("The record", ranked[0])]
    return [("The best record", ranked[0]), ("The worst record", ranked[-1])]


def _record(fit: Fit, words: str, name: str) -> Section:
    k = [record.name for record in fit.records].index(name)
    one, force = fit.problem.pieces[k], fit.forces[k]
    seen = one.t >= fit.scores[name].window.start - 1e-9
    few = seen & (np.cumsum(seen) <= max(200, round(6.0 / float(np.median(np.diff(one.t))))))
    return Section(
        f"{words}: {name}",
        [
            FigureBlock(loops(one.x[seen], one.v[seen], one.force[seen], {"fit": force[seen]}), f"{name}: loops."),
            FigureBlock(
                history(one.t[few], one.force[few], force[few], name="fit"),
                f"{name}: the first seconds and what is left.",
            ),
        ],
    )
