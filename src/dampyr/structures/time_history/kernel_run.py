"""Integration by the time-stepping kernel: its arrays by name, how they are filled, and what it wrote checked.

In the shapes, n is the number of floors, N of damper sites, P of parameters, S of states.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.models.codegen.composition import Composition
from dampyr.models.laws import polynomial_table
from dampyr.structures.building import Building
from dampyr.structures.control_laws import check_decided, lag_of
from dampyr.structures.controller import Controller, design_controller, law_source
from dampyr.structures.propagator import propagator, system
from dampyr.structures.sites import Site, connections, describe_place, drifts
from dampyr.structures.time_history.linear_response import bare_response
from dampyr.structures.time_history.loading import Loads, StepLoads, over_step
from dampyr.structures.time_history.response import Decisions, Integration, Output, output
from dampyr.structures.wanted_force import reasons_of, wanted_forces

Array = NDArray[np.float64]

FORCE_TOLERANCE = 1e-10  # relative, of Newton's method: far below the 2e-4 to which a strict response is computed


class Linear(NamedTuple):
    """The linear building, as the kernel needs it."""

    half: Any  # (2n, 2n + 2 + 3N), see propagator
    whole: Any  # the same, over the whole step
    explicit: Any  # (6N, 2n + 2 + N)
    unknown: Any  # (6N, 2N)
    acceleration: Any  # (n, 2n + N): absolute acceleration from the state and the forces
    damping: Any  # (n, n)
    pull: Any  # (n,): influence @ M, turns accelerations into base shear and velocities into input power
    ground: Any  # (n + 1,): what the ground's acceleration adds to each acceleration and to the base shear, of what is left out
    drifts: Any  # (2n, 2n): the drift of every storey, then its rate, from the state
    connections: Any  # (N, n): a row per site


class Sites(NamedTuple):
    """The dampers: parameters, states and past forces."""

    kind: Any  # (N,) which of the compositions that the kernel was bound with
    params: Any  # (N, 4, P): at h/4, h/2, 3h/4 and h of the step under way; they differ where the input does
    states: Any  # (N, S)
    delays: Any  # (N,) in steps, 0 for none
    inertance: Any  # (N,) kg, filled in by the kernel
    ring: Any  # (N, nodes): the latest undelayed forces


class Control(NamedTuple):
    """The laws that set the inputs of the dampers; a site without one has ``every`` 0."""

    kind: Any  # (N,) which of the functions of `dampyr.structures.controller.law_source`
    rows: Any  # (N, Y, 2n + 2 + N + 2r): this and the following as in `Controller`, a law each, filled up with zeros
    faults: Any  # (N, Y, 4)
    late: Any  # (N, Y)
    channels: Any  # (N, Y)
    of_memory: Any  # (N, A, X)
    of_measured: Any  # (N, A, Y)
    F: Any  # (N, X, X)
    G: Any  # (N, X, Y)
    ideal: Any  # (N,) whether all of its sensors give what they measure
    seed: Any  # (N,) of their noise
    signals: Any  # (N,) how many arguments of the law are signals: the others are its states
    count: Any  # (N,) how many arguments it has
    known: Any  # (2n + 2 + N + 2r,): what a step knows; this and the following are written by the kernel
    past: Any  # (N, depth, Y): the latest measures
    measured: Any  # (N, Y): what the sensors give
    memory: Any  # (N, X)
    next_memory: Any  # (X,)
    arguments: Any  # (N, A): signals and states at the latest decision
    corner: Any  # (A,): arguments that are a little off
    settings: Any  # (N, the longest of a law)
    every: Any  # (N,) whole steps between decisions
    decay: Any  # (N, 4): the remaining share of the coil's gap to its command at h/4, h/2, 3h/4, h
    mean_decay: Any  # (N,): its mean over a step
    total: Any  # (N,): the sum over the steps of the mean input in each
    command: Any  # (N,) the latest decision
    level: Any  # (N,) at the coil, at the end of the step under way
    reached: Any  # (N, 2): the least and the greatest decision so far
    sensed: Any  # (N, D, A + 1): the arguments at every decision, and the decision; written by the kernel
    before: Any  # (N, D, A + 1): the same of the run at twice the step; (N, 0, A + 1) for none
    other: Any  # (N, D): the farthest decision that the law could have taken within the change from ``before``; written too
    imposed: Any  # (N, D): decisions to take in place of the law's, NaN for the law's own; (N, 0) for none
    knots: Any  # (N, P, K), see dampyr.models.laws
    coefficients: Any  # (N, P, K, degree + 1)


class Node(NamedTuple):
    """The building at one instant."""

    z: Any  # (2n,)
    f: Any  # (N,)
    both: Any  # (2n + N,): z and f
    a: Any  # (n,) absolute acceleration
    q: Any  # (2n,): drifts, and their rates
    power: Any  # (2 + N,): input, viscous, each damper


class Scratch(NamedTuple):
    """Workspace of one step."""

    u: Any  # (2n + 2 + 3N,): z0, ag0, ag1, f0, fh, f1
    base: Any  # (6N,): the motion of the sites that the unknown forces do not touch
    y: Any  # (6N,): xh, vh, ah, x1, v1, a1
    start: Any  # (2N,): x0, v0
    g: Any  # (2N,): fh, f1
    raw: Any  # (2N,)
    slope: Any  # (2N, 2)
    jacobian: Any  # (2N, 2N)
    residual: Any  # (2N,)
    states: Any  # (N, S)
    rest: Any  # (N,)
    now: Any  # a Node, at the start of the step
    half: Any  # the same, at its middle
    whole: Any  # the same, at its end
    work: Any  # (2 + N,): input, viscous, each damper, so far


class DampedRun:
    """A building with dampers under a motion and ``loads``, integrated at each call with so many steps per sample."""

    def __init__(
        self, building: Building, motion: GroundMotion, sites: tuple[Site, ...], loads: Loads | None = None
    ) -> None:
        from dampyr.models.codegen.kernels import bind
        from dampyr.structures.time_history.time_stepping import integrate

        self.building, self.motion, self.sites, self.loads = building, motion, sites, loads
        laws, rows = tuple(site.law for site in sites), connections(building, sites)
        self.under_laws = any(laws)
        text, self.kinds = law_source(laws) if self.under_laws else ("", [])
        self.kernel = bind(integrate, distinct(sites), text)
        self.controllers = [
            design_controller(site.law, building, rows, d, loads=loads) if site.law else None
            for d, site in enumerate(sites)
        ]
        self.linear = lru_cache(maxsize=2)(lambda step: _linear(building, sites, step))

    def __call__(
        self, m: int, scale: float = 1.0, before: Array | None = None, imposed: Array | None = None
    ) -> Integration:
        """With m steps per sample, of the motion times ``scale``; ``before`` are the decisions of a run at another step, to
        compare with, and ``imposed`` such to take (see `Control`)."""
        building, sites, ag, step = self.building, self.sites, self.motion.acceleration * scale, self.motion.dt / m
        out, dampers, steps = output(len(ag), building.n, len(sites)), _dampers(sites, step), (len(ag) - 1) * m
        control = self._control(step, steps, before, imposed)
        if control is None:
            out.input[:] = out.mean_input[:] = [site.input_value for site in sites]
        work, models = _scratch(building.n, dampers.states), wanted_forces(sites, dampers.kind, self.controllers)
        loads = self._step_loads(step)
        self.kernel(ag, m, step, FORCE_TOLERANCE, self.linear(step), dampers, control, models, loads, work, out)
        if control is not None:
            _check_inputs(sites, control)
            out.mean_input[:] = control.total / steps if steps else control.level
        _check_bounded(out, self.motion)
        decisions = None if control is None else _decisions(control, steps)
        reasons = reasons_of(models, len(sites))
        return Integration(out.of_floors(building.n_floors), step, decisions=decisions, reasons=reasons)

    def _control(
        self, step: float, steps: int, before: Array | None = None, imposed: Array | None = None
    ) -> Control | None:
        if not self.under_laws:
            return None
        return _control(self.sites, self.kinds, self.controllers, step, steps, before, imposed)

    def _step_loads(self, step: float) -> StepLoads | None:
        return over_step(self.loads, self.building, connections(self.building, self.sites), step)

    def greatest_slopes(self) -> Array:
        """The greatest slopes of the dampers at rest (N, 2), over the inputs that their laws may take: they bound the step."""
        sites, step = self.sites, self.motion.dt
        ag, out, dampers = np.zeros(1), output(1, self.building.n, len(sites)), _dampers(sites, step)
        control, work = self._control(step, 0), _scratch(self.building.n, dampers.states)
        levels, slopes = [site.levels() for site in sites], []
        for k in range(max(map(len, levels))):
            for d, values in enumerate(levels):
                dampers.params[d, :, : values.shape[1]] = values[min(k, len(values) - 1)]
            models = wanted_forces(sites, dampers.kind, self.controllers)
            loads = self._step_loads(step)
            self.kernel(ag, 1, step, FORCE_TOLERANCE, self.linear(step), dampers, control, models, loads, work, out)
            slopes.append(np.abs(out.rest_slopes))
        return np.asarray(np.max(slopes, axis=0))


def runner(building: Building, motion: GroundMotion, sites: tuple[Site, ...], loads: Loads | None = None) -> Any:
    """A function of the steps per sample that integrates once; of the motion times ``scale`` where that is given. Of dampers it
    is a `DampedRun`."""
    if not sites:
        return lambda m, scale=1.0: Integration(bare_response(building, motion.scaled(scale), m, loads), motion.dt / m)
    return DampedRun(building, motion, sites, loads)


def distinct(sites: tuple[Site, ...]) -> tuple[Composition, ...]:
    """What the sites' dampers are composed of, each composition once and in one order: one kernel serves any number of dampers
    of the same kinds, wherever they stand."""
    return tuple(sorted({site.composition for site in sites}, key=lambda composition: composition.names))


def _linear(building: Building, sites: tuple[Site, ...], step: float) -> Linear:
    rows, n = connections(building, sites), building.n
    exact = propagator(building, rows, step)
    a, _, b = system(building, rows)
    by_storey = np.kron(np.eye(2), drifts(building))
    pull = np.ascontiguousarray(building.influence @ building.M)
    ground = np.append(*building.ground_terms())
    acceleration = np.ascontiguousarray(np.hstack([a[n:], b[n:]]))
    damping = np.array(building.C)
    return Linear(
        exact.half, exact.whole, exact.explicit, exact.unknown, acceleration, damping, pull, ground, by_storey, rows
    )


def _dampers(sites: tuple[Site, ...], step: float) -> Sites:
    """Parameters, states and past forces of the dampers at the start."""
    width = max([1, *(len(site.values) for site in sites)])
    depth = max([1, *(site.composition.n_states for site in sites)])
    params, states = np.zeros((len(sites), 4, width)), np.zeros((len(sites), depth))
    for d, site in enumerate(sites):
        params[d, :, : len(site.values)] = site.values
        states[d, : site.composition.n_states] = site.composition.state0
    delays = np.array([site.delay / step for site in sites], dtype=float)
    nodes = 2 * math.ceil(max([0.0, *delays])) + 6
    compositions = distinct(sites)
    kind = np.array([compositions.index(site.composition) for site in sites], dtype=np.int64)
    return Sites(kind, params, states, delays, np.zeros(len(sites)), np.zeros((len(sites), nodes)))


def _check_bounded(out: Output, motion: GroundMotion) -> None:
    bad = ~np.isfinite(out.state).all(axis=1)
    if bad.any():
        when = float(np.argmax(bad)) * motion.dt
        raise InputError(
            f"the response grows without bound by {when:.2f} s: a damper "
            "feeds the building; check its delay, "
            "the signs of its parameters and the range of its input"
        )


def _control(
    sites: tuple[Site, ...],
    kinds: list[int],
    controllers: list[Controller | None],
    step: float,
    steps: int,
    before: Array | None = None,
    imposed: Array | None = None,
) -> Control:
    """The laws of the sites for ``steps`` steps of ``step`` seconds; ``kinds``, ``before`` ... as in `Control`."""
    present = [controller for controller in controllers if controller is not None]
    measured, known = max(len(controller.rows) for controller in present), present[0].rows.shape[1]
    memory, most = (
        max(len(controller.F) for controller in present),
        max(1, *(len(controller.formulas.arguments) for controller in present)),
    )
    decisions = max(math.ceil(steps / max(1, round(site.law.period / step))) for site in sites if site.law)
    count, tables = len(sites), [polynomial_table(site.damper, static=False) for site in sites]
    max_settings = max(1, *(len(controller.settings) for controller in present))
    depth_of_past = max(1, *(int(controller.delays.max(initial=0)) + 1 for controller in present))
    depth = [max(c.shape[axis] for _, c in tables) for axis in range(3)]
    control = Control(
        kind=np.array(kinds),
        rows=np.zeros((count, measured, known)),
        faults=np.zeros((count, measured, 4)),
        late=np.zeros((count, measured), dtype=np.int64),
        channels=np.zeros((count, measured), dtype=np.int64),
        of_memory=np.zeros((count, most, memory)),
        of_measured=np.zeros((count, most, measured)),
        F=np.zeros((count, memory, memory)),
        G=np.zeros((count, memory, measured)),
        ideal=np.ones(count, dtype=np.bool_),
        seed=np.zeros(count, dtype=np.uint64),
        signals=np.zeros(count, dtype=np.int64),
        count=np.zeros(count, dtype=np.int64),
        known=np.zeros(known),
        past=np.zeros((count, depth_of_past, measured)),
        measured=np.zeros((count, measured)),
        memory=np.zeros((count, memory)),
        next_memory=np.zeros(memory),
        arguments=np.zeros((count, most)),
        corner=np.zeros(most),
        settings=np.zeros((count, max_settings)),
        every=np.zeros(count, dtype=np.int64),
        decay=np.zeros((count, 4)),
        mean_decay=np.zeros(count),
        total=np.zeros(count),
        command=np.zeros(count),
        level=np.zeros(count),
        reached=np.tile([math.inf, -math.inf], (count, 1)),
        sensed=np.zeros((count, decisions, most + 1)),
        before=np.zeros((count, 0, most + 1)) if before is None else before,
        other=np.zeros((count, decisions)),
        imposed=np.zeros((count, 0)) if imposed is None else imposed,
        knots=np.full((count, *depth[:2]), math.inf),
        coefficients=np.zeros((count, *depth)),
    )
    for d, site in enumerate(sites):
        control.level[d] = control.command[d] = site.law.low if site.law else site.input_value
        if controller := controllers[d]:
            _fill(control, d, site, controller, step)
            knots, coefficients = tables[d]
            control.knots[d, : knots.shape[0], : knots.shape[1]] = knots
            control.coefficients[d][tuple(map(slice, coefficients.shape))] = coefficients
    return control


def _fill(control: Control, d: int, site: Site, controller: Controller, step: float) -> None:
    """Fill in what a law measures, its filter and settings, its sampling and the coil."""
    for name in ("rows", "faults", "of_memory", "of_measured", "F", "G"):
        values = getattr(controller, name)
        getattr(control, name)[d][tuple(map(slice, values.shape))] = values
    control.late[d, : len(controller.delays)] = controller.delays
    control.channels[d, : len(controller.channels)] = controller.channels
    control.ideal[d], control.seed[d] = controller.is_ideal, site.law.seed
    control.signals[d], control.count[d] = len(controller.formulas.signals), len(controller.formulas.arguments)
    control.arguments[d, control.signals[d] : control.count[d]] = controller.formulas.states
    control.every[d] = round(site.law.period / step)
    control.settings[d, : len(controller.settings)] = controller.settings
    if (lag := lag_of(site.law, site.damper)) > 0:
        control.decay[d] = np.exp(-np.arange(1, 5) * 0.25 * step / lag)
        control.mean_decay[d] = -math.expm1(-step / lag) * lag / step


def _decisions(control: Control, steps: int) -> Decisions:
    """What was decided in a number of steps."""
    every, number = control.every[:, None], np.arange(control.other.shape[1])
    return Decisions(control.sensed, control.other, (every > 0) & (number * every < steps))


def _check_inputs(sites: tuple[Site, ...], control: Control) -> None:
    """Raise InputError where a law returned an input outside its own bounds."""
    for site, (low, high) in zip(sites, control.reached, strict=True):
        if site.law is None or low > high:
            continue
        check_decided(site.law, describe_place(site.place), low, high)


def _node(n: int, sites: int) -> Node:
    """A node of zeros."""
    return Node(
        np.zeros(2 * n),
        np.zeros(sites),
        np.zeros(2 * n + sites),
        np.zeros(n),
        np.zeros(2 * n),
        np.zeros(2 + sites),
    )


def _scratch(n: int, states: Array) -> Scratch:
    """A workspace for n floors and as many sites as ``states`` has rows."""
    sites = len(states)
    return Scratch(
        u=np.zeros(2 * n + 2 + 3 * sites),
        base=np.zeros(6 * sites),
        y=np.zeros(6 * sites),
        start=np.zeros(2 * sites),
        g=np.zeros(2 * sites),
        raw=np.zeros(2 * sites),
        slope=np.zeros((2 * sites, 2)),
        jacobian=np.zeros((2 * sites, 2 * sites)),
        residual=np.zeros(2 * sites),
        states=states.copy(),
        rest=np.zeros(sites),
        now=_node(n, sites),
        half=_node(n, sites),
        whole=_node(n, sites),
        work=np.zeros(2 + sites),
    )
