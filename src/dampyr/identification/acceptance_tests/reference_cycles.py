r"""Reference values for the cycles of a record: of a damper's free run, or of tests of a reference specimen.

Between tests the force at peak velocity is interpolated over speed, straight. The energy of a cycle is interpolated as
:math:`E/s`, s being the stroke, since friction dissipates :math:`2 F_c s` and a dashpot :math:`(\pi/2)\, c\, \hat v\, s`: at
one peak velocity both go with the stroke.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrWarning, InputError
from dampyr.identification.scoring.score import prediction
from dampyr.input_kinds import NO_INPUT
from dampyr.models import Damper
from dampyr.models.damper import INPUTS
from dampyr.origin import NOT_STATED, Origin
from dampyr.records import Record, cut_cycles, cycle_table
from dampyr.records.conditioning.nominal_input import SMALLEST, TOLERANCE, is_steady
from dampyr.records.conditioning.smoothing import force_average
from dampyr.records.cycle_analysis.cycle_table import Cycle

Array = NDArray[np.float64]
Expected = tuple[float | None, str]
SAME = 0.02  # of a speed: within it two tests count as at one speed
STROKE = 0.1  # of a stroke: within it the energy at one peak speed goes with the stroke
OPEN = 0.05  # of a stroke: a cycle that ends farther from its start has an energy of its own
WINDOW = 0.1  # of a moving average: within it two smoothed forces are compared
_read: WeakKeyDictionary[Record, dict[float | None, list[Cycle]]] = WeakKeyDictionary()  # many records share references


@dataclass(frozen=True)
class Conditions:
    """What tests that are compared have in common: their input, constant where ``steady``, and how their force is smoothed.

    ``smoothing`` is the window of the moving average that the force still holds, s; 0 without one.
    """

    unit: str | None
    value: float | None
    steady: bool
    smoothing: float

    @classmethod
    def of(cls, record: Record) -> Conditions:
        """Those of a record (`dampyr.records.nominal_inputs` has made its input a constant where it is one)."""
        value, average = record.input_value, force_average(record)
        steady = value is not None and is_steady(record, max(abs(value), SMALLEST))
        return cls(record.input, value, steady, 0.0 if average is None else average.window)

    def __str__(self) -> str:
        if self.unit == NO_INPUT:
            return "no input"
        if self.value is None:
            return "no input known"
        return f"{self.value:.4g} {self.unit}" if self.steady else f"a varying input in {self.unit}"

    def have_input_of(self, other: Conditions) -> bool:
        """Whether both had the same constant input, or neither any."""
        if self.unit != other.unit or self.value is None or other.value is None:
            return self.unit == other.unit
        largest = max(abs(self.value), abs(other.value), SMALLEST)
        return abs(self.value - other.value) <= TOLERANCE * largest and self.steady and other.steady

    def have_smoothing_of(self, other: Conditions) -> bool:
        """Whether the forces of both went through the same moving average, which is not undone, or through none."""
        return abs(self.smoothing - other.smoothing) <= WINDOW * max(self.smoothing, other.smoothing)


@dataclass(frozen=True)
class ReferenceTest:
    """What a test of a reference gives to judge others by, without its samples: the cycles of its levels."""

    name: str
    conditions: Conditions
    cycles: tuple[Cycle, ...]
    origin: Origin = NOT_STATED

    @classmethod
    def of(cls, record: Record) -> ReferenceTest:
        """That of a record."""
        cycles = tuple(cycle for cycle in _read_cycles(record, None) if cycle.level)
        return cls(record.name, Conditions.of(record), cycles, record.origin)

    @property
    def input_value(self) -> float | None:
        """V or A, or None."""
        return self.conditions.value

    def values(self, quantities: Sequence[str]) -> int:
        """How many values of a test like it are judged: those of each cycle, and the mean of each level."""
        return len(quantities) * (len(self.cycles) + len({cycle.level for cycle in self.cycles}))


Reference = Damper | Sequence[Record] | Sequence[ReferenceTest]


def expected(
    reference: Reference,
    record: Record,
    table: Sequence[Cycle],
    offset: float | None = None,
    allow_extrapolation: bool = False,
) -> dict[str, list[Expected]]:
    """For each quantity and cycle the reference's value, or None and the reason."""
    if isinstance(reference, Damper):
        return _expect_of_damper(reference, record, table, offset, allow_extrapolation)
    return _expect_of_tests(reference, record, table, offset)


