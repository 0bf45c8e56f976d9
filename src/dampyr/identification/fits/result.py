"""The result of a fit: its numbers, notes and residuals, built from the end of the search."""

from __future__ import annotations

import math
import warnings
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import FindingWarning, InputError
from dampyr.findings import Finding, Findings, Severity, handed_on, worst_first
from dampyr.identification.fit_thresholds import FitThresholds
from dampyr.identification.fits.data_sheet import SHEETS, contradictions
from dampyr.identification.fits.diagnostics import explain_no_interval, explain_trouble, notes, residual_findings
from dampyr.identification.fits.fit_options import FitOptions
from dampyr.identification.fits.fit_verdict import FitVerdict, fit_verdict
from dampyr.identification.fits.residuals import Residuals, Trace, analyse, motion
from dampyr.identification.parameter_uncertainty.levels import Levels, estimate_levels
from dampyr.identification.parameter_uncertainty.uncertainty import Uncertainty, uncertainty
from dampyr.identification.scoring.score import Score, compare
from dampyr.identification.scoring.scoring_window import SETTLING, too_short
from dampyr.identification.search.fit_data import Piece
from dampyr.identification.search.optimum import Optimum
from dampyr.identification.search.problem import Problem
from dampyr.identification.search.variable_projection import Outcome
from dampyr.input_kinds import NO_INPUT
from dampyr.models import Damper
from dampyr.models.damper import mapped_covariance
from dampyr.models.prediction_error import check_level
from dampyr.models.sampling_error import sampling_error, sampling_words
from dampyr.origin import Origin, combined
from dampyr.phrases import listing, with_reach
from dampyr.records import Record, cycle_bounds
from dampyr.records.checks.quality import motion_start
from dampyr.shown import Shown

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Nuisance:
    """The random effects of a record: the offset of its force in N, the hysteretic states at the start of its motion, and the
    factors of its load cell and of its viscosity where the fit has them."""

    offset: float
    states: dict[str, float]
    gain: float = 1.0
    temperature: float = 1.0


