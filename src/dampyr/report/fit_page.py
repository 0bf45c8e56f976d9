"""The page of one fit: the damper, its accuracy and its residuals."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

import dampyr
from dampyr.figures.scores import scores
from dampyr.identification import Fit, Identified, Validation, findings, warnings_of
from dampyr.models import Damper
from dampyr.report.best_and_worst import by_input, extremes, record_section
from dampyr.report.blocks import Block, Cell, FigureBlock, Section, Table, Text, sentence
from dampyr.report.fit_sections import correlation_blocks, fit_blocks, score_table
from dampyr.report.html_page import page, write_page
from dampyr.report.leaderboard_section import leaderboard_section
from dampyr.report.prediction_section import mean_l1, prediction_section
from dampyr.report.range_section import range_section
from dampyr.report.residual_section import residual_section


def write_fit_page(
    fit: Fit | Identified,
    path: Path,
    sections: Sequence[Section] = (),
    validation: Validation | Sequence[Validation] | None = None,
) -> Path:
    """Write the page of a fit, or of the result of `dampyr.identification.identify`, and return its path.

    It holds a summary; the leaderboard, if any, and ``sections`` of the caller's; parameters with intervals, laws and
    correlations; the calibrated range; how well the fit describes its records; with ``validation`` (one or several), how well
    it predicts others; the analysis of residuals; the best and the worst record.
    """
    checks = [validation] if isinstance(validation, Validation) else list(validation or ())
    if isinstance(fit, Identified):
        checks = [*fit.validations, *checks]
        sections = [*([leaderboard_section(fit.board)] if fit.board else []), *sections]
        damper, fit = fit.damper, fit.fit
    else:
        damper = fit.damper
    html = page(
        f"Identified: {fit.problem.composition}",
        [
            _short(fit, checks),
            *sections,
            Section("Parameters", fit_blocks(fit)),
            Section("Correlation of the parameters", correlation_blocks(fit)),
            range_section(fit),
            _scores(fit),
            *([prediction_section(fit, checks)] if checks else []),
            residual_section(fit.residuals),
            *(_record(fit, words, name) for words, name in extremes(fit.scores)),
        ],
        subtitle=f"{_counted(len(fit.records), 'record')} by least squares over the whole motion.",
        provenance=_provenance(fit, damper),
    )
    write_page(path, html)
    return path


def _counted(number: int, noun: str) -> str:
    return f"One {noun}, fitted" if number == 1 else f"{number} {noun}s, fitted together"


def _provenance(fit: Fit, damper: Damper | None) -> dict[str, str]:
    if damper is not None:
        return dict(damper.provenance)
    return {"records": ", ".join(record.name for record in fit.records), "dampyr": dampyr.__version__}


def _short(fit: Fit, checks: Sequence[Validation]) -> Section:
    """What a reader who reads nothing else should know."""
    l1 = {name: one.l1 for name, one in fit.scores.items()}
    worst = extremes(fit.scores)[-1][1]
    rows: list[list[Cell]] = [
        ["model", str(fit.problem.composition)],
        [
            "the search",
            ("" if fit.converged or fit.reason.startswith("did not") else "did not converge: ") + fit.reason,
        ],
        ["input", _inputs(fit)],
        [
            "fits its records",
            f"L1 {100 * float(np.mean(list(l1.values()))):.2g} % on average, {100 * l1[worst]:.2g} % in {worst}",
        ],
    ]
    for one in checks:
        summary = f"L1 {100 * mean_l1(one):.2g} % on average, {len(one.scores)} records, split by {one.split}"
        rows.append(["predicts unseen records", summary])
    if not checks:
        rows.append(["predicts unseen records", "not tested (dampyr identify --predict)"])
    rows.append(["errors", f"by {fit.clusters}; {_unsure(fit)}"])
    blocks: list[Block] = [Table(("quantity", "result"), rows)]
    warning_texts = [*warnings_of(fit.residuals), *fit.notes]
    if warning_texts:
        blocks.append(Text("\n\n".join(("Before you use the numbers:", *map(sentence, warning_texts)))))
    else:
        blocks.append(Text(sentence(findings(fit.residuals)[0])))
    return Section("In short", blocks)


def _inputs(fit: Fit) -> str:
    residuals = fit.residuals
    values = [f"{group.input_value:.5g}" for group in residuals.groups]
    if len(values) > 8:
        return f"{len(values)} values from {values[0]} to {values[-1]} {residuals.unit}"
    return f"{', '.join(values)} {residuals.unit}"


def _unsure(fit: Fit) -> str:
    """How many parameters have a small standard error, and how many have none."""
    precise = [
        abs(fit.stderr[name]) <= 0.1 * abs(value)
        for name, value in fit.parameters.items()
        if np.isfinite(fit.stderr[name])
    ]
    undetermined = len(fit.parameters) - len(precise)
    text = f"{sum(precise)} of {len(fit.parameters)} parameters have a standard error of 10 % or less"
    text = f"{text}, {undetermined} have none" if undetermined else text
    if not fit.within_records:
        return text
    return f"{text}; {len(fit.within_records)} of these errors hold within these records only"


def _scores(fit: Fit) -> Section:
    groups = by_input(fit.records, {name: one.l1 for name, one in fit.scores.items()})
    return Section(
        "Goodness of fit",
        [
            Text("These records were fitted: the scores describe the fit and are not predictions."),
            FigureBlock(scores(groups), "L1 ratio of each record, by input."),
            score_table(fit.scores, "From 2 s after the motion starts, each record's own offset taken."),
        ],
    )


def _record(fit: Fit, words: str, name: str) -> Section:
    k = [record.name for record in fit.records].index(name)
    one, force = fit.problem.pieces[k], fit.forces[k]
    seen = one.t >= fit.scores[name].window.start - 1e-9
    return record_section(words, name, (one.t[seen], one.x[seen], one.v[seen], one.force[seen], force[seen]), "fit")
