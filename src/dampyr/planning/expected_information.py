r"""Expected information: what a test would tell of a damper's coefficients, and how far records differ from one another.

A record g has deviations :math:`\delta_g` of its own from the damper's parameters (a gain is one: it changes all parameters of
force alike) and noise with the covariance C. With its derivatives J by the coefficients, what its offset and its state at the
start can take removed, and its weights,

.. math:: A_g = J^T J, \qquad M_g = A_g E D E^T A_g + J^T C J, \qquad
   \mathrm{cov}(\hat\theta) = \Big(\sum A_g\Big)^{-1} \sum M_g \Big(\sum A_g\Big)^{-1}

where D is the covariance of the deviations between records, and E says which parameter a coefficient belongs to: a record that
is 3 % strong at one voltage would be so at another. This is what the sandwich of
`dampyr.identification.parameter_uncertainty.uncertainty` estimates from the records once they are there, so its degrees of
freedom are those of the fit, too. All is relative to the coefficients, and per sample: a long record informs no more through
A, but less noise is left of it in M.

`learned` estimates D and C from the residuals of a fit: C by the autocorrelation of what a record's own deviations leave, D
by expectation and maximisation over the records' scores (a random-coefficient model, Swamy 1970). Without records
`assumed_spread` takes its place.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrWarning, InputError
from dampyr.identification import Fit
from dampyr.identification.parameter_uncertainty.uncertainty import MIN_RECORDS, freedom_by_gains
from dampyr.identification.search.fit_data import Piece, piece
from dampyr.identification.search.normal_equations import modelled_force
from dampyr.identification.search.parametrisation import Column, columns, held_twins
from dampyr.identification.search.problem import Problem, SearchPoint, checked_nuisances
from dampyr.input_kinds import NO_INPUT, input_arguments
from dampyr.models import Damper
from dampyr.models.codegen.composition import Composition
from dampyr.records import Record
from dampyr.rig import Drive, RigSettings

Array = NDArray[np.float64]
GAIN = 0.03  # between records: 1.8 to 3.4 % in the published campaign
DEVIATION = 0.03  # of each parameter besides, as large as the gain: nothing better is known before there are records
RESIDUAL = 0.05  # of the force's spread: good models leave 4 to 8 % on the published campaign
CORRELATED = 0.33  # s, of the published campaign's residuals
LEARNED_FROM = 4  # records; of fewer, how they differ is assumed
ROUNDS = 60  # of expectation and maximisation: it changes by less than a per cent after thirty
MEMORY = 4.0  # s up to which residuals are correlated at most
RELATIVE_STEP = 1e-5  # of the differences that give derivatives
LEVEL = 0.05  # of a record's samples that an input needs to count as one of its levels
MAX_RATE = 500.0  # samples/s along an expected path
RIDGE = 1e-6  # of the information of a whole record, so that the first tests of a design can be compared


@dataclass(frozen=True)
class ModelDeviation:
    """How records differ from the model: ``deviations`` (P, P), the covariance between records of the relative deviations of
    the free parameters ``names``; the residual's standard deviation is ``noise`` N and ``share`` of the force's spread, its
    ``autocorrelation`` (k,) is that at lags of ``lag`` s. ``records`` says how many records it was estimated from."""

    names: tuple[str, ...]
    deviations: Array
    noise: float
    share: float
    autocorrelation: Array
    lag: float
    records: int = 0

    def residual(self, spread: Array) -> Array:
        """The standard deviation (n,) N of the residual where the force has this one."""
        return np.asarray(np.hypot(self.noise, self.share * spread))

    def correlation_at(self, dt: float, n: int) -> Array:
        """The autocorrelation (k,), k <= n, at lags of ``dt``."""
        lags_estimated = self.lag * np.arange(self.autocorrelation.size)
        lags = dt * np.arange(min(n, int(lags_estimated[-1] / dt) + 1))
        return np.interp(lags, lags_estimated, self.autocorrelation)


@dataclass(frozen=True)
class Information:
    """What one record tells: A (G, G), J'CJ (G, G) and J'r (G,), relative to the coefficients."""

    name: str
    A: Array
    noise: Array
    score: Array


@dataclass(frozen=True, eq=False)
class CoefficientLayout:
    """The coefficients that a fit will determine: the laws' ``columns`` and their values ``theta`` (G,) by the present damper.

    ``held`` coefficients count as known: those that are 0 or stand at a limit.
    """

    composition: Composition
    columns: list[Column]
    theta: Array
    unit: str = "V"

    @cached_property
    def labels(self) -> list[str]:
        """The names of the coefficients, as a fit gives them."""
        return [label for c in self.columns if c.size for label in c.labels(self.unit)]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The free parameters."""
        return tuple(c.name for c in self.columns if c.size)

    @cached_property
    def owner(self) -> Array:
        """E (G, P): which parameter a coefficient belongs to."""
        sizes = [c.size for c in self.columns if c.size]
        return np.repeat(np.eye(len(sizes)), sizes, axis=0)

    @cached_property
    def is_linear(self) -> NDArray[np.bool_]:
        """(G,) the coefficients that a gain multiplies."""
        return np.repeat([c.quantity.linear for c in self.columns], [c.size for c in self.columns]).astype(bool)

    @cached_property
    def held(self) -> NDArray[np.bool_]:
        """(G,) the coefficients that count as known."""
        low = np.repeat([c.quantity.low for c in self.columns], [c.size for c in self.columns])
        high = np.repeat([c.quantity.high for c in self.columns], [c.size for c in self.columns])
        near = 1e-6 * np.abs(self.theta)
        return (np.abs(self.theta) < 1e-12) | (self.theta <= low + near) | (self.theta >= high - near)

    def problem(self, piece: Piece) -> Problem:
        """The problem of a single record."""
        nuisances = checked_nuisances(self.composition, [piece], ("offset", "state"))
        return Problem(self.composition, self.columns, [piece], nuisances)

    def damper(self, theta: Array) -> Damper:
        """The damper of other coefficients; :class:`~dampyr.errors.InputError` where they make none."""
        knots = [u for c in self.columns for u in c.knots]
        low, high = (-np.inf, np.inf) if self.unit == NO_INPUT else (min(knots), max(knots))
        by_column = np.split(theta, np.cumsum([c.size for c in self.columns])[:-1])
        laws = {c.name: c.law(part, low, high) for c, part in zip(self.columns, by_column, strict=True)}
        return Damper(self.composition.names, laws, input=self.unit)


