"""What a simulated rig really did, judged by its ground truth: was it safe, and is a record of it right?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from dampyr.records import Record
from dampyr.rig import RigSettings
from dampyr.rig.firmware.protocol import State
from dampyr.rig.simulation import plant
from dampyr.rig.simulation.ground_truth import Truth

GIVES = 4.5e-4  # m that a damper's stop gives under the rig's largest force
BRAKED = 0.15  # s after which a table that is not driven stands
HOT = 0.2  # s in which a damper that is measured to be too hot is noticed


def unsafe(truth: Truth, since: float, rig: RigSettings, beats: Sequence[float]) -> list[str]:
    """The unsafe states after ``since`` [s], in words; ``beats`` are the times of the host's heartbeats."""
    new, limits = truth.time > since, rig.limits
    faults = []
    for what, values, limit in (
        ("force", truth.force, limits.force),
        ("speed", truth.speed, limits.speed),
        ("position", truth.position, 0.5 * limits.stroke + GIVES),
    ):
        worst = float(np.abs(values[new]).max(initial=0.0))
        if worst > limit:
            faults.append(f"{what} {worst:.5g} > {limit:.5g}")
    live = new & (truth.voltage != 0.0)
    if live.any():
        heard = np.array([-np.inf, *beats])
        alone = truth.time[live] - heard[np.searchsorted(heard, truth.time[live], side="right") - 1]
        if alone.max() > limits.heartbeat + 0.002:
            faults.append(f"coil live {alone.max():.3g} s after the last heartbeat")
        cold = truth.time[~(truth.temperature > limits.temperature)]
        hot = truth.time[live] - cold[np.maximum(np.searchsorted(cold, truth.time[live]) - 1, 0)] if cold.size else live
        if rig.wires.temperature and np.max(hot) > HOT:
            faults.append(f"coil live {np.max(hot):.3g} s at {truth.temperature[live].max():.4g} degC")
    moves = (truth.state >= State.FOLLOWING) & (truth.state <= State.STOPPING)
    driven = np.maximum.accumulate(np.where(moves, truth.time, -np.inf))
    if np.any(truth.speed[new & (truth.time - driven > BRAKED)]):
        faults.append("motion in a state that does not move")
    return faults


def true_channels(record: Record, truth: Truth, started: float, rig: RigSettings) -> dict[str, NDArray[np.float64]]:
    """The true quantities at a record's samples, (n,) SI; the board's clock began at ``started`` s of the simulator's.

    Sample k is read a period after it is due; the load cell's filter delays the force, and the displacement is that of the
    force. The voltage is stated for a coil at 20 degC.
    """
    now = started + record.time + 1.0 / rig.board.rate
    at = now - rig.force_delay
    output = np.searchsorted(truth.time, now + 0.5 / rig.board.rate, side="right") - 1
    volts = truth.voltage[output]
    if rig.supply.compensated:
        volts = volts / (1.0 + plant.COPPER * (truth.temperature[output] - plant.COPPER_AT))
    return {
        "displacement": np.interp(at, truth.time, truth.position),
        "force": np.interp(at, truth.time, truth.force),
        "velocity": np.interp(at, truth.time, truth.speed),
        "voltage": volts,
        "temperature": np.interp(now, truth.time, truth.temperature),
    }


def stated(record: Record) -> dict[str, float]:
    """The standard uncertainty of each channel that a record states, SI."""
    return {name: one.standard for name, one in record.uncertainty.items()}


def errors(record: Record, true: Mapping[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
    """Each channel less what it really was, (n,) SI."""
    channels = {name: getattr(record, name) for name in true}
    return {name: np.asarray(values - true[name]) for name, values in channels.items() if values is not None}
