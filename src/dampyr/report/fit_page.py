"""The page of one fit: the damper, its accuracy and its residuals."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from dampyr.findings import Finding
from dampyr.identification import Fit, Identified, Validation, identifiability
from dampyr.identification.fits.diagnostics import findings
from dampyr.report.best_and_worst import best_and_worst_sections, extremes
from dampyr.report.blocks import Block, Cell, Section, Table, Text, Verdict, to_look_at
from dampyr.report.fit_sections import correlation_blocks, fit_blocks, score_blocks
from dampyr.report.html_page import page, write_page
from dampyr.report.identifiability_section import identifiability_section
from dampyr.report.leaderboard_section import leaderboard_section
from dampyr.report.level_sections import levels_section
from dampyr.report.prediction_section import mean_l1, prediction_section
from dampyr.report.range_section import range_section
from dampyr.report.residual_section import residual_section
from dampyr.report.uncertainty_section import uncertainty_section
from dampyr.representation import rounded, sentence


def write_fit_page(
    fit: Fit | Identified,
    path: str | Path,
    sections: Sequence[Section] = (),
    validation: Validation | Sequence[Validation] | None = None,
) -> Path:
    """Write the page of a fit, or of the result of `dampyr.identification.identify`, and return its path.

    It holds a summary; the leaderboard, if any, and ``sections`` of the caller's; parameters with intervals, laws and
    correlations; what the records cannot separate; the calibrated range; how well the fit describes its records; with
    ``validation`` (one or several), how well it predicts others; the analysis of residuals; the best and the worst record.
    """
    checks = [validation] if isinstance(validation, Validation) else list(validation or ())
    if isinstance(fit, Identified):
        checks = [*fit.validations, *checks]
        sections = [*([leaderboard_section(fit.board)] if fit.board else []), *sections]
        inseparable, listed = fit.identifiability, fit.findings
        damper, fit = fit.damper, fit.fit
    else:
        damper, inseparable, listed = fit.damper, identifiability(fit), fit.findings
    number = len(fit.records)
    records = "One record, fitted" if number == 1 else f"{number} records, fitted together"
    if damper is not None:
        provenance = dict(damper.provenance)
    else:
        provenance = {"records": ", ".join(record.name for record in fit.records)}
    html = page(
        f"Identified: {fit.problem.composition}",
        [
            _summary(fit, checks, listed),
            *sections,
            Section("Parameters", fit_blocks(fit)),
            Section("Correlation of the parameters", correlation_blocks(fit)),
            *([levels] if (levels := levels_section(fit)) is not None else []),
            identifiability_section(inseparable),
            range_section(fit),
            *([measured] if (measured := uncertainty_section(fit.records)) is not None else []),
            Section("Goodness of fit", score_blocks(fit)),
            *([prediction_section(fit, checks)] if checks else []),
            residual_section(fit.residuals),
            *best_and_worst_sections(fit),
        ],
        subtitle=f"{records} by least squares over the whole motion.",
        provenance=provenance,
        call=f"dampyr.report.write_fit_page(fit, {Path(path).name!r})",
        origin=fit.origin,
    )
    return write_page(path, html)


def _summary(fit: Fit, checks: Sequence[Validation], listed: Sequence[Finding]) -> Section:
    """What a reader who reads nothing else should know."""
    inputs, precision = _inputs(fit), _precision(fit)
    l1 = {name: one.l1 for name, one in fit.scores.items()}
    mean, worst = 100 * float(np.mean(list(l1.values()))), extremes(fit.scores)[-1][1]
    rows: list[list[Cell]] = [
        ["model", str(fit.problem.composition)],
        ["search and misfit", _verdict(fit)],
        ["the search", fit.reason],
        ["input", inputs],
        [
            "fits its records",
            f"L1 {rounded(mean, 2)} % on average, {rounded(100 * l1[worst], 2)} % in {worst}",
        ],
    ]
    for one in checks:
        summary = f"L1 {100 * mean_l1(one):.2g} % on average, {len(one.scores)} records, split by {one.split}"
        rows.append(["predicts unseen records", summary])
    if not checks:
        rows.append(["predicts unseen records", "not tested (dampyr identify --predict)"])
    rows.append(["errors", f"by {fit.clusters}; {precision}"])
    blocks: list[Block] = [Table(("quantity", "result"), rows)]
    blocks += to_look_at(fit.verdict.besides(listed)) or [Text(sentence(findings(fit.residuals)[0]))]
    return Section("In short", blocks)


def _verdict(fit: Fit) -> Cell:
    verdict = fit.verdict
    if verdict.kind == "fair":
        return verdict.words
    return Verdict("agrees" if verdict.kind == "good" else "differs", verdict.words)


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
