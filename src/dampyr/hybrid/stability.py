r"""Stability of the loop before it runs: the eigenvalues of the linear, sampled loop, its delays included.

Noise, converters and the limit of the force are left out, and an adaptive compensator is held at coefficients. The state of
the loop is that of the numerical part, of the plant, of the compensator, and the forces under way. It is stable where every
eigenvalue is inside the unit circle. An adaptive compensator is judged at the coefficients to which it adapts; where it starts
from others with which the loop is unstable, `LoopStability.start_radius` says so, and the run shows whether it adapts in time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.hybrid.compensators import Compensator
from dampyr.hybrid.loop_kernel import MODEL_BASED
from dampyr.hybrid.setup import HybridSetup

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LoopStability:
    """Verdict on a loop: the largest eigenvalue's size ``radius``, its ``frequency`` [Hz] and ``growth`` [1/s], negative
    where it decays; ``start_radius`` of an adaptive compensator's first coefficients; ``reason`` in words."""

    stable: bool
    radius: float
    frequency: float
    growth: float
    start_radius: float
    reason: str


def loop_stability(setup: HybridSetup, compensator: Compensator) -> LoopStability:
    """Whether the loop is stable, and why it is not."""
    theta = compensator.matched(setup)
    largest = largest_eigenvalue(setup, compensator, theta)
    radius = float(abs(largest))
    frequency = float(abs(np.angle(largest)) * setup.rate / (2.0 * np.pi))
    growth = float(np.log(radius) * setup.rate)
    law = compensator.law(setup)
    start = radius
    if theta is not None:
        first = law.theta * law.scale / setup.rate ** np.arange(len(law.theta))
        start = abs(largest_eigenvalue(setup, compensator, first))
    stable = radius < 1.0
    reason = _describe_stability(setup, stable, frequency, growth)
    if stable and start >= 1.0:
        name = "the published start" if law.kind == MODEL_BASED else "its start"
        reason += f"; with {name} it is not (growing by {np.log(start) * setup.rate:.3g} 1/s) until the compensator has adapted"
    return LoopStability(stable, radius, frequency, growth, start, reason)


def _describe_stability(setup: HybridSetup, stable: bool, frequency: float, growth: float) -> str:
    if stable:
        return f"stable: its slowest mode, at {frequency:.3g} Hz, decays by {-growth:.3g} 1/s"
    damping = float(np.nanmin(setup.structure.damping_ratios))
    return (
        f"unstable: its mode at {frequency:.3g} Hz grows by {growth:.3g} 1/s, because the command and the force come too late "
        f"or too strong for a structure whose least damping ratio is {100 * damping:.3g} %; take a compensator that "
        "delays less, a lower gain, more damping, or a specimen that is softer beside the structure"
    )


def largest_eigenvalue(setup: HybridSetup, compensator: Compensator, theta: Array | None) -> complex:
    """The eigenvalue of the loop over one sample that is farthest from 0."""
    values = np.linalg.eigvals(loop_matrix(setup, compensator, theta))
    return complex(values[np.argmax(np.abs(values))])


def loop_matrix(setup: HybridSetup, compensator: Compensator, theta: Array | None) -> Array:
    """The loop over one sample: states of the numerical part (2n), of the plant (5), past forces, the compensator's."""
    numerical, _, by_force = setup.numerical_step
    plant, command = setup.plant_step
    a, by_target, by_measured, c, d = compensator.linear(setup, theta)
    row, late, n = setup.connection, setup.force_delay, setup.structure.n
    ends = np.cumsum([2 * n, 5, late + 1, len(a)])
    z, p, past, states = np.split(np.eye(ends[-1]), ends[:-1])
    target, measured, forces = row @ z[:n], p[3], np.vstack([p[2], past])
    held = forces[late] + compensator.extrapolation * (forces[late] - forces[late + 1])
    u = c @ states + d[0] * target + d[1] * measured
    following = a @ states + np.outer(by_target, target) + np.outer(by_measured, measured)
    return np.vstack(
        [numerical @ z + np.outer(by_force, held), plant @ p + np.outer(command, u), forces[:-1], following]
    )
