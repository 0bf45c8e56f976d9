"""The card of a damper: one TOML file, schema 1 (docs/reference/card.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.config import parse_toml
from dampyr.errors import FileError, InputError, MissingData
from dampyr.findings import Finding, as_dicts, worst_first
from dampyr.models import prediction_error
from dampyr.models.codegen.composition import compose
from dampyr.models.laws import from_card
from dampyr.origin import NOT_STATED, Origin
from dampyr.source_digest import full_version
from dampyr.source_file import SourceFile

SCHEMA = 1  # the one that this version writes and reads
Damper = TypeVar("Damper")


def write(damper: Any, path: Path) -> Path:
    """Write a :class:`~dampyr.models.damper.Damper` to ``path``, whole or not at all."""
    import tomli_w

    head = f"# A damper, written by dampyr {full_version()}. SI units. Schema: dampyr help card\n"
    if text := damper.origin.notice:
        head = f"# {text}.\n{head}"
    error = damper.prediction_error
    if error is not None and not error.session_estimated:
        head += f"# The level between measurement sessions is not known: {error.session_source}.\n"
    if damper.composition.not_for_buildings:
        head += f"# {damper.composition.not_for_buildings}.\n"
    write_whole(path, head + tomli_w.dumps(_to_tables(damper)))
    return path


def _to_tables(damper: Any) -> dict[str, Any]:
    head: dict[str, Any] = {"parts": list(damper.parts), "input": damper.input, "origin": damper.origin.kind}
    if damper.bandwidth is not None:
        head["velocity_bandwidth_Hz"] = damper.bandwidth
    units = {name: q.unit or "1" for name, q in damper.composition.quantities.items()}
    tables: dict[str, Any] = {"schema": SCHEMA, "damper": head}
    if damper.findings:  # before the long tables, where who opens the file sees them
        tables["findings"] = as_dicts(damper.findings)
    tables["laws"] = {name: {"unit": units[name], **law.card()} for name, law in damper.all_laws.items()}
    if damper.ranges:
        tables["ranges"] = {name: list(map(float, span)) for name, span in damper.ranges.items()}
    if damper.covariance is not None:
        tables["covariance"] = {"matrix": damper.covariance.tolist()}
        if damper.within_records:
            tables["covariance"]["within_records_only"] = list(damper.within_records)
    if damper.prediction_error is not None:
        tables["prediction_error"] = damper.prediction_error.card()
    origin = damper.origin.as_dict() | {"sources": list(map(str, damper.origin.sources))}
    if stated := {name: entries for name, entries in origin.items() if entries and name != "kind"}:
        tables["origin"] = stated
    if damper.provenance:
        tables["provenance"] = dict(damper.provenance)
    return tables


def read(path: Path, make: Callable[..., Damper]) -> Damper:
    """What ``make``, the class of dampers, makes of a card's fields.

    FileError says what is wrong, and refuses a schema that this version cannot read.
    """
    try:
        tables = parse_toml(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise MissingData(
            f"{path}: there is no such card; `dampyr identify ... --save {path.name}` writes one"
        ) from None
    except (InputError, UnicodeDecodeError) as problem:
        raise FileError(path, f"this is not a TOML file: {problem}") from None
    if tables.get("schema") != SCHEMA:
        raise FileError(path, f"schema {tables.get('schema')!r} is not supported; this dampyr reads schema {SCHEMA}")
    try:
        return make(**_from_tables(tables))
    except (InputError, KeyError, TypeError, ValueError, AttributeError) as problem:
        text = f"it lacks {problem.args[0]!r}" if isinstance(problem, KeyError) else str(problem)
        raise FileError(path, f"{text}; see dampyr help card") from None


def _from_tables(tables: dict[str, Any]) -> dict[str, Any]:
    head = tables["damper"]
    laws = {}
    for name, table in tables["laws"].items():
        try:
            laws[name] = from_card(table)
        except InputError as problem:
            raise InputError(f"law {name}: {problem}") from None
    covariance_table = tables.get("covariance", {})
    covariance, within = covariance_table.get("matrix"), covariance_table.get("within_records_only", [])
    if not (isinstance(within, list) and all(isinstance(label, str) for label in within)):
        raise InputError(
            f"covariance.within_records_only = {within!r} is not allowed; give a list of names, or leave it out"
        )
    composition = compose(tuple(head["parts"]))
    for name, quantity in composition.quantities.items():
        unit = tables["laws"].get(name, {}).get("unit", quantity.unit or "1")
        if unit != (quantity.unit or "1"):
            raise InputError(f"law {name} is in {unit!r}; a card holds {quantity.unit or '1'!r}")
    error = tables.get("prediction_error")
    coefficients = sum(len(law.coefficients) for law in laws.values())
    return {
        "prediction_error": None if error is None else prediction_error.from_card(error, coefficients),
        "parts": composition.names,
        "laws": laws,
        "input": head["input"],
        "ranges": {name: (float(span[0]), float(span[1])) for name, span in tables.get("ranges", {}).items()},
        "covariance": None if covariance is None else np.asarray(covariance, dtype=float),
        "bandwidth": head.get("velocity_bandwidth_Hz"),
        "provenance": tables.get("provenance", {}),
        "within_records": tuple(within),
        "findings": _read_findings(tables.get("findings", [])),
        "origin": _read_origin(tables),
    }


def _read_origin(tables: dict[str, Any]) -> Origin:
    """Kind and what else is stated; a card of dampyr up to 0.3.0 has the version among its provenance, and no files."""
    stated = tables.get("origin", {})
    if not isinstance(stated, dict):
        raise InputError(f"origin = {stated!r} must be a table; its kind stands in damper.origin")
    lists = {name: value for name, value in stated.items() if name != "sources"}
    if version := tables.get("provenance", {}).get("dampyr"):
        lists = {"versions": [version]} | lists
    lines = stated.get("sources", ())
    sources = tuple(SourceFile.from_line(str(line)) for line in ([lines] if isinstance(lines, str) else lines))
    kind = tables["damper"].get("origin", NOT_STATED.kind)
    return replace(Origin.from_dict(lists | {"kind": kind}), sources=sources)


def _read_findings(tables: Any) -> tuple[Finding, ...]:
    try:
        return worst_first(map(Finding.from_dict, tables))
    except (TypeError, KeyError, AttributeError):
        raise InputError(
            "findings must be tables with severity and words, and about where they are of some records; correct them, or "
            "leave them out"
        ) from None
