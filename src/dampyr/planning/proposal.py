"""A proposal: the next tests, what each is good for, and which intervals are expected once they are performed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from dampyr.atomic_write import whole_file
from dampyr.campaigns.campaign import Campaign, campaign_of
from dampyr.campaigns.force_prediction import specimen
from dampyr.config import Choices
from dampyr.errors import InputError
from dampyr.findings import OF_DAMPER, Finding, handed_on
from dampyr.identification import Fit, FitOptions
from dampyr.identification.fits.least_squares import fit_model
from dampyr.input_kinds import NO_INPUT
from dampyr.models import Constant, Damper
from dampyr.options import Options, ShownIn, Terminal, takes
from dampyr.origin import Origin
from dampyr.phrases import listing
from dampyr.planning.candidates import KINDS, SECONDS, Candidate, RigEnvelope, envelope, voltages_of
from dampyr.planning.choose import ParameterGoal, PeakGoal, best_tests, pool_of
from dampyr.planning.expected_information import (
    CoefficientLayout,
    Expected,
    Information,
    ModelDeviation,
    assumed_spread,
    calibration,
    expected,
    expected_information,
    expected_record,
    layout,
    learned,
)
from dampyr.planning.goal import Peak, parameter_goal, peak_goal, peak_half_of_fit
from dampyr.planning.separating_tests import separate_level_from_stroke
from dampyr.records import Record, nominal_inputs
from dampyr.rig import RigSettings, load_settings
from dampyr.shown import Shown
from dampyr.units import Quantity

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]
TESTS = 6  # where nobody says how many: three records are the least that give an interval, and twice as many halve it
MAX_TESTS = 60
CAUSES = 2  # parameters that are named as why a test is there
TINY_GAIN = 0.005  # by which an interval would be wider without a test: below it nothing is said


@dataclass(frozen=True)
class PlanOptions(Options):
    """Options of `propose` and `plan_and_perform`; ``peak`` is that of a structure, for the goal "peak"."""

    model: Annotated[str | None, "Model that is fitted, such as dahl; records need one"] = None
    laws: Annotated[
        str | Mapping[str, str] | None,
        Terminal("--law", "[NAME=]KIND"),
        "How parameters follow the input, as of identify, such as dahl.rho=constant",
    ] = None
    fixed: Annotated[
        Mapping[str, float], Terminal("--fix", "NAME=VALUE"), "Parameters that are held at a value, in SI units"
    ] = field(default_factory=dict)
    bandwidth: Annotated[
        float | None,
        Quantity("Hz", low=0, open_low=True),
        "Bandwidth of the velocity that is derived from the displacement",
    ] = None
    tests: Annotated[
        int | None,
        Quantity("", low=1, high=MAX_TESTS),
        "Largest number of tests; 6 without it, 12 where they are performed",
    ] = None
    duration: Annotated[float | None, Quantity("s", low=0, open_low=True), "How long the tests may take together"] = (
        None
    )
    targets: Annotated[
        Mapping[str, float],
        Quantity("", low=0, high=1, open_low=True),
        ShownIn("%"),
        Terminal("--target", "NAME=SHARE"),
        "Half widths of 95 % intervals over their values, such as dahl.rho=5%, at which a plan ends",
    ] = field(default_factory=dict)
    goal: Annotated[
        str,
        Choices({"parameters": "those of the damper", "peak": "the peak of a structure in an earthquake"}),
        "What the tests are to determine well",
    ] = "parameters"
    peak_target: Annotated[
        float | None,
        Quantity("", low=0, high=1, open_low=True),
        ShownIn("%"),
        "Half width of the peak's 95 % interval over it, at which a plan ends",
    ] = None
    voltages: Annotated[
        tuple[float, ...] | None,
        Quantity("V"),
        Terminal("--at"),
        "Voltages to test at; without them those of the records or of the card",
    ] = None
    kinds: Annotated[tuple[str, ...], Choices(KINDS), Terminal("--kind"), "Kinds of step to choose from"] = KINDS
    seconds: Annotated[float, Quantity("s", low=0, open_low=True), "Time of steady motion in each test"] = SECONDS
    mixed_origins: Annotated[bool, "Fit simulated or virtual records together with others"] = False
    peak: Peak | None = None

    def check_goal(self) -> None:
        """Refuse the goal of a peak without its structure, a structure without that goal, and targets of another goal."""
        if (self.goal == "peak") != (self.peak is not None):
            raise InputError("the goal peak needs a structure, a motion and a voltage, and no other goal takes them")
        if self.goal == "peak" and self.targets:
            raise InputError(
                "targets are of parameters, and the goal is a peak; give its own target, or the goal parameters"
            )
        if self.peak_target is not None and self.goal != "peak":
            raise InputError("the target of a peak is a share of it, such as 0.02, and needs the goal peak")

    @property
    def aim(self) -> str:
        """What is to be known well, in words."""
        if self.peak is not None:
            return self.peak.words
        return f"the parameters {', '.join(self.targets)}" if self.targets else "all parameters"

    @property
    def aimed(self) -> bool:
        """Whether there is a target, after which nothing more need be tested."""
        return bool(self.targets) or self.peak_target is not None

    @property
    def max_tests(self) -> int:
        """How many tests there are at most."""
        if self.tests is not None:
            return self.tests
        return MAX_TESTS if self.aimed or self.duration is not None else TESTS


@dataclass(frozen=True, repr=False)
class ProposedTest(Shown):
    """A test of a proposal; ``improves`` says by how much intervals would be wider without it, the most first, and ``reason``
    what else it is there for."""

    candidate: Candidate
    improves: Mapping[str, float]
    reason: str = ""

    @property
    def why(self) -> str:
        """What it is there for, or which intervals would be wider without it, in words."""
        if self.reason:
            return self.reason
        wider = [
            f"{label} {100 * share:.0f} %" for label, share in list(self.improves.items())[:CAUSES] if share > TINY_GAIN
        ]
        return listing(wider) if wider else "one record more for all"


@dataclass(frozen=True, eq=False, repr=False)
class Proposal(Shown):
    """The next tests.

    ``before`` and ``after`` are the half widths of 95 % intervals over the values by coefficient, now and as expected after the
    tests: ``before`` is empty where nothing is known yet, infinite values mean that there is no interval. ``peak_before`` and
    ``peak_after`` are those of the peak, None for other goals. A level that differs from day to day is in no interval.
    """

    tests: tuple[ProposedTest, ...]
    values: Mapping[str, float]
    before: Mapping[str, float]
    after: Mapping[str, float]
    goal: str
    model: str
    rig: RigSettings
    damper: Damper
    envelope: RigEnvelope
    spread: ModelDeviation
    reached: bool
    peak: float | None = None
    peak_before: float | None = None
    peak_after: float | None = None
    notes: tuple[str, ...] = ()

    @property
    def origin(self) -> Origin:
        """That of the damper that it rests on."""
        return self.damper.origin

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong or in doubt in the damper that it rests on."""
        return handed_on([self.damper], OF_DAMPER)

    @property
    def duration(self) -> float:
        """s of all tests, without the rests between them."""
        return sum(test.candidate.duration for test in self.tests)

    @property
    def document(self) -> dict[str, Any]:
        """The campaign as TOML has it."""
        note = f"planned for {self.goal}, model {self.model}"
        return {"name": "planned", "note": note, "step": [test.candidate.table for test in self.tests]}

    def campaign(self) -> Campaign:
        """The tests as a campaign, for `dampyr.campaigns.plan` and `perform`."""
        return replace(campaign_of(self.document), source=self.text)

    @property
    def text(self) -> str:
        """The campaign file."""
        import tomli_w

        lines = [
            f"# Planned by dampyr for {self.goal}; half widths of 95 % intervals that are expected after these tests:"
        ]
        lines += [f"#   {label}: {half_in_percent(half)}" for label, half in self.after.items()]
        return "\n".join(lines) + "\n" + tomli_w.dumps(self.document)

    def save(self, path: str | Path) -> Path:
        """Write a campaign file, which `dampyr run` performs; :class:`~dampyr.errors.FileError` where there is one."""
        path = Path(path)
        with whole_file(path, new=True) as temporary:
            temporary.write_text(self.text, encoding="utf-8", newline="\n")
        return path


