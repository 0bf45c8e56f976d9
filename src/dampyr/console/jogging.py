"""Jogging by hold-to-run: the table moves while a page repeats its request, and no longer.

A page repeats its request every 0.1 s. Here a request is valid for `HOLD`; the firmware gets `PUSH` at a time
and stops by itself after it.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass

from dampyr.errors import InputError, RigFault
from dampyr.rig.firmware.protocol import State
from dampyr.rig.session import GENTLE, ArmedRig

HOLD = 0.35  # s
PUSH = 0.25  # s
BLIND = 0.002  # m/s, the firmware's own limit until the table is homed
MARGIN = 0.001  # m before the end of the stroke


def fastest_jog(homed: bool) -> float:
    """The greatest speed [m/s] that may be asked for."""
    return GENTLE if homed else BLIND


@dataclass
class _Wish:
    client: str
    speed: float
    until: float


class Jogging:
    """The wish of the moment."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock, self._wish, self._moves = clock, None, False  # type: Callable[[], float], _Wish | None, bool
        self._lock = threading.Lock()

    def ask(self, client: str, speed: float, table: ArmedRig) -> None:
        """Wish for a speed [m/s]; 0 ends the wish."""
        max_speed = fastest_jog(table.homed)
        if not abs(speed) <= max_speed:
            more = "" if table.homed else "; home the table to go faster"
            raise InputError(
                f"speed = {speed * 1e3:g} mm/s is not allowed; it must be at most {max_speed * 1e3:g} mm/s{more}"
            )
        if speed and self._at_the_end(table, speed):
            raise InputError(f"the table is {MARGIN * 1e3:g} mm before the end of its stroke; jog the other way")
        with self._lock:
            self._wish = _Wish(client, speed, self._clock() + HOLD) if speed else None

    def forget(self) -> None:
        """No wish any more."""
        with self._lock:
            self._wish = None

    def steer(self, table: ArmedRig, holder: str | None) -> None:
        """Push on, or stop; called for every block."""
        with self._lock:
            wish = self._wish
            if wish and (wish.until < self._clock() or wish.client != holder or self._at_the_end(table, wish.speed)):
                wish = self._wish = None
        if wish is not None and table.loop.status.state in (State.ARMED, State.JOGGING):
            self._push(table, wish.speed)
        elif wish is None and self._moves:
            self._moves = False
            table.ask_uno(table.rig.uno.stop)

    def _push(self, table: ArmedRig, speed: float) -> None:
        try:
            table.jog(speed, PUSH, wait=False)
            self._moves = True
        except RigFault:  # refused while it comes to rest: the next block asks again
            if table.loop.stopped:
                raise

    def _at_the_end(self, table: ArmedRig, speed: float) -> bool:
        """Where the next push could leave the stroke."""
        max_position = 0.5 * table.rig.settings.limits.stroke - MARGIN
        return table.homed and (table.position + speed * PUSH) * (1 if speed > 0 else -1) > max_position
