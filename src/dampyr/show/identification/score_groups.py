"""Scores of records, gathered by the input at which they were made."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from dampyr.identification.scoring.score import Score
from dampyr.input_kinds import NO_INPUT, unit_of
from dampyr.records import Record
from dampyr.show.table import Cell, Table

RELEVELLED = "relevelled: mean L1 with the level (a factor on the force) that each record's first cycles have"


def scores_by_input(records: Iterable[Record], scores: Mapping[str, Score], caption: str) -> Table:
    """Mean and worst L1 over the records of each input that have a score, and the mean with each one's own level."""
    groups: dict[float | None, list[Score]] = {}
    scored = [record for record in records if record.name in scores]
    for record in scored:
        groups.setdefault(record.input_value, []).append(scores[record.name])
    rows: list[list[Cell]] = []
    for u in sorted(groups, key=lambda u: math.inf if u is None else u):
        l1 = [100 * score.l1 for score in groups[u]]
        relevelled = [100 * score.relevelled_l1 for score in groups[u] if math.isfinite(score.relevelled_l1)]
        mean = sum(relevelled) / len(relevelled) if relevelled else None
        rows.append([u, len(l1), sum(l1) / len(l1), max(l1), mean])
    kind = next((record.input for record in scored if record.input), None)
    table = Table(
        ("input", "records", "mean L1", "worst L1", "relevelled"),
        rows,
        (unit_of(kind), "", "%", "%", "%"),
        caption=f"{caption}.",
        notes=[f"{RELEVELLED}."],
        digits=3,
    )
    return table.without("input") if kind == NO_INPUT else table
