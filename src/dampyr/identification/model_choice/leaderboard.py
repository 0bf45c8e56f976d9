r"""Leaderboard of models: every model of the catalogue, bare and with add-ons, ranked by what it predicts unseen.

First each model is *screened* on a few shortened records (`dampyr.identification.model_choice.screening`): bare, then with the
add-on that lowers its error most, then with the next, as long as that lowers it by 2 % and the model is within 15 % of the
best. A model of more than four numbers that is more than 30 % behind the best bare one gets no add-on. Parts that are tried by
name only join where a fit at one input calls for them (`dampyr.identification.model_choice.parts_by_name`). A parameter of an
add-on follows the input only where that lowers the error by 2 %, and of the best few those that shape the force have one value
at all inputs where that raises it by 0.5 % at most, unless ``laws`` say otherwise. Then the best few, within a quarter of the
best, are fitted and validated on all records. The validation error is

.. math:: E = \tfrac34 E_\text{record} + \tfrac14 E_\text{input}

the mean L1 ratio of records that were left out, and of whole inputs that were left out (where there are three or more;
else the first alone), every input counting the same: a damper is used between the inputs of its tests. Leaving an input out
doubles the gap that a law must bridge, which makes a smooth law's error four times as large, hence the quarter.

Of the models whose error is within one standard error of the lowest, the one with the fewest parameters is chosen (Breiman et
al. 1984): between them the records do not decide, and what has fewer numbers is easier to check. Nor do they between errors
below 0.01 %, which only computed records have. The standard error is that of the mean over the records, each input by itself.
Parts that are not for a building say so in their row; the best model without them is chosen in the same way and shown besides.

The lowest of several errors is too low by chance. How much it is here is told by choosing again on four of the five parts and
scoring that choice on the fifth: the ``optimism``. It repeats the choice among the finalists, not the screening; ``nested``
repeats all, at five times the time.

A search has a budget of work, which is counted (`dampyr.identification.search.work`) and not timed: the same records give the
same ranking and the same card on the same version, on a busy machine too, whatever the number of workers. A limit in seconds
can only end a search; what it cuts depends on the machine, so nothing is chosen then.
"""

from __future__ import annotations

import math
import time
import warnings
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from dampyr.argument_kinds import RECORDS, Argument, check_kinds
from dampyr.errors import DampyrWarning, InputError
from dampyr.identification.fits.fit_options import BUDGET, FitOptions
from dampyr.identification.fits.least_squares import check_fittable, fit_model
from dampyr.identification.fits.result import Fit
from dampyr.identification.model_choice import parallel
from dampyr.identification.model_choice.parameter_laws import PAIRS, list_held, may_follow_input, with_constant
from dampyr.identification.model_choice.parts_by_name import CalledPart, find_called_parts
from dampyr.identification.model_choice.screening import (
    BETWEEN,
    CUT,
    EXACT,
    Screened,
    Trial,
    choose_bandwidth,
    choose_splits,
    screen_all,
    screening_set,
    simplify,
    validation_error,
)
from dampyr.identification.model_choice.yardstick import (
    Yardstick,
    check_installed,
    describe_what_is_left,
    find_carriers,
    train_yardsticks,
)
from dampyr.identification.scoring.score import score
from dampyr.identification.scoring.scoring_window import list_unscorable, too_short
from dampyr.identification.scoring.splits import split_tasks
from dampyr.identification.scoring.validation import Fold, Validation, validation_jobs
from dampyr.identification.search.fit_data import unknown_input
from dampyr.identification.search.work import OUT_OF_WORK
from dampyr.input_kinds import NO_INPUT
from dampyr.models import available_parts, compose
from dampyr.models.part import part
from dampyr.origin import NOT_STATED, Origin, check_one_kind, combined
from dampyr.phrases import counted, listing
from dampyr.records import Record, cut, with_velocity
from dampyr.records.conditioning.velocity import check_bandwidth
from dampyr.records.files.campaign_folder import RecordsOrPaths, as_records
from dampyr.shown import Shown

