"""Identification in one call, from records to a damper: `fit`."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import lru_cache
from threading import Lock
from typing import Any

from dampyr.argument_kinds import MODEL, RECORDS, Argument, check_kinds
from dampyr.errors import InputError
from dampyr.identification.fits.result import Fit, Nuisance, build_fit
from dampyr.identification.parameter_uncertainty.levels import PRIOR_SESSION
from dampyr.identification.scoring.scoring_window import SETTLING, check_settling
from dampyr.identification.search.fit_data import piece, weighted, with_common_levels
from dampyr.identification.search.initial_guess import begin, best_of
from dampyr.identification.search.parametrisation import columns, held_twins
from dampyr.identification.search.problem import Problem, checked_nuisances
from dampyr.identification.search.robust import check_loss, iteratively_reweighted
from dampyr.identification.search.variable_projection import MAX_ITERATIONS, search
from dampyr.identification.search.work import Work
from dampyr.models import Composition, Damper, compose
from dampyr.models.prediction_error import check_prior
from dampyr.origin import check_one_kind
from dampyr.records import Record
from dampyr.records.conditioning.velocity import check_bandwidth

__all__ = ["Fit", "Nuisance", "fit", "prepared"]


def fit(
    model: str | Composition | Damper,
    records: Record | Sequence[Record],
    laws: str | Mapping[str, str] | None = None,
    fixed: Mapping[str, float] | None = None,
    bandwidth: float | None = None,
    progress: Callable[[int, float], None] | None = None,
    loss: str = "squares",
    nuisances: Sequence[str] = ("offset", "state"),
    tied: Mapping[str, str] | None = None,
    starts: int = 1,
    seed: int = 0,
    steps: int = MAX_ITERATIONS,
    weighting: str = "records",
    settling: float = SETTLING,
    seconds: float | None = None,
    budget: float | None = None,
    session_prior: float = PRIOR_SESSION,
    mixed_origins: bool = False,
) -> Fit:
    """Identify a damper from records by least squares over their whole motion.

    Parameters
    ----------
    model
        parts of the catalogue, such as ``"dahl"`` or ``"dahl + spring + delay"``, or a damper of the same make.
    records
        one record, or several for a joint fit. Each has an offset of its force and initial states of its own; its
        residual counts over the standard deviation of its force. Records of the role "validation" are refused.
    laws
        how parameters follow the input: a kind for all, or kinds by name with ``"*"`` for the rest, such as
        ``{"*": "polynomial:1", "dahl.rho": "constant"}``; see `dampyr.identification.search.parametrisation.columns`. By
        default the values at the inputs that occur, interpolated monotonically between them. Where a record's input varies and
        has noise, the laws' ends and inner points are those of the command
        (`dampyr.records.conditioning.nominal_input.commanded_input`): noise beyond its ends counts as the end, and ``notes``
        say so. ``"interpolation+temperature"`` and the like also follow the mean temperature of the records, where these have
        one and differ in it by 2 °C or more.
    fixed
        flat parameter name -> value in SI units, held. Of parameters of which only the sum is seen, such as the dashpots of
        ``"dahl + hyperbolic_tangent"``, all but the first are held at 0 unless ``laws``, ``fixed`` or ``tied`` name them, and
        ``notes`` say so.
    bandwidth
        of the velocity in Hz, derived from the displacement; None takes the recorded velocity where there is one.
    progress
        called with the number of the step and the cost.
    loss
        ``"squares"``; ``"huber"``, squares up to 1.345 times a record's scale and linear beyond; or ``"l1"``, the sum of the
        L1 ratios that dampyr scores by, smoothed below a tenth of the scale. The scale is 1.4826 times the median absolute
        residual of each record. Errors come from the same clusters (see `dampyr.identification.search.robust`).
    nuisances
        the random effects of each record: ``"offset"`` of its force in N; ``"state"``, the hysteretic states at the start
        (without it: no memory); ``"gain"``, a factor on the whole modelled force; ``"temperature"``, a factor on every
        parameter in N s/m. The last two are F = offset + g F_model(q c, ...) with ln g and ln q drawn towards 0 by a
        normal prior of standard deviation 0.05 and 0.2, weighed against residuals of 5 % of the force's spread, and need
        two or more records at each input. They describe the records, not the damper: of a record that is predicted only
        the offset is ever taken.
    tied
        parameter -> the other parameter of the same unit whose law it takes, such as ``{"spring.k0": "bouc_wen.k0"}``.
    starts, seed
        the number of starts of the search: the best proposals of the parts, then random ones by ``seed`` around them, each on
        thinned records and to 1e-4 of the cost; the best is finished. ``Fit.starts`` says how many agreed.
    steps
        how many the search may take; where they were not enough, ``converged`` is False.
    weighting
        ``"records"``: every record counts the same, however long it is; ``"samples"``: every sample does, so that a record of
        95 s counts 43 times one of 2.2 s.
    settling
        s from the start of the motion that ``scores`` of the result leave out; it changes no fitted number.
    seconds
        after which the search takes no further step: ``converged`` is then False, and the numbers are those that it reached,
        which depend on the speed of the machine. None: as long as it takes.
    budget
        the same by counted work (`dampyr.identification.search.work`), s of one core: model evaluations times samples times a
        fixed cost of each part, so that the numbers are the same on every machine. None: as much as it takes.
    session_prior
        the standard deviation of the logarithm of the level from one measurement session to another, 0.08 being 8 %:
        assumed for predictions where no input was measured in two sessions, else the prior of what is estimated
        (`dampyr.identification.parameter_uncertainty.levels`). It changes no fitted number and no interval.
    mixed_origins
        fit simulated or virtual records (`dampyr.origin`) together with others, which is refused otherwise.

    Returns
    -------
    Fit
        also where the search did not converge: ``converged`` and ``reason`` say so.

    Raises
    ------
    InputError
        a record without input, without motion, with a constant force, or of mixed inputs; simulated records among others; an
        unknown name or law; a bandwidth that a record's samples do not carry.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> damper = dp.studies.raminelli_2020.damper()
    >>> t = np.linspace(0.0, 4.0, 801)
    >>> x = 0.008 * np.sin(2 * np.pi * t)
    >>> record = dp.records.Record(t, x, damper.force(t, x, voltage=1.98), voltage=1.98)
    >>> fit = dp.identification.fit("dahl", record)
    >>> fit.converged, {name: float(f"{value:.4g}") for name, value in fit.parameters.items()}
    (True, {'dahl.kx': 2576.0, 'dahl.kw': 380.6, 'dahl.rho': 13530.0})
    """
    check_model_and_records("fit", model, records)
    listed = [records] if isinstance(records, Record) else list(records)
    check_loss(loss)
    if starts < 1:
        raise InputError(f"starts = {starts} is not allowed; give 1 or more")
    check_settling(settling)
    check_prior(session_prior)
    if seconds is not None and not seconds > 0:
        raise InputError(f"seconds = {seconds:g} is not allowed; give a time above 0, or None")
    if budget is not None and not budget > 0:
        raise InputError(f"budget = {budget:g} s is not allowed; give work above 0, or None")
    deadline = math.inf if seconds is None else time.perf_counter() + seconds
    work = Work(math.inf if budget is None else budget, deadline)
    if steps < 1:
        raise InputError(f"steps = {steps} is not allowed; give 1 or more")
    if not mixed_origins:
        check_one_kind(listed)
    problem = prepared(model, listed, laws, fixed, bandwidth, nuisances, tied, weighting)
    with one_thread():
        point, agreed = (begin(problem, work), 1) if starts == 1 else best_of(problem, starts, seed, work)
        outcome = search(problem, point, progress, max_iterations=steps, work=work)
        if loss != "squares":
            outcome = iteratively_reweighted(outcome, loss, progress, work)
        outcome = replace(outcome, work=work.spent)
        search_notes = (f"{agreed} of {starts} starts ended in the same optimum",) if starts > 1 else ()
        return build_fit(outcome, tuple(listed), bandwidth, search_notes, (starts, agreed), settling, session_prior)


def check_model_and_records(call: str, model: Any, records: Any) -> None:
    """Raise InputError where ``call``, which takes a model and then records, is given something else."""
    check_kinds(
        call,
        Argument("model", model, (str, Composition, Damper), MODEL),
        Argument("records", records, (Record,), RECORDS, several=True),
    )


def prepared(
    model: str | Composition | Damper,
    records: Sequence[Record],
    laws: str | Mapping[str, str] | None = None,
    fixed: Mapping[str, float] | None = None,
    bandwidth: float | None = None,
    nuisances: Sequence[str] = ("offset", "state"),
    tied: Mapping[str, str] | None = None,
    weighting: str = "records",
) -> Problem:
    """The problem that `fit` solves: the records as arrays and the layout of the unknowns, before the search."""
    composition = model.composition if isinstance(model, Damper) else _composition(model)
    _check(list(records))
    if bandwidth is not None:
        check_bandwidth(records, bandwidth)
    pieces = weighted(with_common_levels([piece(record, bandwidth) for record in records]), weighting)
    held = held_twins(composition, laws, fixed, tied) | dict(fixed or {})
    made = columns(composition, [p.levels for p in pieces], laws, held, tied, [p.temperature for p in pieces])
    if not any(column.size for column in made):
        raise InputError("every parameter is fixed; leave at least one free")
    checked = checked_nuisances(composition, pieces, nuisances)
    return Problem(composition, made, pieces, checked)


@lru_cache(maxsize=1)
def _threads() -> Any:
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
            _within.enter_context(_threads().limit(limits=1, user_api="blas"))
    try:
        yield
    finally:
        with _lock:
            _count -= 1
            if _count == 0:
                _within.close()


def _composition(model: str | Composition) -> Composition:
    return model if isinstance(model, Composition) else compose(model)


def _check(records: list[Record]) -> None:
    if not records:
        raise InputError("there are no records to fit; give one or more")
    held = [r.name for r in records if r.role == "validation"]
    if held:
        raise InputError(f"{held[0]} is a validation record and is never fitted; leave it out, or score it")
    inputs = {r.input for r in records}
    if len(inputs) > 1:
        words = " and ".join(sorted(str(i) for i in inputs))
        raise InputError(
            f"the records' inputs are in {words}; a damper has one input, so convert them, or fit them separately"
        )
    names = [r.name for r in records]
    if len(set(names)) < len(names):
        twice = next(n for n in names if names.count(n) > 1)
        raise InputError(f"two records are called {twice!r}; rename one, so that results can be told apart")