def layout(
    damper: Damper,
    inputs: Sequence[Array | float],
    laws: str | Mapping[str, str] | None = None,
    fixed: Mapping[str, float] | None = None,
) -> CoefficientLayout:
    """The coefficients of a fit to records with these ``inputs`` (numbers, or arrays where they vary), by the laws of a fit.

    Raises :class:`~dampyr.errors.InputError` as `dampyr.identification.fit` does for its laws.
    """
    if damper.temperatures is not None:
        raise InputError("laws of the temperature are not planned for; give a card at one temperature")
    held = held_twins(damper.composition, laws, fixed, None) | dict(fixed or {})
    law_columns = columns(damper.composition, list(inputs), laws, held)
    theta = [np.asarray(damper.all_laws[c.name](np.array(c.knots)), dtype=float) for c in law_columns if c.size]
    if not theta:
        raise InputError("every parameter is fixed; leave at least one free")
    return CoefficientLayout(damper.composition, law_columns, np.concatenate(theta), damper.input)


def expected_record(drive: Drive, damper: Damper, rig: RigSettings, name: str) -> Record:
    """The record that a test would give, were the table to follow its set points and the damper its card."""
    from scipy.interpolate import CubicSpline

    rate = min(rig.board.rate, MAX_RATE)
    points = np.arange(drive.n) * drive.period
    t = np.arange(int(points[-1] * rate) + 1) / rate
    path = CubicSpline(points, drive.displacement)
    x, v = path(t), path(t, 1)
    u = drive.voltage[np.minimum((t / drive.period + 1e-9).astype(int), drive.n - 1)]
    voltage: float | Array = u if np.ptp(u) else float(u[0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)  # of motions beyond the card's: the check before motion says it
        force = damper.force_of_motion(t, x, velocity=v, **input_arguments(damper.input, voltage))
    applied: dict[str, Any] = {"voltage": voltage} if damper.has_input else {"no_input": True}
    return Record(time=t, displacement=x, force=force, velocity=v, name=name, **applied)


def expected_information(plan: CoefficientLayout, record: Record, spread: ModelDeviation) -> Information:
    """What a test would tell whose record would be ``record``: its own force serves to weigh it only."""
    fitted_piece = piece(record, None)
    problem = plan.problem(fitted_piece)
    point = SearchPoint(plan.theta, np.zeros((1, problem.locals)))
    J = _differentiate(plan, problem, point)
    sizes = _spread_by_level(fitted_piece, fitted_piece.force)[fitted_piece.comparable]
    noise = _weigh_noise(
        J, spread, float(np.median(np.diff(fitted_piece.t))), spread.residual(sizes) / fitted_piece.spread
    )
    A = J.T @ J
    return Information(record.name, A, noise, np.zeros(len(A)))


@dataclass(frozen=True)
class _Seen:
    """A record of a fit: its weighted derivatives (n, G) and residual (n,), what its own deviations leave of it (n,) N, and the
    standard deviation (n,) N of the force at the input of each sample."""

    name: str
    J: Array
    e: Array
    left: Array
    sizes: Array
    spread: float
    dt: float


def _read_fit(fit: Fit, plan: CoefficientLayout) -> list[_Seen]:
    seen = []
    for r, (fitted_piece, record) in enumerate(zip(fit.problem.pieces, fit.records, strict=True)):
        problem = plan.problem(fitted_piece)
        locals_of_plan = problem.locals
        if locals_of_plan > fit.problem.locals:
            raise InputError(
                "the fit was made without offsets or states of its records; fit it with them to plan from it"
            )
        point = SearchPoint(plan.theta, fit.optimum.point.local[[r], fit.problem.locals - locals_of_plan :])
        scale = fitted_piece.spread * np.sqrt(fitted_piece.count)
        e = fit.optimum.residuals[r][fitted_piece.comparable] / scale
        J = _differentiate(plan, problem, point)
        own_part = J @ (np.linalg.pinv(J.T @ J, rcond=1e-6, hermitian=True) @ (J.T @ e))
        dt = float(np.median(np.diff(fitted_piece.t)))
        sizes = _spread_by_level(fitted_piece, fit.forces[r])[fitted_piece.comparable]
        seen.append(_Seen(record.name, J, e, (e - own_part) * scale, sizes, fitted_piece.spread, dt))
    return seen


def learned(fit: Fit, plan: CoefficientLayout) -> tuple[ModelDeviation, list[Information]]:
    """How the records of a fit differ from its damper and from one another, and what each of them tells."""
    seen = _read_fit(fit, plan)
    levels = [(float(np.std(s.left[s.sizes == size])), float(size)) for s in seen for size in np.unique(s.sizes)]
    noise, share = _fit_sizes(*np.array(levels).T)
    lag = float(np.median([s.dt for s in seen]))
    standardised = [s.left / np.hypot(noise, share * s.sizes) for s in seen if abs(s.dt - lag) < 1e-3 * lag]
    rho = _autocorrelate(standardised, lag)
    assumed = assumed_spread(plan)
    spread = ModelDeviation(plan.names, assumed.deviations, noise, share, rho, lag, len(seen))
    records = [
        Information(
            s.name, s.J.T @ s.J, _weigh_noise(s.J, spread, s.dt, spread.residual(s.sizes) / s.spread), s.J.T @ s.e
        )
        for s in seen
    ]
    if len(seen) >= LEARNED_FROM:
        spread = replace(spread, deviations=_estimate_deviations(records, plan, assumed.deviations))
    return spread, records


def _differentiate(plan: CoefficientLayout, problem: Problem, point: SearchPoint) -> Array:
    """The derivatives (n, G) of the force by the relative coefficients over spread and root of n, less the nuisances' part."""
    piece = problem.pieces[0]
    high = problem.inner_limits[1]
    size = np.abs(point.theta)
    base = modelled_force(problem, point, 0)[piece.comparable]
    J = np.zeros((base.size, problem.size))
    seen = ~plan.held if problem.varying else ~plan.held & np.any(problem.matrix[0] != 0.0, axis=0)
    for k in map(int, np.flatnonzero(seen)):
        step = RELATIVE_STEP * float(size[k])
        step = -step if point.theta[k] + step > high[k] else step
        theta = point.theta.copy()
        theta[k] += step
        J[:, k] = (modelled_force(problem, SearchPoint(theta, point.local), 0)[piece.comparable] - base) / step
    J *= point.theta  # by relative changes: what a card or a law has in N and in 1/m becomes comparable
    L = np.zeros((base.size, problem.locals))
    for k in range(problem.locals):
        bottom, top = (float(limit[k]) for limit in problem.local_limits)
        change = RELATIVE_STEP * (top - bottom if np.isfinite(top - bottom) else piece.spread)
        change = -change if point.local[0, k] + change > top else change
        local = point.local.copy()
        local[0, k] += change
        L[:, k] = (modelled_force(problem, SearchPoint(point.theta, local), 0)[piece.comparable] - base) / change
    J /= piece.spread * np.sqrt(base.size)
    norms = np.linalg.norm(L, axis=0)
    L = L[:, norms > 0] / norms[norms > 0]
    if L.size:
        # what the record's own offset and state can take up tells nothing of the damper
        J -= L @ np.linalg.lstsq(L, J, rcond=1e-7)[0]
    return J


def _spread_by_level(piece: Piece, force: Array) -> Array:
    """The standard deviation (n,) N of the force at each sample's input: a misfit at 0 V is not that at 3 V.

    Inputs that a record passes for less than a twentieth of its time count as the nearest other one.
    """
    if not np.ndim(piece.u):
        return np.full(force.size, float(np.std(force)))
    u = np.round(np.asarray(piece.u), 3)
    levels, counts = np.unique(u, return_counts=True)
    levels = levels[counts >= LEVEL * u.size]
    if not levels.size:
        return np.full(force.size, float(np.std(force)))
    which = np.argmin(np.abs(u[:, None] - levels), axis=1)
    return np.array([float(np.std(force[which == k])) for k in range(levels.size)])[which]


def _weigh_noise(J: Array, spread: ModelDeviation, dt: float, relative: Array) -> Array:
    """J'CJ of noise with this standard deviation (n,) over the force's spread."""
    n = len(J)
    J = J * relative[:, None]
    rho = spread.correlation_at(dt, n)
    # C is a Toeplitz matrix: a product with it is a convolution, of twice the length or the ends would meet
    size = 1 << (2 * n - 1).bit_length()
    ring = np.zeros(size)
    ring[: rho.size] = rho
    ring[size - rho.size + 1 :] = rho[:0:-1]
    power = np.maximum(np.fft.rfft(ring).real, 0.0)
    F = np.fft.rfft(J, size, axis=0)
    weights = np.full(power.size, 2.0)  # a real transform holds each frequency but the first and the last once for two
    weights[[0, -1]] = 1.0
    out = (F.conj().T * (weights * power)) @ F
    return np.asarray(out.real / n / size)


def assumed_spread(plan: CoefficientLayout) -> ModelDeviation:
    """What is assumed before there are records: of the published campaign, see the numbers above."""
    linear = np.array([c.quantity.linear for c in plan.columns if c.size], dtype=float)
    D = GAIN**2 * np.outer(linear, linear) + DEVIATION**2 * np.eye(linear.size)
    lag = 0.01
    lags = lag * np.arange(int(MEMORY / lag) + 1)
    return ModelDeviation(plan.names, D, 0.0, RESIDUAL, np.exp(-lags / CORRELATED), lag)


def _fit_sizes(residuals: Array, spreads: Array) -> tuple[float, float]:
    """The constant and the proportional part of the residuals' standard deviations, neither below 0."""
    from scipy.optimize import nnls

    rows = np.column_stack((np.ones(spreads.size), spreads**2)) / (residuals**2)[:, None]
    squares, _ = nnls(rows, np.ones(spreads.size))
    return float(np.sqrt(squares[0])), float(np.sqrt(squares[1]))


def _autocorrelate(residuals: list[Array], lag: float) -> Array:
    """Of the residuals, each over its standard deviation, the mean over the records; tapered to 0 at the longest lag."""
    shortest = min(e.size for e in residuals)
    count = max(2, min(int(MEMORY / lag), shortest // 4))
    total = np.zeros(count)
    for residual in residuals:
        e = residual - residual.mean()
        size = 1 << (2 * e.size - 1).bit_length()
        c = np.fft.irfft(np.abs(np.fft.rfft(e, size)) ** 2, size)[:count]
        total += c / max(c[0], 1e-300)
    return np.asarray(total / len(residuals) * (1.0 - np.arange(count) / count))


def _estimate_deviations(records: list[Information], plan: CoefficientLayout, first: Array) -> Array:
    """D by expectation and maximisation over each record's score at the fit to all others.

    That is a record's own deviation less the error of the others' fit, whose covariance follows from the same D.
    """
    E, G = plan.owner, len(plan.theta)
    A, N = np.stack([i.A for i in records]), np.stack([i.noise for i in records])
    ridge = np.diag(np.where(plan.held, 1.0, RIDGE))
    total_A = A.sum(axis=0) + ridge
    B = np.linalg.inv(total_A)
    others = np.linalg.inv(total_A - A)
    scores = np.stack(
        [np.linalg.lstsq(np.eye(G) - a @ B, i.score, rcond=1e-9)[0] for a, i in zip(A, records, strict=True)]
    )
    D = first.copy()
    for _ in range(ROUNDS):
        M = A @ (E @ D @ E.T) @ A + N
        error = others @ (M.sum(axis=0) - M + ridge @ ridge) @ others
        moments = np.zeros_like(D)
        for a, m, x, u in zip(A, M, error, scores, strict=True):
            K = D @ E.T @ a @ np.linalg.pinv(m + a @ x @ a, rcond=1e-12, hermitian=True)
            mean = K @ u
            moments += np.outer(mean, mean) + D - K @ a @ E @ D
        D = moments / len(records)
    return np.asarray(0.5 * (D + D.T))


@dataclass(frozen=True, eq=False)
class Expected:
    """What a set of records is expected to give: the relative covariance (G, G) of the coefficients, the degrees of freedom
    (G,), and the half widths (G,) of 95 % intervals over the coefficients; infinite where fewer than three records say
    anything of a coefficient."""

    covariance: Array
    freedom: Array
    half: Array
    by_record: Array


def expected(
    plan: CoefficientLayout,
    records: Sequence[Information],
    spread: ModelDeviation,
    open_ends: bool = False,
    factors: Array | None = None,
) -> Expected:
    """The expected errors of a fit to these records, with ``open_ends`` finite where a fit would give none; ``factors`` (G,) of
    `calibration` multiply them."""
    G = len(plan.theta)
    free = ~plan.held
    A = np.stack([i.A for i in records]) if records else np.zeros((0, G, G))
    E = plan.owner
    D = E @ spread.deviations @ E.T
    M = A @ D @ A + (np.stack([i.noise for i in records]) if records else A)
    return expected_from(A, M, plan.is_linear & free, free, open_ends, factors)


def calibration(fit: Fit, plan: CoefficientLayout, present: Sequence[Information], spread: ModelDeviation) -> Array:
    """The factors (G,) by which the errors of a fit differ from what is expected of the same records.

    The errors are known to about one part in the root of twice their degrees of freedom, the model of how records differ to
    about a half; the logarithm of the ratio is shrunk accordingly.
    """
    now = expected(plan, present, spread, open_ends=True)
    factors = np.ones(len(plan.labels))
    for k, label in enumerate(plan.labels):
        error, value = fit.stderr.get(label, np.nan), plan.theta[k]
        if plan.held[k] or label in fit.within_records or not np.isfinite(error) or error <= 0.0:
            continue
        freedom = fit.freedom[label]
        ratio = error / abs(value) / np.sqrt(now.covariance[k, k])
        # a ratio of few degrees of freedom may be chance: its logarithm counts by their share beside 2, the model's own doubt
        factors[k] = ratio ** (freedom / (freedom + 2.0))
    return factors


def expected_from(
    A: Array, M: Array, linear: Any, free: Any, open_ends: bool, factors: Array | None = None
) -> Expected:
    """As `expected`, from A and M (n, G, G) of each record; ``linear`` and ``free`` (G,) say which a gain multiplies, and which
    are not held."""
    from scipy.special import stdtrit

    n, G = len(A), A.shape[1]
    ridge = np.where(free, RIDGE, 1.0)
    B = np.linalg.inv(A.sum(axis=0) + np.diag(ridge))
    by_record = np.einsum("ki,gij,kj->gk", B, M, B)
    freedom, inflation, counts = degrees_of_freedom(A, B, linear)
    prior = np.einsum("ki,i,ki->k", B, ridge**2, B)
    cov = B @ M.sum(axis=0) @ B + B @ np.diag(ridge**2) @ B
    grown = np.sqrt((inflation + 1.0) / inflation)  # the root of the sandwich's G/(G - 1), as in a fit
    cov = cov * np.outer(grown, grown)
    half = stdtrit(np.maximum(freedom, 1.0), 0.975) * np.sqrt(by_record.sum(axis=0) * grown**2 + prior)
    if factors is not None:
        half, cov = half * factors, cov * np.outer(factors, factors)
    half = np.where(free, half, np.nan)
    if not open_ends:
        half = np.where(free & (counts < MIN_RECORDS), np.inf, half)
    return Expected(cov, freedom, half, by_record * grown**2 if n else np.zeros((0, G)))


def degrees_of_freedom(A: Array, B: Array, linear: Any) -> tuple[Array, Array, Array]:
    """As in `dampyr.identification.parameter_uncertainty.uncertainty`: the degrees of freedom (G,) of the coefficients, the
    ones that inflate the covariance, and how many records inform each."""
    n, G = len(A), A.shape[1]
    if not n:
        return np.full(G, 0.5), np.full(G, 0.5), np.zeros(G)
    diagonals = np.diagonal(A, axis1=1, axis2=2)
    total = diagonals.sum(axis=0)
    shares = diagonals / np.where(total > 0.0, total, 1.0)
    effective = 1.0 / np.maximum(np.sum(shares**2, axis=0), 1e-100)
    by_shares = np.maximum(np.minimum(effective, n), 1.5) - 1.0
    by_gains = freedom_by_gains(A, B, np.where(linear, 1.0, 0.0), by_shares)
    return 0.5 * (by_shares + by_gains), by_shares, np.sum(shares > 1e-3, axis=0)