@dataclass(frozen=True, repr=False)
class Fit(Shown):
    """The result of `fit`.

    ``damper`` carries the laws, their covariance, the calibrated ranges and the findings, or is None where ``reason`` says why
    the numbers make no damper; ``bare`` is the same without its findings. ``parameters``, ``stderr`` and ``naive_stderr`` are
    in SI units, by labels such as ``dahl.kx @ 1.98 V``; an infinite error means that the records do not determine the number,
    NaN that it is at its limit.
    ``correlation`` (m, m) follows the same order. ``converged`` and ``reason`` say how the search ended;
    ``findings`` what a reader should know besides, the worst first; ``remarks`` are those of them that neither the scores nor
    the records tell. ``clusters`` are what the errors were clustered by ("record", "cycle", or
    "record and cycle"), ``freedom`` the degrees of freedom of each error, one less than the effective number of clusters that
    determine it. ``within_records`` holds the labels that only one or two records determine, and how many: their errors are by
    cycle, hold within these records only and give no interval.
    ``starts`` is the number of starts, and how many of them ended in the same optimum;
    ``settling`` what ``scores`` leave out, s. ``levels`` says how records and measurement sessions differ
    (`dampyr.identification.parameter_uncertainty.levels`), None where the numbers make no damper.

    ``leaderboard`` is the search that chose the model, None where one was named; ``validations`` are the predictions of records
    that were left out of a fit. ``predicted`` holds the scores of the records of the role "validation", or why one could not be
    predicted; ``beyond`` says which of them move more slowly or in smaller reversals than what was fitted
    (`dampyr.identification.fits.motion_coverage`). ``thresholds`` are what the findings and the verdict are judged by.
    """

    bare: Damper | None
    parameters: dict[str, float]
    stderr: dict[str, float]
    naive_stderr: dict[str, float]
    units: dict[str, str]
    correlation: Array
    converged: bool
    reason: str
    remarks: tuple[Finding, ...]
    clusters: str
    freedom: dict[str, float]
    within_records: dict[str, int]
    nuisances: dict[str, Nuisance]
    iterations: int
    outcome: Outcome = field(repr=False)
    records: tuple[Record, ...] = field(repr=False)
    starts: tuple[int, int] = (1, 1)
    settling: float = SETTLING
    levels: Levels | None = None
    # a `Leaderboard`, whose entries hold fits: the module that defines it imports this one
    leaderboard: Any = field(default=None, repr=False)
    validations: tuple[Any, ...] = field(default=(), repr=False)  # of `Validation`, whose module imports this one too
    predicted: Mapping[str, Score | str] = field(default_factory=dict)
    validation_records: tuple[Record, ...] = field(default=(), repr=False)
    beyond: Mapping[str, str] = field(default_factory=dict)
    thresholds: FitThresholds = field(default_factory=FitThresholds, repr=False)

    @cached_property
    def damper(self) -> Damper | None:
        """The damper with what remains true of it, which its card and what is made of it repeat; its provenance says why its
        model was chosen."""
        if self.bare is None:
            return None
        provenance = dict(self.bare.provenance) | (reasons_of_choice(self.leaderboard) if self.leaderboard else {})
        return replace(self.bare, provenance=provenance, findings=Findings(lambda: self._of_damper))

    @cached_property
    def _of_damper(self) -> tuple[Finding, ...]:
        """The findings without that on the level of sessions, which stands in the damper's prediction error."""
        of_records, of_residuals = handed_on(self.records), residual_findings(self.residuals)
        return worst_first(self.verdict.findings, of_records, of_residuals, self.remarks)

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """All that a reader should know of the fit and of all records, each once, the worst first."""
        of_levels = []
        if levels := self.levels:
            text = f"{levels.words}; to settle it, {levels.settles}" if levels.settles else levels.words
            of_levels.append(Finding("note", text))
            if drift := levels.drift:
                severity: Severity = "doubt" if abs(drift.change) > self.thresholds.level_drift else "note"
                of_levels.append(Finding(severity, drift.words))
        beyond = (Finding("doubt", statement) for statement in self.beyond.values())
        return worst_first(worst_first(self._of_damper, of_levels), handed_on(self.validation_records), beyond)

    @property
    def optimum(self) -> Optimum:
        """The end of the search: the point, the forces and the linearised problem there."""
        return self.outcome.optimum

    @property
    def problem(self) -> Problem:
        """What was solved: the records as arrays, and the layout of the unknowns."""
        return self.optimum.problem

    @property
    def verdict(self) -> FitVerdict:
        """Whether the search converged and the model describes the records, in one sentence."""
        return fit_verdict(self.scores, self.converged, self.reason, self.thresholds)

    @property
    def origin(self) -> Origin:
        """That of its records together (`dampyr.origin.combined`)."""
        return combined(record.origin for record in self.records)

    @property
    def nuisance_spread(self) -> dict[str, float]:
        """The standard deviation across the records of each nuisance: N for the offset, factors, states without unit."""
        nuisances = list(self.nuisances.values())
        table = {
            name: [getattr(nuisance, name) for nuisance in nuisances] for name in ("offset", "gain", "temperature")
        }
        table |= {
            name: [nuisance.states[name] for nuisance in nuisances]
            for name in (nuisances[0].states if nuisances else {})
        }
        return {name: float(np.std(values, ddof=1)) if len(values) > 1 else np.nan for name, values in table.items()}

    def intervals(self, level: float = 0.95, between: str = "records") -> dict[str, tuple[float, float]]:
        """Confidence intervals at ``level``, by label, in SI units.

        ``between="sessions"`` adds what the levels of the fitted measurement sessions may have moved (`levels`): that
        of another session's damper. It widens the numbers that a factor on the force changes, such as kx and kw of
        Dahl, and not rho.

        Estimate and standard error with Student's t of ``freedom``. They hold the truth where the model does; where it misses
        the damper's behaviour they describe the fit. Infinite where the records do not determine the number, NaN where it
        is at its limit and where one or two records alone determine it (``within_records``): how records differ is not
        estimated from so few.
        """
        check_level(level)
        from scipy.stats import t

        if between not in ("records", "sessions"):
            raise InputError(f"between = {between!r} is not allowed; choose 'records' or 'sessions'")
        intervals = {}
        for k, (label, value) in enumerate(self.parameters.items()):
            error, freedom = self.stderr[label], self.freedom[label]
            if between == "sessions" and self.levels is not None and np.isfinite(error):
                reach = self.levels.reach_between_sessions(k, error, freedom, level)
            else:
                reach = float(t.ppf(0.5 + 0.5 * level, freedom)) * error
            reach = np.nan if label in self.within_records else reach
            intervals[label] = (value - reach, value + reach)
        return intervals

    def error_holds(self, label: str) -> str:
        """Between or within which records the standard error of a number holds, in words; empty where it has none."""
        if label in self.within_records:
            return "within these records only"
        return "between records" if np.isfinite(self.stderr[label]) else ""

    def why_no_interval(self, label: str) -> str:
        """Why a number has no interval, in words; empty where it has one."""
        return explain_no_interval(self.within_records[label]) if label in self.within_records else ""

    def save(self, path: str | Path) -> Path:
        """Write the card of the fitted damper, as `Damper.save`; :class:`~dampyr.errors.InputError` where there is none."""
        if self.damper is None:
            raise InputError(f"the fit has no damper to save: {self.reason}")
        return self.damper.save(path)

    @property
    def forces(self) -> list[Array]:
        """The fitted force along each record from where its motion starts, with its own offset and initial states, N."""
        return self.optimum.forces

    @property
    def whole_forces(self) -> list[Array]:
        """The fitted force at every sample of each record, before its motion as at its start, N."""
        pairs = zip(self.records, self.forces, strict=True)
        return [np.concatenate((np.full(record.n - force.size, force[0]), force)) for record, force in pairs]

    @cached_property
    def residuals(self) -> Residuals:
        """The analysis of the residual over all samples that were fitted: see `dampyr.identification.residuals`."""
        traces = [
            Trace(p.name, p.t[c], p.x[c], p.v[c], p.force[c], residual[c], float(np.mean(p.u)), *motion(record))
            for p, residual, record in zip(self.problem.pieces, self.optimum.residuals, self.records, strict=True)
            for c in (p.comparable,)
        ]
        return replace(analyse(traces, self.problem.pieces[0].unit, self.thresholds), origin=self.origin)

    @cached_property
    def scores(self) -> dict[str, Score]:
        """How well the fit describes the records it was fitted to (which is no prediction), by record.

        From ``settling`` s after the motion starts; a record that is too short for that is scored from the start of its motion,
        the state of which was fitted, and ``findings`` say so. Of a force that holds a moving average only whole windows after
        the start of the motion are scored.
        """
        scores = {}
        for record, piece, whole in zip(self.records, self.problem.pieces, self.whole_forces, strict=True):
            settling, window = 0.0 if too_short(record, self.settling) else self.settling, None
            if piece.average is not None:
                times = piece.t[piece.comparable]
                window = max(motion_start(record) + settling, float(times[0])), float(times[-1])
            scores[record.name] = compare(record, whole, settling, window)
        return scores


