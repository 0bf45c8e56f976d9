r"""How far a measured force may be from what a damper predicts: parameters, level of the session and of the record, residual.

A record r of the measurement session s has the force

.. math:: F = f + e^{a_s + b_r}\,\hat F(x, v; \theta) + d\,(h_r(\varphi) + \eta), \qquad
          a_s \sim N(0, \sigma_S^2), \quad b_r \sim N(0, \sigma_R^2)

with the offset f, the *level* :math:`e^{a_s + b_r}`, a factor on the whole dynamic force, the standard deviation d of the
predicted force along the record, a *shape error* h that repeats with the phase of the motion, and correlated noise
:math:`\eta`. The phase is :math:`\varphi = \operatorname{atan2}(v/V, x/X)` with the amplitudes X and V of displacement and
velocity, and :math:`h = \rho \sum_{k=1}^{5} (\alpha_k \cos k\varphi + \beta_k \sin k\varphi)` with the radius
:math:`\rho = \sqrt{(x/X)^2 + (v/V)^2}`, so that small reversals have small errors. The noise is an autoregressive one of first
order plus a white one.

Each session s that was fitted has moved the coefficients by :math:`a_s` times its direction, the change of the
coefficients with the logarithm of that session's level. Nobody can tell that from the damper itself where an input was
measured in one session only: a prediction has the difference of two sessions' levels in it.

A draw takes all of these: coefficients from their covariance and from the sessions' levels, the level of the record to
come, its shape error and its noise. `dampyr.identification.parameter_uncertainty.levels` estimates the numbers.

A change :math:`\delta` that is drawn for a parameter p goes towards a limit of its allowed values as far as it can,

.. math:: p + \frac{\delta}{\sqrt{1 + (\delta/d)^2}}

with the distance d to the limit on the side of the change: all of :math:`\delta` where there is none, and all but its third
order where it is small. So every finite covariance gives draws, each of them allowed, and their medians are the fitted values
(docs/decisions/0043-draws-inside-the-allowed-values.md). For a polynomial this is done to its values at as many points of its
range as it has coefficients; where it leaves the allowed values between them, its change is halved until it does not.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrWarning, InputError
from dampyr.models.laws import Polynomial, WithTemperature
from dampyr.models.level_drift import LevelDrift
from dampyr.phrases import percent

Array = NDArray[np.float64]
HARMONICS = 5  # of the phase: a loop's corners need three or more; higher ones count as noise
AMPLITUDE_QUANTILE = 0.995  # of |x| and |v|: one false sample sets no amplitude
# Of a polynomial's values, which its powers give back to rounding only: as near as it comes to a limit.
CLEARANCE = 1e-12
HALVINGS = 50  # of a polynomial's change: the last is its rounding


def check_level(level: float, name: str = "level") -> None:
    """:class:`~dampyr.errors.InputError` unless ``level`` is a share between 0 and 1."""
    if not 0.0 < level < 1.0:
        raise InputError(f"{name} = {level:g} is not allowed; it must lie between 0 and 1, such as 0.9 for 90 %")


@dataclass(frozen=True)
class ShapeError:
    """The residual of the records at one input, over the standard deviation of the predicted force.

    ``shape_mean`` and ``shape_sd`` (10,): cosines and sines of the first to the fifth harmonic of the phase, in pairs.
    ``noise`` is the standard deviation of the correlated noise, ``noise_time`` its correlation time in s, ``white`` that of
    the white one, which is of the sensor: it is in what a sample may be and not in what the damper's peak is. False samples
    are in neither. ``records`` is how many it rests on.
    """

    input: float
    shape_mean: tuple[float, ...]
    shape_sd: tuple[float, ...]
    noise: float
    noise_time: float
    white: float
    records: int
    energy: float = 0.0

    def __post_init__(self) -> None:
        for name in ("shape_mean", "shape_sd"):
            values = tuple(map(float, getattr(self, name)))
            if len(values) != 2 * HARMONICS or not all(map(math.isfinite, values)):
                raise InputError(f"{name} must hold {2 * HARMONICS} finite numbers, not {list(values)}")
            object.__setattr__(self, name, values)
        for name in ("noise", "noise_time", "white"):
            value = float(getattr(self, name))
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(f"{name} = {value:g} is not allowed; it must be finite and at least 0")


@dataclass(frozen=True, eq=False)
class PredictionError:
    """What a prediction of a record may be off by, besides the covariance of the damper's coefficients.

    ``record_sd`` and ``session_sd`` are standard deviations of the logarithm of the level (0.08 is 8 %), between records of one
    session and between sessions, with their degrees of freedom, infinite where the number is stated and not estimated;
    ``session_source`` says which. ``sessions`` are those that were fitted, ``directions`` (S, m) the change of the damper's
    coefficients with the logarithm of each one's level, ``session_levels`` their levels' logarithms against the fit and
    ``session_errors`` how well these are known. ``freedom`` are the degrees of freedom of the covariance;
    ``within_sessions`` (m, m) is the covariance that is left of it once the levels of the fitted sessions have been
    taken out of its records, None where it is the same. Without ``sessions`` no level of theirs is in the coefficients but by
    their covariance, as where that is one between specimens. ``shapes`` are the residuals by input. ``drift`` is that of the
    level with the energy which a record dissipates, None where the records show none.
    """

    record_sd: float
    record_freedom: float
    session_sd: float
    session_freedom: float
    session_source: str
    freedom: float
    sessions: tuple[str, ...]
    directions: Array
    session_levels: tuple[float, ...]
    session_errors: tuple[float, ...]
    shapes: tuple[ShapeError, ...]
    within_sessions: Array | None = None
    drift: LevelDrift | None = None

    def __post_init__(self) -> None:
        for name in ("record", "session"):
            value = float(getattr(self, f"{name}_sd"))
            stated = math.isinf(getattr(self, f"{name}_freedom"))
            # an estimate of a logarithm may be beyond 1, as where the force of one record is in another unit
            if not (math.isfinite(value) and value >= 0.0 and (value <= 1.0 or not stated)):
                limits = "lie between 0 and 1" if stated else "be finite and at least 0"
                raise InputError(f"{name}_sd = {value:g} is not allowed; it must {limits} (0.08 is 8 %)")
        for name in ("record_freedom", "session_freedom", "freedom"):
            if not float(getattr(self, name)) > 0.0:
                raise InputError(f"{name} = {getattr(self, name):g} is not allowed; it must be greater than 0, or inf")
        count = len(self.sessions)
        directions = np.array(self.directions, dtype=float)
        directions = np.atleast_2d(directions) if count else directions.reshape(0, directions.shape[-1])
        if not self.shapes or directions.shape[0] != count or not np.all(np.isfinite(directions)):
            raise InputError(
                f"a prediction error needs one row of finite directions for each of its {count} sessions and one shape or more"
            )
        if len(self.session_levels) != count or len(self.session_errors) != count:
            raise InputError(f"session_levels and session_errors must hold {count} numbers, one for each session")
        if self.within_sessions is not None:
            matrix = np.array(self.within_sessions, dtype=float)
            if matrix.shape != (directions.shape[1],) * 2 or not np.all(np.isfinite(matrix)):
                raise InputError(
                    f"within_sessions must be a finite matrix of {directions.shape[1]} rows and columns, as directions has"
                )
            matrix.setflags(write=False)
            object.__setattr__(self, "within_sessions", matrix)
        directions.setflags(write=False)
        object.__setattr__(self, "directions", directions)
        object.__setattr__(self, "sessions", tuple(self.sessions))

    @property
    def session_estimated(self) -> bool:
        """Whether the level between sessions was estimated, and not stated."""
        return math.isfinite(self.session_freedom)

    def mapped(self, matrix: Array) -> PredictionError:
        """The same for a damper whose coefficients are ``matrix`` (k, m) times these."""
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        within = None if self.within_sessions is None else matrix @ self.within_sessions @ matrix.T
        return PredictionError(**(values | {"directions": self.directions @ matrix.T, "within_sessions": within}))

    def shape_at(self, u: float) -> ShapeError:
        """The residual at the input that is nearest to ``u``."""
        return min(self.shapes, key=lambda shape: abs(shape.input - u))

    def card(self) -> dict[str, Any]:
        """The table of a card."""
        table = {item.name: getattr(self, item.name) for item in fields(self) if getattr(self, item.name) is not None}
        if self.within_sessions is not None:
            table["within_sessions"] = self.within_sessions.tolist()
        if self.drift is not None:
            table["drift"] = self.drift.card()
        table["directions"] = self.directions.tolist()
        for name in ("sessions", "session_levels", "session_errors"):
            table[name] = list(table[name])
        table["shapes"] = [
            {
                key: list(value) if isinstance(value, tuple) else value
                for key, value in asdict(item).items()
                if key != "energy" or self.drift is not None
            }
            for item in self.shapes
        ]
        return table


def from_card(table: Mapping[str, Any], coefficients: int) -> PredictionError:
    """The prediction error of a card's table; :class:`~dampyr.errors.InputError` names what is wrong with it."""
    allowed = [item.name for item in fields(PredictionError)]
    for name in table:
        if name not in allowed:
            raise InputError(f"prediction_error has {name!r}, which is unknown; it holds {', '.join(allowed)}")
    missing = [name for name in allowed if name not in table and name not in ("within_sessions", "drift")]
    if missing:
        raise InputError(f"prediction_error lacks {missing[0]!r}; add it, or leave the table out")
    try:
        shapes = tuple(ShapeError(**item) for item in table["shapes"])
        directions = np.array(table["directions"]) if table["sessions"] else np.zeros((0, coefficients))
        drift = LevelDrift(**table["drift"]) if "drift" in table else None
        error = PredictionError(**(dict(table) | {"shapes": shapes, "directions": directions, "drift": drift}))
    except (TypeError, ValueError) as problem:
        raise InputError(f"prediction_error: {problem}") from None
    if error.directions.shape[1] != coefficients:
        raise InputError(
            f"prediction_error.directions has {error.directions.shape[1]} columns; the laws have {coefficients} coefficients"
        )
    return error


