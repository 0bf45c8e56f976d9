"""The leaderboard on the command line: how many cores it takes, and its tables."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING

from dampyr.cli._output import print_table

if TYPE_CHECKING:
    from dampyr.identification import Leaderboard

MAX_WORKERS = 8  # each process compiles the models of its own trials, which more of them would only repeat


def cores() -> int:
    """How many processes may share the trials: one for each core, up to `MAX_WORKERS`."""
    available = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(available, MAX_WORKERS)


def print_leaderboard(board: Leaderboard) -> None:
    """The finalists, then what was screened."""
    from dampyr.identification.model_choice.leaderboard import choice_in_words

    rows = [
        [k, e.model, *(100 * v for v in (e.error, e.standard_error, e.l1, e.relevelled, e.unseen_input, e.nrmse, e.pointwise,
         e.energy)),
         e.parameters, e.seconds, "yes" if e.converged else "no", "no" if e.not_for_buildings else "yes"]
        for k, e in enumerate(board.entries, start=1)
    ]  # fmt: skip
    names = [
        "",
        "model",
        "error",
        "±",
        "L1",
        "relevelled",
        "unseen input",
        "NRMSE",
        "pointwise",
        "energy",
        "parameters",
        "fit",
        "converged",
        "building",
    ]
    notes = [
        *choice_in_words(board),
        "error: 3/4 of L1 over records left out (five parts), 1/4 of L1 over inputs left out; every score is of a prediction",
        "relevelled: L1 over records left out, with the level that each one's first cycles have",
        "±: one standard error; building: whether the model may stand in for a damper of a building",
        f"velocity {board.velocity}; {board.seconds:.0f} s in all, {board.work:.0f} s of counted work",
        *board.left_out,
    ]
    units = ["", "", "%", "%", "%", "%", "%", "%", "%", "%", "", "s", "", ""]
    title = "Which model predicts best" + ("; the search was cut" if board.cut else "")
    print_table(title, names, rows, units, digits=3, notes=notes)
    print()
    print_screened(board)


def print_screened(board: Leaderboard) -> None:
    """Every model of the catalogue, bare and at its best."""
    rows = []
    for one in sorted(board.screened, key=lambda s: s.best.error):
        reason = f"no damper: {one.best.reason}" if math.isinf(one.best.error) else ""
        added = one.best.model.removeprefix(one.base).removeprefix(" + ")
        rows.append([one.base, _percent(one.bare.error), added or "nothing", _percent(one.best.error), reason])
    names, units = ["model", "bare", "best with", "error", ""], ["", "%", "", "%", ""]
    print_table("Screened on a few short records", names, rows, units, digits=3)
    print()


def _percent(error: float) -> float | None:
    return 100 * error if math.isfinite(error) else None
