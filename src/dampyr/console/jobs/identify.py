"""Identify a damper: one model fitted, or the best of many found, as ``dampyr identify`` does."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.console import curves, record_sources
from dampyr.console.jobs import CARD, CURVES, PAGE
from dampyr.console.safe_paths import data_of
from dampyr.errors import InputError
from dampyr.identification import (
    Fit,
    Leaderboard,
    Validation,
    cross_validate,
    findings,
    fit,
    leaderboard,
    prediction,
    score,
    warnings_of,
)
from dampyr.identification.screening import held_in
from dampyr.records import Record
from dampyr.report.fit_page import write_fit_page
from dampyr.report.fit_sections import parameter_table, score_table
from dampyr.report.leaderboard_section import leaderboard_section
from dampyr.to_json import plain

MAX_WORKERS = 8
Tell = Callable[[str, float], None]


def run(request: dict[str, Any], folder: Path, progress: Tell) -> dict[str, Any]:
    """``request``: records (keys), model or None, tried (models), predict (a split or ""), loss, bandwidth."""
    progress("reading the records", 0.0)
    chosen = record_sources.gather(data_of(folder), request["records"])
    fitted = [record for record in chosen if record.role == "fit"]
    if not fitted:
        raise InputError(
            "only validation records are chosen, and these are never fitted; choose some that are for fits"
        )
    options = {"loss": request["loss"], "bandwidth": request["bandwidth"]}
    board = None if request["model"] else _ranked(fitted, request["tried"], options, progress)
    fit_result, checks = _joint(request["model"], fitted, options, request["predict"], board, progress)
    progress("writing the page", 0.9)
    sections = [leaderboard_section(board)] if board else []
    write_fit_page(fit_result, folder / PAGE, sections, checks)
    if fit_result.damper is not None:
        _card(fit_result, board).save(folder / CARD)
    held = [record for record in chosen if record.role == "validation"]
    write_whole(folder / CURVES, json.dumps(_curves(fit_result, held)))
    return _summarise(fit_result, checks, board, held)


def _ranked(records: list[Record], tried: list[str], options: dict[str, Any], progress: Tell) -> Leaderboard:
    cores = max(1, min((os.cpu_count() or 2) - 1, MAX_WORKERS))  # one is left to the console and the rig
    with ProcessPoolExecutor(cores, mp_context=get_context("spawn")) as executor:
        return leaderboard(records, tried or None, executor=executor, progress=progress, **options)


def _joint(
    model: str | None,
    records: list[Record],
    options: dict[str, Any],
    split: str,
    board: Leaderboard | None,
    progress: Tell,
) -> tuple[Fit, list[Validation]]:
    """The fit to all records and the validations; of a leaderboard the winner's."""
    if board is not None:
        assert board.winner.fit is not None
        return board.winner.fit, list(board.winner.validations)
    assert model is not None
    fixed = held_in(model)
    fit_result = fit(
        model, records, fixed=fixed, progress=lambda k, _: progress("identifying", k / (k + 20.0)), **options
    )
    if not split:
        return fit_result, []

    def tell(done: float) -> None:
        progress(f"predicting by {split}", done)

    return fit_result, [cross_validate(model, records, split, progress=tell, fixed=fixed, **options)]


def _card(fit_result: Fit, board: Leaderboard | None) -> Any:
    assert fit_result.damper is not None
    if board is None:
        return fit_result.damper
    chosen = f"the lowest validation error, {100 * board.winner.error:.3g} %, of {len(board.screened)} models"
    return replace(fit_result.damper, provenance=dict(fit_result.damper.provenance) | {"chosen": chosen})


def _summarise(
    fit_result: Fit, checks: list[Validation], board: Leaderboard | None, held: list[Record]
) -> dict[str, Any]:
    parameters, scores = parameter_table(fit_result), score_table(fit_result.scores, "")
    l1 = [one.l1 for one in fit_result.scores.values()]
    return {
        "model": str(fit_result.problem.composition),
        "input": fit_result.damper.input if fit_result.damper else fit_result.records[0].input,
        "range": fit_result.damper.range if fit_result.damper else None,
        "card": fit_result.damper is not None,
        "converged": fit_result.converged,
        "reason": fit_result.reason,
        "doubts": [*warnings_of(fit_result.residuals), *fit_result.notes],
        "findings": list(findings(fit_result.residuals)),
        "mean_l1": float(np.mean(l1)),
        "parameters": {
            "columns": list(parameters.columns),
            "rows": [list(row) for row in parameters.rows],
            "caption": parameters.caption,
        },
        "scores": {
            "columns": list(scores.columns),
            "units": list(scores.units),
            "rows": [list(r) for r in scores.rows],
        },
        "records": [record.name for record in (*fit_result.records, *held)],
        "held": _predicted(fit_result, held),
        "predictions": [
            {
                "split": one.split,
                "mean_l1": float(np.mean([s.l1 for s in one.scores.values()])),
                "records": len(one.scores),
            }
            for one in checks
            if one.scores
        ],
        "leaderboard": _board(board) if board else None,
    }


def _predicted(fit_result: Fit, held: list[Record]) -> list[dict[str, Any]]:
    """How well it predicts the validation records that were chosen."""
    if fit_result.damper is None:
        return []
    scores = []
    for record in held:
        try:
            scores.append({"record": record.name, "l1": score(fit_result.damper, record).l1, "problem": ""})
        except InputError as problem:
            scores.append({"record": record.name, "l1": math.nan, "problem": str(problem)})
    return scores


def _board(board: Leaderboard) -> list[dict[str, Any]]:
    keys = ("model", "error", "l1", "unseen_input", "nrmse", "energy", "parameters", "bic", "seconds", "converged")
    return [{key: getattr(one, key) for key in keys} for one in board.entries]


def _curves(fit_result: Fit, held: list[Record]) -> dict[str, Any]:
    """Lines by record: measured and modelled force over time, displacement and velocity, and what is left."""
    made = {
        piece.name: _lines(piece.t, piece.x, piece.v, piece.force, force)
        for piece, force in zip(fit_result.problem.pieces, fit_result.forces, strict=True)
    }
    for record in held if fit_result.damper is not None else ():
        try:
            assert fit_result.damper is not None
            at, force = score(fit_result.damper, record), prediction(fit_result.damper, record)
        except InputError:
            continue
        v = record.velocity if record.velocity is not None else np.gradient(record.displacement, record.time)
        part = at.window.slice
        lines = (record.time, record.displacement, v, record.force, force + at.offset)
        made[record.name] = _lines(*(values[part] for values in lines))
    return dict(plain(made))


def _lines(t: Any, x: Any, v: Any, measured: Any, model: Any) -> dict[str, Any]:
    def both(over: Any) -> dict[str, Any]:
        return {"measured": curves.line(over, measured).model_dump(), "model": curves.line(over, model).model_dump()}

    return {
        "time": both(t),
        "displacement": both(x),
        "velocity": both(v),
        "residual": curves.line(t, measured - model).model_dump(),
    }
