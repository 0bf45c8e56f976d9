"""A virtual hybrid test: the loop through a ground motion, with its histories and criteria."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.hybrid import loop_kernel
from dampyr.hybrid.compensators import Compensator
from dampyr.hybrid.criteria import Criteria, tracking_criteria
from dampyr.hybrid.loop_kernel import ORDER, Memory, Numerical, Plant
from dampyr.hybrid.setup import HybridSetup, building_step
from dampyr.hybrid.stability import LoopStability, loop_stability
from dampyr.models.codegen.kernels import compile_cached
from dampyr.origin import VIRTUAL, Origin
from dampyr.shown import Shown
from dampyr.structures import Building

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class VirtualRun(Shown):
    """Histories of a virtual hybrid test, every ``dt`` s.

    ``floors`` (n, T) of the numerical part, ``displacement`` (T,) of the specimen, ``measured`` the same as its sensor gives
    it, ``command`` (T,), all [m]; ``force`` (T,) [N]; ``theta`` (T, 4) of an adaptive compensator (of `KalmanCompensator` over
    its start); ``reference`` (n, T) of the structure. ``at_limit`` samples were at the actuator's greatest force. ``diverged``:
    the run ended early because the displacement passed 1 m.
    """

    setup: HybridSetup
    stability: LoopStability
    floors: Array
    displacement: Array
    measured: Array
    command: Array
    force: Array
    theta: Array
    ground: Array
    at_limit: int
    diverged: bool
    origin: ClassVar[Origin] = VIRTUAL

    @property
    def time(self) -> Array:
        """Times of the samples (T,) [s]."""
        return np.arange(len(self.displacement), dtype=np.float64) * self.setup.dt

    @property
    def target(self) -> Array:
        """The displacement (T,) [m] that the specimen should have."""
        target: Array = self.setup.connection @ self.floors
        return target

    @cached_property
    def reference(self) -> Array:
        """The displacements (n, T) [m] of the whole structure, computed."""
        return reference_history(self.setup.structure, self.ground, self.setup.dt)

    def criteria(self, measured: bool = False) -> Criteria:
        """J1 to J9, judged on the true displacement of the specimen, or on the measured one.

        InputError where the run diverged, for it has none then.
        """
        if self.diverged:
            raise InputError(f"the run diverged at {self.time[-1]:.3f} s; it has no criteria")
        displacement = self.measured if measured else self.displacement
        floor = compared_floor(self.setup)
        return tracking_criteria(displacement, self.target, self.floors, self.reference, floor, self.setup.dt)


def perform_virtual(
    setup: HybridSetup, compensator: Compensator, motion: GroundMotion, seed: int = 0, check: bool = True
) -> VirtualRun:
    """A virtual hybrid test: the loop of computed structure, actuator and specimen through a ground motion.

    Parameters
    ----------
    setup
        Structure, specimen, actuator, sensors and rate.
    compensator
        Gives the actuator's command, such as `KalmanCompensator`.
    motion
        The ground's acceleration, as it is applied.
    seed
        Of the sensors' noise: the same calls give the same bits.
    check
        Whether an unstable loop is refused before it runs; without, it runs all the same.

    Returns
    -------
    VirtualRun
        The histories; ``criteria()`` are J1 to J9.

    Raises
    ------
    InputError
        The loop is unstable; the sentence has the reason.

    Examples
    --------
    >>> import dampyr as dp
    >>> setup = dp.hybrid.HybridSetup(dp.studies.load_structure("vrths_2020_case_1"))
    >>> compensator = dp.hybrid.KalmanCompensator.designed(setup)
    >>> run = dp.hybrid.perform_virtual(setup, compensator, dp.ground_motions.el_centro().scaled(0.4))
    >>> run.stability.stable, run.criteria().J2 < 1.0
    (True, True)
    """
    stability = loop_stability(setup, compensator)
    if check and not stability.stable:
        raise InputError(f"the hybrid test of {setup.structure.name} was not run: the loop is {stability.reason}")
    ground = ground_history(motion, setup.dt)
    out, theta, done, at_limit = histories(setup, compensator, ground, np.random.default_rng(seed), True)
    n = setup.structure.n
    floors, (x, measured, command, force) = out[:n, :done], out[n:, :done]
    return VirtualRun(
        setup, stability, floors, x, measured, command, force, theta[:done], ground[:done], at_limit, done < len(ground)
    )


def histories(
    setup: HybridSetup, compensator: Compensator, ground: Array, noise: np.random.Generator, with_theta: bool
) -> tuple[Array, Array, int, int]:
    """What the kernel writes (n + 4, T) and (T, 4), the samples done, and those at the greatest force."""
    n, s = setup.structure.n, setup.sensors
    states, by_ground, by_force = setup.numerical_step
    plant, command = setup.plant_step
    z = np.zeros(2 * n)
    numerical = Numerical(states, by_ground, by_force, np.ascontiguousarray(setup.connection), int(setup.force_delay),
                          z, z.copy(), np.zeros(setup.force_delay + 2))  # fmt: skip
    noises = [float(np.sqrt(power * setup.rate)) for power in (s.displacement_noise, s.force_noise)]
    machine = Plant(
        states=plant,
        command=command,
        max_force=float(setup.transfer.max_force),
        displacement_noise=noises[0],
        force_noise=noises[1],
        step=s.step,
        limit=float(s.limit),
        displacement_scale=float(s.displacement_scale),
        force_scale=float(s.force_scale),
        p=np.zeros(5),
    )
    memory = Memory(*(np.zeros(size) for size in (4, 3, 4, 4, 4)))
    out, theta = np.zeros((n + 4, len(ground))), np.zeros((len(ground) if with_theta else 0, ORDER))
    drawn = noise.standard_normal((2, len(ground))) if any(noises) else np.zeros((2, len(ground)))
    kernel = compile_cached(loop_kernel.run_loop)
    done, at_limit = kernel(ground, drawn, numerical, machine, compensator.law(setup), memory, out, theta)
    return out, theta, int(done), int(at_limit)


def ground_history(motion: GroundMotion, dt: float) -> Array:
    """The ground's acceleration (T,) [m/s2] every ``dt`` s, linear between the samples of the motion."""
    count = int(np.floor(motion.duration / dt + 1e-9)) + 1
    return np.interp(np.arange(count) * dt, motion.time, motion.acceleration)


def reference_history(structure: Building, ground: Array, dt: float) -> Array:
    """Displacements (n, T) [m] of the whole structure under a ground acceleration (T,) linear between its samples."""
    states, by_ground, _ = building_step(structure, np.zeros(structure.n), dt)
    z, out = np.zeros(2 * structure.n), np.zeros((structure.n, len(ground)))
    compile_cached(loop_kernel.linear_history)(states, by_ground, np.ascontiguousarray(ground), z, z.copy(), out)
    return out


def compared_floor(setup: HybridSetup) -> int:
    """The floor, counted from 1, whose reference the specimen's displacement is compared with: it is held to the ground."""
    row = setup.connection
    if np.count_nonzero(row) != 1:
        raise InputError(
            f"the specimen at {setup.structure.place_label(setup.place)} is not held to the ground; the criteria compare the "
            "displacement of a floor: put it in storey 1, or between the ground and a floor"
        )
    return int(np.argmax(np.abs(row))) + 1
