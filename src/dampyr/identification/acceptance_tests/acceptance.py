r"""Acceptance of a tested damper: whether it lies within a band about a reference, as in production and device tests.

Every whole cycle of every level (`dampyr.records.cut_cycles`) is judged by three quantities: the force at peak
velocity in extension and in compression (the peak-velocity pick-up of a damper dynamometer,
`dampyr.records.cycle_table`), and the energy that it dissipates; and so is the mean of each over the cycles of a
level. With the reference's value :math:`e` the band is

.. math:: e \pm (r |e| + a)

with a relative share r and a slack a in N or J. One cycle outside is outside. What the record's own noise explains is
allowed beyond the edge: z standard errors, :math:`z = \Phi^{-1}(1 - 0.05/N)` for N values, so that noise alone fails
a damper within the band in at most 5 % of tests, however many cycles they have; but no more than a third of the half
band, and the error of a level's mean falls with its cycles. A cycle without a reference value (another input, faster,
a wider stroke) is not judged, and the reason is kept; nothing is extrapolated. Without every level judged there is no
verdict but "failed".

The band of 15 % that stands as the default is what a maker of friction dampers promises of each specimen, of its force and of
the area of its loops [SteelDamper]_. Standards for seismic devices have bands of their own: state yours.

References
----------
.. [SteelDamper] steeldamper.com, "SFD mechanical performance requirements": table of products, items 1 and 6.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from statistics import NormalDist
from typing import Annotated, Literal

import numpy as np

from dampyr.config import Choices
from dampyr.errors import InputError
from dampyr.identification.acceptance_tests.reference_cycles import Expected, Reference, expected
from dampyr.models import Damper
from dampyr.options import Options, ShownIn, Terminal
from dampyr.origin import NOT_STATED, Origin, combined
from dampyr.records import Record, cut_cycles, cycle_table
from dampyr.records.cycle_analysis.cycle_table import Cycle
from dampyr.records.cycle_analysis.cycles import SAME_STROKE, Cut
from dampyr.shown import Shown
from dampyr.units import Quantity

Verdict = Literal["passed", "failed", "not judged"]
QUANTITIES = ("extension", "compression", "energy")
UNITS = {"extension": "N", "compression": "N", "energy": "J"}
SHARE = 0.5  # of a quantity's points of a level: with more of them open than judged the test is no test
RISK = 0.05  # that noise alone fails a damper at the edge of its band
NOISE_SHARE = 1 / 3  # of half the band: more is not allowed for noise
BEYOND = 4 / 3  # of half the band: how far the damper is off whose chance to pass is stated, 20 % with a band of 15 %
SUCCESSIVE = 8  # cycles of a level: from their differences its scatter is told
NORMAL = NormalDist()


@dataclass(frozen=True)
class Tolerance:
    """Half the width of a band: ``relative`` (0.15 is 15 %) of the expected value, plus ``force`` in N or ``energy`` in J."""

    relative: float = 0.15
    force: float = 0.0
    energy: float = 0.0

    def __str__(self) -> str:
        parts = ((100 * self.relative, "%"), (self.force, "N"), (self.energy, "J"))
        return "± " + " and ".join(f"{value:g} {unit}" for value, unit in parts if value)

    def half(self, quantity: str, value: float) -> float:
        """Half the width of the band about ``value``, in N or J."""
        return self.relative * abs(value) + (self.energy if quantity == "energy" else self.force)


@dataclass(frozen=True)
class AcceptOptions(Options):
    """Options of `accept`."""

    tolerance: Annotated[
        float,
        Quantity("", low=0, high=1),
        ShownIn("%"),
        "Half the width of the band, as a share of what the reference gives",
    ] = 0.15
    force_slack: Annotated[
        float, Quantity("N", low=0), "Force that is added to half the width of the band of each force"
    ] = 0.0
    energy_slack: Annotated[
        float, Quantity("J", low=0), "Energy that is added to half the width of the band of each energy"
    ] = 0.0
    quantities: Annotated[
        tuple[str, ...],
        Choices(QUANTITIES),
        Terminal("--judge"),
        "What is judged: the forces at peak velocity in extension and in compression, and the energy of a cycle; may be given "
        "several times",
    ] = QUANTITIES
    offset: Annotated[
        float | None,
        Quantity("N"),
        "Zero of the load cell, which is taken from every measured force; without it its mean over whole cycles is",
    ] = None
    allow_extrapolation: Annotated[bool, "Judge motions and inputs beyond what the card was calibrated on, too"] = False
    relevel: Annotated[
        int,
        Quantity("", low=0),
        "Judge a second time with the level of this many first cycles taken out of the later ones; 0 for not at all",
    ] = 0

    @property
    def band(self) -> Tolerance:
        """The three parts of half the band's width."""
        return Tolerance(self.tolerance, self.force_slack, self.energy_slack)

    def check(self) -> None:
        """Refuse to judge by nothing, or with a band without a width."""
        if not self.quantities:
            raise InputError(f"quantities: no quantity is given; choose from {', '.join(QUANTITIES)}")
        for quantity in self.quantities:
            if self.band.half(quantity, 1.0) == 0.0:
                raise InputError(
                    f"the band of the {quantity} has no width; give a relative tolerance, or one in {UNITS[quantity]}"
                )


