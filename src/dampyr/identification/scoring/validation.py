"""Cross-validation: how well a model predicts records that it was not fitted on.

The records are split into folds; each fold is predicted by a damper that was fitted on the others. From a scored record only
the offset is taken, and every score says what the damper was fitted on.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np

from dampyr.errors import DampyrWarning, InputError
from dampyr.identification.fits.fit_options import FitOptions
from dampyr.identification.fits.least_squares import one_thread, read_and_check, search_model
from dampyr.identification.fits.result import make_damper
from dampyr.identification.scoring.score import Score, score
from dampyr.identification.scoring.scoring_window import list_unscorable
from dampyr.identification.scoring.splits import FoldTask, Target, split_tasks
from dampyr.input_kinds import NO_INPUT, unit_of
from dampyr.models import Damper
from dampyr.models.codegen.composition import Composition
from dampyr.origin import NOT_STATED, Origin, check_one_kind, combined
from dampyr.records import Record
from dampyr.records.checks.quality import motion_start
from dampyr.records.conditioning.velocity import check_bandwidth
from dampyr.records.files.campaign_folder import RecordsOrPaths
from dampyr.shown import Shown


@dataclass(frozen=True, repr=False)
class Fold(Shown):
    """One part of the split: what was fitted, what was predicted, and how well (nothing where the fit gave no damper).

    ``outside`` says which predicted records go beyond what the fitted ones covered, and by how much; ``skipped`` are those
    that are too short to be scored. ``work`` is what the fit has spent, counted s (`dampyr.identification.search.work`).
    """

    fitted_on: tuple[str, ...]
    scores: dict[str, Score]
    converged: bool
    reason: str
    outside: dict[str, str]
    skipped: tuple[str, ...] = ()
    work: float = 0.0


@dataclass(frozen=True, repr=False)
class Validation(Shown):
    """All folds of one split; ``inputs`` are those of the predicted records, by name, in ``unit``, V or A, none where they have
    none. ``not_scored`` are the records that are too short for it, and why."""

    split: str
    folds: tuple[Fold, ...]
    inputs: dict[str, float] = field(default_factory=dict)
    unit: str = ""
    not_scored: dict[str, str] = field(default_factory=dict)
    origin: Origin = NOT_STATED

    @property
    def scores(self) -> dict[str, Score]:
        """Every predicted record's score."""
        return {name: of_record for fold in self.folds for name, of_record in fold.scores.items()}

    @property
    def failed(self) -> dict[str, str]:
        """The folds that gave no damper: the first record that was to be predicted -> the reason."""
        return {fold.fitted_on[0]: fold.reason for fold in self.folds if not (fold.scores or fold.skipped)}

    @cached_property
    def by_input(self) -> dict[float, float]:
        """The mean L1 ratio of the predicted records of each input, by rising input."""
        groups: dict[float, list[float]] = {}
        for name, of_record in self.scores.items():
            groups.setdefault(self.inputs.get(name, 0.0), []).append(of_record.l1)
        return {u: float(np.mean(groups[u])) for u in sorted(groups)}

    @property
    def relevelled(self) -> float:
        """The mean L1 ratio with the level of each record's first cycles, every input counting the same; NaN without any."""
        groups: dict[float, list[float]] = {}
        for name, of_record in self.scores.items():
            if np.isfinite(of_record.relevelled_l1):
                groups.setdefault(self.inputs.get(name, 0.0), []).append(of_record.relevelled_l1)
        return float(np.mean([np.mean(ratios) for ratios in groups.values()])) if groups else float("nan")

    @property
    def error(self) -> float:
        """The mean of `by_input`: every input counts the same. Infinite where a fold gave no damper."""
        return float("inf") if self.failed or not self.by_input else float(np.mean(list(self.by_input.values())))


def mean_relevelled(scores: Mapping[str, Score]) -> float:
    """The mean L1 ratio with the level of each record's first cycles; NaN where no record has one."""
    values = [of_record.relevelled_l1 for of_record in scores.values() if np.isfinite(of_record.relevelled_l1)]
    return float(np.mean(values)) if values else float("nan")


