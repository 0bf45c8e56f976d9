"""The page of one fit: the damper, its accuracy and its residuals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dampyr.findings import Finding, besides
from dampyr.identification import Fit, identifiability
from dampyr.identification.fits.diagnostics import findings
from dampyr.identification.scoring.validation import Validation
from dampyr.input_kinds import INPUTS
from dampyr.phrases import counted, sentence
from dampyr.show.figures.loops import loops
from dampyr.show.figures.loops_by_input import RecordLoop, loops_by_input
from dampyr.show.identification.fit_predictions import mean_l1, prediction_in_words
from dampyr.show.identification.result import measured_and_fitted, parameter_table
from dampyr.show.identification.score import input_words
from dampyr.show.pages.best_and_worst import best_and_worst_sections
from dampyr.show.pages.blocks import Block, FigureBlock, Section, Text
from dampyr.show.pages.fit_sections import correlation_blocks, error_tables, law_blocks, score_blocks
from dampyr.show.pages.html_page import page
from dampyr.show.pages.identifiability_section import identifiability_section
from dampyr.show.pages.leaderboard_section import leaderboard_section
from dampyr.show.pages.level_sections import levels_section
from dampyr.show.pages.prediction_section import prediction_section
from dampyr.show.pages.range_section import range_section
from dampyr.show.pages.residual_section import residual_section
from dampyr.show.pages.uncertainty_section import uncertainty_section
from dampyr.show.table import Cell, Table, Verdict

PANELS = 4  # of loops beside one another: more are too small to read


def html(fit: Fit, sections: Sequence[Section] = (), *, call: str = "") -> str:
    """The page of a fit.

    Its first screen holds the verdict, loops and parameters. Then come the leaderboard, if any, and ``sections`` of the
    caller's; all findings; errors, laws and correlations of the parameters; what the records cannot separate; the
    calibrated range; how well the fit describes its records; how well it predicts others where that was asked for; the
    analysis of residuals; the best and the worst record.
    """
    checks = fit.validations
    sections = [*([leaderboard_section(fit.leaderboard)] if fit.leaderboard else []), *sections]
    number = len(fit.records)
    records = "One record, fitted" if number == 1 else f"{number} records, fitted together"
    others = besides(fit.findings, [fit.verdict.words])
    return page(
        f"Identified: {fit.problem.composition}",
        [
            _answer(fit, checks, others),
            *sections,
            _search_and_findings(fit, checks, others),
            Section("Errors and laws of the parameters", [*error_tables(fit), *law_blocks(fit)]),
            Section("Correlation of the parameters", correlation_blocks(fit)),
            *([levels] if (levels := levels_section(fit)) is not None else []),
            identifiability_section(identifiability(fit), fit.residuals.unit in INPUTS),
            range_section(fit),
            *([measured] if (measured := uncertainty_section(fit.records)) is not None else []),
            Section("Goodness of fit", score_blocks(fit)),
            *([prediction_section(fit, checks)] if checks else []),
            residual_section(fit.residuals),
            *best_and_worst_sections(fit),
        ],
        subtitle=f"{records} by least squares over the whole motion.",
        provenance=_provenance(fit),
        call=call,
        origin=fit.origin,
    )


def _provenance(fit: Fit) -> dict[str, str]:
    """What the card says of itself, or the names of the records; these not where the page lists their files."""
    names = {"records": ", ".join(record.name for record in fit.records)}
    stated = names if fit.damper is None else dict(fit.damper.provenance)
    return {name: value for name, value in stated.items() if name != "records" or not fit.origin.sources}


def _answer(fit: Fit, checks: Sequence[Validation], others: Sequence[Finding]) -> Section:
    """What a reader came for, on one screen: the verdict, the loops, the parameters, and the worst of the findings."""
    verdict = fit.verdict
    kind = {"good": "agrees", "bad": "differs"}.get(verdict.kind)
    blocks: list[Block] = [Verdict(kind, verdict.words) if kind else Text(verdict.words)]  # type: ignore[arg-type]
    blocks += [Text(prediction_in_words(validation)) for validation in checks]
    blocks += [_loops(fit), parameter_table(fit)]
    if others:
        more = f"\n\n{counted(len(others) - 1, 'more finding')} below." if len(others) > 1 else ""
        blocks.append(Text(f"Before you use the numbers: {others[0]}.{more}"))
    return Section("In short", blocks)


def _loops(fit: Fit) -> FigureBlock:
    """The loops of the median record of some inputs, or of the fit where it has one input."""
    groups: dict[str, list[int]] = {}
    for k in sorted(range(len(fit.records)), key=lambda k: float(np.mean(fit.problem.pieces[k].u))):
        groups.setdefault(input_words(fit.records[k]), []).append(k)
    if len(groups) == 1:
        record = measured_and_fitted(fit)[-1]
        words = f"{record}, whose misfit is the median: measured and fitted force."
        return FigureBlock(loops(*measured_and_fitted(fit)[:-1], record_origin=fit.origin), words)
    names = list(groups)
    shown = [names[k] for k in np.unique(np.linspace(0, len(names) - 1, min(len(names), PANELS)).round().astype(int))]
    medians = {name: sorted(groups[name], key=lambda k: fit.scores[fit.records[k].name].l1) for name in shown}
    drawn = {name: numbers[len(numbers) // 2] for name, numbers in medians.items()}
    pieces = {name: fit.problem.pieces[k] for name, k in drawn.items()}
    figure = loops_by_input(
        {name: RecordLoop(pieces[name].x, pieces[name].force, {"fit": fit.forces[k]}) for name, k in drawn.items()},
        fit.origin,
    )
    records = ", ".join(fit.records[k].name for k in drawn.values())
    every = "each input" if len(shown) == len(names) else f"{len(shown)} of {len(names)} inputs"
    return FigureBlock(figure, f"Measured and fitted force; the record with the median misfit of {every}: {records}.")


def _search_and_findings(fit: Fit, checks: Sequence[Validation], others: Sequence[Finding]) -> Section:
    """What else is to be looked at, and what was fitted."""
    rows: list[list[Cell]] = [["input", _inputs(fit)]] if fit.residuals.unit in INPUTS else []
    for validation in checks:
        predicted = f"{len(validation.scores)} records, split by {validation.split}"
        summary = f"L1 {100 * mean_l1(validation):.2g} % on average, {predicted}"
        rows.append(["predicts unseen records", summary])
    if not checks:
        rows.append(["predicts unseen records", "not tested (dampyr identify --predict)"])
    rows.append(["errors", f"by {fit.clusters}; {_precision(fit)}"])
    more = [Text("\n\n".join(finding.sentence for finding in others[1:]))] if len(others) > 1 else []
    residual = [] if others else [Text(sentence(findings(fit.residuals)[0]))]
    return Section("Findings", [*more, *residual, Table(("quantity", "result"), rows)])


def _inputs(fit: Fit) -> str:
    residuals = fit.residuals
    values = [f"{group.input_value:.5g}" for group in residuals.groups]
    if len(values) > 8:
        return f"{len(values)} values from {values[0]} to {values[-1]} {residuals.unit}"
    return f"{', '.join(values)} {residuals.unit}"


def _precision(fit: Fit) -> str:
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
