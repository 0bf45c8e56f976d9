"""What the figures of a protocol and their judgement show."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dampyr.campaigns.protocol_result import CONDITIONS, JudgedFigure, ProtocolFigure, ProtocolLimit, ProtocolResult
from dampyr.findings import as_dicts
from dampyr.phrases import counted, sentence
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.table import Cell, Table
from dampyr.units import for_people


@describe.register
def describe_protocol(result: ProtocolResult) -> Description:
    """Kind and verdict; what was judged, and all figures."""
    return Description(
        f"ProtocolResult {result.kind}",
        [
            ("verdict", result.verdict),
            ("records", counted(len(result.records), "record")),
            (
                "figures",
                f"{len(result.figures)}, {sum(figure.value is not None for figure in result.figures)} with a value",
            ),
            ("judged", in_words(result)),
        ],
        verdict=[sentence(f"{result.verdict}: {in_words(result)}"), *map(sentence, result.reasons)],
        tables=[*([lambda: judged_table(result)] if result.judged else []), lambda: figure_table(result)],
        data=lambda: _numbers(result),
        frame=lambda: _columns(result),
    )


def in_words(result: ProtocolResult) -> str:
    """How many limits and figures came out how, such as "3 passed, 1 failed"."""
    verdicts = [judged.verdict for judged in result.judged]
    counts = {name: verdicts.count(name) for name in ("passed", "failed", "not judged")}
    return ", ".join(f"{count} {name}" for name, count in counts.items() if count) or "no limit"


def criterion(limit: ProtocolLimit, units: Mapping[str, str]) -> str:
    """Such as ``t63 <= 30 ms``."""
    low, high = (_shown(bound, units[limit.quantity]) for bound in (limit.low, limit.high))
    if limit.low is None:
        return f"{limit.quantity} <= {high}"
    return f"{limit.quantity} >= {low}" if limit.high is None else f"{low} <= {limit.quantity} <= {high}"


def judged_table(result: ProtocolResult) -> Table:
    """Criterion, value and verdict of every figure that a limit covers, and of every limit that covers none."""
    rows: list[list[Cell]] = [
        [
            judged.figure.test if judged.figure else None,
            _conditions(judged.figure.conditions if judged.figure else judged.limit.conditions),
            criterion(judged.limit, result.units),
            _value(judged, result.units),
            judged.verdict,
            "" if judged.verdict == "passed" else judged.reason,
            judged.limit.source,
        ]
        for judged in result.judged
    ]
    heads = ("test", "conditions", "criterion", "value", "verdict", "reason", "limit from")
    return Table(heads, rows, caption=f"{result.kind}: {result.verdict}.")


def figure_table(result: ProtocolResult) -> Table:
    """Every figure, judged or not."""
    rows: list[list[Cell]] = [
        [figure.test, _conditions(figure.conditions), figure.quantity, _figure(figure, result.units), figure.reason]
        for figure in result.figures
    ]
    sources = dict.fromkeys(record.provenance.get("voltage", "") for record in result.records)
    notes = [sentence(f"the coil's voltage is {source}") for source in sources if source]
    heads = ("test", "conditions", "quantity", "value", "remark")
    return Table(heads, rows, caption=f"{result.kind}: all figures.", notes=notes)


def _value(judged: JudgedFigure, units: Mapping[str, str]) -> str | None:
    return None if judged.figure is None else _figure(judged.figure, units)


def _figure(figure: ProtocolFigure, units: Mapping[str, str]) -> str | None:
    return None if figure.value is None else _shown(figure.value, units[figure.quantity])


def _shown(value: float | None, unit: str) -> str:
    """A value in the unit that people read; a ratio in percent."""
    if value is None:
        return ""
    name, factor = for_people(unit) if unit else ("%", 100.0)
    return f"{factor * value:.4g} {name}"


def _conditions(conditions: Mapping[str, str | float]) -> str:
    """Such as ``30 mm/s, 0 V to 1.98 V, extension, rise``, each with its name where its unit does not tell."""
    return ", ".join(_condition(name, value) for name, value in conditions.items())


def _condition(name: str, value: str | float) -> str:
    if isinstance(value, str):
        return value
    unit = CONDITIONS.get(name) or ""
    label = name.replace("_", " ")
    if not unit:
        return f"{label} {value:g}"
    shown, factor = (unit, 1.0) if unit == "s" else for_people(unit)
    return f"{label} {factor * value:.4g} {shown}"


def _numbers(result: ProtocolResult) -> dict[str, Any]:
    return {
        "kind": result.kind,
        "verdict": result.verdict,
        "reasons": list(result.reasons),
        "origin": result.origin.as_dict(),
        "findings": as_dicts(result.findings),
        "units": dict(result.units),
        "judged": list(result.judged),
        "figures": list(result.figures),
        "missing": list(result.missing),
    }


def _columns(result: ProtocolResult) -> DataFrameColumns:
    """The figures: SI units; a column for each condition."""
    figures = result.figures
    names = dict.fromkeys(name for figure in figures for name in figure.conditions)
    columns: dict[str, Any] = {name: [figure.conditions.get(name) for figure in figures] for name in names}
    columns |= {name: [getattr(figure, name) for figure in figures] for name in ("quantity", "value", "reason")}
    columns["unit"] = [result.units[figure.quantity] for figure in figures]
    return DataFrameColumns(columns, [figure.test for figure in figures], "test")
