r"""Levels of records and of measurement sessions: how much stronger or weaker a whole record is than the fit, and why.

The level of a record is the factor on the fitted dynamic force that its measured force is nearest to,
:math:`e^{y_r} = \sum (F - \bar F)(\hat F - \bar{\hat F}) / \sum (\hat F - \bar{\hat F})^2`. With the logarithms
:math:`\gamma_r = a_{s(r)} + b_r` of the true levels, :math:`a_s \sim N(0, \sigma_S^2)` of the session and :math:`b_r
\sim N(0, \sigma_R^2)` of the record, a fit takes up a part of them in its own coefficients, :math:`y = (I - H)\gamma`
with H known from the information of the records. Its independent contrasts :math:`z = V^T\gamma` have the variance
:math:`\sigma_R^2 I + \sigma_S^2 V^T Z Z^T V`, Z saying which record belongs to which session: restricted maximum
likelihood (Patterson and Thompson 1971). The two variances have a posterior on a grid, with a prior on the sessions'
that is worth two of them (`PRIOR_FREEDOM`), of which the mean precision and its spread are kept as a scaled inverse
chi-square distribution.

A level that drifts with the energy which a record dissipates (`drift_estimate`) is taken out of :math:`y_r` first.

Where no input was measured in two sessions, the level of a session is that of the damper at its input, and nothing in
the records tells the two apart: :math:`\sigma_S` is then *stated* (`PRIOR_SESSION` unless the fit is told another one),
and every fit says so.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field

import numpy as np
from numpy.typing import NDArray

from dampyr.identification.parameter_uncertainty.drift_estimate import RecordRest, estimate_drift
from dampyr.identification.parameter_uncertainty.uncertainty import Uncertainty, record_groups
from dampyr.identification.search.optimum import Optimum
from dampyr.identification.search.problem import Problem
from dampyr.input_kinds import INPUTS, at_input, input_text
from dampyr.models.level_drift import LevelDrift
from dampyr.models.prediction_error import PredictionError, ShapeError, assumed_words, phase_basis, spread_words
from dampyr.phrases import counted, listing, percent
from dampyr.records import Record
from dampyr.shown import Shown

Array = NDArray[np.float64]
# further records of the published campaign's rig, of another session, have a level of 0 to 11 % by the model that looks, which
# these records do not tell apart from stroke: 8 % is a statement, not a measurement
PRIOR_SESSION = 0.08
PRIOR_FREEDOM = 2.0  # what the prior of the sessions' spread is worth where sessions repeat: two sessions
PRIOR_RECORD = 0.05  # of single records at each input, which cannot tell: as the fit's prior of gains
SEEN = 0.05  # singular value of I - H below which a contrast of levels is rounding
GRID = 80  # values of each standard deviation
SPAN = (1e-3, 1.0)  # of the standard deviation between sessions on the grid
NOTHING = 1e-3  # of the measured force: a model below it does not describe the record
# A false sample stands out of the median of five, and slow noise or a corner of the loop does not.
FALSE = 12.0  # medians of how far samples are from that, eight standard deviations of white noise: a false sample is none of it
STANDS_OUT = 6.0  # medians of the whole residual, four standard deviations: corners of the loop stand out by less
MIN_GROUP = 3  # records at an input, for a shape error of its own


@dataclass(frozen=True, repr=False)
class Levels(Shown):
    """The levels of the fitted records, and what they say of records and sessions to come.

    ``level`` holds each record's factor on the fitted force (1.03: 3 % stronger), ``session`` the session of each: its name, or
    what stands for it. ``record_sd`` and ``session_sd`` are standard deviations of the logarithm; ``repeated`` says whether the
    records tell the second. ``session_reml`` is the estimate of restricted likelihood alone, NaN without. ``words`` are
    for people.
    """

    level: Mapping[str, float]
    session: Mapping[str, str]
    record_sd: float
    record_freedom: float
    session_sd: float
    session_freedom: float
    session_reml: float
    repeated: bool
    named: bool
    words: str
    settles: str
    drift: LevelDrift | None = None
    """How the level goes with the energy that a record dissipates, None where it does not."""
    by_session: Array = field(repr=False, default_factory=lambda: np.zeros((0, 0)))
    """The change (S, G) of each fitted number with the logarithm of the level of each session."""

    @property
    def sessions(self) -> tuple[str, ...]:
        """The sessions in the order in which they occur."""
        return tuple(dict.fromkeys(self.session.values()))

    @property
    def spread_words(self) -> str:
        """How much the level differs between sessions, and whether it is estimated or stated."""
        return spread_words(self.session_sd, self.repeated)

    def reach_between_sessions(self, number: int, error: float, freedom: float, level: float) -> float:
        r"""Half of the interval of a fitted number between sessions, from its standard error between records.

        .. math:: \sqrt{(t_\nu\, s)^2 + (t_S\, s_S)^2}

        of both parts, Student's t each: the half widths of the two, and not their variances, are added in squares (variance
        estimates recovered from intervals). It is never less than that of the records alone, as it could come out where
        the sum's degrees of freedom (Satterthwaite) are more than theirs.
        """
        from scipy.stats import t

        moved = self.session_sd * float(np.linalg.norm(self.by_session[:, number]))
        quantile_of_error, quantile_of_sessions = t.ppf(0.5 + 0.5 * level, [freedom, self.session_freedom])
        return math.hypot(quantile_of_error * error, quantile_of_sessions * moved)


def estimate_levels(
    optimum: Optimum, uncertainty: Uncertainty, records: Sequence[Record], session_prior: float = PRIOR_SESSION
) -> tuple[Levels, PredictionError]:
    """The levels of the fitted records, and the prediction error that goes into the card."""
    problem, to_laws = optimum.problem, optimum.law_matrix
    groups = record_groups(problem)
    fitted = [_Level.of(optimum, pieces) for pieces in groups.values()]
    session, named = _name_sessions(problem, records, groups)
    gains = [optimum.point.nuisance(problem, pieces[0], "gain") for pieces in groups.values()]
    y = np.array([record_level.logarithm for record_level in fitted]) + np.log(gains)
    names = list(dict.fromkeys(session.values()))
    members = np.array([[session[name] == session_name for session_name in names] for name in groups], dtype=float)
    repeats = _list_repeats(problem, groups, session) if named else {}
    shown = np.eye(len(y)) - uncertainty.absorbed
    found = estimate_drift([record_level.rest for record_level in fitted])
    drift, by_energy = (None, np.zeros(len(y))) if found is None else (found[0], found[0].rate * found[1])
    y_cold = y - shown @ by_energy  # a record that dissipates more is weaker in the mean, which is no spread of records
    spread = _estimate_spread(y_cold, shown, members, bool(repeats), session_prior)
    text, settles = _describe(problem, groups, session, named, repeats, spread, session_prior)
    levels = Levels(
        level=dict(zip(groups, map(float, np.exp(y)), strict=True)),
        session=session,
        **asdict(spread),
        repeated=bool(repeats),
        named=named,
        words=text,
        settles=settles,
        drift=drift,
        by_session=members.T @ uncertainty.by_level,
    )
    counts = members.sum(axis=0)
    shrinkage = spread.session_sd**2 / np.maximum(spread.session_sd**2 + spread.record_sd**2 / counts, 1e-300)
    variances = np.diag(uncertainty.covariance)
    determined = np.isfinite(variances) & (variances > 0.0)
    error = PredictionError(
        record_sd=spread.record_sd,
        record_freedom=spread.record_freedom,
        session_sd=spread.session_sd,
        session_freedom=spread.session_freedom,
        session_source=text,
        freedom=float(np.median(uncertainty.freedom[determined])) if determined.any() else math.inf,
        sessions=tuple(names),
        directions=members.T @ uncertainty.by_level @ to_laws.T,
        session_levels=tuple(map(float, shrinkage * (members.T @ y_cold) / counts)),
        session_errors=tuple(map(float, spread.record_sd * np.sqrt(shrinkage / counts))),
        shapes=_average_shapes(
            fitted, np.zeros(len(y)) if drift is None else uncertainty.absorbed @ by_energy / drift.rate
        ),
        drift=drift,
        within_sessions=_take_out_sessions(uncertainty, members, shrinkage * (members.T @ y_cold) / counts, to_laws)
        if repeats
        else None,
    )
    return levels, error


def _take_out_sessions(uncertainty: Uncertainty, members: Array, levels: Array, to_laws: Array) -> Array | None:
    """The covariance (m, m) of the laws' coefficients without what the levels of the sessions have added between records.

    Each record's influence less that of its session's level; None where a coefficient has no finite variance.
    """
    covariance = uncertainty.covariance
    if not np.all(np.isfinite(covariance)):
        return None
    left = uncertainty.influence - (members @ levels)[:, None] * uncertainty.by_level
    whole = covariance - uncertainty.influence.T @ uncertainty.influence + left.T @ left
    values, vectors = np.linalg.eigh(0.5 * (whole + whole.T))
    positive = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return np.asarray(to_laws @ positive @ to_laws.T)


@dataclass(frozen=True)
class _Level:
    """One record against the fit: the logarithm of its level, and its residual over the standard deviation of the fit."""

    input: float
    logarithm: float
    shape: Array
    covariances: Array  # of what is left at lags of 0, 1 and 2 samples
    rest: RecordRest

    @classmethod
    def of(cls, optimum: Optimum, pieces: Sequence[int]) -> _Level:
        problem, forces = optimum.problem, optimum.forces
        measured, model, bases, power = [], [], [], []
        for k in pieces:
            piece, seen = problem.pieces[k], problem.pieces[k].comparable
            measured.append(piece.force[seen] - np.mean(piece.force[seen]))
            model.append(forces[k][seen] - np.mean(forces[k][seen]))
            power.append(measured[-1] * piece.v[seen])
            bases.append(phase_basis(piece.t[seen], piece.x[seen], piece.v[seen]))
        F, M, basis, dissipated = (_join(arrays) for arrays in (measured, model, bases, power))
        true, chosen = np.ones(F.size, dtype=bool), (F, M, basis)
        for turn in range(2):  # of all samples, then without the false ones
            if turn:
                chosen = F[true], M[true], basis[true]
            count, square = chosen[1].size, float(chosen[1] @ chosen[1])
            level = float(chosen[0] @ chosen[1]) / square if square > 0.0 else 1.0
            if level <= 0.0:  # a record that the fit describes upside down: its level is no factor
                level = 1.0
            # A fit may give nothing where its records contradict one another: its error is then that of the measured force.
            least = NOTHING * math.sqrt(float(chosen[0] @ chosen[0]) / count)
            scale = max(math.sqrt(square / count), least, 1e-300)
            residual = (F - level * M) / (level * scale)
            shape = _least_squares(chosen[2], residual[true] if turn else residual)
            rest = residual - basis @ shape
            away = np.abs(rest - _median_of_five(rest))
            true = away <= max(FALSE * float(np.median(away)), STANDS_OUT * float(np.median(np.abs(rest))))
            if np.all(true):
                break
        lags = np.array([_covariance(rest, true, lag) for lag in range(3)])
        first_piece = problem.pieces[pieces[0]]
        u = float(np.mean([np.mean(problem.pieces[k].u) for k in pieces]))
        dt = float(np.median(np.diff(first_piece.t)))
        return cls(u, math.log(level), shape, lags, RecordRest(F, M, basis, dissipated, true, dt))


def _join(arrays: Sequence[Array]) -> Array:
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)


def _covariance(rest: Array, true: NDArray[np.bool_], lag: int) -> float:
    """The mean product of the rest (n,) with itself ``lag`` samples later, of the pairs that have no false sample."""
    both = true[lag:] & true[: rest.size - lag]
    return float(np.where(both, rest[lag:], 0.0) @ rest[: rest.size - lag]) / max(int(np.count_nonzero(both)), 1)


def _least_squares(basis: Array, values: Array) -> Array:
    """The coefficients (k,) of few functions (n, k) of about the same size, the smallest where they are not unique.

    The normal equations of so few are a hundredth of the work of the singular values of all samples, and good to 1e-10.
    """
    return np.asarray(np.linalg.lstsq(basis.T @ basis, basis.T @ values, rcond=None)[0], dtype=float)


def _median_of_five(values: Array) -> Array:
    """The median (n,) of each sample and two on either side, reflected at the ends, as `scipy.ndimage.median_filter` has it."""
    padded = np.pad(values, 2, mode="symmetric")
    a, b, c, d, e = (padded[k : k + values.size] for k in range(5))
    low = np.maximum(np.minimum(a, b), np.minimum(c, d))
    high = np.minimum(np.maximum(a, b), np.maximum(c, d))
    return np.asarray(np.maximum(np.minimum(e, low), np.minimum(np.maximum(e, low), high)))


def _average_shapes(fitted: Sequence[_Level], energies: Array) -> tuple[ShapeError, ...]:
    """The residual by input; where fewer than three records are at one, its spread is that of all about their inputs' means.

    ``energies`` (n,) are those within the damper, in J, at which the fitted force of each record stands.
    """
    by_input: dict[float, list[_Level]] = {}
    stands_at: dict[float, list[float]] = {}
    for record_level, energy in zip(fitted, energies, strict=True):
        by_input.setdefault(round(record_level.input, 6), []).append(record_level)
        stands_at.setdefault(round(record_level.input, 6), []).append(float(energy))
    about = [
        record_level.shape - np.mean([level.shape for level in at_input], axis=0)
        for at_input in by_input.values()
        for record_level in at_input
    ]
    freedom = len(fitted) - len(by_input)
    pooled = (
        np.sqrt(np.sum(np.square(about), axis=0) / freedom) if freedom else np.std([f.shape for f in fitted], axis=0)
    )
    shape_errors = []
    for u in sorted(by_input):
        at_input = by_input[u]
        shapes = np.array([record_level.shape for record_level in at_input])
        spread = np.std(shapes, axis=0, ddof=1) if len(at_input) >= MIN_GROUP else pooled
        noise, time, white = _split_noise(at_input)
        mean, energy = tuple(shapes.mean(axis=0)), float(np.mean(stands_at[u]))
        shape_errors.append(ShapeError(u, mean, tuple(spread), noise, time, white, len(at_input), energy))
    return tuple(shape_errors)


def _split_noise(at_input: Sequence[_Level]) -> tuple[float, float, float]:
    """The correlated noise, its time in s and the white noise whose covariances are those of the rest at 0, 1 and 2 samples."""
    c0, c1, c2 = np.mean([record_level.covariances for record_level in at_input], axis=0)
    dt = float(np.median([record_level.rest.dt for record_level in at_input]))
    if not (c1 > 0.0 and 0.0 < c2 < c1):
        return 0.0, 0.0, math.sqrt(max(float(c0), 0.0))
    # the correlated part falls by the same factor from lag to lag, so c1^2/c2 is what it has at lag 0; white noise is the rest
    correlated = min(float(c1**2 / c2), float(c0))
    return math.sqrt(correlated), -dt / math.log(float(c2 / c1)), math.sqrt(max(float(c0) - correlated, 0.0))


def _name_sessions(
    problem: Problem, records: Sequence[Record], groups: Mapping[str, Sequence[int]]
) -> tuple[dict[str, str], bool]:
    """The session of each record; where the records name none, each input counts as one."""
    by_piece = [record.measurement_session for record in records]
    named = all(by_piece)
    sessions = {}
    for name, pieces in groups.items():
        u = float(np.mean([np.mean(problem.pieces[k].u) for k in pieces]))
        stated = by_piece[pieces[0]]
        at = input_text(u, problem.pieces[pieces[0]].unit)
        sessions[name] = stated if named and stated else f"{at}{', ' * bool(at)}session not stated"
    return sessions, named


def _list_repeats(
    problem: Problem, groups: Mapping[str, Sequence[int]], session: Mapping[str, str]
) -> dict[float, list[str]]:
    """The inputs that were measured in two sessions or more, with these."""
    spans = {
        name: (_lowest_input(problem, pieces), max(float(np.max(problem.pieces[k].u)) for k in pieces))
        for name, pieces in groups.items()
    }
    inputs = sorted({round(end, 6) for span in spans.values() for end in span})
    at = {
        u: list(dict.fromkeys(session[name] for name, (low, high) in spans.items() if low - 1e-6 <= u <= high + 1e-6))
        for u in inputs
    }
    return {u: sessions for u, sessions in at.items() if len(sessions) > 1}


def _lowest_input(problem: Problem, pieces: Sequence[int]) -> float:
    return min(float(np.min(problem.pieces[k].u)) for k in pieces)


@dataclass(frozen=True)
class LevelSpread:
    """Standard deviations of the logarithms of levels, and their degrees of freedom, infinite where they are stated."""

    record_sd: float
    record_freedom: float
    session_sd: float
    session_freedom: float
    session_reml: float


def _estimate_spread(y: Array, shown: Array, members: Array, repeated: bool, prior: float) -> LevelSpread:
    """The spread of records and of sessions from the levels ``y`` (n,), of which a fit shows (I - H): ``shown``."""
    left, values, right = np.linalg.svd(shown)
    seen = values > SEEN
    z = (left.T @ y)[seen] / values[seen]
    V = right[seen]
    stated = prior, math.inf, math.nan
    if z.size == 0:
        return LevelSpread(PRIOR_RECORD, math.inf, *stated)
    # rotated, the contrasts are independent: each has the records' variance and so many times that of the sessions
    strength, turned = np.linalg.eigh(V @ members @ members.T @ V.T)
    w = turned.T @ z
    strength = np.where(strength > SEEN, strength, 0.0)
    within = strength == 0.0
    if not repeated or within.all() or prior == 0.0:
        return LevelSpread(float(np.sqrt(np.mean(z**2))), float(z.size), *stated)
    return _integrate_posterior(w, strength, prior)


def _integrate_posterior(w: Array, strength: Array, prior: float) -> LevelSpread:
    """The posterior of both standard deviations on a grid, as scaled inverse chi-square distributions."""
    size = max(float(np.sqrt(np.mean(w**2))), 1e-4)
    record, session = np.geomspace(0.05 * size, 5.0 * size, GRID), np.geomspace(*SPAN, GRID)
    variance = record[:, None, None] ** 2 + session[None, :, None] ** 2 * strength
    likelihood = -0.5 * np.sum(np.log(variance) + w**2 / variance, axis=-1)
    best = np.unravel_index(int(np.argmax(likelihood)), likelihood.shape)
    at_zero = -0.5 * np.sum(np.log(record[:, None] ** 2) + w**2 / record[:, None] ** 2, axis=-1)
    # the grid has no 0: where the records alone explain the levels as well, the estimate is 0 and not the grid's end
    reml = 0.0 if at_zero.max() >= likelihood[best] - 1e-3 else float(session[best[1]])
    log_prior = -PRIOR_FREEDOM * np.log(session) - 0.5 * PRIOR_FREEDOM * prior**2 / session**2
    weight = np.exp(likelihood + log_prior - (likelihood + log_prior).max())
    of_records = _fit_inverse_chi_square(record, weight.sum(axis=1))
    return LevelSpread(*of_records, *_fit_inverse_chi_square(session, weight.sum(axis=0)), reml)


def _fit_inverse_chi_square(values: Array, weight: Array) -> tuple[float, float]:
    """The scale and the degrees of freedom of the distribution whose precision has this mean and this spread."""
    share = weight / weight.sum()
    # the precision of a scaled inverse chi-square has the mean 1/s^2 and the variance 2/(nu s^4)
    mean = float(share @ values**-2.0)
    variance = float(share @ (values**-2.0 - mean) ** 2)
    return 1.0 / math.sqrt(mean), max(2.0 * mean**2 / max(variance, 1e-300), 1.0)


def _describe(
    problem: Problem,
    groups: Mapping[str, Sequence[int]],
    session: Mapping[str, str],
    named: bool,
    repeats: Mapping[float, Sequence[str]],
    spread: LevelSpread,
    prior: float,
) -> tuple[str, str]:
    """What is known of the level between sessions, and the test that would settle it."""
    unit = problem.pieces[0].unit
    if repeats:
        where = f" at {listing([f'{u:g}' for u in repeats], 4)} {unit}" if unit in INPUTS else ""
        count = len(set(session.values()))
        return (
            f"the level of sessions differs by {percent(spread.session_sd)} (standard deviation), estimated from "
            f"{counted(count, 'session')} that were repeated{where}",
            "",
        )
    inputs = {name: round(_lowest_input(problem, pieces), 6) for name, pieces in groups.items()}
    word = INPUTS.get(unit)
    if not named and word is None:
        why = "the records do not say in which measurement session they were made, so nothing shows how another one differs"
    elif not named:
        why = f"the records do not say in which measurement session they were made, so level and {word} cannot be told apart"
    elif len(set(session.values())) == 1:
        why = "all records are of one measurement session, so nothing shows how another one differs"
    else:
        why = f"no {word} was measured in two sessions, so the level of a session and the {word} cannot be told apart"
    name = min(inputs, key=lambda record: abs(inputs[record] - float(np.median(list(inputs.values())))))
    settles = f"repeat one test, such as {name}{at_input(inputs[name], unit, 'g')}, in every session"
    if not named:
        settles += ", and state the session of each record (measurement_session)"
    return assumed_words(why, prior), settles
