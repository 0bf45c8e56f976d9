"""The input of a damper: a voltage or a current at its coil, or none, as of friction, oil or rubber.

Records, dampers and what is shown of them hold the kind as its unit; where there is no input they speak of none.
"""

from __future__ import annotations

from typing import Any

NO_INPUT = "none"
"""The kind of a damper, and of its records, that has no input: what nobody sets cannot be told by a unit."""

INPUTS = {"V": "voltage", "A": "current"}
"""The inputs that a damper may have, by their units."""

KINDS = (*INPUTS, NO_INPUT)


def input_text(value: float | None, unit: str, digits: str = ".4g") -> str:
    """An input with its unit, "1.98 V"; empty where there is none."""
    return "" if unit == NO_INPUT or value is None else f"{value:{digits}} {unit}"


def at_input(value: float | None, unit: str, digits: str = ".4g", before: str = " at ") -> str:
    """An input inside a sentence, " at 1.98 V"; empty where there is none, so that the sentence holds without it."""
    text = input_text(value, unit, digits)
    return f"{before}{text}" if text else ""


ALL_RECORDS = "all records"
"""The name of the group of records that have no input, where others are grouped by theirs."""


def group_name(value: float | None, unit: str, digits: str = ".5g") -> str:
    """The group that records of an input are shown in, "1.98 V"; all of them where there is none."""
    return input_text(value, unit, digits).rstrip() or ALL_RECORDS


def unit_of(kind: str | None) -> str:
    """The unit of a table's column of inputs; empty where there is none, or none is known."""
    return "" if kind in (None, NO_INPUT) else str(kind)


def input_arguments(unit: str, value: Any) -> dict[str, Any]:
    """The argument ``voltage=`` or ``current=`` that gives a damper its input; none where it has none."""
    return {INPUTS[unit]: value} if unit in INPUTS else {}
