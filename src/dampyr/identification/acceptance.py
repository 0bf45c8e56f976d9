r"""Acceptance of a tested damper: whether it lies within a band about a reference, as in production and device tests.

Every whole cycle is judged by three quantities: the force at peak velocity in extension and in compression (the peak-velocity
pick-up of a damper dynamometer), and the energy that it dissipates. With the reference's value :math:`e` the band is

.. math:: e \pm (r |e| + a)

with a relative share r and a slack a in N or J. One cycle outside is outside. A cycle without a reference value
(another input, faster, a wider stroke) is not judged, and the reason is kept; nothing is extrapolated.

The band of 15 % that stands as the default is what a maker of friction dampers promises of each specimen, of its force and of
the area of its loops [SteelDamper]_. Standards for seismic devices have bands of their own: state yours.

References
----------
.. [SteelDamper] steeldamper.com, "SFD mechanical performance requirements": table of products, items 1 and 6.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from dampyr.errors import InputError
from dampyr.identification.reference_cycles import SAME, Expected, Reference, expected, groups
from dampyr.origin import NOT_STATED, Origin, combined
from dampyr.records import Cycle, Record, cycle_table, cycles
from dampyr.representation import Representation, Summary, Table, data_frame

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Quantity = Literal["extension", "compression", "energy"]
Verdict = Literal["passed", "failed", "not judged"]
QUANTITIES: tuple[Quantity, ...] = ("extension", "compression", "energy")
UNITS = {"extension": "N", "compression": "N", "energy": "J"}
SHARE = 0.5  # of a quantity's points: with more of them open than judged the test is no test


@dataclass(frozen=True)
class Tolerance:
    """Half the width of a band: ``relative`` (0.15 is 15 %) of the expected value, plus ``force`` in N or ``energy`` in J.

    Raises :class:`~dampyr.errors.InputError` for a relative share outside 0 to 1, or a negative slack.
    """

    relative: float = 0.15
    force: float = 0.0
    energy: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.relative <= 1.0:
            raise InputError(
                f"relative = {self.relative:g} is not allowed; it is a share from 0 to 1, such as 0.15 for 15 %"
            )
        for name, unit in (("force", "N"), ("energy", "J")):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(f"{name} = {value:g} {unit} is not allowed; it must be finite and at least 0")

    def __str__(self) -> str:
        given = ((100 * self.relative, "%"), (self.force, "N"), (self.energy, "J"))
        return "± " + " and ".join(f"{value:g} {unit}" for value, unit in given if value)

    def half(self, quantity: str, value: float) -> float:
        """Half the width of the band about ``value``, in N or J."""
        return self.relative * abs(value) + (self.energy if quantity == "energy" else self.force)


@dataclass(frozen=True)
class Point:
    """One quantity of one cycle, SI; forces in compression are negative.

    ``cycle`` counts from 1, ``speed`` is the peak velocity in that direction (of ``energy``: the faster of the two) and is
    positive. Where the point was not judged, ``expected``, ``low``, ``high`` and ``inside`` are None and ``reason`` says why.
    """

    cycle: int
    quantity: Quantity
    speed: float
    stroke_m: float
    measured: float
    expected: float | None = None
    low: float | None = None
    high: float | None = None
    inside: bool | None = None
    reason: str = ""

    @property
    def deviation(self) -> float | None:
        """Measured over expected less 1: above 0 stronger than the reference, in both directions; None where not judged."""
        return None if self.expected is None or self.expected == 0.0 else self.measured / self.expected - 1.0

    @property
    def used(self) -> float | None:
        """Distance from the expected value in halves of the band: the edges are at -1 and 1, above 0 is stronger."""
        if self.expected is None or self.high is None:
            return None
        away = (self.measured - self.expected) * (-1.0 if self.quantity == "compression" else 1.0)
        half = self.high - self.expected
        return away / half if half > 0.0 else (0.0 if away == 0.0 else math.copysign(math.inf, away))


@dataclass(frozen=True)
class AcceptancePlots:
    """Each method draws one figure of these ``results`` and returns its matplotlib axes ``(k,)``."""

    results: tuple[Acceptance, ...]

    @property
    def origin(self) -> Origin:
        """That of all results."""
        return combined(one.origin for one in self.results)

    def forces(self) -> Any:
        """The forces at the peak velocities of every cycle, and the band."""
        from dampyr.figures import style
        from dampyr.figures.acceptance import peak_velocity_band

        return style.in_pyplot(peak_velocity_band, *forces_and_band(self.results), origin=self.origin)

    def used(self) -> Any:
        """How far each judged cycle lies from the reference, in halves of the band: its edges are at -1 and 1."""
        from dampyr.figures import style
        from dampyr.figures.acceptance import band_used

        return style.in_pyplot(band_used, used_of_band(self.results), origin=self.origin)


@dataclass(frozen=True, repr=False)
class Acceptance(Representation):
    """The judgement of one record. ``reason`` says why it is not judged as a whole, "" where it is.

    ``offset`` is what was taken from the measured forces, N; None: the mean over whole cycles of each record. ``level`` is the
    factor that the measured forces were divided by, 1 unless `relevelled` took one from the first cycles. ``origin`` is that
    of record and reference together.
    """

    record: str
    input: str | None
    input_value: float | None
    tolerance: Tolerance
    quantities: tuple[Quantity, ...]
    offset: float | None
    points: tuple[Point, ...]
    reason: str = ""
    level: float = 1.0
    origin: Origin = NOT_STATED

    @property
    def plot(self) -> AcceptancePlots:
        """Figures: ``acceptance.plot.forces()`` and ``.used()``, each giving matplotlib axes."""
        return AcceptancePlots((self,))

    def to_dataframe(self) -> Any:
        """The points as a ``pandas.DataFrame``: SI units, forces in compression negative."""
        names = {
            "cycle": "cycle", "quantity": "quantity", "speed": "speed_m_per_s", "stroke_m": "stroke_m",
            "measured": "measured", "expected": "expected", "low": "low", "high": "high", "inside": "inside",
            "deviation": "deviation", "reason": "reason",
        }  # fmt: skip
        columns = {head: [getattr(p, name) for p in self.points] for name, head in names.items()}
        return data_frame(columns | {"unit": [UNITS[p.quantity] for p in self.points]})

    def _small_figure(self) -> Figure | None:
        from dampyr.figures.acceptance import peak_velocity_band

        return peak_velocity_band(*forces_and_band([self])) if self.points else None

    def _summary(self) -> Summary:
        given = "input not known" if self.input_value is None else f"{self.input_value:.4g} {self.input}"
        rows = [
            ("verdict", self.verdict),
            ("input", given),
            ("band", f"{self.tolerance} of the reference"),
            ("points", f"{len(self.points)}, {len(self.judged)} judged, {len(self.outside)} outside"),
        ]
        worst = self.worst
        if worst is not None and worst.deviation is not None:
            rows.append(("worst", f"{worst.quantity} of cycle {worst.cycle}, {100 * worst.deviation:+.3g} %"))
        if self.unjudged:
            rows.append(("not judged", next(iter(self.unjudged))))
        return f"Acceptance of {self.record!r}", rows

    def _table(self) -> Table:
        heads = ("cycle", "quantity", "peak velocity [mm/s]", "measured", "expected", "from", "to", "unit", "inside")
        rows = [
            [p.cycle, p.quantity, 1e3 * p.speed, p.measured, p.expected, p.low, p.high, UNITS[p.quantity], p.inside]
            for p in self.points
        ]
        return heads, rows

    @property
    def judged(self) -> tuple[Point, ...]:
        """The points that have a reference value."""
        return tuple(p for p in self.points if p.inside is not None)

    @property
    def outside(self) -> tuple[Point, ...]:
        """The points outside the band, the worst first."""
        points = [p for p in self.points if p.inside is False]
        return tuple(sorted(points, key=lambda p: -abs(p.used or 0.0)))

    @property
    def worst(self) -> Point | None:
        """The judged point that uses most of its band, inside or outside."""
        return max(self.judged, key=lambda p: abs(p.used or 0.0), default=None)

    @property
    def passed(self) -> bool | None:
        """True or False, or None where too little was judged.

        False: a judged point lies outside. True: none does, and of every requested quantity at least half of the
        cycles were judged. None: nothing lies outside, but of some quantity fewer were judged.
        """
        if self.outside:
            return False
        return None if self.reason or not self.points else True

    @property
    def verdict(self) -> Verdict:
        """``passed`` in words."""
        if self.passed is None:
            return "not judged"
        return "passed" if self.passed else "failed"

    @property
    def reasons(self) -> dict[str, int]:
        """Why points were not judged: the reason -> how many."""
        return dict(Counter(p.reason for p in self.points if p.reason).most_common())

    @property
    def unjudged(self) -> dict[str, int]:
        """`reasons`, or that of a record without any point, with 0."""
        return self.reasons or ({self.reason: 0} if self.reason else {})

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers, for JSON."""
        points = [asdict(p) | {"deviation": p.deviation, "used": p.used} for p in self.points]
        worst = next((entry for entry, p in zip(points, self.points, strict=True) if p is self.worst), None)
        return asdict(self) | {
            "verdict": self.verdict,
            "passed": self.passed,
            "judged": len(self.judged),
            "outside": len(self.outside),
            "worst": worst,
            "reasons": self.reasons,
            "points": points,
        }


