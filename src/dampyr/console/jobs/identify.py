"""Identification, as ``dampyr identify`` does it."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.console import curves, record_sources
from dampyr.console.equivalent_commands import identify_command
from dampyr.console.identify_schemas import IdentifyRequest, search_workers
from dampyr.console.jobs import CARD, CURVES, DATA, PAGE
from dampyr.console.page_tables import page_table
from dampyr.console.page_words import in_page_words
from dampyr.console.safe_paths import data_of
from dampyr.errors import InputError
from dampyr.findings import besides
from dampyr.identification import Fit, fit, score
from dampyr.identification.fits.diagnostics import findings
from dampyr.identification.model_choice.parallel import local_processes
from dampyr.identification.scoring.score import prediction
from dampyr.show.identification.fit_predictions import mean_l1
from dampyr.show.identification.leaderboard import choice_in_words
from dampyr.show.identification.validation import score_table
from dampyr.show.pages.fit_sections import parameter_tables
from dampyr.show.pages.how_made import made_by
from dampyr.show.pages.result_page import write_page
from dampyr.show.pages.typography import as_words
from dampyr.to_json import plain


def run(request: dict[str, Any], folder: Path, progress: Callable[[str, float], None]) -> dict[str, Any]:
    """``request`` is an `IdentifyRequest`."""
    parsed = IdentifyRequest(**request)
    progress("reading the records", 0.0)
    chosen = record_sources.read_all(data_of(folder), parsed.records)
    with local_processes(search_workers() if parsed.model is None else 1) as executor:
        result = fit(chosen, parsed.model, parsed.options(), progress, executor)
    progress("writing the page", 0.9)
    with made_by(identify_command(parsed)):
        write_page(result, folder / PAGE)
    if result.damper is not None:
        result.damper.save(folder / CARD)
    write_whole(folder / CURVES, json.dumps(_curves(result)))
    return {DATA: result.as_dict(), **_summarise(result)}


def _summarise(fit: Fit) -> dict[str, Any]:
    """What the page shows in its own form, besides the data."""
    l1 = [score.l1 for score in fit.scores.values()]
    return {
        "model": str(fit.problem.composition),
        "notice": fit.origin.notice,
        "card": fit.damper is not None,
        "converged": fit.converged,
        "reason": fit.reason,
        "verdict": {"kind": fit.verdict.kind, "words": as_words(fit.verdict.words)},
        "warnings_of_fit": [
            as_words(in_page_words(finding.sentence)) for finding in besides(fit.findings, [fit.verdict.words])
        ],
        "findings": list(findings(fit.residuals)),
        "mean_l1": float(np.mean(l1)),
        "parameters": [page_table(table) for table in parameter_tables(fit)],
        "choice": choice_in_words(fit.leaderboard) if fit.leaderboard else [],
        "settling": fit.settling,
        "scores": page_table(score_table(fit.scores)),
        "records": [record.name for record in (*fit.records, *fit.validation_records)],
        "held": [
            {"record": name, "l1": math.nan, "problem": score}
            if isinstance(score, str)
            else {"record": name, "l1": score.l1, "problem": ""}
            for name, score in fit.predicted.items()
        ],
        "predictions": [
            {
                "split": validation.split,
                "mean_l1": mean_l1(validation),
                "records": len(validation.scores),
            }
            for validation in fit.validations
            if validation.scores
        ],
    }


def _curves(fit: Fit) -> dict[str, Any]:
    """Lines by record: measured and modelled force over time, displacement and velocity, and the residual."""
    lines = {
        piece.name: curves.measured_and_modelled(piece.t, piece.x, piece.v, piece.force, force)
        for piece, force in zip(fit.problem.pieces, fit.forces, strict=True)
    }
    for record in fit.validation_records if fit.damper is not None else ():
        try:
            assert fit.damper is not None
            scored, force = score(fit.damper, record), prediction(fit.damper, record)
        except InputError:
            continue
        v = record.velocity if record.velocity is not None else np.gradient(record.displacement, record.time)
        channels = (record.time, record.displacement, v, record.force, force + scored.offset)
        lines[record.name] = curves.measured_and_modelled(*(values[scored.window.slice] for values in channels))
    return dict(plain(lines))
