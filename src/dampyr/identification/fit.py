"""One call from records to a damper: `fit`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.identification.design import columns
from dampyr.identification.pieces import Piece, piece
from dampyr.identification.problem import Problem
from dampyr.identification.products import modelled
from dampyr.identification.score import Score, compare
from dampyr.identification.solver import Outcome, search
from dampyr.identification.starting import begin
from dampyr.identification.uncertainty import Uncertainty, uncertainty
from dampyr.models import Composition, Damper, compose
from dampyr.records import Record, cycles

if TYPE_CHECKING:
    from dampyr.identification.residuals import Residuals

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Nuisance:
    """What a record brought with it: the offset of its force in N, and the hysteretic states at the start of its motion."""

    offset: float
    states: dict[str, float]


@dataclass(frozen=True)
class Fit:
    """What `fit` found.

    ``damper`` carries the laws, their covariance and the calibrated ranges, or is None where ``reason`` says why the numbers
    make no damper. ``parameters``, ``stderr`` and ``naive_stderr`` are in SI units, by labels such as ``dahl.kx @ 1.98 V``;
    an infinite error means that the records do not determine the number, NaN that it stands at its limit.
    ``correlation`` (m, m) follows the same order. ``converged`` and ``reason`` say how the search ended;
    ``notes`` what a reader should know besides. ``clusters`` are what the errors were clustered by ("record" or "cycle"),
    ``freedom`` the degrees of freedom of each error, one less than the effective number of clusters that speak of it.
    """

    damper: Damper | None
    parameters: dict[str, float]
    stderr: dict[str, float]
    naive_stderr: dict[str, float]
    units: dict[str, str]
    correlation: Array
    converged: bool
    reason: str
    notes: tuple[str, ...]
    clusters: str
    freedom: dict[str, float]
    nuisances: dict[str, Nuisance]
    iterations: int
    problem: Problem = field(repr=False)
    outcome: Outcome = field(repr=False)
    records: tuple[Record, ...] = field(repr=False)

    def intervals(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Confidence intervals at ``level``, by label, in SI units.

        Estimate and standard error with Student's t of ``freedom``. They hold the truth where the model does; where it misses
        the damper's behaviour they describe the fit. Infinite where the records do not determine the number, NaN where it
        stands at its limit.
        """
        if not 0.0 < level < 1.0:
            raise InputError(f"level = {level:g} is not allowed; it must be between 0 and 1, such as 0.95")
        from scipy.stats import t

        found = {}
        for label, value in self.parameters.items():
            reach = float(t.ppf(0.5 + 0.5 * level, self.freedom[label])) * self.stderr[label]
            found[label] = (value - reach, value + reach)
        return found

    @cached_property
    def forces(self) -> list[Array]:
        """The fitted force along each record from where its motion starts, with its own offset and initial states, N."""
        return [modelled(self.problem, self.outcome.point, r) for r in range(len(self.records))]

    @cached_property
    def scores(self) -> dict[str, Score]:
        """How well the fit describes the records it was fitted to (which is no prediction), by record."""
        found = {}
        for record, force in zip(self.records, self.forces, strict=True):
            whole = np.concatenate((np.full(record.n - force.size, force[0]), force))
            found[record.name] = compare(record, whole)
        return found

    @cached_property
    def residuals(self) -> Residuals:
        """What the fit leaves of the measured force, analysed: see `dampyr.identification.residuals`."""
        from dampyr.identification.residuals import residuals

        return residuals(self)


