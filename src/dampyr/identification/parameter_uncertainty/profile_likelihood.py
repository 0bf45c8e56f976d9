r"""The profile of a fit's objective over one coefficient, and the interval that it gives.

At each value of the coefficient all others, and the nuisances of every record, are brought to their best; what the objective
:math:`S` (the sum of squares) rises by above its lowest is the profile. Residuals are correlated over whole cycles, so the rise
of a sum over samples is far too large to be compared with a quantile. It is scaled so that the curvature at the optimum is that
of the fit's clustered standard error :math:`s_k` (the adjusted likelihood of Chandler and Bate 2007):

.. math:: q(\theta_k) = \frac{S_p(\theta_k) - S_{\min}}{\tfrac12 S_p''(\hat\theta_k)\, s_k^2}

The interval is where :math:`q \le t^2`, Student's t with the degrees of freedom of that error. Where the objective is a
parabola, this is the interval of `Fit.intervals`; where it is not, it is asymmetric, and a side on which the profile never
rises that far inside the allowed values is open: the records do not bound it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.findings import Finding, handed_on, worst_first
from dampyr.identification.fits.result import Fit
from dampyr.identification.search.optimum import Optimum
from dampyr.identification.search.problem import Problem, SearchPoint, with_held
from dampyr.identification.search.variable_projection import WARM_DAMPING, levenberg_marquardt
from dampyr.models.prediction_error import check_level
from dampyr.origin import NOT_STATED, Origin
from dampyr.phrases import listing
from dampyr.shown import Shown

Array = NDArray[np.float64]
TIGHT = 1e-10  # of the cost: a hundredth of the tolerance of a fit, so that the rise near the optimum is smooth
SHORT = 0.3  # standard errors: how far from the optimum the curvature is measured
BEYOND = 1.3  # times the threshold: how far a curve goes on, so that a figure shows the crossing
WIDEN = 1.5  # by which steps grow beyond where a parabola would have crossed
FAR = 30.0  # half widths of the parabola's interval: what has not crossed there does not cross
FACTOR = math.log(1e4)  # of a logarithmic coefficient: the same, as a factor
MAX_POINTS = 60  # of one side
LOWER = 0.02  # of the rise: below the optimum by that, the fit had not ended at its lowest point


@dataclass(frozen=True, repr=False)
class Profile(Shown):
    """The profile of one coefficient: result of `profile`, SI units.

    ``values`` (n,) of the coefficient, and the ``rise`` (n,) of the adjusted objective there, which at the ends of the
    interval is ``threshold`` = t^2 with ``freedom`` degrees of freedom. ``interval`` holds them; of a side that is not
    ``closed`` (low, high) it holds the end of the allowed values. It is NaN where one or two records alone determine the
    coefficient: how records differ is not estimated then, and the curve holds ``within`` these records only. ``reason`` says
    what is open, and why.
    """

    label: str
    unit: str
    value: float
    standard_error: float
    level: float
    freedom: float
    threshold: float
    values: Array
    rise: Array
    interval: tuple[float, float]
    closed: tuple[bool, bool]
    within: bool
    reason: str
    findings: tuple[Finding, ...]
    origin: Origin = NOT_STATED


def profile(fit: Fit, label: str, level: float = 0.95, points: int = 21) -> Profile:
    """The profile of a fit's objective over the coefficient ``label``, such as ``"dahl.rho @ 1.98 V"``.

    Parameters
    ----------
    fit
        of `dampyr.identification.fit`. Of a robust loss the weights of the samples stay as they are at its end.
    level
        of the interval, between 0 and 1.
    points
        how many of the curve lie within the interval of the standard error; more are taken where the profile goes on.

    Returns
    -------
    Profile
        also where a side does not close: ``closed`` and ``reason`` say so. A coefficient without a standard error (at its
        limit, or not determined) is scaled as the median of the others that share its records.

    Raises
    ------
    InputError
        an unknown label, a level outside 0 to 1, fewer than 5 points, or where no coefficient of the same records has an error.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> damper, rng = dp.studies.raminelli_2020.damper(), np.random.default_rng(0)
    >>> t, records = np.linspace(0.0, 4.0, 801), []
    >>> for f in (0.7, 1.0, 1.3, 1.6):
    ...     x = 0.008 * np.sin(2 * np.pi * f * t)
    ...     force = damper.force(t, x, voltage=1.98) + rng.normal(0.0, 5.0, t.size)
    ...     records.append(dp.records.Record(t, x, force, voltage=1.98, name=f"{f} Hz"))
    >>> fit = dp.identification.fit(records, "dahl")
    >>> curve = dp.identification.profile(fit, "dahl.kw")
    >>> curve.closed, curve.interval[0] < fit.parameters["dahl.kw"] < curve.interval[1]
    ((True, True), True)
    """
    from scipy.stats import t

    labels = list(fit.parameters)
    if label not in labels:
        raise InputError(f"{label!r} is not a number of this fit; choose from {listing(labels, 12)}")
    check_level(level)
    if points < 5:
        raise InputError(f"points = {points} is not allowed; give 5 or more")
    place = labels.index(label)
    block = next(block for block in fit.optimum.blocks if place in block.places)
    path = _Path(fit, block, block.places.index(place), label)
    freedom = path.freedom
    threshold = float(t.ppf(0.5 + 0.5 * level, freedom)) ** 2
    sides = [path.follow(side, math.sqrt(threshold), points // 2) for side in (-1.0, 1.0)]
    coordinates, rise = path.curve
    ends, reasons = [], []
    for side, crossed in zip(("below", "above"), sides, strict=True):
        limit = path.limits[0 if side == "below" else 1]
        ends.append(limit if crossed is None else path.value_of(crossed))
        if crossed is None:
            bounded = math.isfinite(limit)
            why = f"do not tell it from its limit {limit:g}" if bounded else "do not bound it"
            reasons.append(f"open {side}: the records {why}")
    within = label in fit.within_records
    return Profile(
        origin=fit.origin,
        label=label,
        unit=fit.units[label],
        value=fit.parameters[label],
        standard_error=fit.stderr[label],
        level=level,
        freedom=freedom,
        threshold=threshold,
        values=np.array([path.value_of(c) for c in coordinates]),
        rise=rise,
        interval=(math.nan, math.nan) if within else (ends[0], ends[1]),
        closed=(sides[0] is not None, sides[1] is not None),
        within=within,
        reason="; ".join(reasons) or "both close",
        findings=worst_first(
            handed_on([fit]),
            (Finding("note", text) for text in path.notes),
            [Finding("note", f"{fit.why_no_interval(label)}: no interval")] if within else [],
        ),
    )


class _Path:
    """The profile as it is followed: what was evaluated, by the coordinate of the coefficient, and the point there."""

    def __init__(self, fit: Fit, block: Optimum, k: int, label: str) -> None:
        self.problem, self.k, self.notes = block.problem, k, list[str]()
        start = block.point
        log = bool(self.problem.is_logarithmic[k])
        self.value_of: Callable[[float], float] = math.exp if log else float
        self.coordinate_of: Callable[[float], float] = math.log if log else float
        self.log = log
        self.limits = float(self.problem.limits[0][k]), float(self.problem.limits[1][k])
        low, high = (float(side[k]) for side in self.problem.inner_limits)
        self.ends = (math.log(low) if low > 0.0 else -math.inf) if log else low, math.log(high) if log else high
        self.best = self.coordinate_of(float(start.theta[k]))
        self.seen: dict[float, tuple[float, SearchPoint]] = {}
        self._evaluate(self.best, start)
        self._scale(fit, block, label)
        if block.is_robust:
            self.notes.append("the weights of the robust loss stay as they are at the optimum")

    def _evaluate(self, coordinate: float, near: SearchPoint | None = None) -> float:
        """The lowest cost with the coefficient held there, started from the nearest point that is known."""
        if coordinate not in self.seen:
            if near is None:
                near = self.seen[min(self.seen, key=lambda c: abs(c - coordinate))][1]
            theta, value = near.theta.copy(), self.value_of(coordinate)
            theta[self.k] = value
            held = with_held(self.problem, {self.k: value})
            end = levenberg_marquardt(held, SearchPoint(theta, near.local), None, TIGHT, damping=WARM_DAMPING)
            self.seen[coordinate] = end.cost, end.point
        return self.seen[coordinate][0]

    def _scale(self, fit: Fit, block: Optimum, label: str) -> None:
        """``per_unit``: what the cost rises by where the adjusted rise is 1; ``error``: the error in the coordinate."""
        ratios, freedoms = variance_ratios(fit, block)
        information = block.information
        ratio, error = ratios.get(self.k), fit.stderr[label]
        if ratio is None and not ratios:
            raise InputError(
                f"{label} has no standard error, and no other number that its records determine has one, so a rise of the "
                "objective has no scale; add records"
            )
        if ratio is None:
            middle = float(np.median(list(ratios.values())))
            self.freedom = min(freedoms.values())
            self.per_unit = 0.5 * middle
            self.error = math.sqrt(middle / max(float(information[self.k, self.k]), 1e-300))
            why = "stands at its limit" if math.isnan(error) else "has no standard error"
            self.notes.append(f"{label} {why}: its rise is scaled as that of the other numbers of its records")
            return
        self.freedom = freedoms[self.k]
        self.error = error / (float(fit.parameters[label]) if self.log else 1.0)
        curvature = self._curvature(min(SHORT * self.error, 1.0) if self.log else SHORT * self.error)
        if not curvature > 0.0:
            curvature = 1.0 / float(scaled_inverse(information)[self.k, self.k])
            self.notes.append(
                "the objective is not convex at the optimum: its curvature there is that of the linear model"
            )
        self.per_unit = 0.5 * curvature * self.error**2

    def _curvature(self, h: float) -> float:
        """The second difference of the cost with the step h, on one side of the optimum where a limit is nearer than h."""
        centre = self.best
        if self.best - h < self.ends[0]:
            centre = self.best + h
        elif self.best + h > self.ends[1]:
            centre = self.best - h
        below, middle, above = (self._evaluate(centre + k * h) for k in (-1.0, 0.0, 1.0))
        return (below + above - 2.0 * middle) / h**2

    def rise(self, coordinate: float) -> float:
        """The adjusted rise at a coordinate, above the lowest point that is known."""
        return (self._evaluate(coordinate) - self.lowest) / self.per_unit

    @property
    def lowest(self) -> float:
        """The lowest cost that is known."""
        return min(cost for cost, _ in self.seen.values())

    def follow(self, side: float, half_width: float, points: int) -> float | None:
        """The coordinate where the rise crosses ``half_width`` squared on one side; None where it does not."""
        threshold, end = half_width**2, self.ends[0 if side < 0 else 1]
        reach = min(half_width * self.error, FACTOR) if self.log else half_width * self.error
        step, farthest = reach / points, FACTOR if self.log else FAR * reach
        coordinate, last = self.best, self.best
        crossed: tuple[float, float] | None = None
        for _ in range(MAX_POINTS):
            coordinate = last + side * step
            at_end = side * (coordinate - end) >= 0.0
            coordinate = end if at_end else coordinate
            if coordinate == last:
                break
            rise = self.rise(coordinate)
            if crossed is None and rise >= threshold:
                crossed = last, coordinate
            if at_end or rise >= BEYOND * threshold or abs(coordinate - self.best) >= farthest:
                break
            last = coordinate
            if abs(coordinate - self.best) >= reach:
                step *= WIDEN
        return None if crossed is None else self._refine(*crossed, threshold)

    def _refine(self, inside: float, outside: float, threshold: float) -> float:
        from scipy.optimize import brentq

        if self.rise(inside) >= threshold:  # a lower point was found since
            return inside
        return float(brentq(lambda c: self.rise(c) - threshold, inside, outside, xtol=1e-4 * self.error, rtol=1e-10))

    @property
    def curve(self) -> tuple[list[float], Array]:
        """The coordinates in order, and the rise at each; a note where the fit was not at the lowest point."""
        order = sorted(self.seen)
        rise = np.array([(self.seen[c][0] - self.lowest) / self.per_unit for c in order])
        above = float((self.seen[self.best][0] - self.lowest) / self.per_unit)
        if above > LOWER:
            lowest = self.value_of(min(self.seen, key=lambda c: self.seen[c][0]))
            self.notes.append(
                f"the fit had not ended at its lowest point: at {lowest:.6g} the adjusted objective is lower by {above:.2g}"
            )
        return order, rise


def variance_ratios(fit: Fit, block: Optimum) -> tuple[dict[int, float], dict[int, float]]:
    """For each coefficient of a block that has a standard error: its variance over that of the inverse information, and its
    degrees of freedom."""
    labels = list(fit.parameters)
    finite = [k for k, place in enumerate(block.places) if math.isfinite(fit.stderr[labels[place]])]
    inverse = np.diag(scaled_inverse(block.information[np.ix_(finite, finite)]))
    scale = coordinate_scale(block.problem, block.point)
    ratios, freedoms = {}, {}
    for k, variance in zip(finite, inverse, strict=True):
        label = labels[block.places[k]]
        if variance > 0.0:
            ratios[k] = (fit.stderr[label] / float(scale[k])) ** 2 / float(variance)
            freedoms[k] = fit.freedom[label]
    return ratios, freedoms


def coordinate_scale(problem: Problem, point: SearchPoint) -> Array:
    """What a step of each search coordinate is worth in SI units, (G,): the value where it is logarithmic, else 1."""
    return np.where(problem.is_logarithmic, point.theta, 1.0)


def scaled_inverse(matrix: Array) -> Array:
    """The inverse of a symmetric matrix whose unknowns have units of their own; zero along what is not determined."""
    d = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    scale = np.where(d > 0.0, 1.0 / np.where(d > 0.0, d, 1.0), 0.0)
    return np.asarray(
        np.linalg.pinv(matrix * np.outer(scale, scale), rcond=1e-12, hermitian=True) * np.outer(scale, scale)
    )
