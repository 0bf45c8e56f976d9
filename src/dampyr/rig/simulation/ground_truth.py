"""Ground truth of the simulated rig: its true quantities once a millisecond, and its events as sentences."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.rig.firmware.protocol import Fault, State
from dampyr.rig.firmware.twin import Twin
from dampyr.rig.simulation import plant
from dampyr.rig.simulation.chip import ChipFirmware

Array = NDArray[np.float64]
MAX_ROWS = 1_800_000  # rows: half an hour
RESTING = 1e-4  # m/s below which the table stands: one encoder count in 50 ms
LASTING = 0.05  # s before rest is reported: a turning point of the motion is shorter
DEAD = 0.01  # A below which the coil is dead, with no voltage at it: 2 % of the coil's 0.5 A at 2.2 V
T, X, V, F, U, AMPERE, HEAT, ENABLE, STATE, FAULTS, DUTY, HELD = range(len(plant.TRUTH))


@dataclass(frozen=True, eq=False)
class Truth:
    """Arrays (n,) of the last half hour, once a millisecond, SI.

    ``position`` m and ``speed`` m/s of the table, ``force`` N of the specimen, ``voltage`` V and ``current`` A of the coil,
    ``temperature`` degC of the specimen, ``enable`` the Uno's line, its ``state``, ``faults`` and ``duty``, and ``held``: the
    input was outside the specimen's calibrated range, and its laws held the value at the range's end.
    """

    time: Array
    position: Array
    speed: Array
    force: Array
    voltage: Array
    current: Array
    temperature: Array
    enable: NDArray[np.bool_]
    state: NDArray[np.int64]
    faults: NDArray[np.int64]
    duty: Array
    held: NDArray[np.bool_]
    at_rest_since: float
    coil_dead_since: float


class TruthLog:
    """Collects the rows of the ground truth, ``capacity`` of them; ``on_event`` is called with the time and a sentence for each
    event in them.
    """

    def __init__(self, on_event: Callable[[float, str], None] | None = None) -> None:
        self.on_event, self.capacity = on_event, MAX_ROWS
        self.chunks: deque[Array] = deque()
        self.count = 0
        self.at_rest_since = self.coil_dead_since = 0.0
        self._reported = {"rest": True, "dead": True}
        self.previous = (0, int(State.FAULT), int(Fault.RESTARTED), 0)

    def report(self, time: float, event: str) -> None:
        """Report an event."""
        if self.on_event is not None:
            self.on_event(time, event)

    def add(self, rows: Array) -> None:
        """Append rows, oldest first, and report the changes in them."""
        if not rows.size:
            return
        self.chunks.append(rows)
        self.count += len(rows)
        while self.chunks and self.count - len(self.chunks[0]) >= self.capacity:
            self.count -= len(self.chunks.popleft())
        self.at_rest_since = _since(rows, np.abs(rows[:, V]) < RESTING, self.at_rest_since)
        alive = (rows[:, U] != 0.0) | (np.abs(rows[:, AMPERE]) >= DEAD)
        self.coil_dead_since = _since(rows, ~alive, self.coil_dead_since)
        if self.on_event is not None:
            columns = rows[:, [ENABLE, STATE, FAULTS, HELD]].astype(int)
            changed = np.any(np.diff(columns, axis=0, prepend=[self.previous]) != 0, axis=1)
            for k in np.flatnonzero(changed):
                self._note(float(rows[k, T]), *map(int, columns[k]))
            now = float(rows[-1, T])
            self._report_lasting("rest", ("at rest", "moving"), self.at_rest_since, now)
            self._report_lasting("dead", ("coil dead", "coil live"), self.coil_dead_since, now)

    def record_state(self, time: float, twin: Twin | ChipFirmware) -> None:
        """Report what a request changed immediately, between two rows."""
        self._note(time, int(twin.enabled), int(twin.state), int(twin.faults), self.previous[3])

    def _note(self, time: float, enable: int, state: int, faults: int, held: int) -> None:
        was = self.previous
        self.previous = (enable, state, faults, held)
        if faults & ~was[2]:
            self.report(time, f"firmware fault {Fault(faults & ~was[2]).name}")
        if state != was[1]:
            self.report(time, f"state {State(state).name}")
        if enable != was[0]:
            self.report(time, "enable high" if enable else "enable low")
        if held and not was[3]:
            self.report(time, "input outside the specimen's calibrated range; its laws hold the value at the end")

    def _report_lasting(self, name: str, events: tuple[str, str], since: float, now: float) -> None:
        """Report when a condition has held for `LASTING`, and when it has ended."""
        if np.isnan(since):
            if self._reported[name]:
                self.report(now, events[1])
            self._reported[name] = False
        elif now - since >= LASTING:
            if not self._reported[name]:
                self.report(since, events[0])
            self._reported[name] = True

    def truth(self) -> Truth:
        """The stored rows, as arrays."""
        rows = np.concatenate([*self.chunks, np.empty((0, len(plant.TRUTH)))])
        time, x, v, f, u, i, heat, enable, state, faults, duty, held = rows.T.copy()
        flags = (enable.astype(bool), state.astype(np.int64), faults.astype(np.int64), duty, held.astype(bool))
        return Truth(time, x, v, f, u, i, heat, *flags, self.at_rest_since, self.coil_dead_since)


def _since(rows: Array, holds: NDArray[np.bool_], old: float) -> float:
    """The time since which a condition has held without a break, NaN where it does not; ``old`` before these rows."""
    if not holds[-1]:
        return np.nan
    breaks = np.flatnonzero(~holds)
    if breaks.size:
        return float(rows[breaks[-1] + 1, T])
    return float(rows[0, T]) if np.isnan(old) else old