def half_in_percent(half: float | None) -> str:
    """A half width over its value, such as ``8.7 %``; "none" where there is no interval."""
    if half is None or not np.isfinite(half):
        return "none"
    return f"{100 * half:.2g} %"


@takes(PlanOptions)
def propose(
    evidence: Damper | Fit | Record | Sequence[Record] | None = None,
    rig: RigSettings | str | Path | None = None,
    options: PlanOptions | None = None,
    progress: Progress = lambda stage, done: None,
    **given: Any,
) -> Proposal:
    """The next tests on a rig, by what they are expected to tell of a damper.

    Parameters
    ----------
    evidence
        What is known of the damper: its records, or a fit to them, or a card. After a card the intervals are those of the new
        tests alone, since a card brings no records; after records those of all together. None: the card that the rig names, or
        the simulated rig's own.
    rig
        A rig or its ``rig.toml``; the original rig where nothing is given.
    options
        The further arguments as one object; those that are given by name, such as ``targets={"dahl.rho": 0.05}``, take
        their places. ``peak``: the `Peak` of a structure, for the goal "peak".
    progress
        Called with what is being done, and the fraction of it that is done.

    Returns
    -------
    Proposal
        the tests, and the intervals that are expected after them.

    Raises
    ------
    InputError
        nothing is known of the damper, no test is within the rig's limits, or an option that excludes another; before anything
        moves.

    Examples
    --------
    >>> import dampyr as dp
    >>> card = dp.studies.raminelli_2020.damper()
    >>> proposal = dp.planning.propose(card, tests=2, kinds=["sine"], voltages=[1.98], laws="constant", seconds=4.0)
    >>> len(proposal.tests), proposal.duration < 60.0
    (2, True)
    """
    folder = None
    if rig is None or isinstance(rig, RigSettings):
        settings = rig or RigSettings()
    else:
        settings, folder = load_settings(rig), Path(rig).parent
    options = PlanOptions.of("propose", options, given)
    options.check_goal()
    evidence = specimen(settings, folder) if evidence is None else evidence
    if evidence is None:
        raise InputError(
            "nothing is known of the damper, not even a card, so no motion can be checked against its force; give a card or "
            "records, or name a card in the rig's file (specimen.card)"
        )
    if isinstance(evidence, Damper):
        return _propose(evidence, None, settings, options, progress)
    if not isinstance(evidence, Fit):
        evidence = fitted(evidence, options, progress)
    if evidence.damper is None:
        raise InputError(f"the records give no damper to plan from: {evidence.reason}; try another model")
    return _propose(evidence.damper, evidence, settings, options, progress)