def spread_words(session_sd: float, estimated: bool) -> str:
    """A standard deviation of the level between sessions, and whether the records have it."""
    return f"{percent(session_sd)} ({'estimated' if estimated else 'stated, not measured'})"


def session_words(error: PredictionError) -> str:
    """How much sessions and records differ."""
    between = spread_words(error.session_sd, error.session_estimated)
    return f"levels of sessions differ by {between}, of records by {percent(error.record_sd)}"


def prior_words(error: PredictionError) -> str:
    """On what level between sessions a band rests, beside what it holds; empty where the spread of specimens has it in it."""
    if error.session_estimated:
        return f"with an estimated level of {percent(error.session_sd)} between sessions"
    if not error.sessions and error.session_sd == 0.0:
        return ""
    return f"with a stated prior of {percent(error.session_sd)} between sessions"


def assumed_words(why: str, prior: float) -> str:
    """Why the level between sessions is not known, and what is assumed in its place."""
    return f"{why}; {percent(prior)} (standard deviation) is assumed between sessions"


def check_prior(session_prior: float) -> None:
    """:class:`~dampyr.errors.InputError` unless it is a standard deviation of a logarithm, from 0 to 1."""
    if not (math.isfinite(session_prior) and 0.0 <= session_prior <= 1.0):
        raise InputError(
            f"session_prior = {session_prior:g} is not allowed; it is a standard deviation from 0 to 1, such as 0.08 for 8 %"
        )