FINAL_STEPS = 300  # of a finalist's fits: more than the default, as no start is chosen by hand
PARTS = 5  # of the records, left out in turn
SCREENING_SHARE = 0.85  # of the budget, after which no further add-on is tried
# Of the budget for one fit of the screening: beyond it a model is too slow to be preferred anyway.
TRIAL_SHARE = 1 / 120
FINAL_SHARE = 1 / 16  # the same for a fit to all records
FAR_BEHIND = 1.25  # times the lowest screening error: what is beyond it does not win on all records, and is often slow
LEAST_FINALISTS = 2  # a winner and a runner-up
LEAST_WORK = 5.0  # counted s that a fit to all records has however little is left


@dataclass(frozen=True, repr=False)
class Finalist(Shown):
    """A finalist. ``error`` is what the ranking goes by; ``l1``, ``nrmse``, ``pointwise`` and ``energy`` (its size) are means
    over records that were left out, ``unseen_input`` the mean L1 ratio over inputs that were left out (NaN where there are
    fewer than three). ``standard_error`` is that of ``error``; ``not_for_buildings`` says why the model must not stand in for a
    damper of a building, and is empty where it may. ``seconds`` is the time of the fit to all records. ``fit`` is None where it
    made no damper. The parameters that are ``constant`` have one value at all inputs where they might have followed them.
    """

    model: str
    error: float
    standard_error: float
    l1: float
    nrmse: float
    pointwise: float
    energy: float
    unseen_input: float
    parameters: int
    seconds: float
    converged: bool
    reason: str
    validations: tuple[Validation, ...] = field(repr=False)
    fit: Fit | None = field(repr=False)
    not_for_buildings: str = ""
    constant: tuple[str, ...] = ()

    @property
    def work(self) -> float:
        """What its fits have spent, counted s (`dampyr.identification.search.work`)."""
        folds = sum(fold.work for validation in self.validations for fold in validation.folds)
        return folds + (self.fit.outcome.work if self.fit is not None else 0.0)

    @property
    def relevelled(self) -> float:
        """The mean L1 ratio of records that were left out, with the level of each one's first cycles."""
        return next(
            (validation.relevelled for validation in self.validations if validation.split == "record"), float("nan")
        )


@dataclass(frozen=True, repr=False)
class Leaderboard(Shown):
    """The finalists by rising validation error, what was screened before, and what was chosen for all.

    ``optimism`` is by how much the lowest error is too low for having been chosen (a ratio, like the errors; NaN where it could
    not be estimated), ``nested`` the mean L1 ratio of the records that a whole search without them predicts, where that was
    asked for. ``left_out`` says what was not tried or stopped, and why. ``cut`` is empty, or says that a limit in seconds ended
    the search: then the entries are the finalists that were finished, and none is chosen. ``work`` is what the trials and the
    fits have spent, counted s (`dampyr.identification.search.work`). ``yardsticks`` are the black boxes that were trained on
    the same parts, where that was asked for, and ``what_is_left`` says in a sentence what they see that the winner does not.
    ``called`` are the parts that are usually tried by name only and were called for by the records.
    """

    entries: tuple[Finalist, ...]
    screened: tuple[Screened, ...]
    bandwidth: float | None
    left_out: tuple[str, ...]
    seconds: float
    optimism: float = float("nan")
    nested: float = float("nan")
    cut: str = ""
    work: float = float("nan")
    origin: Origin = NOT_STATED
    yardsticks: tuple[Yardstick, ...] = ()
    what_is_left: str = ""
    called: tuple[CalledPart, ...] = ()

    @property
    def best(self) -> Finalist:
        """The lowest validation error."""
        return self.entries[0]

    @property
    def winner(self) -> Finalist:
        """The one that is chosen: of those within one standard error of the lowest error, the simplest.

        Raises :class:`~dampyr.errors.InputError` where the search was cut.
        """
        if self.cut:
            raise SearchTimedOut(self)
        return simplest(self.entries)

    @property
    def runner_up(self) -> Finalist | None:
        """The lowest error but for the winner."""
        return next((entry for entry in self.entries if entry is not self.winner), None)

    @property
    def for_building(self) -> Finalist | None:
        """The winner where it may stand in for a damper of a building, else the best that may, chosen in the same way."""
        if not self.winner.not_for_buildings:
            return self.winner
        suited = [entry for entry in self.entries if not entry.not_for_buildings and np.isfinite(entry.error)]
        return simplest(suited) if suited else None


