"""Choice of tests among candidates: one by one the best, then exchanges until none improves it.

What is to become small is a *criterion* of the expected errors: the mean logarithm of the intervals' half widths, how far they
are from target widths, or the interval of a building's peak. Each takes the degrees of freedom in, so that a design does not
promise with three records what thirty would give.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.planning.expected_information import CoefficientLayout, Expected, Information, ModelDeviation, expected_from

Array = NDArray[np.float64]
Criterion = Callable[[Expected], float]
TOLERANCE = 1e-6  # of the criterion, a logarithm: an exchange must improve it by more
PASSES = 4  # over all chosen tests; the second one rarely finds anything
POWER = 4.0  # of the ratios to the targets: the worst of them counts most, and the others still count


@dataclass(frozen=True)
class ParameterGoal:
    """The half widths of 95 % intervals of coefficients over their values: ``weights`` (G,), whose weighted mean logarithm is
    taken; or ``targets`` (G,), infinite where there is none."""

    weights: Array
    targets: Array | None = None

    def __call__(self, errors: Expected) -> float:
        """The criterion, a logarithm: at most 0 where all targets are met."""
        if self.targets is None:
            free = self.weights > 0
            half = np.maximum(errors.half[free], 1e-12)
            return float(self.weights[free] @ np.log(half) / self.weights.sum())
        aimed = np.isfinite(self.targets)
        ratios = errors.half[aimed] / self.targets[aimed]
        return float(np.log(np.mean(ratios**POWER)) / POWER)


@dataclass(frozen=True)
class PeakGoal:
    """The half width of the 95 % interval of a peak over the peak: ``gradient`` (G,) is of its logarithm by the relative
    coefficients."""

    gradient: Array

    def __call__(self, errors: Expected) -> float:
        """Its logarithm."""
        return float(np.log(max(self.half(errors), 1e-12)))

    def half(self, errors: Expected) -> float:
        """The half width over the peak of expected errors."""
        return self.half_of(errors.covariance, errors.freedom)

    def half_of(self, covariance: Array, freedom: Array) -> float:
        """The half width over the peak of this relative covariance (G, G), with the freedom of the coefficients that it depends
        on most."""
        from scipy.special import stdtrit

        c = np.where(np.isfinite(self.gradient), self.gradient, 0.0)
        parts = np.abs(c) * np.sqrt(np.maximum(np.diag(covariance), 0.0))
        # the coefficients that matter most to the peak lend it their degrees of freedom
        mean = float(parts @ freedom / max(parts.sum(), 1e-300))
        variance = max(float(c @ covariance @ c), 0.0)
        return float(stdtrit(max(mean, 1.0), 0.975) * np.sqrt(variance))


@dataclass(frozen=True, eq=False)
class Pool:
    """Records that are there, and candidates, as stacked matrices."""

    A: Array
    M: Array
    present: int
    factors: Array

    def criterion(self, plan: CoefficientLayout, chosen: Sequence[int], goal: Criterion) -> float:
        """The criterion of the present records and these candidates."""
        places = [*range(self.present), *(self.present + k for k in chosen)]
        free = ~plan.held
        linear = plan.is_linear & free
        return goal(expected_from(self.A[places], self.M[places], linear, free, open_ends=True, factors=self.factors))


def pool_of(
    plan: CoefficientLayout,
    present: Sequence[Information],
    candidates: Sequence[Information],
    spread: ModelDeviation,
    factors: Array,
) -> Pool:
    """The stacked matrices of records and candidates; ``factors`` (G,) calibrate the errors."""
    every = [*present, *candidates]
    A = np.stack([i.A for i in every])
    D = plan.owner @ spread.deviations @ plan.owner.T
    return Pool(A, A @ D @ A + np.stack([i.noise for i in every]), len(present), factors)


def best_tests(
    plan: CoefficientLayout,
    pool: Pool,
    number: int,
    goal: Criterion,
    durations: Sequence[float],
    time: float = np.inf,
    enough: float = -np.inf,
    progress: Callable[[float], None] = lambda done: None,
    first: Sequence[int] = (),
) -> list[int]:
    """The places of the chosen candidates, at most ``number`` of them and ``time`` s together, each at most once: tests of one
    motion share what the model misses there, and the spread between records would not show it.

    Those of ``first`` are among them whatever they tell. Fewer where the criterion falls to ``enough`` with them.
    """
    lengths = np.asarray(durations, dtype=float)
    chosen = list(first)

    def allowed(others: list[int]) -> list[int]:
        left = time - lengths[others].sum()
        return [k for k in range(lengths.size) if k not in others and lengths[k] <= left + 1e-9]

    while len(chosen) < number:
        options = allowed(chosen)
        if not options:
            break
        values = [pool.criterion(plan, [*chosen, k], goal) for k in options]
        chosen.append(options[int(np.argmin(values))])
        progress(len(chosen) / (number + PASSES))
        if min(values) <= enough:
            break
    for turn in range(PASSES):
        if not _exchange(plan, pool, goal, chosen, allowed, len(first)):
            break
        progress((number + turn + 1) / (number + PASSES))
    progress(1.0)
    return chosen


def _exchange(
    plan: CoefficientLayout,
    pool: Pool,
    goal: Criterion,
    chosen: list[int],
    allowed: Callable[[list[int]], list[int]],
    kept: int,
) -> bool:
    """Replace each chosen test but the first ``kept`` by a better one where there is one; whether there was."""
    improved = False
    for place in range(kept, len(chosen)):
        others = chosen[:place] + chosen[place + 1 :]
        now = pool.criterion(plan, chosen, goal)
        options = allowed(others)
        values = [pool.criterion(plan, [*others[:place], k, *others[place:]], goal) for k in options]
        best = int(np.argmin(values))
        if values[best] < now - TOLERANCE:
            chosen[place] = options[best]
            improved = True
    return improved