def with_session_prior(error: PredictionError, prior: float) -> PredictionError:
    r"""The prediction error with another stated standard deviation :math:`\sigma_S'` of the level between sessions.

    The level of a fitted session is its records' mean level times the share :math:`w = \sigma_S^2 / (\sigma_S^2 + q)`, with the
    variance q of that mean, and has the standard error :math:`e = \sigma_S \sqrt{1 - w}`; so :math:`w = 1 - e^2/\sigma_S^2` and
    :math:`q = e^2/w`, from which both follow anew. It is what a fit with this prior gives. Raises
    :class:`~dampyr.errors.InputError` where the level is estimated, or is that of specimens, and for a card whose prior is 0,
    which does not tell q.
    """
    check_prior(prior)
    if error.session_estimated:
        raise InputError(
            "the level between sessions was estimated from sessions that repeat a test, so no prior is assumed; leave "
            "session_prior out, or identify again with it"
        )
    if not error.sessions:
        raise InputError(
            "the spread of this damper is one of specimens; state session_prior where these are identified"
        )
    if error.session_sd == 0.0 and prior > 0.0:
        raise InputError("the card was identified with a session_prior of 0, which cannot be undone; identify again")
    errors, levels = np.array(error.session_errors), np.array(error.session_levels)
    share = 1.0 - np.square(errors / error.session_sd) if error.session_sd else np.zeros(len(levels))
    q = np.square(errors) / np.where(share > 0.0, share, 1.0)
    new = prior**2 / np.maximum(prior**2 + q, 1e-300)
    return replace(
        error,
        session_sd=prior,
        session_source=assumed_words(error.session_source.rpartition("; ")[0], prior),
        session_levels=tuple(map(float, levels * np.divide(new, share, out=np.zeros_like(new), where=share > 0.0))),
        session_errors=tuple(map(float, prior * np.sqrt(1.0 - new))),
    )