def fit(
    model: str | Composition | Damper,
    records: Record | Sequence[Record],
    laws: str | Mapping[str, str] | None = None,
    fixed: Mapping[str, float] | None = None,
    bandwidth: float | None = None,
    progress: Callable[[int, float], None] | None = None,
) -> Fit:
    """Identify a damper from records by least squares over their whole motion.

    Parameters
    ----------
    model
        parts of the catalogue, such as ``"dahl"`` or ``"dahl + spring + delay"``, or a damper of the same make.
    records
        one record, or several for a joint fit. Each keeps an offset of its force and its initial states to itself and
        weighs by the standard deviation of its force. Records of the role "validation" are refused.
    laws
        how parameters follow the input: see `dampyr.identification.design.columns`. By default the values at the
        inputs that occur, interpolated monotonically between them.
    fixed
        flat parameter name -> value in SI units, held.
    bandwidth
        of the velocity in Hz, derived from the displacement; None takes the recorded velocity where there is one.
    progress
        called with the number of the step and the cost.

    Returns
    -------
    Fit
        also where the search did not converge: ``converged`` and ``reason`` say so.

    Raises
    ------
    InputError
        a record without input, without motion, with a constant force, or of mixed inputs; an unknown name or law.
    """
    listed = [records] if isinstance(records, Record) else list(records)
    problem = prepared(model, listed, laws, fixed, bandwidth)
    with _threads().limit(limits=1, user_api="blas"):  # small factorisations: threads would only wait
        outcome = search(problem, begin(problem), progress)
        return _report(problem, outcome, tuple(listed), bandwidth)


def prepared(
    model: str | Composition | Damper,
    records: Sequence[Record],
    laws: str | Mapping[str, str] | None = None,
    fixed: Mapping[str, float] | None = None,
    bandwidth: float | None = None,
) -> Problem:
    """What `fit` solves: the records conditioned and the unknowns laid out, before anything is searched."""
    composition = model.composition if isinstance(model, Damper) else _composition(model)
    _check(list(records))
    pieces = [piece(record, bandwidth) for record in records]
    made = columns(composition, [p.u for p in pieces], laws, fixed)
    if not any(column.size for column in made):
        raise InputError("every parameter is fixed; leave at least one free")
    kept = tuple(name for name in ("offset", "state") if name != "offset" or not composition.static)
    return Problem(composition, made, pieces, kept)


@lru_cache(maxsize=1)
def _threads() -> Any:
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


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
        raise InputError(f"the records' inputs are in {words}; a damper has one input, so convert or fit them apart")
    names = [r.name for r in records]
    if len(set(names)) < len(names):
        twice = next(n for n in names if names.count(n) > 1)
        raise InputError(f"two records are called {twice!r}; rename one, so that results can be told apart")


def _report(problem: Problem, outcome: Outcome, records: tuple[Record, ...], bandwidth: float | None) -> Fit:
    known = uncertainty(problem, outcome.point, outcome.at_limit)
    labels = [label for c in problem.columns if c.size for label in c.labels(problem.pieces[0].unit)]
    unit_of = [c.quantity.unit for c in problem.columns for _ in range(c.size)]
    damper, trouble = _damper(problem, outcome, known, records, bandwidth)
    states = list(problem.composition.states)
    return Fit(
        damper=damper,
        parameters=dict(zip(labels, map(float, outcome.point.theta), strict=True)),
        stderr=_errors(labels, known.covariance, outcome.at_limit),
        naive_stderr=_errors(labels, known.naive, outcome.at_limit),
        units=dict(zip(labels, unit_of, strict=True)),
        correlation=_correlation(known.covariance),
        converged=outcome.converged and not trouble,
        reason=trouble or outcome.reason,
        notes=tuple(_notes(problem, outcome, known, labels)),
        clusters=known.clusters,
        freedom=dict(zip(labels, map(float, known.freedom), strict=True)),
        nuisances={
            p.name: Nuisance(
                outcome.point.nuisance(problem, r, "offset"),
                dict(zip(states, map(float, outcome.point.states(problem, r)), strict=True)),
            )
            for r, p in enumerate(problem.pieces)
        },
        iterations=outcome.iterations,
        problem=problem,
        outcome=outcome,
        records=records,
    )


def _errors(labels: list[str], covariance: Array, at_limit: tuple[int, ...]) -> dict[str, float]:
    errors = np.sqrt(np.diag(covariance))
    errors[list(at_limit)] = np.nan
    return dict(zip(labels, map(float, errors), strict=True))


def _limit(problem: Problem, k: int) -> str:
    return [c.quantity.range_in_words() for c in problem.columns for _ in range(c.size)][k]