@dataclass(frozen=True)
class AcceptancePoint:
    """One quantity of one cycle, SI; forces in compression are negative.

    ``cycle`` counts from 1, ``speed`` is the peak velocity in that direction (of ``energy``: the faster of the two)
    and is positive. ``error`` is the standard error of ``measured``, None where the record does not tell it. The band
    is ``low`` to ``high``; ``inside`` allows ``allowance`` beyond it for noise. Where the point was not judged,
    ``expected``, ``low``, ``high`` and ``inside`` are None and ``reason`` says why.
    """

    cycle: int
    quantity: str
    speed: float
    stroke_m: float
    measured: float
    expected: float | None = None
    low: float | None = None
    high: float | None = None
    inside: bool | None = None
    reason: str = ""
    level: int = 1
    error: float | None = None
    allowance: float = 0.0

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

    def allows(self, measured: float) -> bool | None:
        """Whether ``measured`` lies within the band and the allowance for noise; None where there is no band."""
        if self.low is None or self.high is None:
            return None
        return self.low - self.allowance <= measured <= self.high + self.allowance


@dataclass(frozen=True)
class JudgedLevel:
    """The cycles of one level together, SI.

    ``cycles`` were run, from the cycle ``first`` on, ``judged`` of them by every quantity. ``deviation`` of each
    quantity is the mean measured over the mean expected value less 1, ``inside`` whether that mean lies within the
    band, both None where too few cycles were judged, and ``scatter`` the standard deviation of single values over the
    mean expected one; ``reason`` says why.
    """

    number: int
    stroke_m: float
    frequency_hz: float
    first: int
    cycles: int
    judged: int = 0
    deviation: Mapping[str, float | None] = field(default_factory=dict)
    scatter: Mapping[str, float | None] = field(default_factory=dict)
    inside: Mapping[str, bool | None] = field(default_factory=dict)
    reason: str = ""