def force_power(unit: str) -> int:
    """By which power of a factor on all forces a parameter in ``unit`` changes: 1 for N, N s/m or kg, -1 for m/N."""
    numerator, _, denominator = unit.partition("/")
    return sum(
        sign * sum(word.rstrip("0123456789^") in ("N", "kg") for word in part.split())
        for sign, part in ((1, numerator), (-1, denominator))
    )


def at_level(damper: Any, level: float) -> Any:
    """The damper with ``level`` times the dynamic force."""
    if not (math.isfinite(level) and level > 0.0):
        raise InputError(f"level = {level:g} is not allowed; it must be greater than 0, 1 being the fitted one")
    quantities, static = damper.composition.quantities.values(), damper.composition.static
    powers = [0 if k in static else force_power(quantity.unit) for k, quantity in enumerate(quantities)]
    sizes = [len(law.coefficients) for law in damper.all_laws.values()]
    return damper.with_coefficients(damper.coefficients * np.repeat([level**power for power in powers], sizes))


def square_root(covariance: Array) -> Array:
    """The matrix A (m, m) of which A A' is the covariance, from the correlations: the rounding of one variance, in 1/m^2,
    may be more than all of another, in m^2/N^2."""
    scale = np.sqrt(np.diag(covariance))
    scale = np.where(scale > 0.0, scale, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return np.asarray(scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))


def moved(damper: Any, change: Array) -> Any:
    """The damper with its coefficients changed by ``change`` (m,), as far as the allowed values let them."""
    laws, quantities = damper.all_laws.values(), damper.composition.quantities.values()
    ends = np.cumsum([len(law.coefficients) for law in laws])[:-1]
    return damper.with_coefficients(
        np.concatenate(
            [
                _move_law(law, part, quantity.low, quantity.high)
                for law, part, quantity in zip(laws, np.split(change, ends), quantities, strict=True)
            ]
        )
    )


