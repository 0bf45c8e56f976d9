"""What the levels of records and sessions show."""

from __future__ import annotations

import math
from typing import Any

from dampyr.identification.parameter_uncertainty.levels import Levels
from dampyr.phrases import counted, percent
from dampyr.show.descriptions import Description, describe
from dampyr.show.table import Cell, Table


@describe.register
def describe_levels(levels: Levels) -> Description:
    """How far records and sessions are apart, and a table of the records."""
    rows = [
        ("records", f"{counted(len(levels.level), 'record')}, {percent(levels.record_sd)} apart within a session"),
        ("sessions", levels.words),
        *([("settled by", levels.settles)] if levels.settles else []),
    ]
    return Description("Levels", rows, tables=[lambda: _by_record(levels)], data=lambda: _numbers(levels))


def _by_record(levels: Levels) -> Table:
    """One row a record: its session and its level."""
    rows: list[list[Cell]] = [[name, levels.session[name], 100 * (level - 1.0)] for name, level in levels.level.items()]
    return Table(("record", "session", "level"), rows, ("", "", "%"))


def _numbers(levels: Levels) -> dict[str, Any]:
    """All of it for JSON; standard deviations of logarithms, None in the place of infinite degrees of freedom."""
    return {
        "level": dict(levels.level),
        "session": dict(levels.session),
        "record_sd": levels.record_sd,
        "record_freedom": _or_none(levels.record_freedom),
        "session_sd": levels.session_sd,
        "session_freedom": _or_none(levels.session_freedom),
        "session_reml": _or_none(levels.session_reml),
        "session_level_known": levels.repeated,
        "words": levels.words,
        "settled_by": levels.settles,
    }


def _or_none(value: float) -> float | None:
    return value if math.isfinite(value) else None