def accept(
    record: Record,
    reference: Reference,
    tolerance: Tolerance | None = None,
    quantities: Iterable[Quantity] = QUANTITIES,
    offset: float | None = None,
    allow_extrapolation: bool = False,
) -> Acceptance:
    """Judge every whole cycle of ``record`` by a reference.

    ``reference`` is a `Damper`, which runs freely along the record's own motion and input, both forces being read by the same
    cycles; or one or more `Record` of a reference damper at the same input, whose points are interpolated over speed in each
    direction, and whose energies are compared where the strokes agree to 10 % (the record itself among them is left out).

    From the forces of every record, and of the damper's run, its own mean over whole cycles is taken, since a load cell's zero
    and the gas force are not the damper's work. A force that is larger in one direction only moves that mean, so half of the
    excess shows in each direction; where the zero is known, give it: ``offset`` in N is then taken from the measured forces,
    and a damper's force stays as it is. ``allow_extrapolation`` judges beyond what a damper was calibrated on, with a warning.

    Raises :class:`~dampyr.errors.InputError` for an argument that is wrong. What cannot be judged is a value with a reason.
    """
    band = tolerance or Tolerance()
    requested = _checked_quantities(quantities, band)
    if offset is not None and not math.isfinite(offset):
        raise InputError(f"offset = {offset:g} N is not finite; give the load cell's zero, or leave it out")
    table = cycle_table(record, offset) if cycles(record) else []
    expectations = expected(reference, record, table, offset, allow_extrapolation)
    points = tuple(_point(k, q, cycle, expectations[q][k], band) for k, cycle in enumerate(table) for q in requested)
    reason = _reason(points, requested) if points else "no whole cycle"
    against = reference if isinstance(reference, Sequence) else [reference]
    origin = combined(each.origin for each in (record, *against))
    about = record.name, record.input, record.input_value
    return Acceptance(*about, band, requested, offset, points, reason, origin=origin)