def _move_law(law: Any, change: Array, low: float, high: float) -> Array:
    """The coefficients of a law after their change, its values between ``low`` and ``high``."""
    if isinstance(law, WithTemperature):
        halves = zip((law.cold, law.warm), np.split(change, 2), strict=True)
        return np.concatenate([_move_law(half, part, low, high) for half, part in halves])
    before = np.array(law.coefficients)
    if not isinstance(law, Polynomial):
        return _move_inside(before, change, low, high)
    # by its values at points that crowd at the ends, where a polynomial is bounded by them and its powers are well conditioned
    width = (law.high - law.low) or 1.0
    points = law.low + 0.5 * width * (1.0 - np.cos(np.linspace(0.0, math.pi, before.size)))
    powers = np.vander(points, increasing=True)
    values, change = powers @ before, powers @ change
    clear = CLEARANCE * float(np.abs([values, change]).max())
    step = np.linalg.solve(powers, _move_inside(values, change, low + clear, high - clear) - values)
    for _ in range(HALVINGS):
        smallest, largest = law.with_coefficients(before + step).extremes()
        if low < smallest and largest <= high:
            return np.asarray(before + step)
        step = 0.5 * step
    return before  # it stands at its limit where the change would take it beyond


def _move_inside(values: Array, change: Array, low: float, high: float) -> Array:
    """The values after their change towards a limit, by what is left to it: the difference would lose the digits of that."""
    limit = np.where(change < 0.0, low, high)
    distance = np.abs(limit - values)
    with np.errstate(divide="ignore", invalid="ignore"):
        r = np.where(distance > 0.0, np.abs(change) / distance, math.inf)
        h = np.hypot(1.0, r)
        left = np.where(distance > 0.0, distance / (h * (h + r)), 0.0)
        return np.where(np.isinf(distance), values + change, np.where(change < 0.0, limit + left, limit - left))


@dataclass(frozen=True)
class Draw:
    """One draw: the damper's coefficients, and the level of the record to come."""

    damper: Any
    level: float


def draws_of(
    damper: Any, error: PredictionError, n: int, rng: np.random.Generator, session: str | None = None
) -> Iterator[Draw]:
    """``n`` dampers of the posterior, each with the level of the next record: of a new session, or of a fitted one by its name.

    In a fitted session the sessions' levels are those of the fit, so that only what is not known of that session's counts.
    """
    covariance = damper.finite_covariance()
    root = square_root(covariance if error.within_sessions is None else error.within_sessions)
    fitted = None if session is None else error.sessions.index(session)
    for _ in range(n):
        spread = error.session_sd * _draw_t_factor(rng, error.session_freedom)
        change = _draw_t_factor(rng, error.freedom) * root @ rng.standard_normal(len(root))
        if fitted is None:
            change = change + spread * rng.standard_normal(len(error.sessions)) @ error.directions
        drawn = moved(damper, change)
        if fitted is None:
            level = spread * rng.standard_normal()
        else:
            level = error.session_levels[fitted] + error.session_errors[fitted] * rng.standard_normal()
        # each spread is itself known from few records or sessions, hence Student's t for each by itself
        level += error.record_sd * _draw_t_factor(rng, error.record_freedom) * rng.standard_normal()
        yield Draw(drawn, math.exp(level))


def _draw_t_factor(rng: np.random.Generator, freedom: float) -> float:
    """What makes a normal number one of Student's t."""
    return math.sqrt(freedom / rng.chisquare(freedom)) if math.isfinite(freedom) else 1.0


