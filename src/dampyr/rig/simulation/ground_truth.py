"""What really happened in the simulated rig, once a millisecond, and in words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from dampyr.rig.firmware.protocol import Fault, State
from dampyr.rig.simulation import plant

if TYPE_CHECKING:
    from dampyr.rig.simulation.simulator import Simulator

Array = NDArray[np.float64]
MAX_ROWS = 1_800_000  # rows: half an hour
RESTING = 1e-4  # m/s below which the table stands
LASTING = 0.05  # s before rest is told: a turning point is none
DEAD = 0.01  # A below which the coil is dead, with no voltage at it
T, X, V, F, U, AMPERE, HEAT, ENABLE, STATE, FAULTS, DUTY, HELD = range(len(plant.TRUTH))


@dataclass(frozen=True, eq=False)
class Truth:
    """Arrays (n,) of the last half hour, once a millisecond, SI.

    ``position`` m and ``speed`` m/s of the table, ``force`` N of the specimen, ``voltage`` V and ``current`` A of the coil,
    ``temperature`` degC of the specimen, ``enable`` the Uno's line, its ``state``, ``faults`` and ``duty``, and ``held``: the
    input was outside the specimen's calibrated range, and its laws kept the value at the range's end.
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
    """Gathers the rows of the truth; ``told`` hears what they say."""

    def __init__(self, on_event: Callable[[float, str], None] | None = None) -> None:
        self.on_event = on_event
        self.chunks: list[Array] = []
        self.count = 0
        self.at_rest_since = self.coil_dead_since = 0.0
        self._says = {"rest": True, "dead": True}
        self.before = (0, int(State.FAULT), int(Fault.RESTARTED), 0)

    def tell(self, time: float, words: str) -> None:
        """Something happened."""
        if self.on_event is not None:
            self.on_event(time, words)

    def add(self, rows: Array) -> None:
        """Keep rows, oldest first, and tell what changed in them."""
        if not rows.size:
            return
        self.chunks.append(rows)
        self.count += len(rows)
        while self.count - len(self.chunks[0]) >= MAX_ROWS:
            self.count -= len(self.chunks.pop(0))
        self.at_rest_since = _since(rows, np.abs(rows[:, V]) < RESTING, self.at_rest_since)
        alive = (rows[:, U] != 0.0) | (np.abs(rows[:, AMPERE]) >= DEAD)
        self.coil_dead_since = _since(rows, ~alive, self.coil_dead_since)
        if self.on_event is not None:
            self._changes(rows)
            self._says["rest"] = self._ended("rest", ("at rest", "moving"), self.at_rest_since, float(rows[-1, T]))
            self._says["dead"] = self._ended(
                "dead", ("coil dead", "coil live"), self.coil_dead_since, float(rows[-1, T])
            )

    def see(self, rig: Simulator) -> None:
        """What a request changed at once."""
        twin = rig.twin
        self._note(rig.time, int(twin.enabled), int(twin.state), int(twin.faults), self.before[3])

    def _changes(self, rows: Array) -> None:
        columns = rows[:, [ENABLE, STATE, FAULTS, HELD]].astype(int)
        changed = np.any(np.diff(columns, axis=0, prepend=[self.before]) != 0, axis=1)
        for k in np.flatnonzero(changed):
            self._note(float(rows[k, T]), *map(int, columns[k]))

    def _note(self, time: float, enable: int, state: int, faults: int, held: int) -> None:
        was = self.before
        self.before = (enable, state, faults, held)
        if faults & ~was[2]:
            self.tell(time, f"firmware fault {Fault(faults & ~was[2]).name}")
        if state != was[1]:
            self.tell(time, f"state {State(state).name}")
        if enable != was[0]:
            self.tell(time, "enable high" if enable else "enable low")
        if held and not was[3]:
            self.tell(time, "input outside the specimen's calibrated range; its laws hold the value at the end")

    def _ended(self, name: str, words: tuple[str, str], since: float, now: float) -> bool:
        """Tell when something holds for `LASTING`, and when it has ended."""
        said = self._says[name]
        if np.isnan(since) or now - since < LASTING:
            if said and np.isnan(since):
                self.tell(now, words[1])
                return False
            return said
        if not said:
            self.tell(since, words[0])
        return True

    def truth(self) -> Truth:
        """The rows that are kept, as arrays."""
        rows = np.concatenate([*self.chunks, np.empty((0, len(plant.TRUTH)))])
        time, x, v, f, u, i, heat, enable, state, faults, duty, held = rows.T.copy()
        flags = (enable.astype(bool), state.astype(np.int64), faults.astype(np.int64), duty, held.astype(bool))
        return Truth(time, x, v, f, u, i, heat, *flags, self.at_rest_since, self.coil_dead_since)


def _since(rows: Array, holds: NDArray[np.bool_], old: float) -> float:
    """Since when something has held without a break, NaN where it does not; ``old`` is the answer before these rows."""
    if not holds[-1]:
        return np.nan
    breaks = np.flatnonzero(~holds)
    if breaks.size:
        return float(rows[breaks[-1] + 1, T])
    return float(rows[0, T]) if np.isnan(old) else old