def fitted(
    records: Record | Sequence[Record], options: PlanOptions, progress: Progress = lambda stage, done: None
) -> Fit:
    """The fit that a plan is judged by: with a lag of the input where it varies within a test.

    The coil's current follows its voltage late, and without the lag every step of the voltage would count as misfit.
    """
    listed = [records] if isinstance(records, Record) else nominal_inputs(list(records))
    if options.model is None:
        raise InputError("records are given without a model; name one, such as dahl")
    model = options.model
    varies = any(np.ndim(r.voltage) and np.ptp(r.voltage) for r in listed if r.voltage is not None)
    if varies and "lag" not in map(str.strip, model.split("+")):
        model = f"{model} + lag"

    def show(step: int, _: float) -> None:
        progress("fitting the model", step / (step + 20.0))

    of_fit = FitOptions(
        laws=options.laws, fixed=options.fixed, bandwidth=options.bandwidth, mixed_origins=options.mixed_origins
    )
    result = fit_model(model, listed, of_fit, show)
    progress("fitting the model", 1.0)
    return result


def _propose(
    damper: Damper, evidence: Fit | None, rig: RigSettings, options: PlanOptions, progress: Progress
) -> Proposal:
    notes: list[str] = []
    kinds = _choose_kinds(rig, options, notes)
    if not damper.has_input:
        kinds, notes = tuple(kind for kind in options.kinds if kind != "voltage_steps"), []
    bare = damper.without("lag") if "lag" in damper.composition.names else damper
    if options.peak is not None:
        options.peak.check(damper)
    chosen_voltages = options.voltages if options.voltages is not None or evidence is None else _list_knots(evidence)
    if not damper.has_input and options.voltages is None:
        chosen_voltages = None
    levels = voltages_of(damper, rig, chosen_voltages)
    candidates_of = envelope(
        rig, bare, levels, kinds, options.seconds, lambda p: progress("finding what the rig can do", p)
    )
    separating = _list_separating_tests(evidence, rig, bare, levels, kinds, options, notes)
    candidates = (*separating, *candidates_of.candidates)
    records = []
    for k, candidate in enumerate(candidates):
        records.append(expected_record(candidate.step.drive(rig), bare, rig, f"candidate {k + 1}"))
        progress("weighing the candidates", 0.3 * (k + 1) / len(candidates))
    study = _Study(damper, bare, evidence, rig, options)
    pool = study.of(records, lambda p: progress("weighing the candidates", 0.3 + 0.7 * p))
    # the criterion is a logarithm: of the peak's half width, or of the ratios to the targets, which is 0 where all are met
    enough = -np.inf if not options.targets else 0.0
    if options.peak_target is not None:
        enough = float(np.log(options.peak_target))
    places = best_tests(
        pool.plan,
        pool_of(pool.plan, pool.present, pool.candidates, pool.spread, pool.factors),
        options.max_tests,
        pool.goal,
        [candidate.duration for candidate in candidates],
        np.inf if options.duration is None else options.duration,
        enough=enough - float(np.log(pool.peak_factor)),
        progress=lambda p: progress("choosing tests", p),
        first=range(len(separating)),
    )
    if not places:
        shortest = min(candidate.duration for candidate in candidates)
        raise InputError(
            f"duration = {options.duration:g} s is shorter than the shortest candidate, {shortest:.3g} s; give more, or fewer "
            "seconds of motion"
        )
    chosen = [records[k] for k in places]
    if study.layout_of(chosen).labels == pool.plan.labels:
        last = replace(pool, candidates=[pool.candidates[k] for k in places])
    else:  # without a lag, or at fewer voltages, there are fewer coefficients
        last = study.of(chosen)
    after = expected(last.plan, [*last.present, *last.candidates], last.spread, factors=last.factors)
    reasons = [separating.get(candidates[k], "") for k in places]
    tests = tuple(
        ProposedTest(candidates[k], last.improved_by(place, after), reason)
        for place, (k, reason) in enumerate(zip(places, reasons, strict=True))
    )
    before, peak_before = _measure_before(damper, evidence, last, notes)
    if last.spread.records == 0:
        notes.append(
            "how records differ is assumed (3 % of gain, 3 % of each parameter, residuals of 5 %): after a first fit it is "
            "estimated"
        )
    # none wider than the records give already: more tests take nothing away
    narrowest = before if evidence is not None else {}
    halves = zip(last.plan.labels, after.half, strict=True)
    peak_after = last.goal.half(after) * last.peak_factor if isinstance(last.goal, PeakGoal) else None
    if peak_after is not None and evidence is not None and peak_before is not None:
        peak_after = min(peak_after, peak_before)
    return Proposal(
        tests=tests,
        values=dict(zip(last.plan.labels, map(float, last.plan.theta), strict=True)),
        before=before,
        after={label: min(float(half), narrowest.get(label, np.inf)) for label, half in halves},
        goal=options.aim,
        model=str(last.plan.composition),
        rig=rig,
        damper=damper,
        envelope=candidates_of,
        spread=last.spread,
        reached=options.aimed and last.goal(after) + float(np.log(last.peak_factor)) <= enough,
        peak=last.peak,
        peak_before=peak_before,
        peak_after=peak_after,
        notes=(*notes, *_note_sessions(evidence, [test.candidate for test in tests])),
    )


