"""One march of the kernel: the arrays it needs are made, and what it wrote is checked."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.structures.building import Building
from dampyr.structures.control_law import gains, source
from dampyr.structures.linear_response import march_bare
from dampyr.structures.propagator import propagator, system
from dampyr.structures.sites import Site, laws_of
from dampyr.structures.workspace import Linear, Output, Sites, output, scratch

Array = NDArray[np.float64]

FORCES_TO = 1e-10  # relative; the forces of a step are Newton's to about this


@dataclass(frozen=True, eq=False)
class Run:
    """One march and how it was judged."""

    out: Output
    step: float
    tolerance: float | None = None
    error: float | None = None
    reason: str = ""


def runner(building: Building, motion: GroundMotion, sites: tuple[Site, ...]) -> Any:
    """A function of the steps per sample that marches once; of the motion times ``scale`` where that is given."""
    if not sites:
        return lambda m, scale=1.0: Run(march_bare(building, motion.scaled(scale), m), motion.dt / m)
    kernel = _governed(building, sites) if laws_of(sites) else _constant(sites)
    linear = lru_cache(maxsize=2)(lambda step: _linear(building, sites, step))

    def run(m: int, samples: int | None = None, start: float = 0.0, scale: float = 1.0) -> Run:
        """``start`` is where between the least and the greatest input of its law each damper is at first."""
        ag = motion.acceleration[:samples] * scale
        step = motion.dt / m
        out = output(len(ag), building.n, len(sites))
        memory = _memory(sites, step, start)
        kernel(ag, m, step, linear(step), memory, scratch(building.n, memory.states), out)
        _check_bounded(out, motion)
        return Run(out, step)

    return run


def _constant(sites: tuple[Site, ...]) -> Any:
    """The march at constant inputs."""
    from dampyr.models.codegen.kernels import bind
    from dampyr.structures.time_stepping import march

    kernel = bind(march, tuple(site.composition for site in sites))

    def run(ag: Array, m: int, step: float, linear: Linear, memory: Sites, work: Any, out: Output) -> None:
        out.input[:] = [site.input_value for site in sites]
        kernel(ag, m, step, FORCES_TO, linear, memory, work, out)

    return run


def _governed(building: Building, sites: tuple[Site, ...]) -> Any:
    """The march where at least one input is set by a law."""
    from dampyr.models.codegen.kernels import bind
    from dampyr.structures.control_kernel import check_reached, control
    from dampyr.structures.controlled_stepping import march

    text, kinds = source(tuple(site.law for site in sites))
    kernel = bind(march, tuple(site.composition for site in sites), text)
    rows = connections(building, sites)
    nothing = np.zeros(2 * building.n + 1)
    law_gains = np.array(
        [gains(s.law, building, row) if s.law else nothing for s, row in zip(sites, rows, strict=True)]
    )

    def run(ag: Array, m: int, step: float, linear: Linear, memory: Sites, work: Any, out: Output) -> None:
        governors = control(sites, kinds, law_gains, step)
        kernel(ag, m, step, FORCES_TO, linear, memory, governors, work, out)
        check_reached(sites, governors)

    return run


def _linear(building: Building, sites: tuple[Site, ...], step: float) -> Linear:
    rows, n = connections(building, sites), building.n
    exact = propagator(building, rows, step)
    a, _, b = system(building, rows)
    by_storey = np.kron(np.eye(2), drifts(building))
    pull = np.ascontiguousarray(building.influence @ building.M)
    acceleration = np.ascontiguousarray(np.hstack([a[n:], b[n:]]))
    damping = np.array(building.C)
    return Linear(exact.half, exact.whole, exact.explicit, exact.unknown, acceleration, damping, pull, by_storey, rows)


def _memory(sites: tuple[Site, ...], step: float, start: float = 0.0) -> Sites:
    """Parameters, states and past of the dampers at the start."""
    width = max([1, *(len(site.values) for site in sites)])
    depth = max([1, *(site.composition.n_states for site in sites)])
    params, states = np.zeros((len(sites), 4, width)), np.zeros((len(sites), depth))
    for d, site in enumerate(sites):
        params[d, :, : len(site.values)] = site.values if start == 0.0 or site.law is None else site.between(start)
        states[d, : site.composition.n_states] = site.composition.state0
    delays = np.array([site.delay / step for site in sites], dtype=float)
    nodes = 2 * math.ceil(max([0.0, *delays])) + 6
    return Sites(params, states, delays, np.zeros(len(sites)), np.zeros((len(sites), nodes)))


def _check_bounded(out: Output, motion: GroundMotion) -> None:
    bad = ~np.isfinite(out.state).all(axis=1)
    if bad.any():
        when = float(np.argmax(bad)) * motion.dt
        raise InputError(
            f"the response grows without bound by {when:.2f} s: a damper "
            "feeds the building; check its delay, "
            "the signs of its parameters and the range of its input"
        )


def connections(building: Building, sites: tuple[Site, ...]) -> Array:
    return np.array([building.connection(site.place) for site in sites]).reshape(len(sites), building.n)


def drifts(building: Building) -> Array:
    return np.array([building.connection(storey) for storey in range(1, building.n + 1)])
