"""Many random plants: the same virtual hybrid test on plants drawn from the stated uncertainties, in parallel threads."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.hybrid.compensators import Compensator
from dampyr.hybrid.criteria import CRITERIA, tracking_criteria, tracking_error
from dampyr.hybrid.setup import HybridSetup, PlantSpread
from dampyr.hybrid.stability import largest_eigenvalue
from dampyr.hybrid.virtual_test import compared_floor, ground_history, histories, reference_history
from dampyr.shown import Shown

Array = NDArray[np.float64]

PLANT = ("stiffness", "pole", "beta1", "beta2")


@dataclass(frozen=True, eq=False, repr=False)
class BatchResult(Shown):
    """Results over random plants, one row each.

    ``plants`` (N, 4): stiffness [N/m], pole [1/s], beta1 [1/s], beta2 [1/s2]; ``true`` and ``measured`` (N, 9): J1 to J9, nan
    where a run diverged; ``radius`` (N,): the largest eigenvalue of the loop, below 1 where it is stable; ``at_limit`` (N,)
    samples at the actuator's greatest force; ``diverged`` (N,).
    """

    name: str
    plants: Array
    true: Array
    measured: Array
    radius: Array
    at_limit: NDArray[np.int64]
    diverged: NDArray[np.bool_]

    @property
    def unstable(self) -> int:
        """How many loops are unstable by their eigenvalues, diverged, or reached the actuator's greatest force."""
        return int(np.count_nonzero((self.radius >= 1.0) | self.diverged | (self.at_limit > 0)))

    def worst(self, criterion: str = "J2") -> int:
        """The row of the worst plant by a criterion; one that diverged is worse than any other."""
        if criterion not in CRITERIA:
            raise InputError(f"{criterion!r} is not a criterion; choose from {', '.join(CRITERIA)}")
        values = self.true[:, CRITERIA.index(criterion)]
        return int(np.argmax(np.where(np.isnan(values), np.inf, values)))


def draw_plants(nominal: HybridSetup, count: int, seed: int = 0, uncertainty: PlantSpread | None = None) -> Array:
    """Random plants (count, 4): normal about the nominal one, stiffness, pole, beta1, beta2."""
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise InputError(f"{count!r} plants cannot be drawn; give a whole number of at least 1")
    u, t = uncertainty or PlantSpread(), nominal.transfer
    centre = [nominal.specimen.stiffness, t.pole, t.beta1, t.beta2]
    spread = [u.stiffness, u.pole, u.beta1, u.beta2]
    return np.random.default_rng(seed).normal(centre, spread, (count, 4))


def run_many(
    nominal: HybridSetup,
    compensator: Compensator,
    motion: GroundMotion,
    count: int,
    seed: int = 0,
    uncertainty: PlantSpread | None = None,
    workers: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> BatchResult:
    """The virtual hybrid test on random plants, each with noise of its own.

    Parameters
    ----------
    nominal
        The set-up whose specimen and actuator are the mean of the plants.
    compensator
        The one that all plants have.
    motion
        The ground's acceleration, as it is applied.
    count
        Number of plants, at least 1.
    seed
        Of the plants and of the noise.
    uncertainty
        Standard deviations of the plants; None: those of the benchmark.
    workers
        Number of threads, which does not change the result; None: one for each processor that this process may use.
    progress
        Called with the fraction that is done, 0 to 1.

    Returns
    -------
    BatchResult
        The criteria of each plant, and how many were unstable.

    Raises
    ------
    InputError
        ``count`` is not a whole number of at least 1, or the specimen is not held to the ground.

    Examples
    --------
    >>> import dampyr as dp
    >>> setup = dp.hybrid.HybridSetup(dp.studies.load_structure("vrths_2020_case_1"))
    >>> compensator, motion = dp.hybrid.KalmanCompensator.designed(setup), dp.ground_motions.el_centro().scaled(0.4)
    >>> batch = dp.hybrid.run_many(setup, compensator, motion, 3)
    >>> batch.unstable, batch.true.shape
    (0, (3, 9))
    """
    from threadpoolctl import ThreadpoolController

    workers = workers or (len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count())
    plants = draw_plants(nominal, count, seed, uncertainty)
    ground = ground_history(motion, nominal.dt)
    reference = reference_history(nominal.structure, ground, nominal.dt)
    floor = compared_floor(nominal)
    true, measured = np.full((count, 9), np.nan), np.full((count, 9), np.nan)
    radius, at_limit, diverged = np.zeros(count), np.zeros(count, dtype=np.int64), np.zeros(count, dtype=bool)
    n = nominal.structure.n

    def run_plant(k: int) -> None:
        setup = nominal.with_plant(*(float(value) for value in plants[k]))
        radius[k] = abs(largest_eigenvalue(setup, compensator, compensator.matched(setup)))
        noise = np.random.default_rng([seed, k])
        out, _, done, at_limit[k] = histories(setup, compensator, ground, noise, False)
        diverged[k] = done < len(ground)
        if not diverged[k]:
            target = setup.connection @ out[:n]
            true[k] = tracking_criteria(out[n], target, out[:n], reference, floor, setup.dt)
            measured[k] = [*tracking_error(out[n + 1], target, reference[floor - 1], setup.dt), *true[k, 5:]]

    # matrices of 20 rows in threads of BLAS's own wait for one another longer than they compute
    with ThreadpoolController().limit(limits=1, user_api="blas"), ThreadPoolExecutor(workers) as pool:
        for done, _ in enumerate(pool.map(run_plant, range(count)), start=1):
            if progress is not None:
                progress(done / count)
    return BatchResult(nominal.structure.name, plants, true, measured, radius, at_limit, diverged)