def reasons_of_choice(board: Any) -> dict[str, str]:
    """Why a model was chosen, for the provenance of a card: its error, and the runner-up with its own."""
    error, count, best = 100 * board.winner.error, len(board.screened), board.best
    text = f"the lowest validation error, {error:.3g} %, of {count} models"
    if board.winner is not best:
        text = (
            f"the simplest within one standard error of the lowest validation error of {count} models: "
            f"{error:.3g} %, against {with_reach(100 * best.error, 100 * best.standard_error)} % of {best.model}"
        )
    reasons = {"chosen": text}
    if board.runner_up:
        reasons["runner-up"] = f"{board.runner_up.model}, {100 * board.runner_up.error:.3g} %"
    return reasons


def residuals(fit: Fit) -> Residuals:
    """The analysis of a fit's residual, over all samples that were fitted."""
    return fit.residuals


def build_fit(
    outcome: Outcome,
    records: tuple[Record, ...],
    options: FitOptions,
    starts: tuple[int, int] = (1, 1),
) -> Fit:
    """The fit at the end of a search; ``starts``: how many there were, and how many of them ended in the same optimum."""
    optimum, problem = outcome.optimum, outcome.optimum.problem
    uncertainties = uncertainty(optimum, outcome.at_limit)
    labels = [label for c in problem.columns if c.size for label in c.labels(problem.pieces[0].unit)]
    unit_of = [c.quantity.unit for c in problem.columns for _ in range(c.size)]
    stderr = _label_errors(labels, uncertainties.covariance, outcome.at_limit)
    few = zip(labels, uncertainties.within, uncertainties.records, strict=True)
    within = {label: int(count) for label, cycles_only, count in few if cycles_only and np.isfinite(stderr[label])}
    damper, trouble = make_damper(outcome, records, options, uncertainties, tuple(within))
    levels = None
    if damper is not None and all(np.all(np.isfinite(force)) for force in optimum.forces):
        levels, error = estimate_levels(optimum, uncertainties, records, options.session_prior)
        damper = replace(damper, prediction_error=error)
    states = list(problem.composition.states)
    of_starts = [f"{starts[1]} of {starts[0]} starts ended in the same optimum"] if starts[0] > 1 else []
    sheets = {record.provenance.get("data_sheet", "") for record in records} & set(SHEETS)
    broken_promises = [text for sheet in sorted(sheets) if damper for text in contradictions(damper, sheet)]
    by_cycle = [label in within for label in labels if np.isfinite(stderr[label])]
    clusters = "record" if not any(by_cycle) else "cycle" if all(by_cycle) else "record and cycle"
    return Fit(
        bare=damper,
        parameters=dict(zip(labels, map(float, optimum.point.theta), strict=True)),
        stderr=stderr,
        naive_stderr=_label_errors(labels, uncertainties.naive, outcome.at_limit),
        units=dict(zip(labels, unit_of, strict=True)),
        correlation=_correlate(uncertainties.covariance),
        converged=outcome.converged and not trouble,
        reason=trouble or outcome.reason,
        remarks=(
            *notes(outcome, uncertainties, labels, within, options.thresholds),
            *(
                Finding("note", statement)
                for statement in (*of_starts, *_note_short_records(records, options.settling))
            ),
            *(Finding("doubt", statement) for statement in (*broken_promises, *_note_sampling(damper, problem))),
        ),
        clusters=clusters,
        freedom=dict(zip(labels, map(float, uncertainties.freedom), strict=True)),
        within_records=within,
        nuisances={
            p.name: Nuisance(
                optimum.point.nuisance(problem, r, "offset"),
                {states[k]: float(optimum.point.states(problem, r)[k]) for k in problem.composition.free_at_start},
                optimum.point.nuisance(problem, r, "gain"),
                optimum.point.nuisance(problem, r, "temperature"),
            )
            for r, p in enumerate(problem.pieces)
        },
        iterations=outcome.iterations,
        outcome=outcome,
        records=records,
        starts=starts,
        settling=options.settling,
        levels=levels,
        thresholds=options.thresholds,
    )


