"""What a protocol's records show: its figures, and how they compare with limits that a person gives.

A kind of protocol has ``quantities``, its figures with their SI units, and ``figures(records)``; it may have ``limits()``
of its own, ``ends(blocks)``, why the campaign ends before all tests have run, and ``counted(complete)``, what a record says
of those before it. A sheet of limits is a CSV table: the columns ``quantity``, ``low`` and ``high``, and others that name a
condition, such as ``speed [mm/s]`` or ``direction``. An empty cell is no bound, or any condition.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from math import isclose
from pathlib import Path
from typing import Any

from dampyr.campaigns.campaign import campaign_of
from dampyr.campaigns.expand import read_rows
from dampyr.campaigns.kinds import protocol_kind
from dampyr.config import fill, unknown
from dampyr.errors import FileError, InputError
from dampyr.findings import Finding, handed_on
from dampyr.identification.acceptance_tests.acceptance import Verdict
from dampyr.origin import Origin, combined
from dampyr.records import Record, read_campaign
from dampyr.shown import Shown
from dampyr.units import parse

CONDITIONS = {
    "test": None, "direction": None, "step": None, "speed": "m/s", "voltage": "V", "low_voltage": "V", "high_voltage": "V",
    "dwell": "s", "block": "", "cycles": "",
}  # fmt: skip
"""The conditions by which a sheet chooses figures, with their SI units; None: a text."""
SAME_CONDITION = 0.01  # relative
NO_LIMITS = "no limits were given"


@dataclass(frozen=True)
class ProtocolFigure:
    """A figure of a test, in the SI unit of its quantity; None with the ``reason``. For ``conditions`` see `CONDITIONS`."""

    test: str
    quantity: str
    value: float | None
    conditions: Mapping[str, str | float] = field(default_factory=dict)
    reason: str = ""


def figures_of(
    records: Sequence[Record], figures: Callable[[Record], list[ProtocolFigure]], quantities: Iterable[str]
) -> list[ProtocolFigure]:
    """The figures of each record; of one that gives none every quantity without a value, with the reason."""
    found: list[ProtocolFigure] = []
    for record in records:
        try:
            found += figures(record)
        except InputError as problem:
            found += [ProtocolFigure(record.name, name, None, reason=str(problem)) for name in quantities]
    return found


@dataclass(frozen=True)
class ProtocolLimit:
    """Bounds of a quantity, SI, where the conditions hold; ``source`` is the sheet, or what else states it."""

    quantity: str
    low: float | None
    high: float | None
    conditions: Mapping[str, str | float] = field(default_factory=dict)
    source: str = ""

    def covers(self, figure: ProtocolFigure) -> bool:
        """Whether a figure is of this quantity and under these conditions."""
        has = {"test": figure.test, **figure.conditions}
        return figure.quantity == self.quantity and all(
            name in has and _agree(has[name], value) for name, value in self.conditions.items()
        )


@dataclass(frozen=True)
class JudgedFigure:
    """A limit and a figure that it covers; a limit that covers none has a ``reason`` and no figure."""

    limit: ProtocolLimit
    figure: ProtocolFigure | None
    verdict: Verdict
    reason: str = ""


@dataclass(frozen=True, repr=False)
class ProtocolResult(Shown):
    """The figures of a protocol that was run, and its judgement.

    ``kind`` of protocol; ``units`` of its quantities; ``missing`` tests that the protocol asks for and that have no complete
    record. It has passed when every limit has covered a figure, every figure lies within, and no test is missing.
    """

    kind: str
    protocol: Any
    records: tuple[Record, ...]
    figures: tuple[ProtocolFigure, ...]
    judged: tuple[JudgedFigure, ...]
    missing: tuple[str, ...] = ()

    @property
    def units(self) -> Mapping[str, str]:
        """The SI unit of each quantity."""
        return dict(self.protocol.quantities)

    @property
    def verdict(self) -> Verdict:
        """One figure outside fails it; what is not judged leaves it open."""
        verdicts = {judged.verdict for judged in self.judged}
        if "failed" in verdicts:
            return "failed"
        return "not judged" if self.reasons else "passed"

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why it is not judged as a whole; empty where it is."""
        reasons = [] if self.judged else [NO_LIMITS]
        if self.missing:
            more = f" and {len(self.missing) - 1} more" if len(self.missing) > 1 else ""
            reasons.append(f"no complete record of {self.missing[0]}{more}")
        reasons += [judged.reason for judged in self.judged if judged.verdict == "not judged"]
        return tuple(dict.fromkeys(reasons))

    @cached_property
    def origin(self) -> Origin:
        """That of the records together."""
        return combined(record.origin for record in self.records)

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong or in doubt in the records."""
        return handed_on(self.records)


def protocol_text(kind: str, protocol: Any) -> str:
    """A protocol as its records hold it."""
    return json.dumps({"kind": kind, **asdict(protocol)})


def judge_protocol(folder: str | Path, limits: str | Path | Sequence[ProtocolLimit] = ()) -> ProtocolResult:
    """The figures of the protocol whose records are in ``folder``, judged by ``limits``, a sheet or what `read_limits` gives.

    Raises :class:`~dampyr.errors.InputError` where the records are of no protocol, of several, or of one without figures.
    """
    records = [record for record in read_campaign(folder, role=None) if "protocol" in record.provenance]
    texts = dict.fromkeys(record.provenance["protocol"] for record in records)
    if len(texts) != 1:
        stated = f"of {len(texts)} protocols; give each a folder of its own" if texts else "of no protocol"
        raise InputError(f"{folder}: its records are {stated}; run a campaign with a [protocol], and give its folder")
    table = json.loads(next(iter(texts)))
    kind = table.pop("kind")
    protocol = fill(protocol_kind(kind), table, "protocol")
    if not hasattr(protocol, "figures"):
        raise InputError(f"{folder}: {kind} has no figures of its own; judge its records with dampyr accept")
    asked = (read_limits(limits, protocol.quantities) if isinstance(limits, str | Path) else tuple(limits)) + tuple(
        protocol.limits() if hasattr(protocol, "limits") else ()
    )
    figures = tuple(protocol.figures(records))
    planned = [test.name for test in campaign_of({"protocol": {"kind": kind, **table}}).tests]
    recorded = {record.name for record in records}
    return ProtocolResult(
        kind,
        protocol,
        tuple(records),
        figures,
        tuple(judged for limit in asked for judged in _judge(limit, figures)),
        tuple(name for name in planned if name not in recorded),
    )


def read_limits(path: str | Path, quantities: Mapping[str, str]) -> tuple[ProtocolLimit, ...]:
    """The limits of a sheet, for figures of these ``quantities`` with their units; FileError names the row that is wrong."""
    path, limits = Path(path), []
    for number, row in enumerate(read_rows(path), 1):
        try:
            limits.append(_limit(row, quantities, path.name))
        except InputError as problem:
            raise FileError(path, f"row {number}: {problem}") from None
    return tuple(limits)


def _limit(row: Mapping[str, Any], quantities: Mapping[str, str], source: str) -> ProtocolLimit:
    quantity = str(row.get("quantity", ""))
    if quantity not in quantities:
        raise InputError(unknown(f"quantity = {quantity!r}", quantity, sorted(quantities)))
    for name in row:
        if name not in ("quantity", "low", "high", *CONDITIONS):
            raise InputError(unknown(f"column {name!r}", name, ["quantity", "low", "high", *CONDITIONS]))
    low, high = (_bound(row.get(side, ""), quantities[quantity]) for side in ("low", "high"))
    if low is None and high is None:
        raise InputError(f"{quantity} has no limit; give low, high or both")
    if low is not None and high is not None and low > high:
        raise InputError(f"low = {row['low']} is above high = {row['high']}; exchange the two")
    conditions: dict[str, str | float] = {}
    for name, unit in CONDITIONS.items():
        value = str(row.get(name, "")).strip() if unit is None else _bound(row.get(name, ""), unit or "")
        if value is not None and value != "":
            conditions[name] = value
    return ProtocolLimit(quantity, low, high, conditions, source)


def _bound(cell: str | float, unit: str) -> float | None:
    """A cell in SI; None where it is empty, be it that its column has a unit."""
    return None if isinstance(cell, str) and not re.search(r"\d", cell) else parse(cell, unit)


def _agree(value: str | float, wanted: str | float) -> bool:
    if isinstance(value, str) or isinstance(wanted, str):
        return str(value) == str(wanted)
    return isclose(value, wanted, rel_tol=SAME_CONDITION, abs_tol=1e-12)


def _judge(limit: ProtocolLimit, figures: Sequence[ProtocolFigure]) -> list[JudgedFigure]:
    covered = [figure for figure in figures if limit.covers(figure)]
    if not covered:
        return [JudgedFigure(limit, None, "not judged", f"no figure is {limit.quantity} under these conditions")]
    return [_judged(limit, figure) for figure in covered]


def _judged(limit: ProtocolLimit, figure: ProtocolFigure) -> JudgedFigure:
    if figure.value is None:
        return JudgedFigure(limit, figure, "not judged", figure.reason)
    above = limit.high is not None and figure.value > limit.high
    below = limit.low is not None and figure.value < limit.low
    side = "above the upper limit" if above else "below the lower limit"
    return JudgedFigure(limit, figure, "failed", side) if above or below else JudgedFigure(limit, figure, "passed")
