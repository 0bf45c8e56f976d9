"""A fit of one model to records by least squares over their whole motion."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import lru_cache
from threading import Lock
from typing import Any

import numpy as np

from dampyr.argument_kinds import MODEL, RECORDS, Argument, check_kinds
from dampyr.errors import InputError
from dampyr.identification.fits.fit_options import FitOptions
from dampyr.identification.fits.result import Fit, build_fit
from dampyr.identification.search.fit_data import piece, unknown_input, weighted, with_common_levels
from dampyr.identification.search.initial_guess import begin, search_several_starts
from dampyr.identification.search.parametrisation import columns, held_twins
from dampyr.identification.search.problem import Problem, checked_nuisances
from dampyr.identification.search.robust import iteratively_reweighted
from dampyr.identification.search.variable_projection import Outcome, search
from dampyr.identification.search.work import Work
from dampyr.input_kinds import NO_INPUT
from dampyr.models import Damper, compose
from dampyr.models.codegen.composition import Composition
from dampyr.origin import check_one_kind
from dampyr.records import Record
from dampyr.records.conditioning.nominal_input import mixed_inputs
from dampyr.records.conditioning.velocity import check_bandwidth
from dampyr.records.files.campaign_folder import as_records
from dampyr.records.record import Role

STARTS_INSTEAD = 6  # where the model has no force at the only one


def fit_model(
    model: str | Composition | Damper,
    records: Record | Sequence[Record],
    options: FitOptions | None = None,
    progress: Callable[[int, float], None] | None = None,
) -> Fit:
    """A fit of one model to records: the search of `dampyr.identification.fit`, without a choice of models or predictions.

    ``progress`` is called with the number of the step and the cost. Raises :class:`~dampyr.errors.InputError` as `fit` does,
    and for records of the role "validation".
    """
    options = options or FitOptions()
    listed = [records] if isinstance(records, Record) else list(records)
    outcome, starts = search_model(model, listed, options, progress)
    with one_thread():
        return build_fit(outcome, tuple(listed), options, starts)


def search_model(
    model: str | Composition | Damper,
    records: Sequence[Record],
    options: FitOptions,
    progress: Callable[[int, float], None] | None = None,
) -> tuple[Outcome, tuple[int, int]]:
    """The end of the search of `fit_model`, and the starts: how many there were, and how many ended in the same optimum."""
    deadline = math.inf if options.seconds is None else time.perf_counter() + options.seconds
    work = Work(math.inf if options.budget is None else options.budget, deadline)
    if not options.mixed_origins:
        check_one_kind(records)
    problem = prepared(model, records, options)
    starts = _count_starts(problem) if options.starts is None else options.starts
    # A step to where the force is no number, such as beyond a gas column, has no cost and is not taken.
    with one_thread(), np.errstate(over="ignore", invalid="ignore"):
        point, agreed = (
            (begin(problem, work), 1) if starts == 1 else search_several_starts(problem, starts, options.seed, work)
        )
        outcome = search(problem, point, progress, max_iterations=options.steps, work=work)
        if starts == 1 and not np.isfinite(outcome.cost):  # there is no force along some record, such as a long one
            starts = STARTS_INSTEAD
            point, agreed = search_several_starts(problem, starts, options.seed, work)
            outcome = search(problem, point, progress, max_iterations=options.steps, work=work)
        if options.loss != "squares":
            outcome = iteratively_reweighted(outcome, options.loss, progress, work)
    return replace(outcome, work=work.spent), (starts, agreed)


def _count_starts(problem: Problem) -> int:
    """As many as a part needs; one where every coefficient is linear."""
    return problem.composition.search_starts if np.any(~problem.is_linear | problem.is_logarithmic) else 1


def read_and_check(call: str, records: Any, model: Any, role: Role | None = None) -> list[Record]:
    """The records, those of files read; InputError where ``call``, which takes records and a model, is given other things."""
    first = Argument("records", records, (Record,), RECORDS, several=True)
    second = Argument("model", model, (str, Composition, Damper), MODEL)
    if second.takes(records) and not second.takes(model):
        raise InputError(f"{call}: records come first since 0.4.0; write {call}(records, model)")
    read = as_records(records, role)
    check_kinds(call, replace(first, value=read), second)
    return read


def prepared(
    model: str | Composition | Damper, records: Sequence[Record], options: FitOptions | None = None
) -> Problem:
    """The problem that `fit_model` solves: the records as arrays and the layout of the unknowns, before the search."""
    options = options or FitOptions()
    composition = compose(model) if isinstance(model, str) else model
    if isinstance(composition, Damper):
        composition = composition.composition
    check_fittable(records)
    if options.bandwidth is not None:
        check_bandwidth(records, options.bandwidth)
    pieces = [piece(record, options.bandwidth) for record in records]
    pieces = weighted(with_common_levels(pieces), options.weighting)
    held = held_twins(composition, options.laws, options.fixed, options.tied) | dict(options.fixed)
    temperatures = [p.temperature for p in pieces]
    parameter_columns = columns(composition, [p.levels for p in pieces], options.laws, held, options.tied, temperatures)
    if not any(column.size for column in parameter_columns):
        raise InputError("every parameter is fixed; leave at least one free")
    return Problem(composition, parameter_columns, pieces, checked_nuisances(composition, pieces, options.nuisances))


@lru_cache(maxsize=1)
def _control_threads() -> Any:
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


_lock, _within = Lock(), ExitStack()
_count = 0


@contextmanager
def one_thread() -> Iterator[None]:
    """One thread for each linear algebra call: the factorisations are small, and sums come out the same on any number of cores.

    The limit is of the whole process, so where several threads of it fit the last one to end takes it off.
    """
    global _count
    with _lock:
        _count += 1
        if _count == 1:
            _within.enter_context(_control_threads().limit(limits=1, user_api="blas"))
    try:
        yield
    finally:
        with _lock:
            _count -= 1
            if _count == 0:
                _within.close()


def check_fittable(records: Sequence[Record]) -> None:
    """Refuse records that are not fitted together: none, validation records, inputs of several kinds, equal names."""
    if not records:
        raise InputError("there are no records to fit; give one or more")
    held = [r.name for r in records if r.role == "validation"]
    if held:
        raise InputError(f"{held[0]} is a validation record and is never fitted; leave it out, or score it")
    inputs = {r.input for r in records}
    if len(inputs) > 1:
        if None in inputs:
            raise InputError(unknown_input(next(r.name for r in records if r.input is None)))
        if NO_INPUT in inputs:
            raise InputError(f"{mixed_inputs(records)}; they are of two dampers, so fit them separately")
        text = " and ".join(sorted(str(i) for i in inputs))
        raise InputError(
            f"the records' inputs are in {text}; a damper has one input, so convert them, or fit them separately"
        )
    names = [r.name for r in records]
    if len(set(names)) < len(names):
        twice = next(n for n in names if names.count(n) > 1)
        raise InputError(f"two records are called {twice!r}; rename one, so that results can be told apart")