class SearchTimedOut(InputError):
    """A choice was asked of a search that a limit in seconds ended; ``board`` is what it had finished."""

    def __init__(self, board: Leaderboard) -> None:
        super().__init__(board.cut)
        self.board = board


def leaderboard(
    records: RecordsOrPaths,
    options: FitOptions | None = None,
    executor: Executor | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Leaderboard:
    """Rank models by what they predict of records that they were not fitted on: `dampyr.identification.fit` without a model.

    Parameters
    ----------
    records
        five or more, at one input or several; fewer are cut into five pieces or more, which ``left_out`` says: their errors are
        those of more of the same tests.
    options
        ``models`` are compositions to begin from, none of them every model of the catalogue that is no add-on, and the
        pairs of `PAIRS`; ``add_ons`` are tried in addition, greedily; ``finalists`` are validated on all records.
        ``bandwidth`` is chosen by a probe where it is not given: as recorded, or derived from the displacement with 15 times
        the highest test frequency (each record with its own where no bandwidth serves all). After 85 % of the ``budget``
        (`BUDGET` without one) no further add-on is tried, no fit of a trial takes more than a 120th of it, and no fit to all
        records more than a 16th; what was stopped says so, and where it is stopped does not depend on the machine. After
        ``seconds`` no further trial or fit begins: what is cut then depends on the machine, so `cut` says it, the entries are
        the finalists that were finished, and none is chosen. ``nested`` repeats all, screening and choice, five times without
        a fifth of the records, and scores what each choice predicts of it: an estimate without the optimism of choosing.
        ``yardstick`` trains black boxes on the same parts (`dampyr.identification.model_choice.yardstick`). The others are of
        every fit.
    executor
        runs the trials, such as ``ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn"))``; None runs them one
        after the other. The result is the same to the last digit. Forked processes are refused: in trials they crashed after
        compiled code had run in the process that they came from.
    progress
        called with what is being done and the fraction done, every few seconds where an executor runs the trials.

    Raises :class:`~dampyr.errors.InputError` for records that are too short to be cut into five, or to be scored, or where no
    model could be fitted.
    """
    parallel.refuse_forks(executor)
    records = as_records(records)
    check_kinds("leaderboard", Argument("records", records, (Record,), RECORDS, several=True))
    options = options or FitOptions()
    if options.yardstick:
        check_installed()
    listed = [r for r in records if r.role != "validation"]
    if not options.mixed_origins:
        check_one_kind(listed)
    unknown = [r.name for r in listed if r.input is None]
    if unknown:
        raise InputError(unknown_input(unknown[0]))
    whole = listed
    listed, pieces = enough_records(whole, options.settling)
    list_unscorable(listed, options.settling)
    begun = time.perf_counter()
    check_fittable(listed)
    deadline = math.inf if options.seconds is None else time.monotonic() + options.seconds
    budget = BUDGET if options.budget is None else options.budget
    report = progress or (lambda what, done: None)
    bandwidth = options.bandwidth
    if bandwidth is not None:
        check_bandwidth(listed, bandwidth)
    report("choosing the velocity", 0.0)
    of_fits = replace(options, bandwidth=None, seconds=None)
    in_trials = replace(of_fits, budget=TRIAL_SHARE * budget)
    spent = 0.0
    if bandwidth is None:
        bandwidth, spent = choose_bandwidth(
            listed, in_trials, executor, lambda done: report("choosing the velocity", done)
        )
    small = screening_set(listed, bandwidth)  # with its velocity, so that no trial derives it from thinned samples
    allowed, left_out = _select_add_ons(options.add_ons, listed)
    bases = [*options.models] or first_models()
    screened, unfinished = screen_all(
        bases,
        small,
        replace(in_trials, add_ons=allowed, starts=options.starts or 1),
        executor,
        lambda done: report("screening models", done),
        SCREENING_SHARE * budget - spent,
        deadline,
    )
    spent += sum(trial.work for model in screened for trial in model.trials)
    called: list[CalledPart] = []
    if not options.models and not unfinished:
        called, more, unfinished, work = _screen_called_parts(
            screened,
            small,
            replace(in_trials, add_ons=allowed),
            executor,
            report,
            SCREENING_SHARE * budget - spent,
            deadline,
        )
        screened, spent = [*screened, *more], spent + work
    cut = any(trial.reason == CUT for model in screened for trial in model.trials)
    chosen = [] if cut else _select_finalists(screened, options.finalists)
    if not chosen and not cut:
        raise InputError(f"no model could be fitted; the first failed: {screened[0].bare.reason}")
    if may_follow_input(options, listed):
        chosen, screened, work = _simplify_all(
            chosen,
            screened,
            partial(simplify, small=small, options=in_trials),
            executor,
            lambda done: report("looking for constant parameters", done),
            SCREENING_SHARE * budget - spent,
            deadline,
        )
        spent += work
    entries = _judge(
        chosen,
        listed,
        whole,
        replace(of_fits, bandwidth=bandwidth),
        executor,
        budget - spent,
        budget,
        lambda done: report("validating the best", done),
        deadline,
    )
    ranked = sorted(entries, key=lambda entry: (entry.error, entry.model))
    notes = [*pieces, *left_out, *([] if cut else _describe_stops(screened, unfinished, ranked))]
    missing = [trial.model for trial in chosen if trial.model not in {entry.model for entry in entries}]
    spent += sum(entry.work for entry in entries)
    board = Leaderboard(
        tuple(ranked),
        tuple(screened),
        bandwidth,
        tuple(notes),
        time.perf_counter() - begun,
        optimism(ranked),
        cut=_describe_cut(screened, missing, options.seconds) if cut or missing else "",
        work=spent,
        origin=combined(r.origin for r in whole),
        called=tuple(called),
    )
    if options.yardstick and not board.cut:
        board = _measure_by_yardstick(board, listed, options, lambda done: report("training black boxes", done))
    if not options.nested or board.cut:
        return board
    error = _estimate_nested_error(listed, replace(options, nested=False, yardstick=False), executor, report, deadline)
    return replace(board, nested=error, seconds=time.perf_counter() - begun)


def _screen_called_parts(
    screened: Sequence[Screened],
    small: list[Record],
    options: FitOptions,
    executor: Executor | None,
    report: Callable[[str, float], None],
    limit: float,
    deadline: float,
) -> tuple[list[CalledPart], list[Screened], list[str], float]:
    """The parts without a trial that the records call for, their trials, which of them are unfinished, and all their work."""
    best = min((model.best for model in screened), key=lambda trial: trial.rank)
    if best.error <= EXACT or not np.isfinite(best.error):
        return [], [], [], 0.0
    names = [name for name in available_parts() if part(name).not_tried]
    called, work = find_called_parts(
        names, best.model, small, options, executor, lambda done: report("trying other parts", done), deadline
    )
    if not called:
        return [], [], [], work
    more, unfinished = screen_all(
        [found.name for found in called],
        small,
        options,
        executor,
        lambda done: report("screening other parts", done),
        limit - work,
        deadline,
        best.error,
    )
    return called, more, unfinished, work + sum(trial.work for model in more for trial in model.trials)


def _simplify_all(
    finalists: Sequence[Trial],
    screened: Sequence[Screened],
    simplify_one: Callable[[Trial], tuple[Trial, tuple[Trial, ...]]],
    executor: Executor | None,
    progress: Callable[[float], None],
    limit: float,
    deadline: float,
) -> tuple[list[Trial], list[Screened], float]:
    """The finalists with the parameters constant that may be, the screened models with the trials of it, and their work.

    Finalists stay as they are from the one on that ``limit``, counted s, or ``deadline`` leaves no time for.
    """
    spent = 0.0

    def used_up(done: tuple[Trial, tuple[Trial, ...]]) -> bool:
        nonlocal spent
        spent += sum(trial.work for trial in done[1])
        return spent > limit

    jobs = [partial(simplify_one, finalist) for finalist in finalists] * (limit > 0.0)
    found = [done for done in parallel.run_all(jobs, executor, progress, used_up, deadline) if done] if jobs else []
    simpler = {best.model: best for best, _ in found}
    tried = {best.model: trials for best, trials in found}
    return (
        [simpler.get(finalist.model, finalist) for finalist in finalists],
        [replace(model, with_constant=tried.get(model.best.model, ())) for model in screened],
        spent,
    )


def _measure_by_yardstick(
    board: Leaderboard, records: Sequence[Record], options: FitOptions, progress: Callable[[float], None]
) -> Leaderboard:
    """The board with the black boxes on the parts that it was ranked by, with the velocity that it used."""
    derived = [
        r if r.velocity is not None and board.bandwidth is None else with_velocity(r, board.bandwidth) for r in records
    ]
    yardsticks = train_yardsticks(derived, PARTS, options.seed, options.settling, progress)
    winner = board.winner
    carried = {} if winner.fit is None else find_carriers(winner.fit, options.seed)
    return replace(board, yardsticks=yardsticks, what_is_left=describe_what_is_left(winner.l1, yardsticks, carried))


def enough_records(records: list[Record], settling: float) -> tuple[list[Record], tuple[str, ...]]:
    """Five records or more: as they are, or cut into pieces of equal time, with a sentence that says so."""
    if len(records) >= PARTS:
        return records, ()
    if not records:
        raise InputError("there are no records to fit; give one or more")
    count = -(-PARTS // len(records))
    pieces = [piece for record in records for piece in cut(record, record.duration / count)]
    short = next((piece for piece in pieces if too_short(piece, settling)), None)
    if short is not None:
        raise InputError(
            f"a choice of models leaves five parts out in turn; {counted(len(records), 'record')} would be cut "
            f"into pieces, but {short.name} lasts {short.duration:.3g} s and settling takes {settling:g} s of it: give more or "
            "longer records, a shorter settling, or name a model"
        )
    return pieces, (
        f"{counted(len(records), 'record')} {'were' if len(records) > 1 else 'was'} cut into {len(pieces)} pieces, so that "
        "parts can be left out: the errors are of more of the same tests, not of other ones",
    )


def first_models() -> list[str]:
    """The models that a leaderboard begins with without being told to."""
    return [*(name for name in available_parts() if _is_tried(name)), *PAIRS]


def _is_tried(name: str) -> bool:
    """Whether a part is a model that a leaderboard tries without being told to."""
    return not part(name).add_on and not part(name).not_tried


def _select_add_ons(add_ons: Sequence[str], records: Sequence[Record]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The add-ons that these records can identify, and why others are left out."""
    varies = any(isinstance(r.input_channel, np.ndarray) for r in records)
    if "lag" in add_ons and not varies:
        remaining = tuple(a for a in add_ons if a != "lag")
        if any(r.input == NO_INPUT for r in records):
            return remaining, ("lag was not tried: there is no input, so nothing lags",)
        return remaining, ("lag was not tried: the input is constant in every record, so nothing lags",)
    return tuple(add_ons), ()


def _select_finalists(screened: Sequence[Screened], count: int) -> list[Trial]:
    """The best models of the screening, two or more; one more where none of them may stand in for a damper of a building."""
    tried = [s.best for s in screened if np.isfinite(s.best.error)]
    ranked = sorted(tried, key=lambda trial: (trial.rank, len(compose(trial.model).parameters)))
    near = sum(trial.rank <= FAR_BEHIND * ranked[0].rank for trial in ranked)
    best = ranked[: min(count, max(near, LEAST_FINALISTS))]
    suited = [trial for trial in ranked if not compose(trial.model).not_for_buildings]
    return best + suited[:1] * (not any(trial in suited for trial in best))


def _judge(
    finalists: Sequence[Trial],
    records: list[Record],
    whole: list[Record],
    options: FitOptions,
    executor: Executor | None,
    remaining: float,
    budget: float,
    report: Callable[[float], None],
    deadline: float,
) -> list[Finalist]:
    """Every finalist on all records, each fold and each fit to all records a job of its own, so that no core waits.

    The fits are to the ``whole`` records, of which ``records`` may be pieces. ``remaining`` is counted work, s, of which the
    fits have equal shares, twice over as most end before. Finalists that ``deadline`` cuts, of ``time.time``, are left out.
    """
    splits = choose_splits(records)
    options = replace(options, folds=PARTS, steps=FINAL_STEPS)
    count = len(finalists) * (1 + sum(len(split_tasks(records, split, PARTS, options.seed)) for split in splits))
    share = 2.0 * max(remaining, 0.0) / max(count, 1)
    options = replace(options, budget=max(LEAST_WORK, min(FINAL_SHARE * budget, share)))
    jobs: list[tuple[str, Callable[[], Any]]] = []
    planned = []
    for finalist in finalists:
        model = finalist.model
        held = replace(options, fixed=list_held(model) | dict(options.fixed))
        of_model = with_constant(held, finalist.constant)
        parts = [validation_jobs(records, model, split, of_model) for split in splits]
        jobs += [(model, job) for folds, _ in parts for job in folds]
        jobs.append((model, partial(_fit_timed, model, whole, of_model)))
        planned.append((finalist, parts))
    # The slowest first, so that no core waits for another at the end.
    order = sorted(range(len(jobs)), key=lambda k: -len(compose(jobs[k][0]).parameters))
    done = parallel.run_all([partial(_run_quietly, jobs[k][1]) for k in order], executor, report, deadline=deadline)
    results = iter([result for _, result in sorted(zip(order, done, strict=True), key=lambda pair: pair[0])])
    entries = []
    for finalist, parts in planned:
        folds, fitted = [[next(results) for _ in folds] for folds, _ in parts], next(results)
        if fitted is not None and all(fold is not None for of_split in folds for fold in of_split):
            validations = [assemble(of_split) for of_split, (_, assemble) in zip(folds, parts, strict=True)]
            entries.append(_make_entry(finalist, validations, *fitted))
    return entries


def _run_quietly(job: Callable[[], Any]) -> Any:
    """The job without its warnings: they are of fits that may never be shown."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        return job()


def _fit_timed(model: str, records: list[Record], options: FitOptions) -> tuple[Fit, float]:
    begun = time.perf_counter()
    return fit_model(model, records, options), time.perf_counter() - begun


def _make_entry(finalist: Trial, validations: list[Validation], fit_result: Fit, seconds: float) -> Finalist:
    scores = list(validations[0].scores.values())

    def mean(key: str) -> float:
        values = np.array([abs(getattr(of_record, key)) for of_record in scores])
        return float(np.nanmean(values)) if np.any(np.isfinite(values)) else float("nan")

    return Finalist(
        model=finalist.model,
        error=validation_error(validations) if fit_result.bare is not None else float("inf"),
        standard_error=standard_error(validations),
        l1=validations[0].error,
        nrmse=mean("nrmse"),
        pointwise=mean("pointwise"),
        energy=mean("energy"),
        unseen_input=validations[1].error if len(validations) > 1 else float("nan"),
        parameters=len(fit_result.parameters),
        seconds=seconds,
        converged=fit_result.converged,
        reason=fit_result.reason,
        validations=tuple(validations),
        fit=fit_result,
        not_for_buildings=compose(finalist.model).not_for_buildings,
        constant=finalist.constant,
    )


def standard_error(validations: Sequence[Validation]) -> float:
    """Of `validation_error`: from the spread of its contributions among the records of each input, and where an input has one
    record only, among all."""
    weights = (1.0,) if len(validations) == 1 else (1.0 - BETWEEN, BETWEEN)
    inputs = validations[0].inputs
    parts = dict.fromkeys(validations[0].scores, 0.0)
    for weight, validation in zip(weights, validations, strict=True):
        counts = Counter(inputs.get(name, 0.0) for name in validation.scores)
        for name, of_record in validation.scores.items():
            u = inputs.get(name, 0.0)
            parts[name] = parts.get(name, 0.0) + weight * of_record.l1 / (len(counts) * counts[u])
    groups: dict[float, list[float]] = {}
    for name, value in parts.items():
        groups.setdefault(inputs.get(name, 0.0), []).append(value)
    # contributions of n records at an input add up: n times the variance of one; the differences between inputs are no scatter
    within_inputs = [len(values) * float(np.var(values, ddof=1)) for values in groups.values() if len(values) > 1]
    if len(within_inputs) == len(groups) and within_inputs:
        return math.sqrt(sum(within_inputs))
    values = list(parts.values())
    return math.sqrt(len(values) * float(np.var(values, ddof=1))) if len(values) > 1 else float("nan")


def simplest(entries: Sequence[Finalist]) -> Finalist:
    """Of the entries, by rising error, that within one standard error of the first, or below `EXACT`, which has the fewest
    parameters; among those with equally many one that is for buildings, then the lowest error."""
    first = entries[0]
    limit = max(first.error + (first.standard_error if np.isfinite(first.standard_error) else 0.0), EXACT)
    near = [entry for entry in entries if entry.error <= limit] or [first]
    return min(near, key=lambda entry: (entry.parameters, bool(entry.not_for_buildings), entry.error))


def optimism(entries: Sequence[Finalist]) -> float:
    """By how much the lowest error is too low: the choice by four parts of the records scored on the fifth, less that by all
    scored on all; NaN for a single finalist or parts without scores."""
    ranked = [entry for entry in entries if np.isfinite(entry.error)]
    table = np.array([[_average_l1(fold) for fold in entry.validations[0].folds] for entry in ranked])
    if len(ranked) < 2 or not np.all(np.isfinite(table)):
        return float("nan")
    counts = np.array([len(fold.scores) for fold in ranked[0].validations[0].folds])
    sums = table * counts
    # chosen by what the model predicts of all other parts, judged by this one
    apart = [int(np.argmin(sums.sum(axis=1) - sums[:, k])) for k in range(len(counts))]
    honest = sum(sums[m, k] for k, m in enumerate(apart)) / counts.sum()
    return float(honest - np.min(sums.sum(axis=1)) / counts.sum())


def _average_l1(fold: Fold) -> float:
    return float(np.mean([of_record.l1 for of_record in fold.scores.values()])) if fold.scores else float("nan")


def _describe_cut(screened: Sequence[Screened], missing: Sequence[str], seconds: float | None) -> str:
    """What a limit in seconds has cut, and how to go on."""
    trials = [trial for model in screened for trial in model.trials]
    done = sum(trial.reason != CUT for trial in trials)
    what = f"{counted(len(missing), 'finalist')} not validated" if missing else f"{done} of {len(trials)} trials done"
    return (
        f"the search was cut after {seconds:g} s, {what}, and what it finished until then depends on the machine, so no model "
        "is chosen: search without a limit in seconds, give more of them, or name the model that you want"
    )


def _describe_stops(screened: Sequence[Screened], unfinished: Sequence[str], entries: Sequence[Finalist]) -> list[str]:
    """What the work did not suffice for."""
    notes = []
    trials = [trial.model for model in screened for trial in model.trials if OUT_OF_WORK in trial.reason]
    if trials:
        notes.append(
            f"the trial fits of {listing(trials, 3)} were stopped by the budget of work: their errors may be lower"
        )
    if unfinished:
        notes.append(f"no work was left to try more add-ons with {listing(unfinished, 3)}; give a larger budget")
    slow = [
        entry.model
        for entry in entries
        if OUT_OF_WORK in entry.reason
        or any(OUT_OF_WORK in fold.reason for validation in entry.validations for fold in validation.folds)
    ]
    if slow:
        notes.append(
            f"fits of {listing(slow, 3)} to all records were stopped by the budget of work: their errors may be lower"
        )
    return notes


def _estimate_nested_error(
    records: list[Record],
    options: FitOptions,
    executor: Executor | None,
    report: Callable[[str, float], None],
    deadline: float,
) -> float:
    """The mean L1 ratio of records that a whole search did not see, by the model that it chose; NaN after ``deadline``."""
    tasks = split_tasks(records, "record", PARTS, options.seed)
    values = []
    for k, task in enumerate(tasks):
        report("choosing again without a fifth of the records", k / len(tasks))
        left = None if deadline == math.inf else deadline - time.monotonic()
        if left is not None and left <= 0:
            return float("nan")
        board = leaderboard(task.fitted, replace(options, seconds=left), executor)
        if board.cut:
            return float("nan")
        damper = board.winner.fit.bare if board.winner.fit else None
        if damper is None:
            return float("nan")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DampyrWarning)
            values += [
                score(damper, target.record, options.settling, allow_extrapolation=True).l1
                for target in task.predicted
                if not too_short(target.record, options.settling)
            ]
    report("choosing again without a fifth of the records", 1.0)
    return float(np.mean(values))
