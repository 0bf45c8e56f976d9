"""Screening: every model of a list on a few short records, bare and with add-ons, by what it predicts; and which of a model's
parameters follow the input."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from dampyr.errors import DampyrWarning, InputError
from dampyr.identification.fits.fit_options import FitOptions
from dampyr.identification.model_choice import parallel
from dampyr.identification.model_choice.parameter_laws import list_held, list_shapes, may_follow_input, with_constant
from dampyr.identification.scoring.validation import Validation, cross_validate
from dampyr.identification.search.work import OUT_OF_TIME, OUT_OF_WORK
from dampyr.models import compose
from dampyr.records import Record, cycle_bounds, measure, with_velocity
from dampyr.records.checks.quality import motion_start
from dampyr.records.conditioning.velocity import check_bandwidth, default_bandwidth
from dampyr.shown import Shown

BETWEEN = 0.25  # the weight of inputs left out: see `dampyr.identification.leaderboard`
CONTENDING = 1.15  # times the lowest error: a model beyond it gets no further add-on
WORTH = 0.02  # of the error: what an add-on, or values at each input of its parameters, must lower it by to stay
# Of the error: what one value of a parameter that shapes the force may raise it by. The screening set is short: an error of 2 %
# more on it may be 10 % more on all records.
ALIKE = 0.005
SIMPLE = 4  # numbers of a model that gets add-ons however it does bare: with them it may be the damper
COMPARABLE = 1.3  # times the lowest error of a bare model: one of more numbers that is beyond it gets no add-on
NOT_BEGUN = "not tried: the work was used up"
CUT = "not tried: the search was cut"
EXACT = 1e-4  # an L1 ratio that no measured record shows: models whose errors are below it describe the records alike
STEPS = 15  # of each fit: enough to rank the models, not to converge
PROBE = "hyperbolic_tangent + spring + compliance"  # friction and elasticity, quick to fit
PER_INPUT = 4  # records of each input: from the smallest to the largest speed, two between
MAX_SAMPLES = 600  # of a shortened record, where the bandwidth of its motion allows it
SHORTEST = 5.0  # s
MIN_CYCLES = 4  # or so many cycles of a slow record
SAMPLES_PER_BANDWIDTH = 4.0  # twice the rate below which the motion would alias


@dataclass(frozen=True)
class TrialModel:
    """A model, and those of its parameters that have one value at all inputs."""

    model: str
    constant: tuple[str, ...] = ()

    def try_on(self, small: list[Record], options: FitOptions) -> Trial:
        """`trial` of it."""
        return replace(trial(self.model, small, with_constant(options, self.constant)), constant=self.constant)


@dataclass(frozen=True)
class Trial:
    """One model on the screening set: its validation error there; ``reason`` says why it is infinite, or what stopped a fit.

    ``work`` is what its fits have spent, counted s (`dampyr.identification.search.work`); the parameters that are ``constant``
    had one value at all inputs where they might have followed them.
    """

    model: str
    error: float
    seconds: float
    reason: str = ""
    work: float = 0.0
    constant: tuple[str, ...] = ()

    @property
    def trial_model(self) -> TrialModel:
        """What was tried."""
        return TrialModel(self.model, self.constant)

    @property
    def rank(self) -> float:
        """What it is ranked by: its error, or `EXACT` where that is lower."""
        return max(self.error, EXACT)


@dataclass(frozen=True, repr=False)
class Screened(Shown):
    """One model of the catalogue: every trial, the bare one first; the best is `best`. Those of ``with_constant`` asked which
    parameters of a finalist need not follow the input."""

    base: str
    trials: tuple[Trial, ...]
    with_constant: tuple[Trial, ...] = ()

    @property
    def bare(self) -> Trial:
        """Without add-ons."""
        return self.trials[0]

    @property
    def best(self) -> Trial:
        """With the add-ons that were worth it: of the trials within `WORTH` of the lowest error that with the fewest add-ons,
        and among those with the fewest parameters that follow the input."""
        lowest = min(trial.rank for trial in self.trials)
        near = [trial for trial in self.trials if (1.0 - WORTH) * trial.rank <= lowest]
        return min(near, key=lambda trial: (trial.model.count("+"), -len(trial.constant), trial.rank))


def choose_bandwidth(
    records: list[Record],
    options: FitOptions,
    executor: Executor | None = None,
    progress: Callable[[float], None] = lambda done: None,
) -> tuple[float | None, float]:
    """That of the derived velocity, or None for the velocity as recorded, whichever lets the probe predict better; and the
    work of finding out.

    Records without a velocity, sampled so differently that no bandwidth serves all of them, use their own bandwidths: None.
    """
    fastest = round(max(default_bandwidth(record) for record in records), 1)
    derived: float | None = fastest
    try:
        check_bandwidth(records, fastest)
    except InputError:
        derived = None
    if derived is None or any(record.velocity is None for record in records):
        return derived, 0.0
    jobs = [partial(trial, PROBE, screening_set(records, b), replace(options, seed=0)) for b in (None, derived)]
    recorded, smooth = parallel.run_all(jobs, executor, progress)
    return None if recorded.error < smooth.error else derived, recorded.work + smooth.work


def screen_all(
    bases: Sequence[str],
    small: list[Record],
    options: FitOptions,
    executor: Executor | None,
    progress: Callable[[float], None],
    limit: float = math.inf,
    deadline: float = math.inf,
    lead: float = math.inf,
) -> tuple[list[Screened], list[str]]:
    """Every model bare; those that are simple or near the best with each of ``options.add_ons``; then, round by round, those in
    contention with one more.

    Where a parameter may follow the input, an add-on is tried with one value of each of its own, and the one that is best is
    tried with a value at each input too. Every bare model is tried. Of the others none counts after those that together, in
    their order, have spent ``limit``, counted s; the models that would have been gone on with, or have trials that were not
    done, are returned too. No trial begins after ``deadline``, a value of ``time.time`` in s: those that it cuts have the
    reason `CUT`. ``lead`` is the lowest error of models that were tried before.
    """
    trials: dict[str, list[Trial]] = {base: [] for base in bases}
    ends, add_ons = {base: TrialModel(base) for base in bases}, options.add_ons
    going, rounds, tally = list(bases), len(add_ons) + 1, _Tally(limit, len(bases))
    follows = may_follow_input(options, small)

    def try_all(plan: dict[str, list[TrialModel]], report: Callable[[float], None]) -> None:
        # Each add-on with all models before the next one, so that a lack of work is the same for all.
        places = range(max(map(len, plan.values()), default=0))
        models = [model for n in places for planned in plan.values() for model in planned[n : n + 1]]
        tasks = [partial(model.try_on, small, options) for model in models]
        results = parallel.run_all(tasks, executor, report, tally.add, deadline) if tasks else []
        why = NOT_BEGUN if tally.used_up else CUT
        done = {
            model: result or Trial(model.model, math.inf, 0.0, why, constant=model.constant)
            for model, result in zip(models, results, strict=True)
        }
        for base, planned in plan.items():
            trials[base] += [done[model] for model in planned]

    for k in range(rounds):
        if not going or tally.used_up:
            break
        plan = {base: _extend(ends[base], add_ons, follows) if k else [ends[base]] for base in going}
        try_all(plan, lambda done, k=k: progress((k + 0.9 * done) / rounds))  # type: ignore[misc]
        if k == 0:
            chosen = _select_comparable(going, trials, lead)
        else:
            going = _follow_add_ons(going, trials, ends)
            if not tally.used_up:
                following = {base: _let_follow(ends[base], add_ons) for base in going}
                try_all(following, lambda done, k=k: progress((k + 0.9 + 0.1 * done) / rounds))  # type: ignore[misc]
                _follow_add_ons(going, trials, ends)
            chosen = _select_contenders(going, trials, ends, lead)
        progress((k + 1) / rounds)
        going = chosen if k + 1 < rounds else []
    progress(1.0)
    unfinished = [base for base in bases if any(done.reason in (NOT_BEGUN, CUT) for done in trials[base])]
    return [Screened(base, tuple(trials[base])) for base in bases], [
        *unfinished,
        *(ends[base].model for base in going if base not in unfinished),
    ]


@dataclass
class _Tally:
    """What trials have spent, in their order, of ``limit``, counted s; the first ``sure`` are tried whatever they take."""

    limit: float
    sure: int
    spent: float = 0.0

    def add(self, done: Trial) -> bool:
        """Count one; whether no later one counts."""
        self.spent, self.sure = self.spent + done.work, self.sure - 1
        return self.used_up

    @property
    def used_up(self) -> bool:
        """Whether the limit is reached and nothing is sure."""
        return self.sure <= 0 and self.spent > self.limit


def _extend(before: TrialModel, add_ons: Sequence[str], follows: bool) -> list[TrialModel]:
    """The model with one add-on more, whichever it does not hold yet; where parameters may follow the input (``follows``) those
    of the add-on are constant."""
    parts = compose(before.model).parts
    held = {p.name for p in parts} | {inner for p in parts for inner in p.holds}
    extended = []
    for name in add_ons:
        if name not in held:
            model = f"{before.model} + {name}"
            added = [shape for shape in list_shapes(model) if shape.startswith(f"{name}.")] if follows else []
            extended.append(TrialModel(model, (*before.constant, *added)))
    return extended


def _let_follow(end: TrialModel, add_ons: Sequence[str]) -> list[TrialModel]:
    """The model with the parameters of its last add-on following the input, where they were constant."""
    last = end.model.rpartition(" + ")[2]
    kept = tuple(name for name in end.constant if not name.startswith(f"{last}."))
    return [TrialModel(end.model, kept)] if last in add_ons and kept != end.constant else []


def _select_comparable(bases: Sequence[str], trials: dict[str, list[Trial]], lead: float) -> list[str]:
    """The models that get add-ons: the simple ones, and those that are near the best without any.

    What an add-on takes away in a model of many numbers it takes away in a better one too; a simple model may be far off
    without the one that it lacks.
    """
    lead = min(lead, *(trials[base][0].error for base in bases))
    simple = {base for base in bases if len(compose(base).parameters) - len(list_held(base)) <= SIMPLE}
    return [base for base in bases if base in simple or trials[base][0].error <= COMPARABLE * lead]


def _follow_add_ons(going: Sequence[str], trials: dict[str, list[Trial]], ends: dict[str, TrialModel]) -> list[str]:
    """The models that the last trials were worth it for; ``ends`` follows them."""
    remaining = []
    for base in going:
        before = min((t.error for t in trials[base] if t.trial_model == ends[base]), default=math.inf)
        best = min(trials[base], key=lambda trial: trial.rank)
        if best.trial_model != ends[base] and best.error < (1.0 - WORTH) * before:
            ends[base] = best.trial_model
            remaining.append(base)
    return remaining


def _select_contenders(
    going: Sequence[str], trials: dict[str, list[Trial]], ends: dict[str, TrialModel], lead: float
) -> list[str]:
    """The models that are not far behind the best."""
    lead = min(lead, *(trial.error for tried in trials.values() for trial in tried))
    return [
        base for base in going if min(t.error for t in trials[base] if t.trial_model == ends[base]) <= CONTENDING * lead
    ]


def simplify(found: Trial, small: list[Record], options: FitOptions) -> tuple[Trial, tuple[Trial, ...]]:
    """A finalist with one value of each parameter that need not follow the input, and the trials that found which: one after
    the other, the last first. One stays constant where the error on the screening set ``small`` does not rise by more than
    `ALIKE` over the lowest that this model had."""
    best, lowest, trials = found, found.rank, []
    for name in list_shapes(found.model):
        if name not in best.constant:
            done = TrialModel(found.model, (*best.constant, name)).try_on(small, options)
            trials.append(done)
            if done.rank <= (1.0 + ALIKE) * lowest:
                best, lowest = done, min(lowest, done.rank)
    return best, tuple(trials)


def trial(model: str, small: list[Record], options: FitOptions) -> Trial:
    """The validation error of one model on the screening set; what cannot be fitted says why."""
    begun = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DampyrWarning)  # of a model that may never be chosen
            validations = validate_model(model, small, replace(options, folds=2, steps=STEPS))
        reasons = [reason for validation in validations for reason in validation.failed.values()]
        folds = [fold for validation in validations for fold in validation.folds]
        reasons += [fold.reason for fold in folds if OUT_OF_WORK in fold.reason or OUT_OF_TIME in fold.reason]
        work = sum(fold.work for fold in folds)
        return Trial(model, validation_error(validations), time.perf_counter() - begun, "; ".join(reasons[:1]), work)
    except (InputError, np.linalg.LinAlgError) as problem:
        return Trial(model, float("inf"), time.perf_counter() - begun, str(problem))


def validate_model(model: str, records: list[Record], options: FitOptions) -> list[Validation]:
    """The validations of one model by `choose_splits` the records."""
    options = replace(options, fixed=list_held(model))
    return [cross_validate(records, model, split, options) for split in choose_splits(records)]


def choose_splits(records: Sequence[Record]) -> list[str]:
    """The splits that a model is ranked by: by record, and by input where there are three or more."""
    return ["record"] + ["input"] * (len({record.input_value for record in records}) > 2)


def validation_error(validations: Sequence[Validation]) -> float:
    """The splits' errors, weighted."""
    if len(validations) == 1:
        return validations[0].error
    by_record, by_input = validations
    return (1.0 - BETWEEN) * by_record.error + BETWEEN * by_input.error


