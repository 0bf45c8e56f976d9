"""Criteria as data: which figure of which cycles may differ from what, by how much on each side, and where that is read.

A run passes when every level that was asked was run with its cycles and every criterion holds; it fails when one does not hold,
and is "not judged" otherwise, with the reason.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from statistics import fmean
from typing import Annotated

from dampyr.config import Choices, fill, load_toml
from dampyr.errors import FileError, InputError, choose_from
from dampyr.identification.acceptance_tests.acceptance import Verdict
from dampyr.records.cycle_analysis.device_figures import DeviceFigures, device_figures
from dampyr.records.record import Record

SHIPPED = Path(__file__).parent / "device_criteria_files"
QUANTITIES = ("largest_force", "energy", "effective_stiffness", "characteristic_strength", "damping_ratio")
SAME_AMPLITUDE = 0.1  # relative: a level that was run is the one that was asked
ROUNDING = 1e-9


@dataclass(frozen=True)
class Criterion:
    """One row; ``lower`` and ``upper`` are relative to the reference, None: that side is free."""

    quantity: Annotated[str, Choices(QUANTITIES)]
    cycles: Annotated[str, Choices(("third", "all"))]
    reference: Annotated[str, Choices(("design", "cycle 3", "mean"))]
    source: str
    lower: float | None = None
    upper: float | None = None


@dataclass(frozen=True)
class RequiredLevel:
    """A level that must be run: amplitude in m, least number of cycles, and the design's values of quantities, SI."""

    amplitude: float
    cycles: int
    design: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class CriterionVerdict:
    """One criterion on one cycle: its value, that of its reference, its limits (None: free) and whether it holds, SI."""

    criterion: Criterion
    amplitude: float
    cycle: int
    value: float
    reference: float
    lower: float | None
    upper: float | None

    @property
    def holds(self) -> bool:
        """Whether the value lies within its limits."""
        slack = ROUNDING * abs(self.value)
        below = self.lower is not None and self.value < self.lower - slack
        return not below and (self.upper is None or self.value <= self.upper + slack)

    @property
    def used(self) -> float:
        """How much of the way from the reference to the limit on its side the value takes: more than 1 is beyond it."""
        limit = self.upper if self.value > self.reference else self.lower
        away, room = abs(self.value - self.reference), 0.0 if limit is None else abs(limit - self.reference)
        if limit is None or away <= ROUNDING * abs(self.reference):
            return 0.0
        return away / room if room else inf


@dataclass(frozen=True)
class JudgedByCriteria:
    """Every criterion on every cycle of the levels that were asked, and what could not be judged, in sentences."""

    cycles: tuple[CriterionVerdict, ...]
    unjudged: tuple[str, ...]

    @property
    def verdict(self) -> Verdict:
        """``failed``, ``not judged`` or ``passed``."""
        if any(not cycle.holds for cycle in self.cycles):
            return "failed"
        return "passed" if self.cycles and not self.unjudged else "not judged"


def available_criteria() -> list[str]:
    """The names of the criteria that are shipped, such as ``ntc_2018_viscous``."""
    return sorted(path.stem for path in SHIPPED.glob("*.toml") if path.stem != "template")


def read_criteria(name: str | Path) -> tuple[Criterion, ...]:
    """The criteria of a file or of a shipped name (``ntc_2018_viscous``); FileError where a row has no limit or source."""
    path = Path(name)
    if not path.suffix:
        shipped = sorted(file.stem for file in SHIPPED.glob("*.toml"))
        if str(name) not in shipped:
            raise InputError(f"{str(name)!r} is not among the criteria; {choose_from(str(name), shipped)}")
        path = SHIPPED / f"{name}.toml"
    table = load_toml(path)
    rows = table.get("criterion")
    if set(table) != {"criterion"} or not isinstance(rows, list) or not rows:
        raise FileError(path, "needs tables [[criterion]] and nothing else; copy the template")
    try:
        return tuple(_criterion(row, f"criterion {k + 1}") for k, row in enumerate(rows))
    except InputError as problem:
        raise FileError(path, str(problem)) from None