def _list_separating_tests(
    evidence: Fit | None,
    rig: RigSettings,
    damper: Damper,
    inputs: Sequence[float],
    kinds: Sequence[str],
    options: PlanOptions,
    notes: list[str],
) -> dict[Candidate, str]:
    """The tests that tell a level from a stroke where the records do not, and why each is there; ``notes`` say what is open."""
    if evidence is None or "sine" not in kinds:
        return {}
    found = separate_level_from_stroke(evidence, rig, damper, inputs, options.seconds)
    if found is None:
        return {}
    needed = sum(test.duration for test in found.tests)
    if not found.tests:
        notes.append(f"{found.words}; this rig can do no three sines that would tell, at these inputs")
        return {}
    if options.max_tests <= len(found.tests) or (options.duration is not None and needed > options.duration):
        notes.append(
            f"{found.words}; three tests of {needed:.0f} s together would tell, and are proposed where {len(found.tests) + 1} "
            "tests or more and as much time are allowed"
        )
        return {}
    notes.append(f"{found.words}; the first three of these tests, made in one session, tell")
    return dict(zip(found.tests, found.reasons, strict=True))


def _choose_kinds(rig: RigSettings, options: PlanOptions, notes: list[str]) -> tuple[str, ...]:
    """The kinds of step to plan with; tests of varying voltage only where a fit can take them."""
    laws = options.laws
    kinds_of_law = [laws] if isinstance(laws, str) else [*(laws or {}).values()]
    at_values = any(str(kind).startswith("interpolation") for kind in kinds_of_law)
    why = "laws by interpolation need one voltage in each test" if at_values else ""
    if not why and rig.wires.coil_voltage:
        why = "the coil's voltage is read back here, and its noise would count as voltages that differ"
    if not why or "voltage_steps" not in options.kinds:
        return options.kinds
    notes.append(f"no steps of voltage within a test: {why}")
    return tuple(kind for kind in options.kinds if kind != "voltage_steps")