def screening_set(records: Sequence[Record], bandwidth: float | None = None) -> list[Record]:
    """At most four records of each input, from the smallest to the largest peak speed, shortened and thinned.

    Each has a velocity: as recorded, or derived with ``bandwidth`` Hz (its own by default where it has none) before samples are
    left out, as the rest of a slow record would not carry the bandwidth of a fast one.
    """
    groups: dict[float, list[Record]] = {}
    for record in records:
        groups.setdefault(float(record.input_value or 0.0), []).append(record)
    chosen: list[Record] = []
    for _, at_input in sorted(groups.items()):
        ranked = sorted(at_input, key=_measure_speed)
        places = np.unique(np.round(np.linspace(0, len(ranked) - 1, PER_INPUT)).astype(int))
        for record in (ranked[k] for k in places):
            as_recorded = record.velocity is not None and bandwidth is None
            chosen.append(shortened(record if as_recorded else with_velocity(record, bandwidth)))
    return chosen


def _measure_speed(record: Record) -> float:
    return float(np.sqrt(np.mean(np.gradient(record.displacement, record.time) ** 2)))


def shortened(record: Record) -> Record:
    """The first five seconds or four cycles of the motion, whichever is longer, with no more samples than the motion needs.

    Samples are left out evenly, never averaged; the sampling rate stays four times the bandwidth of the motion.
    """
    start = motion_start(record)
    wanted = SHORTEST
    if cycle_bounds(record):
        wanted = max(SHORTEST, MIN_CYCLES / measure(record).frequency_hz)
    short = record.until(min(start + wanted, float(record.time[-1]))) if start + wanted > record.time[0] else record
    rate = SAMPLES_PER_BANDWIDTH * default_bandwidth(record)
    stride = max(1, min(short.n // MAX_SAMPLES, int(1.0 / (rate * record.dt))))
    return short.thinned(stride)
