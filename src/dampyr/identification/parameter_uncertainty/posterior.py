r"""Samples of the posterior of a fit's numbers.

The likelihood is the adjusted one of Chandler and Bate (2007): with the lowest sum of squares over the nuisances of all
records, :math:`2C(\theta)`, its Hessian H at the optimum and the clustered covariance V of the fit,

.. math:: q(\theta) = 2\,\big(C(\theta) - C(\hat\theta)\big)\, \frac{d^T V^{-1} d}{d^T H d}, \qquad d = \theta - \hat\theta

has the shape of the objective and the curvature of V (their vertical adjustment). The density is that of Student's t in several
dimensions, :math:`(1 + q/\nu)^{-(\nu + p)/2}`, with the fewest degrees of freedom of the p numbers, as the scale comes from few
records; or normal, :math:`\exp(-q/2)`.

All of it is in the coordinates of the search: logarithms of the parameters that are searched so. The prior is flat in these
coordinates, inside the allowed values: 1/rho for rho. Numbers at different inputs whose laws share nothing are independent,
and sampled separately. The sampler is emcee (Foreman-Mackey et al. 2013), an ensemble whose walkers step along each other's
differences.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.findings import Finding, handed_on, worst_first
from dampyr.identification.fits.result import Fit
from dampyr.identification.parameter_uncertainty.profile_likelihood import coordinate_scale
from dampyr.identification.search.normal_equations import linearise, step_point
from dampyr.identification.search.optimum import Optimum
from dampyr.identification.search.problem import SearchPoint, to_coordinates, to_values, with_held
from dampyr.models import Damper
from dampyr.models.prediction_error import check_level
from dampyr.origin import Origin
from dampyr.phrases import listing
from dampyr.shown import Shown

Array = NDArray[np.float64]
LENGTHS = 50.0  # autocorrelation times: what emcee's authors ask for before they trust the time itself
BURN_IN = 5.0  # autocorrelation times that the walkers need to forget where they started
MIXED = 1.05  # R-hat of halves of all walkers: of chains of 50 autocorrelation times it is 1.02 by chance alone
RANK = 1e-9  # of the largest variance, in units of the linear model's: below it there is only rounding
CHUNK = 100  # steps between two looks at the chain
STEPS = 6000  # of each walker at most, unless asked otherwise
WALKERS = 16  # at least; four for each number, where that is more
DIFFERENCE = 0.25  # standard errors: how far from the optimum the Hessian is measured
SETTLED = 1e-5  # of the cost: what the nuisances still promise when their search ends
PASSES = 5  # over the records for one value of the numbers
TAILS = ("t", "normal")
MISSING = 'samples of the posterior need the package emcee, which is not installed: run pip install "dampyr[bayes]"'


@dataclass(frozen=True, repr=False)
class Posterior(Shown):
    """Samples of the posterior: result of `sample_posterior`.

    ``samples`` holds an array (n,) for each label, SI units, row by row one draw of all; ``held`` what stood at a limit and
    was held there. ``converged`` and ``reason`` say whether the chains were long enough; ``autocorrelation_time`` (steps),
    ``r_hat`` and ``acceptance`` by label what that rests on, ``steps`` of each walker. ``findings`` say what a reader should
    know besides, and what is wrong or in doubt in the fit.
    """

    samples: dict[str, Array]
    units: dict[str, str]
    held: dict[str, float]
    converged: bool
    reason: str
    findings: tuple[Finding, ...]
    autocorrelation_time: dict[str, float]
    r_hat: dict[str, float]
    acceptance: dict[str, float]
    steps: int
    tails: str
    seed: int
    fit: Fit = field(repr=False)

    @property
    def origin(self) -> Origin:
        """That of the fit's records."""
        return self.fit.origin

    @property
    def size(self) -> int:
        """How many draws there are."""
        return next(iter(self.samples.values())).size

    def intervals(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Equal-tailed credible intervals at ``level`` by label, SI units."""
        check_level(level)
        tail = 0.5 * (1.0 - level)
        limits = {label: np.quantile(values, (tail, 1.0 - tail)) for label, values in self.samples.items()}
        return {label: (float(low), float(high)) for label, (low, high) in limits.items()}

    @cached_property
    def correlation(self) -> Array:
        """The correlation of the samples, (m, m), in the order of ``samples``."""
        return np.atleast_2d(np.corrcoef(np.stack(list(self.samples.values()))))

    def dampers(self, n: int, seed: int = 0) -> list[Damper]:
        """``n`` dampers drawn from the samples, as `dampyr.structures.ensemble` takes them; all are admissible.

        Raises InputError where the fit made no damper, or where fewer than 1 % of the draws are admissible.
        """
        if self.fit.damper is None:
            raise InputError(f"this fit made no damper: {self.fit.reason}")
        rng, labels = np.random.default_rng(seed), list(self.fit.parameters)
        theta = np.array([self.fit.parameters[label] for label in labels])
        places = [labels.index(label) for label in self.samples]
        table = np.stack(list(self.samples.values()), axis=-1)

        def draw() -> Array:
            theta[places] = table[rng.integers(self.size)]
            return theta

        trouble = ": the laws leave the allowed values between the fitted inputs; fit them by interpolation"
        return self.fit.optimum.draw_dampers(n, self.fit.damper, draw, trouble)

    def to_xarray(self) -> Any:
        """The samples as an ``xarray.DataArray`` with the dimensions sample and parameter, SI units."""
        import xarray

        table = np.stack(list(self.samples.values()), axis=-1)
        return xarray.DataArray(table, {"parameter": list(self.samples)}, ("sample", "parameter"), "posterior")


def sample_posterior(
    fit: Fit,
    lengths: float = LENGTHS,
    steps: int = STEPS,
    tails: str = "t",
    seed: int = 0,
    progress: Callable[[str, float], None] | None = None,
) -> Posterior:
    """Samples of the posterior of a fit's numbers, the nuisances of the records at their best.

    Parameters
    ----------
    fit
        of `dampyr.identification.fit`. Numbers at a limit are held there.
    lengths
        of the chains in autocorrelation times, at which they end.
    steps
        of each walker at most: chains that are not long enough by then are returned with ``converged`` False.
    tails
        ``"t"`` as the intervals of the fit, or ``"normal"`` with the same covariance.
    seed
        of the walkers: the same seed gives the same samples.
    progress
        called with the inputs that are sampled and the fraction of it that is done.

    Returns
    -------
    Posterior
        what follows 5 autocorrelation times, thinned by half a time.

    Raises
    ------
    InputError
        emcee is not installed (``pip install "dampyr[bayes]"``); a number that the records do not determine; a wrong option.
    """
    if tails not in TAILS:
        raise InputError(f"{tails!r} is an unknown tail; choose {' or '.join(TAILS)}")
    if not lengths > 0:
        raise InputError(f"lengths = {lengths:g} is not allowed; give a number above 0, such as {LENGTHS:g}")
    if steps < CHUNK:
        raise InputError(f"steps = {steps} is not allowed; give {CHUNK} or more")
    _check_errors(fit)
    tell = progress or (lambda stage, done: None)
    labels, blocks = list(fit.parameters), fit.optimum.blocks
    sampled, held, notes = [], dict[str, float](), list[str]()
    for number, block in enumerate(blocks):
        target = _Target(fit, block, tails, notes)
        held |= {labels[block.places[k]]: float(target.start.theta[k]) for k in target.at_limit}
        if target.size:

            def report(done: float, number: int = number) -> None:
                tell("sampling", (number + done) / len(blocks))

            sampled.append(_run_chain(target, lengths, steps, seed + number, report))
    tell("sampling", 1.0)
    if not sampled:
        raise InputError("every number of this fit stands at a limit, so there is nothing to sample")
    if held:
        notes.append(f"held at the limit where {'it stands' if len(held) == 1 else 'they stand'}: {', '.join(held)}")
    if fit.within_records:
        notes.append(f"{listing(list(fit.within_records), 4)}: within these records only, of which there are too few")
    size = min(chain.values.shape[0] for chain in sampled)
    rng = np.random.default_rng(seed)
    samples: dict[str, Array] = {}
    by_label: dict[str, dict[str, float]] = {"time": {}, "r_hat": {}, "acceptance": {}}
    for chain in sampled:  # independent of one another, so any row goes with any
        rows = chain.values[rng.permutation(chain.values.shape[0])[:size]]
        for column, label in enumerate(chain.labels):
            samples[label] = rows[:, column]
            by_label["time"][label] = float(chain.time[column])
            by_label["r_hat"][label] = float(chain.r_hat[column])
            by_label["acceptance"][label] = chain.acceptance
    poor = [chain for chain in sampled if chain.trouble]
    return Posterior(
        samples={label: samples[label] for label in labels if label in samples},
        units={label: fit.units[label] for label in samples},
        held=held,
        converged=not poor,
        reason=poor[0].trouble if poor else f"converged: every chain is {lengths:g} autocorrelation times or longer",
        findings=worst_first(
            handed_on([fit]),
            (Finding("doubt", f"did not converge: {chain.trouble}") for chain in poor[:1]),
            (Finding("note", text) for text in notes),
        ),
        autocorrelation_time=by_label["time"],
        r_hat=by_label["r_hat"],
        acceptance=by_label["acceptance"],
        steps=max(chain.steps for chain in sampled),
        tails=tails,
        seed=seed,
        fit=fit,
    )


def _check_errors(fit: Fit) -> None:
    unknown = [label for label, error in fit.stderr.items() if math.isinf(error)]
    if unknown:
        raise InputError(
            f"the records do not determine {listing(unknown, 4)}, so there is no error to sample by; fix "
            f"{'it' if len(unknown) == 1 else 'them'} (fixed=) or record what dampyr.identification.identifiability proposes"
        )


class _Target:
    """The density of one block, over the coordinates (p,) of its numbers that have an error."""

    def __init__(self, fit: Fit, block: Optimum, tails: str, notes: list[str]) -> None:
        labels = list(fit.parameters)
        own_labels = [labels[place] for place in block.places]
        self.problem, self.start = block.problem, block.point
        self.free = [k for k, label in enumerate(own_labels) if math.isfinite(fit.stderr[label])]
        self.at_limit = [k for k in range(len(own_labels)) if k not in self.free]
        self.labels = [own_labels[k] for k in self.free]
        self.size = len(self.free)
        if not self.size:
            return
        self.log = self.problem.is_logarithmic[self.free]
        self.best = self.start.coordinates(self.problem)[self.free]
        low, high = (side[self.free] for side in self.problem.inner_limits)
        self.low, self.high = to_coordinates(low, self.log), to_coordinates(high, self.log)
        self.by_theta = block.equations.reduced.by_theta
        self.lowest = self._cost(self.best)
        errors = np.array([fit.stderr[label] for label in self.labels])
        places = [labels.index(label) for label in self.labels]
        errors = errors / coordinate_scale(self.problem, self.start)[self.free]
        covariance = fit.correlation[np.ix_(places, places)] * np.outer(errors, errors)
        self.hessian = self._hessian(block.information[np.ix_(self.free, self.free)], errors, notes)
        samples = sum(piece.count - self.problem.locals for piece in self.problem.pieces)
        naive = 2.0 * self.lowest / max(samples - self.problem.size, 1)
        records = len({piece.cut_from or piece.name for piece in self.problem.pieces})
        by_record = not any(label in fit.within_records for label in self.labels)
        lacking = max(self.size - (records - 1), 0) if by_record else 0
        self.precision, self.spread = _invert_covariance(covariance, self.hessian, naive, lacking)
        if lacking:
            notes.append(
                f"{listing(self.labels, 3)}: {records} records show no variance between them in {lacking} of {self.size} "
                "directions, which have that of independent samples"
            )
        if block.is_robust:
            notes.append("the weights of the robust loss stay as they are at the optimum")
        self.freedom = min(fit.freedom[label] for label in self.labels) if tails == "t" else math.inf

    def _cost(self, coordinates: Array) -> float:
        """The lowest cost over the nuisances, the numbers held there; infinite where the model gives no force."""
        theta = self.start.theta.copy()
        theta[self.free] = to_values(coordinates, self.log)
        step = np.zeros(self.problem.size)
        step[self.free] = coordinates - self.best
        held = with_held(self.problem, dict(enumerate(theta.tolist())))
        local = np.clip(self.start.local - self.by_theta @ step, *self.problem.local_limits)
        point, cost = SearchPoint(theta, local), math.inf
        for _ in range(PASSES):
            equations = linearise(held, point)
            if not equations.finite or equations.cost > cost:
                break
            inner = equations.solve()
            promised = equations.reduction(inner)
            cost = equations.cost - promised if promised <= SETTLED * equations.cost else equations.cost
            if promised <= SETTLED * equations.cost:
                break
            point = step_point(held, point, inner)
        return cost

    def _hessian(self, linear: Array, errors: Array, notes: list[str]) -> Array:
        """The Hessian of the cost at the optimum, by differences; that of the ``linear`` model where these are not convex."""
        h = DIFFERENCE * errors
        # inside the limits on both sides: beyond them the nuisances answer, not the coefficients
        h = np.minimum(h, 0.5 * np.minimum(self.best - self.low, self.high - self.best))
        p, H = self.size, np.empty((self.size, self.size))
        axes = np.diag(h)
        for i in range(p):
            H[i, i] = (self._cost(self.best + axes[i]) + self._cost(self.best - axes[i]) - 2.0 * self.lowest) / h[
                i
            ] ** 2
            for j in range(i):
                both, apart = axes[i] + axes[j], axes[i] - axes[j]
                same = self._cost(self.best + both) + self._cost(self.best - both)
                other = self._cost(self.best + apart) + self._cost(self.best - apart)
                H[i, j] = H[j, i] = (same - other) / (4.0 * h[i] * h[j])
        d = np.sqrt(np.diag(linear))
        if np.all(np.isfinite(H)) and float(np.linalg.eigvalsh(H / np.outer(d, d)).min()) > 0.0:
            return H
        notes.append(
            f"the objective is not convex at the optimum of {listing(self.labels, 3)}: the linear model's curvature serves"
        )
        return linear

    def log_density(self, coordinates: Array) -> float:
        """Of Student's t, or the normal one; minus infinity outside the allowed values."""
        if np.any((coordinates < self.low) | (coordinates > self.high)):
            return -math.inf
        d = coordinates - self.best
        curved = float(d @ self.hessian @ d)
        if curved <= 0.0:
            return 0.0
        cost = self._cost(coordinates)
        if not math.isfinite(cost):
            return -math.inf
        # the objective's shape, scaled along this direction to the curvature of the clustered covariance; rounding may make the
        # rise near the optimum negative, which the logarithm does not take
        q = max(2.0 * (cost - self.lowest) * float(d @ self.precision @ d) / curved, -0.5)
        if math.isinf(self.freedom):
            return -0.5 * q
        return -0.5 * (self.freedom + self.size) * math.log1p(q / max(self.freedom, 1.0))


def _invert_covariance(covariance: Array, hessian: Array, naive: float, lacking: int) -> tuple[Array, Array]:
    """The inverse of the covariance, and a root of the covariance.

    The clustered covariance of G records has at most G - 1 directions, as their scores add up to zero. The ``lacking`` ones
    (those of the least variance for their information) have the error of independent samples: ``naive``, the variance of a
    weighted residual.
    """
    d = np.sqrt(np.diag(hessian))
    values, vectors = np.linalg.eigh(hessian / np.outer(d, d))
    root = (vectors * np.sqrt(values)) * d[:, None]  # hessian = root root^T
    inverse = np.linalg.inv(root)
    ratio, turned = np.linalg.eigh(root.T @ covariance @ root)
    ratio = np.where(np.arange(ratio.size) < lacking, naive, np.maximum(ratio, RANK * float(ratio.max())))
    half = root @ turned
    return (half / ratio) @ half.T, (inverse.T @ turned) * np.sqrt(ratio)


@dataclass(frozen=True)
class _Chain:
    labels: list[str]
    values: Array
    time: Array
    r_hat: Array
    acceptance: float
    steps: int
    trouble: str


def _run_chain(target: _Target, lengths: float, steps: int, seed: int, tell: Callable[[float], None]) -> _Chain:
    """emcee's walkers until their chains are long enough."""
    try:
        import emcee
    except ImportError:
        raise InputError(MISSING) from None
    walkers = max(WALKERS, 4 * target.size)
    rng = np.random.default_rng(seed)
    moves = [(emcee.moves.DEMove(), 0.7), (emcee.moves.DESnookerMove(), 0.1), (emcee.moves.StretchMove(), 0.2)]
    sampler = emcee.EnsembleSampler(walkers, target.size, target.log_density, moves=moves)
    sampler.random_state = np.random.RandomState(seed).get_state()
    state: Any = _draw_starts(target, walkers, rng)
    time, done = np.full(target.size, math.inf), 0
    while done < steps:
        state = sampler.run_mcmc(state, min(CHUNK, steps - done), skip_initial_state_check=True)
        done = sampler.iteration
        time = sampler.get_autocorr_time(tol=0)
        slowest = float(np.max(time))
        tell(min(done / (lengths * slowest), 1.0) if math.isfinite(slowest) else 0.0)
        if done >= lengths * slowest:
            break
    slowest = float(np.max(time)) if np.all(np.isfinite(time)) else float(done)
    burn_in = min(int(BURN_IN * slowest), done // 2)
    chain = sampler.get_chain(discard=burn_in)
    r_hat = split_r_hat(chain)
    where = f"the chains of {listing(target.labels, 3)}"
    trouble = ""
    if done < lengths * slowest:
        trouble = f"{where} are {done / slowest:.3g} autocorrelation times long, not {lengths:g}; give more steps than {steps}"
    elif float(np.max(r_hat)) > MIXED:
        trouble = f"{where} have not mixed (R-hat {np.max(r_hat):.3f}, above {MIXED:g}); ask for more lengths than {lengths:g}"
    thinned = chain[:: max(int(0.5 * slowest), 1)].reshape(-1, target.size)
    share = float(np.mean(sampler.acceptance_fraction))
    return _Chain(target.labels, to_values(thinned, target.log), time, r_hat, share, done, trouble)


def _draw_starts(target: _Target, walkers: int, rng: np.random.Generator) -> Array:
    """Where walkers begin: draws from the fit's covariance, nearer the optimum where these leave the limits."""
    starts = np.empty((walkers, target.size))
    for k in range(walkers):
        reach = 1.0
        while True:
            start = target.best + reach * (target.spread @ rng.standard_normal(target.size))
            if math.isfinite(target.log_density(start)):
                break
            reach *= 0.8
        starts[k] = start
    return starts


def split_r_hat(chain: Array) -> Array:
    """R-hat (p,) of a chain (steps, walkers, p), both halves of each walker counted as chains (Gelman et al. 2013)."""
    half = chain.shape[0] // 2
    if half < 2:
        return np.full(chain.shape[2], math.inf)
    parts = np.concatenate((chain[:half], chain[half : 2 * half]), axis=1)
    within = np.mean(np.var(parts, axis=0, ddof=1), axis=0)
    between = np.var(np.mean(parts, axis=0), axis=0, ddof=1)
    return np.asarray(np.sqrt((half - 1) / half + between / np.where(within > 0.0, within, 1.0)))