def relevelled(one: Acceptance, cycles: int) -> Acceptance:
    """The judgement of the later cycles with the level of the first ``cycles`` taken out: the shape alone is judged.

    The level is the mean of measured over expected, of all judged points of these cycles. One that cannot be told
    (nothing of the first cycles was judged, or no later cycle is there) is a reason, and nothing is judged.
    """
    first = [p for p in one.judged if p.cycle <= cycles and p.expected]
    later = tuple(p for p in one.points if p.cycle > cycles)
    ratios = [p.measured / p.expected for p in first if p.expected]
    level = float(np.mean(ratios)) if ratios else math.nan
    if not (level > 0.0 and later):
        reason = "no later cycle" if level > 0.0 else f"no level: nothing of the first {cycles} cycles was judged"
        return replace(one, points=(), reason=one.reason or reason)
    points = tuple(
        p if p.low is None or p.high is None
        else replace(p, measured=p.measured / level, inside=p.low <= p.measured / level <= p.high)
        for p in later
    )  # fmt: skip
    return replace(one, points=points, reason=_reason(points, one.quantities), level=level)


def in_short(acceptances: Sequence[Acceptance]) -> str:
    """How many records came out how, such as "2 passed, 1 failed"."""
    counts = {each: sum(one.verdict == each for one in acceptances) for each in ("passed", "failed", "not judged")}
    return ", ".join(f"{count} {each}" for each, count in counts.items() if count)