def _note_short_records(records: tuple[Record, ...], settling: float) -> list[str]:
    """The records that are scored from the start of their motion, because settling would leave next to nothing of them."""
    short = [record.name for record in records if too_short(record, settling)]
    if not short:
        return []
    return [
        f"{listing(short, 3)}: too short for a settling of {settling:g} s, so scored from the start of the motion; a "
        "prediction of such a record is not scored unless a shorter settling is given"
    ]


def _note_sampling(damper: Damper | None, problem: Problem) -> list[str]:
    """What the records' samples make wrong in the force of this damper, of the worst record; warned of, too."""
    if damper is None or not any(part.speed for part in damper.composition.parts):
        return []
    at = [damper if math.isnan(p.temperature) else damper.at_temperature(p.temperature, True) for p in problem.pieces]
    values_of = ((p, warm.values(p.u, allow_extrapolation=True)) for p, warm in zip(problem.pieces, at, strict=True))
    errors = {sampling_error(damper.composition, p.t, p.x, p.v, values): (p, values) for p, values in values_of}
    p, values = errors[max(errors)]
    if not (text := sampling_words(damper.composition, p.t, p.x, p.v, values)):
        return []
    warnings.warn(f"{p.name}: {text}", FindingWarning, stacklevel=4)
    return [f"{p.name}: {text}"]