@dataclass(frozen=True, repr=False)
class Acceptance(Shown):
    """The judgement of one record. ``reason`` says why it is not judged as a whole, "" where it is.

    ``offset`` is what was taken from the measured forces, N; None: the mean over whole cycles of each record. ``level`` is the
    factor that the measured forces were divided by, 1 unless `relevelled` took one from the first cycles.

    ``run`` cycles were run, in halves, and ``cut`` are whole; ``stroke_m`` is the largest stroke of the motion and
    ``judged_stroke_m`` that of the judged cycles, 0 without any. ``wrong_rejection`` is the chance that a damper just
    like the reference fails at the record's own scatter, ``wrong_acceptance`` the chance that one passes whose one
    quantity at one level lies beyond the edge of the band by a third of its half width (off by 20 % where 15 % are
    allowed), at the level where that chance is largest; None where the record has too few cycles and samples to tell
    its scatter.
    ``origin`` is that of record and reference together.
    """

    record: str
    input: str | None
    input_value: float | None
    tolerance: Tolerance
    quantities: tuple[str, ...]
    offset: float | None
    points: tuple[AcceptancePoint, ...]
    reason: str = ""
    level: float = 1.0
    levels: tuple[JudgedLevel, ...] = ()
    run: float = 0.0
    cut: int = 0
    stroke_m: float = 0.0
    wrong_rejection: float | None = None
    wrong_acceptance: float | None = None
    origin: Origin = NOT_STATED

    @property
    def judged_cycles(self) -> int:
        """How many cycles were judged by every quantity."""
        return sum(level.judged for level in self.levels)

    @property
    def judged_stroke_m(self) -> float:
        """The largest stroke of the judged cycles, m; 0 without any."""
        return max((p.stroke_m for p in self.judged), default=0.0)

    @property
    def levels_outside(self) -> tuple[JudgedLevel, ...]:
        """The levels of which a mean lies outside the band."""
        return tuple(level for level in self.levels if False in level.inside.values())

    @property
    def judged(self) -> tuple[AcceptancePoint, ...]:
        """The points that have a reference value."""
        return tuple(p for p in self.points if p.inside is not None)

    @property
    def outside(self) -> tuple[AcceptancePoint, ...]:
        """The points outside the band, the worst first."""
        points = [p for p in self.points if p.inside is False]
        return tuple(sorted(points, key=lambda p: -abs(p.used or 0.0)))

    @property
    def worst(self) -> AcceptancePoint | None:
        """The judged point that uses most of its band, inside or outside."""
        return max(self.judged, key=lambda p: abs(p.used or 0.0), default=None)

    @property
    def passed(self) -> bool | None:
        """True or False, or None where too little was judged.

        False: a judged point, or the mean of a level, lies outside. True: none does, and at every level of the motion at least
        half of the cycles were judged by every requested quantity. None: nothing lies outside, but somewhere fewer were judged.
        """
        if self.outside or self.levels_outside:
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
        """`reasons`, and why the whole is not judged where that is none of them, with 0."""
        return self.reasons if not self.reason or self.reason in self.reasons else self.reasons | {self.reason: 0}


def judge_record(record: Record, reference: Reference, options: AcceptOptions) -> Acceptance:
    """Every whole cycle of every level of ``record``, judged by a reference; what cannot be judged is a value with a reason."""
    return judge_cut(record, cut_cycles(record), reference, options)


def judge_cut(
    record: Record, motion_cut: Cut, reference: Reference, options: AcceptOptions, values: int = 0
) -> Acceptance:
    """`judge_record` of a motion that was cut. ``values`` is how many the whole test has that can be outside by noise, where
    the record is a part of it."""
    band, requested = options.band, tuple(q for q in QUANTITIES if q in options.quantities)
    table = cycle_table(record, options.offset, motion_cut) if motion_cut.cycles else []
    table = [cycle for cycle in table if cycle.level]
    expectations = expected(reference, record, table, options.offset, options.allow_extrapolation)
    points = tuple(_make_point(q, cycle, expectations[q][k], band) for k, cycle in enumerate(table) for q in requested)
    against = [reference] if isinstance(reference, Damper) else reference
    origin = combined(source.origin for source in (record, *against))
    levels = tuple(
        JudgedLevel(run.number, run.stroke_m, 1.0 / run.period_s, run.first, run.count) for run in motion_cut.levels
    )
    judged = Acceptance(
        record.name, record.input, record.input_value, band, requested, options.offset, points,
        levels=levels, run=motion_cut.run, cut=len(motion_cut.cycles), stroke_m=motion_cut.stroke_m,
        origin=origin,
    )  # fmt: skip
    return _judge(judged, explain_unjudged(motion_cut), values)


def relevelled(judgement: Acceptance, cycles: int) -> Acceptance:
    """The judgement of the later cycles with the level of the first ``cycles`` taken out: the shape alone is judged.

    The level is the mean of measured over expected, of all judged points of these cycles. One that cannot be told
    (nothing of the first cycles was judged, or no later cycle is there) is a reason, and nothing is judged.
    """
    first = [p for p in judgement.judged if p.cycle <= cycles and p.expected]
    later = tuple(p for p in judgement.points if p.cycle > cycles)
    ratios = [p.measured / p.expected for p in first if p.expected]
    level = float(np.mean(ratios)) if ratios else math.nan
    if not (level > 0.0 and later):
        reason = "no later cycle" if level > 0.0 else f"no level: nothing of the first {cycles} cycles was judged"
        return replace(judgement, points=(), levels=(), reason=judgement.reason or reason)
    points = tuple(
        replace(p, measured=p.measured / level, error=None if p.error is None else p.error / level) for p in later
    )
    levels = tuple(
        replace(run, first=max(run.first, cycles + 1), cycles=min(run.cycles, run.first + run.cycles - cycles - 1))
        for run in judgement.levels
        if run.first + run.cycles > cycles + 1
    )
    return _judge(replace(judgement, points=points, levels=levels, level=level), "")