def _expect_of_damper(
    damper: Damper, record: Record, table: Sequence[Cycle], offset: float | None, beyond: bool
) -> dict[str, list[Expected]]:
    if not table:
        return _expect_nothing(0, "")
    if record.input != damper.input:
        over = f"is over the {INPUTS[damper.input]}" if damper.has_input else "has no input"
        return _expect_nothing(len(table), f"the reference {over}; {Conditions.of(record)} here")
    try:
        with warnings.catch_warnings():
            if not beyond:
                warnings.simplefilter("ignore", DampyrWarning)  # what lies beyond is not judged, and says so
            force = prediction(damper, record, beyond)
    except InputError as problem:
        return _expect_nothing(len(table), str(problem).partition("; ")[0])
    if not np.all(np.isfinite(force)):
        return _expect_nothing(len(table), "the reference's force is not finite along this motion")
    zero = None if offset is None else 0.0
    whole = cycle_table(record.replace(note="the force of a reference", force=force), zero)
    ran = [cycle for cycle in whole if cycle.level]
    reasons = ["" if beyond else _explain_outside(damper, cycle) for cycle in table]

    def with_reasons(values: Sequence[float]) -> list[Expected]:
        return [(None, why) if why else (value, "") for value, why in zip(values, reasons, strict=True)]

    return {
        "extension": with_reasons([c.force_out for c in ran]),
        "compression": with_reasons([c.force_in for c in ran]),
        "energy": with_reasons([c.energy for c in ran]),
    }


def _explain_outside(damper: Damper, cycle: Cycle) -> str:
    """Why a cycle lies beyond what a damper was calibrated on; "" where it does not."""
    for name, value, text, unit in (
        ("velocity", max(cycle.speed_out, -cycle.speed_in), "faster than the reference was calibrated", "mm/s"),
        (
            "displacement",
            0.5 * cycle.stroke_m,
            "a wider stroke than the reference was calibrated on",
            "mm of amplitude",
        ),
    ):
        high = damper.ranges.get(name, (0.0, np.inf))[1]
        if value > (1.0 + SAME) * high:
            return f"{text} (up to {1e3 * high:.4g} {unit})"
    return ""


def _expect_of_tests(
    tests: Sequence[Record | ReferenceTest], record: Record, table: Sequence[Cycle], offset: float | None
) -> dict[str, list[Expected]]:
    others = [test for test in tests if not (isinstance(test, Record) and _is_same(test, record))]
    if not others:
        return _expect_nothing(len(table), "the reference is this record itself")
    same, reason = comparable_tests(others, Conditions.of(record))
    if reason:
        return _expect_nothing(len(table), reason)
    of_test = [_read_cycles(test, offset) if isinstance(test, Record) else test.cycles for test in same]
    reference = [cycle for cycles in of_test for cycle in cycles if cycle.level]
    if not reference:
        return _expect_nothing(len(table), "the reference has no whole cycle")
    out = ReferenceLine(np.array([(c.speed_out, c.force_out) for c in reference]))
    back = ReferenceLine(np.array([(-c.speed_in, c.force_in) for c in reference]))
    closed = [c for c in reference if c.open_m <= OPEN * c.stroke_m] or reference
    loops = ReferenceLine(np.array([(_peak_speed(c), c.energy / c.stroke_m, c.stroke_m) for c in closed]))
    return {
        "extension": [out.at(c.speed_out) for c in table],
        "compression": [back.at(-c.speed_in) for c in table],
        "energy": [_expect_energy(c, loops) for c in table],
    }


