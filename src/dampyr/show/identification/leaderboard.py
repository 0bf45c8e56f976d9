"""What a leaderboard of models shows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from dampyr.identification.model_choice.leaderboard import Finalist, Leaderboard
from dampyr.input_kinds import NO_INPUT
from dampyr.phrases import counted, listing, percent, sentence, with_reach
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures.leaderboard import leaderboard_figure
from dampyr.show.table import Cell, Table

#: what JSON and a data frame hold of an entry
ENTRY_KEYS = (
    "model", "error", "standard_error", "l1", "nrmse", "pointwise", "energy", "unseen_input", "relevelled", "parameters",
    "seconds", "converged", "reason", "not_for_buildings", "constant",
)  # fmt: skip


@describe.register
def describe_entry(entry: Finalist) -> Description:
    """The errors of a finalist and its fit."""
    return Description(
        f"Finalist {entry.model!r}",
        [
            (
                "error",
                f"{_error(entry)}, L1 {percent(entry.l1)}"
                + (f", of unseen inputs {percent(entry.unseen_input)}" if _has_input([entry]) else ""),
            ),
            ("NRMSE", f"{percent(entry.nrmse)}, pointwise {percent(entry.pointwise)}, energy {percent(entry.energy)}"),
            ("fit", f"{counted(entry.parameters, 'parameter')}, {entry.seconds:.3g} s; {entry.reason}"),
            *([("the same at all inputs", listing(entry.constant, len(entry.constant)))] if entry.constant else []),
            *([("buildings", entry.not_for_buildings)] if entry.not_for_buildings else []),
        ],
    )


@describe.register
def describe_leaderboard(board: Leaderboard) -> Description:
    """What was chosen, and what was screened; a table of the finalists and a figure of the screened models."""
    title = f"Leaderboard of {counted(len(board.entries), 'finalist')}"
    return Description(
        f"{title}, cut" if board.cut else title,
        _rows(board),
        verdict=[sentence(words) for words in choice_in_words(board)],
        tables=[lambda: finalists(board), lambda: screened(board)],
        figure=lambda: leaderboard_figure(*screened_errors(board)),
        data=lambda: _numbers(board),
        frame=lambda: _columns(board),
    )


def _rows(board: Leaderboard) -> list[tuple[str, str]]:
    trials = sum(len(model.trials) + len(model.with_constant) for model in board.screened)
    screened = f"{counted(len(board.screened), 'model')}, {counted(trials, 'composition')}, {board.seconds:.3g} s"
    if board.cut:
        return [("chosen", f"nothing: {board.cut}"), ("screened", screened)]
    winner, best = board.winner, board.best
    rows = [("chosen", f"{winner.model}, validation error {percent(winner.error)}")]
    if winner is not best:
        rows.append(("lowest", f"{best.model}, {_error(best)}"))
    if board.runner_up:
        rows.append(("runner-up", f"{board.runner_up.model}, {percent(board.runner_up.error)}"))
    rows.append(("for a building", board.for_building.model if board.for_building else "none of the finalists"))
    if np.isfinite(board.optimism):
        rows.append(("optimism", f"{percent(board.optimism)} of the lowest error, by choosing among the finalists"))
    rows += [("screened", screened), ("velocity", velocity_in_words(board))]
    if board.called:
        rows.append(("tried besides", listing([found.name for found in board.called], 3)))
    if board.left_out:
        rows.append(("left out", listing(board.left_out, 2)))
    return rows


def finalists(board: Leaderboard) -> Table:
    """One row a finalist, the best first."""
    rows: list[list[Cell]] = [
        [k, e.model, 100 * e.error, 100 * e.standard_error, e.parameters, "no" if e.not_for_buildings else "yes",
         *(100 * v for v in (e.l1, e.relevelled, e.unseen_input, e.nrmse, e.pointwise, e.energy)), e.seconds,
         "yes" if e.converged else "no"]
        for k, e in enumerate(board.entries, start=1)
    ]  # fmt: skip
    for box in board.yardsticks:
        errors = (100 * box.l1, None, 100 * box.unseen_input, None, None, None)
        rows.append(["", f"black box: {box.name}", 100 * box.error, None, box.numbers, "", *errors, box.seconds, ""])
    has_input = _has_input(board.entries)
    whole_inputs = (
        "3/4 of L1 over records left out (five random parts), and 1/4 of L1 over whole inputs left out where there are three "
        "or more, every input counting the same"
        if has_input
        else "L1 over records left out (five random parts)"
    )
    table = Table(
        ("", "model", "error", "±", "parameters", "building", "L1", "relevelled", "unseen input", "NRMSE", "pointwise",
         "energy", "fit", "converged"),
        rows,
        ("", "", "%", "%", "", "", "%", "%", "%", "%", "%", "%", "s", ""),
        caption="Which model predicts best"
        + ("; the search was cut." if board.cut else ": the finalists, validated on all records."),
        notes=(
            "Every score is of a prediction: nothing here was scored on what it was fitted on.",
            f"error: {whole_inputs}; ±: one standard error.",
            "relevelled: L1 over records left out, with the level (a factor on the whole force) that each one's first cycles "
            "have; building: whether the model may stand in for a damper of a building.",
            *[f"{sentence(words)}" for words in _constants_in_words(board.entries)],
            *["Black boxes were trained on the same parts: a yardstick, of which no card is made."] * bool(board.yardsticks),
        ),
        digits=3,
    )  # fmt: skip
    return table if has_input else table.without("unseen input")


def _error(entry: Finalist) -> str:
    """The error of prediction with one standard error, of which it has the digits."""
    if not entry.standard_error > 0.0:
        return percent(entry.error)
    return f"{with_reach(100 * entry.error, 100 * entry.standard_error)} %"


def _constants_in_words(entries: Sequence[Finalist]) -> list[str]:
    """Which parameters of each finalist a search found to have one value at all inputs."""
    return [
        f"the same at all inputs in {entry.model}, as it predicts as well so: {listing(entry.constant, len(entry.constant))}"
        for entry in entries
        if entry.constant
    ]


def _has_input(entries: Sequence[Finalist]) -> bool:
    return not any(record.input == NO_INPUT for entry in entries if entry.fit for record in entry.fit.records)


def screened(board: Leaderboard) -> Table:
    """Every model of the catalogue, bare and at its best."""
    rows: list[list[Cell]] = []
    for model in sorted(board.screened, key=lambda s: s.best.error):
        added = model.best.model.removeprefix(model.base).removeprefix(" + ") or "nothing"
        failed = f"no damper: {model.best.reason}" if math.isinf(model.best.error) else ""
        rows.append(
            [model.base, _percent(model.bare.error), added, _percent(model.best.error), len(model.trials), failed]
        )
    return Table(
        ("model", "bare", "best with", "error", "tried", ""),
        rows,
        ("", "%", "", "%", "", ""),
        caption="Screened on a few short records.",
        notes=[f"{reason}." for reason in (*map(str, board.called), *board.left_out)],
        digits=3,
    )


def _percent(error: float) -> float | None:
    return 100 * error if math.isfinite(error) else None


def _numbers(board: Leaderboard) -> dict[str, Any]:
    """The ranking and the screening for `dampyr.to_json`, without the fits and validations of the entries."""
    return {
        "origin": board.origin.as_dict(),
        "entries": [{key: getattr(entry, key) for key in ENTRY_KEYS} for entry in board.entries],
        "screened": board.screened,
        "chosen": None if board.cut else board.winner.model,
        "for_building": board.for_building.model if not board.cut and board.for_building else None,
        "cut": board.cut,
        "work": board.work,
        "optimism": board.optimism,
        "nested": board.nested,
        "yardsticks": board.yardsticks,
        "what_is_left": board.what_is_left,
        "bandwidth_hz": board.bandwidth,
        "called": board.called,
        "left_out": board.left_out,
        "seconds": board.seconds,
    }


def _columns(board: Leaderboard) -> DataFrameColumns:
    """The finalists, the best first; errors are ratios, ``seconds`` s."""
    keys = [key for key in ENTRY_KEYS if key != "model"]
    columns = {key: [getattr(entry, key) for entry in board.entries] for key in keys}
    columns["constant"] = [", ".join(entry.constant) for entry in board.entries]
    return DataFrameColumns(columns, [entry.model for entry in board.entries], "model")


def screened_errors(board: Leaderboard) -> tuple[list[str], list[float], list[float]]:
    """Each screened model with its add-ons in lines below it, its error bare, and its error with them."""
    models = [
        model.best.model.replace(model.base, model.base + "\n", 1).replace("\n + ", "\n+ ").rstrip("\n")
        for model in board.screened
    ]
    return models, [model.bare.error for model in board.screened], [model.best.error for model in board.screened]


def velocity_in_words(board: Leaderboard) -> str:
    """Which velocity was used."""
    if board.bandwidth is not None:
        return f"derived with {board.bandwidth:g} Hz"
    fitted = next((entry.fit.records for entry in board.entries if entry.fit), ())
    derived = any(record.velocity is None for record in fitted)
    return "as recorded, or derived with each record's own bandwidth" if derived else "as recorded"


def choice_in_words(board: Leaderboard) -> list[str]:
    """Which model was chosen and why, which may stand in a building, and how much the choice flatters, a sentence each; or why
    none was chosen."""
    if board.cut:
        return [board.cut]
    winner, best, suited = board.winner, board.best, board.for_building
    work = f"{board.seconds:.0f} s in all, {board.work:.0f} s of counted work"
    words = [f"chosen: {winner.model}, the lowest error"]
    if winner is not best:
        words = [
            f"chosen: {winner.model}, {counted(winner.parameters, 'number')} and an error of {percent(winner.error)}; of the "
            f"models within one standard error of the lowest ({best.model}, {_error(best)}) "
            f"it {_merit(board)}"
        ]
    words += _constants_in_words([winner])
    if suited is None:
        words.append("no finalist may stand in for a damper of a building; try dahl, bouc_wen or modified_bouc_wen")
    else:
        words.append(f"best model that may stand in a building: {suited.model}, {percent(suited.error)}")
    if np.isfinite(board.optimism):
        words.append(
            f"choosing the lowest by four parts and scoring it on the fifth gives an L1 {percent(board.optimism)} higher than "
            "the lowest: what the choice among the finalists flatters"
        )
    levels = winner.fit.levels if winner.fit is not None else None
    if levels is not None and not levels.repeated:
        words.append("no error here knows how another measurement session would differ; the notes of the fit say why")
    if np.isfinite(board.nested):
        words.append(
            f"the whole search, repeated without a fifth of the records each time, predicts it to {percent(board.nested)}"
        )
    words += [board.what_is_left] if board.what_is_left else []
    return [*words, f"the velocity is {velocity_in_words(board)}; {work}"]


def _merit(board: Leaderboard) -> str:
    """Why the winner goes before the lowest error, within one standard error of it."""
    if board.winner.parameters < board.best.parameters:
        return "has the fewest numbers"
    if board.best.not_for_buildings and not board.winner.not_for_buildings:
        return "has as few numbers as any, and may stand in for a damper of a building"
    return "has as few numbers as any"
