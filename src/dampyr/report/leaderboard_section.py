"""Section of a fit's page: the leaderboard that its model was chosen by."""

from __future__ import annotations

import math

from dampyr.figures.leaderboard import leaderboard_figure
from dampyr.identification import Leaderboard
from dampyr.identification.model_choice.leaderboard import choice_in_words
from dampyr.report.blocks import Cell, FigureBlock, Section, Table, Text
from dampyr.representation import sentence

NAMES = (
    "", "model", "error", "±", "parameters", "building", "L1", "relevelled", "unseen input", "NRMSE", "pointwise", "energy",
    "fit",
)  # fmt: skip
UNITS = ("", "", "%", "%", "", "", "%", "%", "%", "%", "%", "%", "s")


def leaderboard_section(board: Leaderboard) -> Section:
    """The finalists, and every model bare and at its best."""
    words = " ".join(sentence(each) for each in choice_in_words(board))
    words += (
        " The error is three quarters of the L1 ratio of records that were left out (five random parts), and one of that of "
        "whole inputs that were left out where there are three or more, every input counting the same. Nothing here was "
        "scored on what it was fitted on. Relevelled is the L1 ratio of records that were left out, each with the level (a "
        "factor on the whole force) that its own first cycles have."
    )
    rows: list[list[Cell]] = [
        [k, e.model, 100 * e.error, 100 * e.standard_error, e.parameters, "no" if e.not_for_buildings else "yes",
         *(100 * v for v in (e.l1, e.relevelled, e.unseen_input, e.nrmse, e.pointwise, e.energy)), e.seconds]
        for k, e in enumerate(board.entries, start=1)
    ]  # fmt: skip
    return Section(
        "Which model predicts best",
        [
            Text(words),
            Table(NAMES, rows, UNITS, caption="The finalists, validated on all records.", digits=3),
            FigureBlock(
                leaderboard_figure(*board.screened_errors()),
                "Every model on a few short records: bare, and with the add-ons that improved it.",
            ),
            _screened(board),
        ],
    )


def _screened(board: Leaderboard) -> Table:
    rows: list[list[Cell]] = []
    for one in sorted(board.screened, key=lambda s: s.best.error):
        added = one.best.model.removeprefix(one.base).removeprefix(" + ") or "nothing"
        failed = f"no damper: {one.best.reason}" if math.isinf(one.best.error) else ""
        rows.append([one.base, _percent(one.bare.error), added, _percent(one.best.error), len(one.trials), failed])
    caption = " ".join([f"Screened; the velocity is {board.velocity}.", *(f"{reason}." for reason in board.left_out)])
    return Table(
        ("model", "bare", "best with", "error", "tried", ""),
        rows,
        ("", "%", "", "%", "", ""),
        caption=caption,
        digits=3,
    )


def _percent(error: float) -> float | None:
    return 100 * error if math.isfinite(error) else None
