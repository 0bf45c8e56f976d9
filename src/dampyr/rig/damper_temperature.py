"""Temperature of the damper from one host to the next: saved with its time, and cooled by the thermal model until it is read.

A damper is as warm after its host has ended as before. A host that took it for cold would drive it beyond its limit, and give
its coil the wrong voltage. The day's clock may jump meanwhile, by NTP or by hand; so the time since the machine was started
counts, where the machine tells it and was not started anew.
"""

from __future__ import annotations

import math
import time as clocks
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import tomli_w

from dampyr.atomic_write import write_whole
from dampyr.config import load_toml
from dampyr.errors import FileError
from dampyr.rig.settings import RigSettings
from dampyr.rig.thermal_model import Warmth

NAME = "temperature.toml"


@dataclass(frozen=True)
class SavedTemperature:
    """A damper's temperature [degC] at a time (UTC), and at an `uptime` of the machine, "" where that is not known."""

    temperature: float
    time: datetime
    uptime: str = ""

    @classmethod
    def parse(cls, temperature: object, time: object, uptime: object = "") -> SavedTemperature:
        """From texts or numbers; :class:`ValueError` where they cannot be read as such."""
        value, at = float(str(temperature)), datetime.fromisoformat(str(time))
        if not math.isfinite(value) or at.tzinfo is None:
            raise ValueError(f"temperature_degC = {temperature}, time = {time}")
        return cls(value, at, str(uptime))

    def cooled(self, rig: RigSettings, now: datetime | None = None, uptime: str | None = None) -> float:
        """What is left of it [degC] now; a clock that was set back cools nothing."""
        start, _, then = self.uptime.partition(" ")
        start_now, _, until = (machine_uptime() if uptime is None else uptime).partition(" ")
        if start and start == start_now:
            seconds = float(until) - float(then)
        else:
            seconds = ((now or datetime.now(UTC)) - self.time).total_seconds()
        warmth = Warmth(rig, self.temperature)
        warmth.cool(max(0.0, seconds))
        return warmth.estimate


def machine_uptime() -> str:
    """A name of this start of the machine, and the seconds since, suspended ones too; "" where it tells neither."""
    try:
        start = Path("/proc/sys/kernel/random/boot_id").read_text("ascii").strip()
        return f"{start} {clocks.clock_gettime(clocks.CLOCK_BOOTTIME):.3f}"
    except (OSError, AttributeError):  # neither Linux
        return ""


def save_temperature(folder: Path, temperature: float) -> Path:
    """Write ``temperature.toml`` beside a ``rig.toml``, whole or not at all; `FileError` where the disk takes nothing."""
    path, now = folder / NAME, datetime.now(UTC).isoformat(timespec="milliseconds")
    values = {"temperature_degC": round(temperature, 3), "time": now, "uptime": machine_uptime()}
    text = "# Of the damper, as estimated; delete this file where another damper is mounted.\n"
    try:
        write_whole(path, text + tomli_w.dumps(values))
    except OSError as problem:
        raise FileError(path, f"cannot be written ({problem.strerror or problem}); make room") from problem
    return path


def load_temperature(folder: Path) -> SavedTemperature | None:
    """The temperature beside a ``rig.toml``; None where there is none, :class:`FileError` where it is wrong."""
    path = folder / NAME
    if not path.is_file():
        return None
    document = load_toml(path)
    try:
        return SavedTemperature.parse(document["temperature_degC"], document["time"], document.get("uptime", ""))
    except (KeyError, ValueError) as problem:
        raise FileError(
            path, f"says no temperature_degC and time ({problem}); delete it, once the damper is as cold as the room"
        ) from None