def _list_knots(evidence: Fit) -> tuple[float, ...]:
    """The inputs of a fit's records: its knots."""
    return tuple(sorted({u for c in evidence.problem.columns for u in c.knots}))


def _note_sessions(evidence: Fit | None, tests: Sequence[Candidate]) -> tuple[str, ...]:
    """Where the records do not show how measurement sessions differ: whether these tests, made in one, settle it."""
    of_records = None if evidence is None else evidence.levels
    if evidence is None or of_records is None or not of_records.settles:
        return ()
    if of_records.named and len(of_records.sessions) == 1:
        return (f"{of_records.words}; to settle it, repeat one of these tests on another day or after a new mounting",)
    tested = {u for test in tests for u in getattr(test.step, "voltages", (getattr(test.step, "voltage", None),))}
    missing = [f"{u:g}" for u in _list_knots(evidence) if not any(v is not None and abs(u - v) < 1e-6 for v in tested)]
    if evidence.problem.pieces[0].unit == NO_INPUT:
        do = "repeat a test of the records among these, which are made in one session"
    elif missing:
        do = f"add a test at {listing(missing)} V to the session of these tests: then each voltage is tested in two sessions"
    else:
        do = "these tests, made in one session, settle it, for they are at every voltage of the records"
    state = "" if of_records.named else "; state the session of the earlier records, too (measurement_session)"
    return (f"{of_records.words}; {do}{state}",)


@dataclass(frozen=True, eq=False)
class _Pool:
    """Present records and candidates in one layout, with the spread and the goal."""

    plan: CoefficientLayout
    present: list[Information]
    candidates: list[Information]
    spread: ModelDeviation
    goal: ParameterGoal | PeakGoal
    peak: float | None
    factors: Array
    peak_factor: float

    def improved_by(self, place: int, after: Expected) -> dict[str, float]:
        """By how much each interval would be wider without the candidate at ``place``, the most first."""
        others = [c for k, c in enumerate(self.candidates) if k != place]
        without = expected(self.plan, [*self.present, *others], self.spread, True, self.factors)
        wider = without.half / after.half - 1.0
        order = [int(k) for k in np.argsort(-np.nan_to_num(wider, nan=-1.0, posinf=-1.0))]
        return {self.plan.labels[k]: float(wider[k]) for k in order if np.isfinite(wider[k]) and wider[k] > 0.0}