def phase_basis(t: Array, x: Array, v: Array) -> Array:
    """The functions (n, 10) of the shape error along a motion; a straight line through the displacement is taken off."""
    since = t - np.mean(t)  # the line in closed form: a tenth of the time of a general fit
    away = x - np.mean(x)
    away -= float(since @ away) / max(float(since @ since), 1e-300) * since
    basis = np.empty((2 * HARMONICS, t.size))  # the samples of each function lie side by side in memory
    for row, trace in zip(basis, (away, v), strict=False):
        np.divide(trace, max(float(np.quantile(np.abs(trace), AMPLITUDE_QUANTILE)), 1e-300), out=row)
    radius = np.hypot(basis[0], basis[1])
    still = radius == 0.0
    radius[still] = 1.0
    cosine, sine = basis[:2] / radius  # of the phase
    cosine[still] = 1.0
    for k in range(2, 2 * HARMONICS, 2):  # radius times cosine and sine of k/2 + 1 times the phase
        np.subtract(basis[k - 2] * cosine, basis[k - 1] * sine, out=basis[k])
        np.add(basis[k - 2] * sine, basis[k - 1] * cosine, out=basis[k + 1])
    return basis.T


def residual_draw(basis: Array, dt: float, shape: ShapeError, rng: np.random.Generator) -> tuple[Array, Array]:
    """A residual (n,) over the standard deviation of the force, and its white noise (n,) besides, along the motion of a
    `phase_basis` with ``dt`` s a sample."""
    n = len(basis)
    wide = math.sqrt(
        1.0 + 1.0 / max(shape.records, 1)
    )  # the mean over so few records is itself off by 1/n of their spread
    coefficients = np.array(shape.shape_mean) + wide * np.array(shape.shape_sd) * rng.standard_normal(2 * HARMONICS)
    out, white = basis @ coefficients, shape.white * rng.standard_normal(n)
    if shape.noise > 0.0:
        from scipy.signal import lfilter

        keep = math.exp(-dt / shape.noise_time) if shape.noise_time > 0.0 else 0.0
        drive = shape.noise * math.sqrt(1.0 - keep**2) * rng.standard_normal(n)
        drive[0] = (
            shape.noise * rng.standard_normal()
        )  # as large from the first sample on, or the record would begin calm
        out = out + lfilter([1.0], [1.0, -keep], drive)
    return np.asarray(out), white


def force_draws(
    damper: Any,
    path: Mapping[str, Any],
    n: int,
    seed: int,
    session: str | None = None,
    allow_extrapolation: bool = False,
    averaging: Callable[[Array], Array] | None = None,
) -> tuple[Array, Array]:
    """Forces (n, samples) in N of the damper along a ``path``, the arguments t, x, voltage, current and velocity of
    `Damper.force`, and the white noise (n, samples) of the sensor that is measured besides; ``averaging`` is what the measured
    force went through before its noise.

    Raises :class:`~dampyr.errors.InputError` where the damper has no prediction error or none of its sessions has this name.
    """
    error = damper.prediction_error
    if error is None:
        raise InputError(
            "this damper has no prediction error, so its predictions have no band; identify it again from its records"
        )
    if session is not None and session not in error.sessions:
        raise InputError(
            f"{session!r} is not a session that the damper was fitted on; choose from {', '.join(error.sessions)}"
        )
    t, u = path["t"], damper.pick_input(path["voltage"], path["current"])
    rng = np.random.default_rng(seed)
    basis, dt = phase_basis(t, path["x"], path["velocity"]), float(np.median(np.diff(t)))
    shape, forces, noise = error.shape_at(float(np.mean(u))), np.empty((n, len(t))), np.empty((n, len(t)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)  # the prediction itself warns of what is outside
        for k, draw in enumerate(draws_of(damper, error, n, rng, session)):
            force = draw.level * draw.damper.force(**path, allow_extrapolation=allow_extrapolation)
            if error.drift is not None:
                force = error.drift.applied(force, path["velocity"], dt, shape.energy, error.drift.draw_rate(rng))
            force = force if averaging is None else averaging(force)
            residual, white = residual_draw(basis, dt, shape, rng)
            size = float(np.std(force))
            forces[k], noise[k] = force + size * residual, size * white
    return forces, noise