def band(acceptances: Iterable[Acceptance], quantity: Quantity) -> list[tuple[float, float, float, float]]:
    """The band along the speed, for a picture: (speed m/s, expected, low, high), means of points with the same speed to 2 %."""
    points = [p for one in acceptances for p in one.judged if p.quantity == quantity]
    rows = np.array([(p.speed, p.expected, p.low, p.high) for p in points], dtype=float).reshape(-1, 4)
    return [(speed, middle, low, high) for speed, middle, low, high in groups(rows, SAME).tolist()]


Drawn = dict[bool | None, tuple[list[float], list[float]]]


def forces_and_band(acceptances: Sequence[Acceptance]) -> tuple[list[list[tuple[float, float, float, float]]], Drawn]:
    """The bands of extension and compression, and peak speeds m/s and forces N of the points inside, outside and not judged."""
    points: dict[bool | None, list[Point]] = {True: [], False: [], None: []}
    for one in acceptances:
        for p in one.points:
            if p.quantity != "energy":
                points[p.inside].append(p)
    drawn = {state: ([p.speed for p in own], [p.measured for p in own]) for state, own in points.items()}
    return [band(acceptances, "extension"), band(acceptances, "compression")], drawn


def used_of_band(acceptances: Sequence[Acceptance]) -> dict[str, dict[str, list[float]]]:
    """Record -> quantity -> what each judged cycle uses of the band; see `Point.used`."""
    return {
        one.record: {q: [p.used or 0.0 for p in one.judged if p.quantity == q] for q in one.quantities}
        for one in acceptances
    }


def _checked_quantities(quantities: Iterable[Quantity], band: Tolerance) -> tuple[Quantity, ...]:
    given = tuple(dict.fromkeys([quantities] if isinstance(quantities, str) else quantities))
    unknown = [q for q in given if q not in QUANTITIES]
    if unknown or not given:
        what = f"{unknown[0]!r} is not among the quantities" if unknown else "no quantity is given"
        raise InputError(f"{what}; choose from {', '.join(QUANTITIES)}")
    narrow = [q for q in given if band.half(q, 0.0) == 0.0 and band.relative == 0.0]
    if narrow:
        raise InputError(
            f"the band of the {narrow[0]} has no width; give a relative tolerance, or one in {UNITS[narrow[0]]}"
        )
    return tuple(q for q in QUANTITIES if q in given)


def _point(k: int, quantity: Quantity, cycle: Cycle, expectation: Expected, tolerance: Tolerance) -> Point:
    measured = {"extension": cycle.force_out, "compression": cycle.force_in, "energy": cycle.energy}[quantity]
    speeds = {"extension": cycle.speed_out, "compression": -cycle.speed_in}
    speed = speeds.get(quantity, max(speeds.values()))
    value, reason = expectation
    if value is None:
        return Point(k + 1, quantity, speed, cycle.stroke_m, measured, reason=reason)
    half = tolerance.half(quantity, value)
    low, high = value - half, value + half
    return Point(k + 1, quantity, speed, cycle.stroke_m, measured, value, low, high, low <= measured <= high)


def _reason(points: Sequence[Point], requested: Sequence[Quantity]) -> str:
    """Why the whole cannot be judged; "" where at least half of the cycles of every quantity were."""
    by_reason: dict[str, list[str]] = {}
    for quantity in requested:
        own = [p for p in points if p.quantity == quantity]
        open_ones = Counter(p.reason for p in own if p.inside is None)
        if sum(open_ones.values()) > SHARE * len(own):
            by_reason.setdefault(open_ones.most_common(1)[0][0], []).append(quantity)
    return "; ".join(
        why if len(names) == len(requested) else f"{', '.join(names)}: {why}" for why, names in by_reason.items()
    )