@dataclass(frozen=True, eq=False)
class _Study:
    """What is known, and how a fit with further records would be laid out."""

    damper: Damper
    bare: Damper
    evidence: Fit | None
    rig: RigSettings
    options: PlanOptions

    def layout_of(self, records: Sequence[Record]) -> CoefficientLayout:
        """The coefficients of a fit to the present records and these."""
        inputs: list[float | Array] = [r.voltage for r in records if r.voltage is not None]
        inputs += [0.0 for r in records if r.input == NO_INPUT]
        inputs += [p.u for p in self.evidence.problem.pieces] if self.evidence else []
        damper = self._with_lag() if any(np.ndim(u) for u in inputs) else self.bare
        return layout(damper, inputs, self.options.laws, self.options.fixed)

    def of(self, records: Sequence[Record], progress: Callable[[float], None] = lambda done: None) -> _Pool:
        """The information of the present records and of these."""
        plan = self.layout_of(records)
        spread, present = (assumed_spread(plan), []) if self.evidence is None else learned(self.evidence, plan)
        factors = (
            np.ones(len(plan.labels)) if self.evidence is None else calibration(self.evidence, plan, present, spread)
        )
        informations = []
        for k, record in enumerate(records):
            informations.append(expected_information(plan, record, spread))
            progress((k + 1) / len(records))
        peak = None
        goal: ParameterGoal | PeakGoal
        if self.options.peak is None:
            goal = parameter_goal(plan, self.options.targets)
        else:
            goal, peak = peak_goal(plan, self.options.peak)
        return _Pool(
            plan,
            present,
            informations,
            spread,
            goal,
            peak,
            factors,
            self._peak_factor(plan, present, spread, goal, factors),
        )

    def _peak_factor(
        self,
        plan: CoefficientLayout,
        present: Sequence[Information],
        spread: ModelDeviation,
        goal: ParameterGoal | PeakGoal,
        factors: Array,
    ) -> float:
        """By which the half width of the peak by the fit differs from what is expected of the same records, shrunk as in
        `calibration`: the correlations of the coefficients are in it, too."""
        if self.evidence is None or not isinstance(goal, PeakGoal):
            return 1.0
        now = goal.half(expected(plan, present, spread, open_ends=True, factors=factors))
        achieved, freedom = peak_half_of_fit(self.evidence, plan, goal)
        if not (np.isfinite(achieved) and now > 0.0 and achieved > 0.0):
            return 1.0
        return float((achieved / now) ** (freedom / (freedom + 2.0)))

    def _with_lag(self) -> Damper:
        """The damper with a lag of its input, that of the rig's coil where it has none."""
        if "lag" in self.damper.composition.names:
            return self.damper
        tau = self.rig.supply.inductance / self.rig.supply.resistance
        low, high = self.bare.range
        laws = {**self.bare.all_laws, "lag.tau": Constant(max(tau, 1e-4), low, high)}
        return Damper((*self.bare.composition.names, "lag"), laws, input=self.bare.input, ranges=self.bare.ranges)


def _measure_before(
    damper: Damper, evidence: Fit | None, last: _Pool, notes: list[str]
) -> tuple[dict[str, float], float | None]:
    """The half widths over the values now, by the labels of the plan, and that of the peak."""
    if evidence is not None:
        spans = evidence.intervals()
        halves = {
            label: 0.5 * (spans[label][1] - spans[label][0]) / abs(value)
            for label, value in evidence.parameters.items()
            if value and label in last.plan.labels
        }
        halves_by_label = {label: half if np.isfinite(half) else np.inf for label, half in halves.items()}
        peak = peak_half_of_fit(evidence, last.plan, last.goal)[0] if isinstance(last.goal, PeakGoal) else None
        return halves_by_label, peak
    if damper.covariance is None:
        notes.append("the card has no covariance, so how well it is known before these tests is not known")
        return {}, None
    notes.append("the card brings no records: after these tests the intervals are those of the tests alone")
    return _measure_card(damper, last.plan), None


def _measure_card(damper: Damper, plan: CoefficientLayout) -> dict[str, float]:
    """1.96 standard errors of a card's values at the knots of a plan, over the values."""
    base, covariance = damper.coefficients, damper.covariance
    assert covariance is not None
    halves_by_label, place = {}, 0
    for column in plan.columns:
        if not column.size:
            continue
        labels = plan.labels[place : place + column.size]
        place += column.size
        if column.name not in damper.all_laws:
            continue
        for label, u in zip(labels, column.knots, strict=True):
            value = float(damper.all_laws[column.name](u))
            gradient = np.zeros(base.size)
            for k in range(base.size):
                step = 1e-4 * max(abs(base[k]), 1e-9)
                moved = base.copy()
                moved[k] += step
                with_it = damper.with_coefficients(moved).all_laws[column.name]
                gradient[k] = (float(with_it(u)) - value) / step
            variance = float(gradient @ np.where(np.isfinite(covariance), covariance, 0.0) @ gradient)
            lost = np.any((gradient != 0.0) & ~np.isfinite(np.diag(covariance)))
            if value:
                halves_by_label[label] = np.inf if lost else 1.96 * np.sqrt(max(variance, 0.0)) / abs(value)
    return halves_by_label