def _criterion(row: object, where: str) -> Criterion:
    if isinstance(row, Mapping):
        if not str(row.get("source", "")).strip():
            raise InputError(f"{where} has no source; name the document, the section and the table that you read")
        row = {name: value for name, value in row.items() if value != ""}
    criterion = fill(Criterion, row, where)
    if criterion.lower is None and criterion.upper is None:
        raise InputError(
            f"{where} has no limit; give lower, upper or both, relative to the reference, such as lower = -0.15"
        )
    if criterion.lower is not None and criterion.upper is not None and criterion.lower > criterion.upper:
        raise InputError(f"{where}: lower = {criterion.lower:g} is above upper = {criterion.upper:g}; exchange them")
    return criterion


def judge_by_criteria(
    records: Sequence[Record], criteria: Sequence[Criterion], asked: Sequence[RequiredLevel]
) -> JudgedByCriteria:
    """Judge the levels that were asked, each wherever a record has it; InputError without a level or a criterion."""
    if not criteria or not asked:
        raise InputError("there is nothing to judge by; give at least one criterion and one level")
    runs = [level for record in records for level in _levels(record)]
    judged: list[CriterionVerdict] = []
    unjudged: list[str] = []
    for level in asked:
        run = [
            cycles for cycles in runs if abs(cycles[0].amplitude - level.amplitude) <= SAME_AMPLITUDE * level.amplitude
        ]
        place = f"{1e3 * level.amplitude:.4g} mm"
        if not any(len(cycles) >= level.cycles for cycles in run):
            most = max((len(cycles) for cycles in run), default=0)
            unjudged.append(f"{place}: {level.cycles} cycles are asked, {most} were run; run the level again")
        for cycles in run:
            rows, reasons = judge_level(cycles, criteria, level)
            judged += rows
            unjudged += [f"{place}, {reason}" for reason in reasons]
    return JudgedByCriteria(tuple(judged), tuple(unjudged))


def _levels(record: Record) -> list[list[DeviceFigures]]:
    """The cycles of every level, in their order."""
    levels: dict[int, list[DeviceFigures]] = {}
    for cycle in device_figures(record):
        levels.setdefault(cycle.level, []).append(cycle)
    return list(levels.values())


def judge_level(
    cycles: Sequence[DeviceFigures], criteria: Sequence[Criterion], level: RequiredLevel
) -> tuple[list[CriterionVerdict], list[str]]:
    """Every criterion on the cycles of one level, and a sentence for each that could not be judged."""
    judged: list[CriterionVerdict] = []
    unjudged: list[str] = []
    for criterion in criteria:
        rows, reason = _judge_criterion(cycles, criterion, level)
        judged += rows
        unjudged += [f"{criterion.quantity}: {reason}"] if reason else []
    return judged, unjudged


def _judge_criterion(
    cycles: Sequence[DeviceFigures], criterion: Criterion, level: RequiredLevel
) -> tuple[list[CriterionVerdict], str]:
    """The rows of one criterion on a level, and why it has none."""
    values = [float(getattr(cycle, criterion.quantity)) for cycle in cycles]
    if (criterion.cycles == "third" or criterion.reference == "cycle 3") and len(values) < 3:
        return [], f"{len(values)} cycles have no third; run at least 3"
    if criterion.reference == "design" and criterion.quantity not in level.design:
        return [], "the design's value is missing; give it"
    references = {"design": level.design.get(criterion.quantity), "mean": fmean(values)}
    reference = values[2] if criterion.reference == "cycle 3" else float(references[criterion.reference] or 0.0)
    lower, upper = (
        None if side is None else reference + side * abs(reference) for side in (criterion.lower, criterion.upper)
    )
    chosen = [2] if criterion.cycles == "third" else range(len(values))
    rows = [CriterionVerdict(criterion, cycles[k].amplitude, k + 1, values[k], reference, lower, upper) for k in chosen]
    return rows, ""