def _correlation(covariance: Array) -> Array:
    spread = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
        out = covariance / np.outer(spread, spread)
    out[~np.isfinite(out)] = np.nan
    return np.asarray(out)


def _notes(problem: Problem, outcome: Outcome, known: Uncertainty, labels: list[str]) -> list[str]:
    notes = [
        f"{labels[k]} stands at its limit ({_limit(problem, k)}); its error is not known" for k in outcome.at_limit
    ]
    blind = [labels[k] for k in known.blind]
    if blind:
        notes.append(f"the records do not determine {', '.join(blind)} (infinite error)")
    errors = np.sqrt(np.diag(known.covariance))
    vague = [k for k in np.flatnonzero(errors > np.abs(outcome.point.theta)) if np.isfinite(errors[k])]
    if vague:
        notes.append(
            f"the error of {', '.join(labels[k] for k in vague)} is larger than the value: the records hardly hold it"
        )
    few = int(np.min(np.delete(known.counts, list(outcome.at_limit)), initial=10**6))
    if known.clusters == "cycle" and few < 10:
        notes.append(f"errors rest on {few} cycles only; they are rough")
    for record in problem.pieces:
        if float(np.trapezoid(record.force - np.mean(record.force), record.x - np.mean(record.x))) < 0:
            notes.append(f"{record.name}: its loops create energy; is the force's sign inverted?")
    return notes


def _damper(
    problem: Problem,
    outcome: Outcome,
    known: Uncertainty,
    records: tuple[Record, ...],
    bandwidth: float | None,
) -> tuple[Damper | None, str]:
    """The damper that the coefficients make, or None and why they make none."""
    inputs = np.concatenate([np.ravel(p.u) for p in problem.pieces])
    low, high = float(inputs.min()), float(inputs.max())
    try:
        damper = Damper(
            parts=problem.composition.names,
            laws={
                c.name: c.law(theta, low, high)
                for c, theta in zip(problem.columns, outcome.point.of(problem), strict=True)
            },
            input=problem.pieces[0].unit,
            ranges=_ranges(records, problem.pieces),
            covariance=_law_covariance(problem, known.covariance),
            bandwidth=bandwidth,
            provenance=_provenance(records),
        )
    except InputError as problem_:
        return None, f"the fitted numbers make no damper: {problem_}"
    return damper, ""


def _law_covariance(problem: Problem, covariance: Array) -> Array:
    """The covariance of the laws' own coefficients; fixed parameters are known."""
    size = sum(max(c.size, 1) for c in problem.columns)
    T = np.zeros((size, problem.size))
    row = 0
    for column, span in zip(problem.columns, problem.slices, strict=True):
        if column.size:
            T[row : row + column.size, span] = column.to_coefficients()
        row += max(column.size, 1)
    finite = np.where(np.isfinite(covariance), covariance, 0.0)
    out = T @ finite @ T.T
    for k in np.flatnonzero(~np.isfinite(np.diag(covariance))):
        out[T[:, k] != 0.0, T[:, k] != 0.0] = np.inf
    return np.asarray(0.5 * (out + out.T))


def _ranges(records: tuple[Record, ...], pieces: list[Piece]) -> dict[str, tuple[float, float]]:
    strokes = [0.5 * float(np.ptp(p.x)) for p in pieces]
    speeds = [float(np.max(np.abs(p.v))) for p in pieces]
    frequencies = []
    for record in records:
        found = cycles(record)
        if found:
            frequencies.append(len(found) / float(record.time[found[-1][1]] - record.time[found[0][0]]))
    ranges = {"displacement": (0.0, max(strokes)), "velocity": (0.0, max(speeds))}
    if frequencies:
        ranges["frequency"] = (min(frequencies), max(frequencies))
    return ranges


def _provenance(records: tuple[Record, ...]) -> dict[str, str]:
    from dampyr import __version__

    names = [r.name for r in records]
    shown = ", ".join(names) if len(names) <= 50 else f"{len(names)} records"
    return {
        "method": "least squares over whole records (dampyr.identification.fit)",
        "records": shown,
        "dampyr": __version__,
    }