def _make_point(quantity: str, cycle: Cycle, expectation: Expected, tolerance: Tolerance) -> AcceptancePoint:
    measured = {"extension": cycle.force_out, "compression": cycle.force_in, "energy": cycle.energy}[quantity]
    error = {"extension": cycle.error_out, "compression": cycle.error_in, "energy": cycle.energy_error}[quantity]
    speeds = {"extension": cycle.speed_out, "compression": -cycle.speed_in}
    speed = speeds.get(quantity, max(speeds.values()))
    value, reason = expectation
    point = AcceptancePoint(
        cycle.number, quantity, speed, cycle.stroke_m, measured, reason=reason, level=cycle.level, error=error
    )
    if value is None:
        return point
    half = tolerance.half(quantity, value)
    return replace(point, expected=value, low=value - half, high=value + half)


def explain_unjudged(motion_cut: Cut) -> str:
    """Why a motion is no test of levels; "" where it is one."""
    if not motion_cut.cycles:
        return "no whole cycle"
    if not motion_cut.levels or (len(motion_cut.levels) > 1 and not motion_cut.repeats):
        like = sum(level.count for level in motion_cut.levels if level.count > 1)
        return f"the motion does not repeat itself: of {len(motion_cut.cycles)} whole cycles {like} are like their neighbours"
    largest = max(cycle.stroke_m for cycle in motion_cut.cycles if cycle.level)
    if motion_cut.stroke_m > (1.0 + SAME_STROKE) * largest:
        return (
            f"the largest stroke, {1e3 * motion_cut.stroke_m:.4g} mm, belongs to no whole cycle of a level; the largest of "
            f"those is {1e3 * largest:.4g} mm"
        )
    return ""


def _judge(judgement: Acceptance, reason: str, values: int = 0) -> Acceptance:
    """What is inside, with the allowance for noise, of the points and of the levels; and the reason against a verdict."""
    having = [p for p in judgement.points if p.expected is not None]
    count = values or len(having) + len({(p.level, p.quantity) for p in having})
    # Bonferroni over all points and means; one side each, as a value at the edge leaves the band on one side
    z = NORMAL.inv_cdf(1.0 - RISK / max(count, 1))
    points = tuple(_place(p, z) for p in judgement.points)
    levels = tuple(
        _judge_level(level, [p for p in points if p.level == level.number], judgement.quantities, z)
        for level in judgement.levels
    )
    rejection, acceptance = _estimate_risks(levels, points, z)
    return replace(
        judgement, points=points, levels=levels, reason=reason or _join_reasons(levels, judgement.quantities),
        wrong_rejection=rejection, wrong_acceptance=acceptance,
    )  # fmt: skip


def _halve_band(points: Sequence[AcceptancePoint]) -> float:
    """Half the width of the band about the mean of points that have a reference value."""
    return float(np.mean([0.5 * (p.high - p.low) for p in points if p.low is not None and p.high is not None]))


def _allow_for_noise(half: float, error: float, z: float) -> float:
    return min(z * error, NOISE_SHARE * half)


def _place(p: AcceptancePoint, z: float) -> AcceptancePoint:
    if p.low is None or p.high is None:
        return p
    allowance = _allow_for_noise(0.5 * (p.high - p.low), p.error or 0.0, z)
    p = replace(p, allowance=allowance)
    return replace(p, inside=p.allows(p.measured))


