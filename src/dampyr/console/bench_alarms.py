"""Peak hold of the readings, and alarms: limits that an operator sets, each alarm latched until it is acknowledged.

An alarm informs. What stops the rig are its three safety layers, with limits of their own in ``rig.toml``.
"""

from __future__ import annotations

import json
import math
import threading
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.errors import InputError
from dampyr.rig.interlock import Samples

Reading = Literal["position", "force", "velocity", "voltage", "temperature"]
READINGS: dict[Reading, tuple[str, float, str]] = {  # name, factor from SI to what is shown, unit
    "position": ("position", 1e3, "mm"),
    "force": ("force", 1.0, "N"),
    "velocity": ("velocity", 1e3, "mm/s"),
    "voltage": ("coil voltage", 1.0, "V"),
    "temperature": ("damper temperature", 1.0, "°C"),
}
FILE = "alarm-limits.json"
BACK = 0.02  # of a limit by which a reading has to come back before the alarm is over
MAX_ALARMS = 100
WINDOW = 0.010  # s over which a velocity is taken


@dataclass(frozen=True)
class Extreme:
    """The least and the greatest value of a reading since the last reset, SI."""

    low: float
    high: float


@dataclass(frozen=True)
class AlarmLimit:
    """The range within which a reading raises no alarm, SI; None: no limit on that side."""

    reading: Reading
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class Alarm:
    """``time`` with its zone; ``active`` while its cause lasts; ``acknowledged`` by whom, empty where by nobody yet."""

    number: int
    time: str
    words: str
    active: bool
    acknowledged: str = ""


class Alarms:
    """Limits, alarms and extremes; filled by the thread that reads the rig, asked by any."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / FILE
        self._lock = threading.Lock()
        self._limits: dict[Reading, AlarmLimit] = {}
        self._alarms: list[Alarm] = []
        self._beyond: dict[tuple[Reading, str], int] = {}
        self._extremes: dict[Reading, Extreme] = {}
        self._number = 0
        try:
            self._limits = {limit.reading: limit for limit in _saved(self._path)}
        except InputError as problem:
            self.raise_alarm(str(problem))

    @property
    def limits(self) -> tuple[AlarmLimit, ...]:
        """The limits that are set."""
        with self._lock:
            return tuple(self._limits.values())

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """The alarms, the latest first."""
        with self._lock:
            return tuple(reversed(self._alarms))

    @property
    def extremes(self) -> dict[Reading, Extreme]:
        """The extremes of each reading since the last reset."""
        with self._lock:
            return dict(self._extremes)

    def set_limit(self, limit: AlarmLimit) -> None:
        """Set, change or (without low and high) remove the limit of a reading; it is saved for the next session."""
        for name, value in (("low", limit.low), ("high", limit.high)):
            if value is not None and not math.isfinite(value):
                raise InputError(f"{name} = {value} is not allowed; give a number, or leave it empty")
        if limit.low is not None and limit.high is not None and not limit.low < limit.high:
            _, factor, unit = READINGS[limit.reading]
            raise InputError(
                f"low = {limit.low * factor:g} {unit} is not below high = {limit.high * factor:g} {unit}; exchange them"
            )
        with self._lock:
            limits = dict(self._limits)
            limits.pop(limit.reading, None)
            if limit.low is not None or limit.high is not None:
                limits[limit.reading] = limit
            self._path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(self._path, json.dumps([asdict(limit) for limit in limits.values()], indent=1) + "\n")
            self._limits = limits
            for side in ("low", "high"):
                self._over(limit.reading, side)

    def take(self, samples: Samples, temperature: float, rate: float) -> list[str]:
        """Look at a block; the words of the alarms that it raised."""
        size = max(1, round(WINDOW * rate))
        x = samples.displacement
        velocity = (x[size:] - x[:-size]) * (rate / size) if len(x) > size else np.empty(0)
        ranges: dict[Reading, tuple[float, float]] = {"temperature": (temperature, temperature)}
        channels: tuple[tuple[Reading, Any], ...] = (
            ("position", x),
            ("force", samples.force),
            ("velocity", velocity),
            ("voltage", samples.voltage),
        )
        for name, values in channels:
            if len(values):
                ranges[name] = float(values.min()), float(values.max())
        with self._lock:
            return [words for name, (low, high) in ranges.items() for words in self._look(name, low, high)]

    def raise_alarm(self, words: str) -> None:
        """Raise an alarm that is over at once, such as a trip: it is latched until it is acknowledged."""
        with self._lock:
            self._raised(words, active=False)

    def acknowledge(self, who: str, number: int | None = None) -> int:
        """Acknowledge one alarm, or all; how many there were."""
        with self._lock:
            chosen = [
                alarm.number for alarm in self._alarms if not alarm.acknowledged and number in (None, alarm.number)
            ]
            self._alarms = [
                replace(alarm, acknowledged=who) if alarm.number in chosen else alarm for alarm in self._alarms
            ]
            return len(chosen)

    def reset_extremes(self) -> None:
        """Forget the extremes: they begin anew with the next sample."""
        with self._lock:
            self._extremes = {}

    def _look(self, name: Reading, low: float, high: float) -> list[str]:
        before = self._extremes.get(name)
        self._extremes[name] = Extreme(min(low, before.low), max(high, before.high)) if before else Extreme(low, high)
        limit = self._limits.get(name)
        if limit is None:
            return []
        raised = []
        for side, bound, value, sign in (("low", limit.low, low, -1.0), ("high", limit.high, high, 1.0)):
            if bound is None:
                continue
            if sign * (value - bound) > 0.0:
                if (name, side) not in self._beyond:
                    words, factor, unit = READINGS[name]
                    than = "above" if sign > 0 else "below"
                    sentence = (
                        f"{words} {value * factor:.4g} {unit} is {than} its alarm limit of {bound * factor:.4g} {unit}"
                    )
                    self._beyond[name, side] = self._raised(sentence, active=True)
                    raised.append(sentence)
            elif sign * (value - bound) < -BACK * abs(bound):
                self._over(name, side)
        return raised

    def _raised(self, words: str, active: bool) -> int:
        self._number += 1
        now = datetime.now().astimezone().isoformat(timespec="seconds")
        self._alarms = [*self._alarms, Alarm(self._number, now, words, active)][-MAX_ALARMS:]
        return self._number

    def _over(self, name: Reading, side: str) -> None:
        number = self._beyond.pop((name, side), None)
        self._alarms = [replace(alarm, active=False) if alarm.number == number else alarm for alarm in self._alarms]


def _saved(path: Path) -> list[AlarmLimit]:
    """The limits of an earlier session."""
    if not path.is_file():
        return []
    try:
        limits = [AlarmLimit(**limit) for limit in json.loads(path.read_text("utf-8"))]
    except (OSError, ValueError, TypeError):
        limits = [AlarmLimit("force", math.nan)]
    for limit in limits:
        values = [value for value in (limit.low, limit.high) if value is not None]
        if limit.reading not in READINGS or not all(isinstance(v, int | float) and math.isfinite(v) for v in values):
            raise InputError(f"{path.name} cannot be read, so no alarm limits are set; set them again")
    return limits
