"""Response of the bare building: linear, so every instant follows exactly from the sample before it, all at once.

The nodes, peaks and integrals are those of the time-stepping kernel, which is left out together with its compiler.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dampyr.ground_motions import GroundMotion
from dampyr.structures.building import Building
from dampyr.structures.propagator import driven, system, transition
from dampyr.structures.sites import drifts
from dampyr.structures.time_history.kernel_math import turning_point
from dampyr.structures.time_history.loading import Loads
from dampyr.structures.time_history.response import Output, output

Array = NDArray[np.float64]


def bare_response(building: Building, motion: GroundMotion, m: int, loads: Loads | None = None) -> Output:
    """The response of a building without dampers under a motion and loads, evaluated 2m times per sample of the motion."""
    n, none = building.n, np.zeros((0, building.n))
    state = _samples(building, motion, loads)
    a, _, _ = system(building, none)
    ground = np.column_stack([motion.acceleration[:-1], motion.acceleration[1:]])
    u, half = np.hstack([state[:-1], ground]), 0.5 * motion.dt / m
    out = output(motion.n, n, 0)
    out.state[:] = state
    direct, mass = building.ground_terms()
    out.acceleration[:] = state @ a[n:].T + np.outer(motion.acceleration, direct)
    if loads is not None:
        out.acceleration[:] += loads.values @ loads.seen.T
        pairs = np.hstack([loads.values[:-1], loads.values[1:]])
    to_drift = drifts(building)
    before, energy = state[:-1], np.zeros((motion.n - 1, 2))
    for j in range(2 * m + 1):
        part = j / (2 * m)
        now = u @ transition(building, none, motion.dt, part).T
        if loads is not None:
            now = now + pairs @ driven(building, loads.push, motion.dt, part).T
        # Simpson's rule over each half step, for the energies
        weight = (1.0 if j in (0, 2 * m) else 4.0 if j % 2 else 2.0) * half / 3.0
        at = ground @ [1.0 - part, part]
        energy += weight * _powers(building, now, at)
        if loads is not None:
            load = loads.values[:-1] + part * (loads.values[1:] - loads.values[:-1])
            energy[:, 0] += weight * np.einsum("tr,rn,tn->t", load, loads.power, now[:, n:])
        acceleration, missing = now @ a[n:].T + np.outer(at, direct), mass * at
        if loads is not None:
            acceleration, missing = acceleration + load @ loads.seen.T, missing - load @ loads.shear
        _observe(building, acceleration, missing, out)
        _raise_peaks(out.displacement_peak, before, now, half)
        _raise_peaks(out.drift_peak, _transform(before, to_drift), _transform(now, to_drift), half)
        before = now
    out.work[1:] = np.cumsum(energy, axis=0)
    return out.of_floors(building.n_floors)


def _samples(building: Building, motion: GroundMotion, loads: Loads | None) -> Array:
    """The state at the samples (samples, 2n)."""
    size = 2 * building.n
    step = transition(building, np.zeros((0, building.n)), motion.dt, 1.0)
    push = np.column_stack([motion.acceleration[:-1], motion.acceleration[1:]]) @ step[:, size:].T
    if loads is not None:
        push += np.hstack([loads.values[:-1], loads.values[1:]]) @ driven(building, loads.push, motion.dt, 1.0).T
    state, phi = np.zeros((motion.n, size)), step[:, :size]
    for k in range(motion.n - 1):
        state[k + 1] = phi @ state[k] + push[k]
    return state


def peak_displacement(x: Array, v: Array, dt: float) -> float:
    """The largest displacement of a motion (n,) sampled every ``dt``, between its samples too."""
    peak = np.zeros(1)
    state = np.column_stack([x, v])
    _raise_peaks(peak, state[:-1], state[1:], dt)
    return float(max(peak[0], abs(x[0])))


def _transform(state: Array, matrix: Array) -> Array:
    """``matrix`` applied to displacements and velocities alike."""
    n = len(matrix)
    return np.hstack([state[:, :n] @ matrix.T, state[:, n:] @ matrix.T])


def _powers(building: Building, state: Array, ground: Array) -> Array:
    """The power (samples, 2) that the ground puts in, and that the dashpots take."""
    v = state[:, building.n :]
    of_ground = -(v @ (building.influence @ building.M)) * ground
    return np.column_stack([of_ground, np.einsum("ti,ij,tj->t", v, building.C, v)])


def _observe(building: Building, acceleration: Array, missing: Array, out: Output) -> None:
    """Raise the peaks of acceleration and base shear; ``missing`` [N] is what the mass that was left out adds to the latter."""
    np.maximum(out.acceleration_peak, np.abs(acceleration).max(axis=0), out=out.acceleration_peak)
    shear = np.abs(acceleration @ (building.influence @ building.M) + missing).max()
    out.shear_peak[0] = max(out.shear_peak[0], shear)


def _raise_peaks(peaks: Array, before: Array, now: Array, dt: float) -> None:
    """Raise ``peaks`` to the largest displacement, at nodes and where the cubic between two of them turns."""
    n = len(peaks)
    x0, u0, x1, u1 = before[:, :n], before[:, n:] * dt, now[:, :n], now[:, n:] * dt
    np.maximum(peaks, np.abs(x1).max(axis=0), out=peaks)
    for row, k in np.argwhere(u0 * u1 < 0):
        _, turn = turning_point(x0[row, k], x1[row, k], u0[row, k], u1[row, k], 1.0)
        peaks[k] = max(peaks[k], abs(turn))
