"""The arrays that the coupling kernel works on, by name. n floors, N damper sites, P parameters, S states."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Linear(NamedTuple):
    """The building, as the kernel needs it. n floors, N sites."""

    half: Any  # (2n, 2n + 2 + 3N), see propagator
    whole: Any  # the same, over the whole step
    explicit: Any  # (6N, 2n + 2 + N)
    unknown: Any  # (6N, 2N)
    acceleration: Any  # (n, 2n + N): absolute acceleration from the state and the forces
    damping: Any  # (n, n)
    pull: Any  # (n,): influence @ M, what makes base shear of acceleration and input power of velocity
    drifts: Any  # (2n, 2n): the drift of every storey, then its rate, from the state
    connections: Any  # (N, n): a row per site


class Sites(NamedTuple):
    """The dampers: what they are and what they remember."""

    params: Any  # (N, 4, P): at h/4, h/2, 3h/4 and h of the step under way; they differ where the input does
    states: Any  # (N, S)
    delays: Any  # (N,) in steps, 0 for none
    inertance: Any  # (N,) kg, filled in by the kernel
    ring: Any  # (N, nodes): the latest undelayed forces


class Control(NamedTuple):
    """The laws that set the inputs of the dampers; a site without one has ``every`` 0."""

    kind: Any  # (N,) which of the functions of `dampyr.structures.control_law.source`
    gains: Any  # (N, 2n + 1): what makes the signal of the state and the ground's velocity
    settings: Any  # (N, the most of a law)
    every: Any  # (N,) whole steps between decisions
    decay: Any  # (N, 4): what is left at h/4, h/2, 3h/4, h of the coil's gap to its command
    command: Any  # (N,) what was decided last
    level: Any  # (N,) at the coil, at the end of the step under way
    reached: Any  # (N, 2): the least and the greatest that was decided
    knots: Any  # (N, P, K), see dampyr.models.laws
    coefficients: Any  # (N, P, K, degree + 1)


class Output(NamedTuple):
    """What the kernel writes; a row per sample of the ground motion."""

    state: Any  # (samples, 2n)
    acceleration: Any  # (samples, n), absolute
    force: Any  # (samples, N)
    input: Any  # (samples, N) V or A, that of the force
    work: Any  # (samples, 2 + N): input, viscous, each damper
    displacement_peak: Any  # (n,)
    drift_peak: Any  # (n,)
    acceleration_peak: Any  # (n,)
    shear_peak: Any  # (1,)
    force_peak: Any  # (N,)
    rest_slopes: Any  # (N, 2): dF/dx and dF/dv at rest
    misfit: Any  # (3,): steps not solved to the tolerance, the largest relative misfit, iterations in all


class Node(NamedTuple):
    """The building at one instant."""

    z: Any  # (2n,)
    f: Any  # (N,)
    both: Any  # (2n + N,): z and f
    a: Any  # (n,) absolute acceleration
    q: Any  # (2n,): drifts, and their rates
    power: Any  # (2 + N,): input, viscous, each damper


class Scratch(NamedTuple):
    """Work space of one step."""

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


def node(n: int, sites: int) -> Node:
    """An empty node."""
    return Node(
        np.zeros(2 * n),
        np.zeros(sites),
        np.zeros(2 * n + sites),
        np.zeros(n),
        np.zeros(2 * n),
        np.zeros(2 + sites),
    )


def scratch(n: int, states: Array) -> Scratch:
    """An empty work space for n floors and as many sites as ``states`` has rows."""
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
        now=node(n, sites),
        half=node(n, sites),
        whole=node(n, sites),
        work=np.zeros(2 + sites),
    )


def output(samples: int, n: int, sites: int) -> Output:
    """An empty output."""
    return Output(
        state=np.zeros((samples, 2 * n)),
        acceleration=np.zeros((samples, n)),
        force=np.zeros((samples, sites)),
        input=np.zeros((samples, sites)),
        work=np.zeros((samples, 2 + sites)),
        displacement_peak=np.zeros(n),
        drift_peak=np.zeros(n),
        acceleration_peak=np.zeros(n),
        shear_peak=np.zeros(1),
        force_peak=np.zeros(sites),
        rest_slopes=np.zeros((sites, 2)),
        misfit=np.zeros(3),
    )