def _judge_level(
    level: JudgedLevel, points: Sequence[AcceptancePoint], requested: Sequence[str], z: float
) -> JudgedLevel:
    """A level with what its points say together."""
    cycles = {p.cycle for p in points}
    judged = sum(all(p.inside is not None for p in points if p.cycle == k) for k in cycles)
    deviation: dict[str, float | None] = {}
    scatter: dict[str, float | None] = {}
    inside: dict[str, bool | None] = {}
    reasons: dict[str, list[str]] = {}
    for quantity in requested:
        of_quantity = [p for p in points if p.quantity == quantity]
        having = [p for p in of_quantity if p.expected is not None]
        if len(of_quantity) - len(having) > SHARE * len(of_quantity):
            why = Counter(p.reason for p in of_quantity if p.expected is None).most_common(1)[0][0]
            reasons.setdefault(why, []).append(quantity)
        if not having:
            deviation[quantity] = scatter[quantity] = inside[quantity] = None
            continue
        value = float(np.mean([p.expected for p in having if p.expected is not None]))
        away = float(np.mean([p.measured for p in having])) - value
        half = _halve_band(having)
        error = float(np.linalg.norm([p.error or 0.0 for p in having])) / len(having)
        spread = _estimate_scatter(having)
        deviation[quantity] = away / value if value else None
        scatter[quantity] = spread / abs(value) if spread is not None and value else None
        inside[quantity] = abs(away) <= half * (1.0 + 1e-12) + _allow_for_noise(half, error, z)
    why = "; ".join(w if len(names) == len(requested) else f"{', '.join(names)}: {w}" for w, names in reasons.items())
    return replace(level, judged=judged, deviation=deviation, scatter=scatter, inside=inside, reason=why)


def _estimate_scatter(points: Sequence[AcceptancePoint]) -> float | None:
    """The standard deviation of single values, N or J: by their errors, or by successive cycles where these differ more.

    Differences of successive cycles hold no drift, and their median no single cycle that is off.
    """
    errors = [p.error for p in points if p.error is not None]
    by_error = float(np.sqrt(np.mean(np.square(errors)))) if errors else None
    if len(points) < SUCCESSIVE:
        return by_error
    off = np.array([p.measured - p.expected for p in points if p.expected is not None])
    # half of the differences of two normal values are below 0.67 times the root of two standard deviations
    by_cycles = float(np.median(np.abs(np.diff(off)))) / (NORMAL.inv_cdf(0.75) * math.sqrt(2.0))
    return max(by_cycles, by_error or 0.0)


def _estimate_risks(
    levels: Sequence[JudgedLevel], points: Sequence[AcceptancePoint], z: float
) -> tuple[float | None, float | None]:
    """The chances of a wrong rejection and of a wrong acceptance, see `Acceptance`; None where a scatter is not known."""
    right, wrong = 0.0, 0.0  # logarithm of the chance that all pass; the largest chance to pass
    judged = [(level, quantity) for level in levels for quantity, inside in level.inside.items() if inside is not None]
    for level, quantity in judged:
        of_quantity = [
            p for p in points if (p.level, p.quantity) == (level.number, quantity) and p.expected is not None
        ]
        spread, half = _estimate_scatter(of_quantity), _halve_band(of_quantity)
        if spread is None:
            return None, None
        error = float(np.linalg.norm([p.error or 0.0 for p in of_quantity])) / len(of_quantity)
        limits = [(spread, half + p.allowance) for p in of_quantity]
        mean = (spread / math.sqrt(len(of_quantity)), half + _allow_for_noise(half, error, z))
        right += sum(math.log(max(_chance_to_pass(0.0, *limit), 1e-300)) for limit in [*limits, mean])
        off = BEYOND * half
        all_pass = math.prod(_chance_to_pass(off, *limit) for limit in limits)
        wrong = max(
            wrong, min(all_pass, _chance_to_pass(off, *mean))
        )  # the mean passes where the single values do: no product
    return (max(0.0, -math.expm1(right)), wrong) if judged else (None, None)


def _chance_to_pass(off: float, spread: float, limit: float) -> float:
    """The chance that a value which is ``off`` by so much and scatters with ``spread`` is within ``limit``."""
    if spread <= 0.0:
        return float(abs(off) <= limit)
    return NORMAL.cdf((limit - off) / spread) - NORMAL.cdf((-limit - off) / spread)


def _join_reasons(levels: Sequence[JudgedLevel], requested: Sequence[str]) -> str:
    """Why the whole cannot be judged; "" where at least half of the cycles of every level and quantity were."""
    reasons = {level.number: level.reason for level in levels if level.reason}
    if not reasons:
        return ""
    if len(reasons) == len(levels) and len(set(reasons.values())) == 1:
        return next(iter(reasons.values()))
    return "; ".join(
        f"level {level.number} of {len(levels)}, {1e3 * level.stroke_m:.4g} mm: {level.reason}"
        for level in levels
        if level.reason
    )