def cross_validate(
    records: RecordsOrPaths,
    model: str | Composition | Damper,
    split: str = "record",
    options: FitOptions | None = None,
    progress: Callable[[float], None] | None = None,
) -> Validation:
    """Predict every record by a damper that was not fitted to it: ``predict`` of `dampyr.identification.fit`.

    Parameters
    ----------
    records
        that are fitted and predicted in turn.
    model
        as of `dampyr.identification.fit`.
    split
        ``"record"``: ``options.folds`` random parts by ``options.seed``; ``"input"``: one voltage (or current) left out at a
        time, the lowest and the highest excepted, which would be extrapolated; ``"frequency"`` or ``"amplitude"``: as many
        parts in the order of the measured frequency or stroke, so that the outer ones are predicted beyond what was fitted;
        ``"waveform"``: one kind of motion (`dampyr.records.cycle_analysis.waveform.waveform`) left out at a time;
        ``"time"``: the first 60 % of every motion fitted, the rest predicted.
    options
        of each fit.
    progress
        called with the fraction that is done.

    Returns
    -------
    Validation
        records of which the settling leaves less than a quarter are fitted and not scored; it says which.

    Raises
    ------
    InputError
        an unknown split, fewer records than folds, fewer than three inputs, a single kind of motion, or no record that is
        long enough to be scored.
    """
    jobs, assemble = validation_jobs(records, model, split, options)
    done = []
    for k, job in enumerate(jobs):
        if progress:
            progress(k / len(jobs))
        done.append(job())
    if progress:
        progress(1.0)
    return assemble(done)


def validation_jobs(
    records: RecordsOrPaths,
    model: str | Composition | Damper,
    split: str = "record",
    options: FitOptions | None = None,
) -> tuple[list[Callable[[], Fold]], Callable[[Sequence[Fold]], Validation]]:
    """`cross_validate` as independent jobs, one a fold, and what makes their results a `Validation`."""
    records = read_and_check("cross_validate", records, model, "fit")
    options, listed = options or FitOptions(), list(records)
    if not options.mixed_origins:
        check_one_kind(listed)
    not_scored = list_unscorable(listed, options.settling)
    tasks = split_tasks(listed, split, options.folds, options.seed)
    if options.bandwidth is not None:
        check_bandwidth(listed, options.bandwidth)
    unit, origin = unit_of(listed[0].input), combined(r.origin for r in listed)
    inputs = {} if listed[0].input == NO_INPUT else {r.name: float(r.input_value or 0.0) for r in listed}
    jobs: list[Callable[[], Fold]] = [
        partial(_run_fold_on_one_thread, model, task, not_scored, options) for task in tasks
    ]
    return jobs, lambda done: Validation(split, tuple(done), inputs, unit, not_scored, origin)


def _run_fold_on_one_thread(*arguments: Any) -> Fold:
    with one_thread():  # the scores too
        return _run_fold(*arguments)


def _run_fold(
    model: str | Composition | Damper, task: FoldTask, not_scored: Mapping[str, str], options: FitOptions
) -> Fold:
    outcome, _ = search_model(model, task.fitted, options)
    damper, trouble = make_damper(outcome, tuple(task.fitted), options)
    converged, reason = outcome.converged and not trouble, trouble or outcome.reason
    names = tuple(_name_fitted(r, task) for r in task.fitted)
    skipped = tuple(t.record.name for t in task.predicted if t.record.name in not_scored)
    scores: dict[str, Score] = {}
    outside: dict[str, str] = {}
    work = outcome.work
    if damper is None:
        return Fold(names, scores, converged, reason, outside, work=work)
    for target in task.predicted:
        if target.record.name in not_scored:
            continue
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", DampyrWarning)
            try:
                scores[target.record.name] = _predict(damper, target, options.settling)
            except InputError as problem:  # a law that leaves its allowed values beyond the fitted inputs
                return Fold(names, {}, False, str(problem), outside, work=work)
        if caught:
            outside[target.record.name] = "; ".join(str(w.message) for w in caught)
    return Fold(names, scores, converged, reason, outside, skipped, work)


def _name_fitted(record: Record, task: FoldTask) -> str:
    """What was fitted, in words: a name, and until when where the rest of the record is predicted."""
    again = any(t.record.name == record.name for t in task.predicted)
    return f"{record.name} until {record.time[-1]:.4g} s" if again else record.name


def _predict(damper: Damper, target: Target, settling: float) -> Score:
    low, high = damper.range
    record, u = target.record, target.record.input_value
    window = None
    if target.first is not None:
        window = (max(target.first, motion_start(record) + settling), float(record.time[-1]))
    beyond = u is not None and not low <= u <= high
    return score(damper, record, settling, window, allow_extrapolation=beyond)