def _label_errors(labels: list[str], covariance: Array, at_limit: tuple[int, ...]) -> dict[str, float]:
    errors = np.sqrt(np.diag(covariance))
    errors[list(at_limit)] = np.nan
    return dict(zip(labels, map(float, errors), strict=True))


def _correlate(covariance: Array) -> Array:
    spread = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
        out = covariance / np.outer(spread, spread)
    out[~np.isfinite(out)] = np.nan
    return np.asarray(out)


def make_damper(
    outcome: Outcome,
    records: tuple[Record, ...],
    options: FitOptions,
    uncertainty: Uncertainty | None = None,
    within: tuple[str, ...] = (),
) -> tuple[Damper | None, str]:
    """The damper at the end of a search, or None, and what is wrong with it, if anything.

    Without ``uncertainty`` it has no covariance: for a prediction that has no band.
    """
    optimum = outcome.optimum
    problem = optimum.problem
    inputs = np.concatenate([np.ravel(p.levels) for p in problem.pieces])
    unit = problem.pieces[0].unit
    low, high = (-math.inf, math.inf) if unit == NO_INPUT else (float(inputs.min()), float(inputs.max()))
    try:
        damper = Damper(
            parts=problem.composition.names,
            laws={
                c.name: problem.columns[k].law(theta, low, high)
                for c, k, theta in zip(problem.columns, problem.owners, optimum.point.of(problem), strict=True)
            },
            input=unit,
            ranges=_measure_ranges(records, problem.pieces),
            covariance=None if uncertainty is None else mapped_covariance(optimum.law_matrix, uncertainty.covariance),
            bandwidth=options.bandwidth,
            within_records=within,
            provenance=_state_provenance(records, options.thresholds),
            origin=combined(record.origin for record in records),
        )
    except InputError as problem_:
        between = any(c.size and c.kind == "polynomial" for c in problem.columns)
        repair = (
            "; between the inputs it is fitted at a polynomial may go anywhere: lower its degree" if between else ""
        )
        return None, f"the fitted numbers make no damper: {problem_}{repair}"
    return damper, explain_trouble(outcome)


def _measure_ranges(records: tuple[Record, ...], pieces: list[Piece]) -> dict[str, tuple[float, float]]:
    strokes = [0.5 * float(np.ptp(p.x)) for p in pieces]
    speeds = [float(np.max(np.abs(p.v))) for p in pieces]
    frequencies = []
    for record in records:
        spans = cycle_bounds(record)
        if spans:
            frequencies.append(len(spans) / float(record.time[spans[-1][1]] - record.time[spans[0][0]]))
    ranges = {"displacement": (0.0, max(strokes)), "velocity": (0.0, max(speeds))}
    if frequencies:
        ranges["frequency"] = (min(frequencies), max(frequencies))
    return ranges


def _state_provenance(records: tuple[Record, ...], thresholds: FitThresholds) -> dict[str, str]:
    names, origins = [r.name for r in records], Counter(r.origin.kind for r in records)
    unusual = dict.fromkeys([thresholds.changed, *(record.thresholds.changed for record in records)])
    shown = ", ".join(names) if len(names) <= 50 else f"{len(names)} records"
    return {
        "method": "least squares over whole records (dampyr.identification.fit)",
        "records": shown,
        **({"origins": ", ".join(f"{count} {kind}" for kind, count in origins.items())} if len(origins) > 1 else {}),
        **({"thresholds": "; ".join(filter(None, unusual))} if any(unusual) else {}),
    }
