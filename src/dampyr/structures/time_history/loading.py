r"""What pushes a building in a response: its ground, its supports, and forces on its floors, on one base of time.

.. math:: M \ddot q + C \dot q + K q = -M \iota\, a_g + \sum_c P_c\, u_c - \sum_d \lambda_d f_d

Each load c is a history u, linear between samples, and a column P: of a force on a floor the unit of that floor and u in N, of
a support :math:`-M R_s` and its acceleration. Absolute accelerations are :math:`\ddot q + \iota a_g + \sum_s R_s \ddot y_s`,
and what the structure hands to the ground is all inertia less what the floors' forces balance of it.

Motions and loads with different times are sampled at their common step, in which all corners of both lie: nothing is smoothed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dampyr.argument_kinds import described
from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, followed_by_rest
from dampyr.structures.building import Building
from dampyr.structures.floor_loads import FloorLoads
from dampyr.structures.propagator import driven_sites
from dampyr.structures.supports import SupportedBuilding, SupportMotions

Array = NDArray[np.float64]
LONGEST, SHORTEST = 0.01, 1e-4  # s between samples of a response to loads
EVEN = 1e-4  # relative: what times of even samples differ by in the digits of a file
DIGITS, ROUNDED = 9, 1.5e-6  # of a step: decimal digits of its denominator, and its relative error in a file


class Loads(NamedTuple):
    """The loads of a building as numbers; r of them, n coordinates, N dampers."""

    values: Any  # (samples, r): N of a force, m/s2 of a support
    push: Any  # (n, r): M^-1 P, accelerations by one unit
    seen: Any  # (n, r): what of it is in absolute accelerations
    shear: Any  # (r,): what a unit takes off the inertia that reaches the ground
    power: Any  # (r, n): P'
    carried: Any  # (n, r): the velocity of a coordinate by that of a support


class StepLoads(NamedTuple):
    """The same over one step, as the kernel needs it."""

    values: Any  # (samples, r)
    half: Any  # (2n, 2r), see `dampyr.structures.propagator.driven`
    whole: Any  # (2n, 2r)
    site: Any  # (6N, 2r)
    seen: Any  # (n, r)
    shear: Any  # (r,)
    power: Any  # (r, n)
    ends: Any  # (2r,): the loads at both ends of the step; this and the following are written by the kernel
    at: Any  # (r,): at a node
    velocity: Any  # (r,): the integrals so far, of a support its velocity


@dataclass(frozen=True, eq=False)
class Excitation:
    """All that pushes a building: ``motion`` of the ground on the common step, of zeros where it rests; ``floor_loads`` and
    ``supports`` as given, and their histories ``values`` (samples, r), the ``floors`` that are loaded before the supports."""

    motion: GroundMotion
    floor_loads: FloorLoads | None
    supports: SupportMotions | None
    floors: tuple[int, ...]
    values: Array
    title: str

    def rows(self, building: Building) -> Array:
        """The loaded floors of ``building`` as dampers to the ground would be connected (floors, n)."""
        return np.eye(building.n)[[floor - 1 for floor in self.floors]]

    def loads(self, building: Building) -> Loads | None:
        """The loads in the coordinates of ``building``, the floors first; None where there are none."""
        if not self.values.shape[1]:
            return None
        forces = self.rows(building).T
        by_floors = np.linalg.solve(building.M, forces)
        R = building.support_influence if isinstance(building, SupportedBuilding) else np.zeros((building.n, 0))
        supports = R.shape[1]
        return Loads(
            values=self.values,
            push=np.hstack([by_floors, -R]),
            seen=np.ascontiguousarray(np.hstack([by_floors, np.zeros_like(R)])),
            shear=np.append(building.carried @ forces, np.zeros(supports)),
            power=np.ascontiguousarray(np.hstack([forces, -building.M @ R]).T),
            carried=np.hstack([np.zeros_like(by_floors), R]),
        )

    @property
    def support_accelerations(self) -> Array:
        """Those of the supports (supports, samples), in their order in the structure."""
        return np.ascontiguousarray(self.values[:, len(self.floors) :].T)


def excitation(
    building: Building, motion: GroundMotion | SupportMotions | None, loads: FloorLoads | None, after: float
) -> Excitation:
    """Motion and loads of a response on one base of time, with ``after`` seconds of rest, in which loads keep their last
    value."""
    _check(building, motion, loads)
    if loads is None and isinstance(motion, GroundMotion):
        return Excitation(followed_by_rest(motion, after), None, None, (), np.zeros((0, 0)), motion.name)
    if isinstance(after, bool) or not math.isfinite(after) or after < 0:
        raise InputError(f"after = {after!r} s is not allowed; it must be at least 0")
    title = " and ".join(given.name for given in (motion, loads) if given is not None)
    if loads is None:
        assert isinstance(motion, SupportMotions)
        assert isinstance(building, SupportedBuilding)
        moved = motion.followed_by_rest(after).of(building)
        rest = GroundMotion(np.zeros(moved[0].n), moved[0].dt, "rest")
        values = np.column_stack([each.acceleration for each in moved])
        return Excitation(rest, None, motion, (), values, title)
    end = max(loads.duration, 0.0 if motion is None else motion.duration) + after
    steps = [_step(loads.time, loads.name)] + ([] if motion is None else [motion.dt])
    step = common_step(steps, title) if len(steps) > 1 else steps[0]
    dt = step / math.ceil(step / LONGEST * (1 - 1e-9))
    time = dt * np.arange(math.ceil(end / dt * (1 - 1e-9)) + 1, dtype=np.float64)
    columns, ground = [loads.at(time)], np.zeros(len(time))
    if isinstance(motion, GroundMotion):
        ground = _sampled(motion, time)
    elif motion is not None:
        assert isinstance(building, SupportedBuilding)
        columns += [_sampled(each, time)[:, None] for each in motion.of(building)]
    elif isinstance(building, SupportedBuilding):  # its supports rest
        columns += [np.zeros((len(time), len(building.supports)))]
    whole = GroundMotion(ground, dt, title, history=("sampled with the loads",))
    supports = motion if isinstance(motion, SupportMotions) else None
    return Excitation(whole, loads, supports, loads.floors_of(building), np.hstack(columns), title)


def _check(building: Building, motion: Any, loads: Any) -> None:
    if loads is not None and not isinstance(loads, FloorLoads):
        raise InputError(
            f"loads is {described(loads)}; give FloorLoads, such as dampyr.structures.read_loads('wind.csv') or "
            "FloorLoads(time, {1: forces})"
        )
    if motion is None and loads is None:
        raise InputError("neither a motion nor loads are given; give a GroundMotion, loads=, or both")
    if isinstance(building, SupportedBuilding) and isinstance(motion, GroundMotion):
        names = ", ".join(f"{name!r}: motion" for name in building.supports)
        raise InputError(
            f"{building.name} stands on several supports; give SupportMotions({{{names}}}) where they move alike, and for a "
            "car dampyr.structures.axle_roads(...)"
        )
    if isinstance(motion, SupportMotions) and not isinstance(building, SupportedBuilding):
        raise InputError(
            f"{building.name} stands on one ground, and motions of the supports {', '.join(motion.motions)} are given; give a "
            "GroundMotion, or a structure of dampyr.structures.with_supports"
        )


def _sampled(motion: GroundMotion, time: Array) -> Array:
    """The acceleration at finer times, linear between its samples, and rest after them."""
    rest = max(0.0, float(time[-1]) - motion.duration)
    whole = followed_by_rest(motion, rest) if rest > 1e-9 * motion.duration else motion
    return np.interp(time, whole.time, whole.acceleration)


def _step(time: Array, name: str) -> float:
    """The step in which all times of a record lie."""
    gaps, mean = np.diff(time), float((time[-1] - time[0]) / (len(time) - 1))
    if np.max(np.abs(gaps - mean)) <= EVEN * mean:
        return mean if time[0] < EVEN * mean else common_step([mean, float(time[0])], name)
    return common_step([gap for gap in np.unique(np.round(np.append(gaps, time[0]), 9)) if gap > 0], name)


def common_step(steps: Iterable[float], what: str) -> float:
    """The longest step [s] of which all ``steps`` are whole multiples; InputError where it is under 0.1 ms."""
    numerators, denominators = [], []
    for step in steps:
        simpler = (Fraction(step).limit_denominator(10**digits) for digits in range(1, DIGITS))
        # a step in the digits of a file, such as 0.033333, is the simplest number that it may stand for
        fraction = next((each for each in simpler if abs(float(each) - step) <= ROUNDED * step), Fraction(step))
        numerators.append(fraction.numerator)
        denominators.append(fraction.denominator)
    whole = math.lcm(*denominators)
    common = Fraction(
        math.gcd(*(top * (whole // below) for top, below in zip(numerators, denominators, strict=True))), whole
    )
    if common < Fraction(SHORTEST):
        raise InputError(
            f"{what}: the times have no common step of at least {1e3 * SHORTEST:g} ms; resample one of them, so that its step "
            "is a whole part or a multiple of the other's"
        )
    return float(common)


def over_step(loads: Loads | None, building: Building, connections: Array, step: float) -> StepLoads | None:
    """The loads over a step of so many seconds; None for none."""
    if loads is None:
        return None
    half, whole, site = driven_sites(building, connections, loads.push, step)
    count = loads.values.shape[1]
    return StepLoads(
        np.ascontiguousarray(loads.values), half, whole, site, loads.seen, loads.shear, loads.power, np.zeros(2 * count),
        np.zeros(count), np.zeros(count),
    )  # fmt: skip