def comparable_tests(
    tests: Sequence[Record | ReferenceTest], conditions: Conditions
) -> tuple[list[Record | ReferenceTest], str]:
    """The tests at the same input, smoothed alike; and why there are none."""
    of_test = [Conditions.of(test) if isinstance(test, Record) else test.conditions for test in tests]
    if not any(map(conditions.have_input_of, of_test)):
        had = sorted(set(map(str, of_test)))
        inputs = f"{', '.join(had[:4])}{', …' if had[4:] else ''}"
        return [], f"no reference at this input: {conditions} here, {inputs} there"
    alike = [
        test
        for test, there in zip(tests, of_test, strict=True)
        if conditions.have_input_of(there) and conditions.have_smoothing_of(there)
    ]
    text = f"is smoothed over {conditions.smoothing:.4g} s" if conditions.smoothing else "is not smoothed"
    return alike, "" if alike else f"the force here {text}, that of the reference otherwise"


class ReferenceLine:
    """Points of a reference (rows of speed and values) as a line, straight between groups of one speed; it has two ends."""

    def __init__(self, points: Array) -> None:
        self.low, self.high = float(points[:, 0].min()), float(points[:, 0].max())
        self.rows = groups(points, SAME)

    def at(self, speed: float) -> Expected:
        """The first value at ``speed`` m/s, or why there is none."""
        if speed > (1.0 + SAME) * self.high:
            return None, f"faster than the reference (up to {1e3 * self.high:.4g} mm/s)"
        if speed < (1.0 - SAME) * self.low:
            return None, f"slower than the reference (from {1e3 * self.low:.4g} mm/s)"
        return float(np.interp(speed, self.rows[:, 0], self.rows[:, 1])), ""

    def adjacent_rows(self, speed: float) -> Array:
        """The rows between which ``speed`` lies, one beyond the ends."""
        after = int(np.searchsorted(self.rows[:, 0], speed))
        return self.rows[max(after - 1, 0) : after + 1]


def _expect_energy(cycle: Cycle, loops: ReferenceLine) -> Expected:
    if cycle.open_m > OPEN * cycle.stroke_m:
        return None, f"the cycle ends {1e3 * cycle.open_m:.3g} mm from where it began"
    speed = _peak_speed(cycle)
    value, reason = loops.at(speed)
    if value is None:
        return None, reason
    rows = loops.adjacent_rows(speed)
    alike = np.abs(rows[:, 2] / cycle.stroke_m - 1.0) <= STROKE
    if not np.all(alike):  # between two strokes nothing is known, but at the speed of its own there is
        own = rows[alike & (np.abs(rows[:, 0] / speed - 1.0) <= SAME)]
        if not len(own):
            return None, f"the reference has another stroke at this speed ({_format_span(1e3 * rows[:, 2])} mm)"
        value = float(own[0, 1])
    return value * cycle.stroke_m, ""


def groups(rows: Array, width: float) -> Array:
    """Rows by their first column, rising; those within ``width`` of the first of their group as one mean row."""
    ordered = rows[np.argsort(rows[:, 0], kind="stable")]
    grouped: list[list[Array]] = []
    for row in ordered:
        if grouped and row[0] <= (1.0 + width) * grouped[-1][0][0]:
            grouped[-1].append(row)
        else:
            grouped.append([row])
    return np.array([np.mean(group, axis=0) for group in grouped]).reshape(-1, rows.shape[1])


def _read_cycles(record: Record, offset: float | None) -> list[Cycle]:
    tables = _read.setdefault(record, {})
    if offset not in tables:
        tables[offset] = cycle_table(record, offset) if cut_cycles(record).cycles else []
    return tables[offset]


def _peak_speed(cycle: Cycle) -> float:
    return max(cycle.speed_out, -cycle.speed_in)


def _is_same(one: Record, other: Record) -> bool:
    channels = ("time", "displacement", "force")
    same_input = (one.input, one.input_value) == (other.input, other.input_value)
    return one is other or (same_input and all(np.array_equal(getattr(one, c), getattr(other, c)) for c in channels))


def _format_span(values: Array) -> str:
    low, high = f"{values.min():.4g}", f"{values.max():.4g}"
    return low if low == high else f"{low} to {high}"


def _expect_nothing(count: int, reason: str) -> dict[str, list[Expected]]:
    return {name: [(None, reason)] * count for name in ("extension", "compression", "energy")}
