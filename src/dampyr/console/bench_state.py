"""State of the bench as plain values for a page, SI."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from dampyr.console.bench_alarms import Alarm, AlarmLimit, Extreme, Reading
from dampyr.console.bench_reference import Comparison
from dampyr.console.guided import Guided
from dampyr.rig.acquisition import fault_in_words
from dampyr.rig.firmware.protocol import Fault, State, Status
from dampyr.rig.settings import RigSettings

Phase = Literal[
    "disconnected",
    "connecting",
    "idle",
    "arming",
    "armed",
    "homing",
    "measuring",
    "moving",
    "campaign",
    "disarming",
    "disconnecting",
]
RingState = Literal["off", "watching", "acted"]
Outcome = Literal["running", "complete", "stopped", "aborted", "failed"]


@dataclass(frozen=True)
class Ring:
    """A safety layer and its message."""

    name: str
    state: RingState
    words: str


@dataclass(frozen=True)
class CampaignRun:
    """A campaign that runs or ran: ``name`` of its file, ``folder`` of its records; times in s, stroke in m, force in N."""

    name: str
    folder: str
    tests: int
    outcome: Outcome = "running"
    reason: str = ""
    phase: str = "arming"
    test: str = ""
    done: int = 0
    fraction: float = 0.0
    time_left: float = 0.0
    cycles: float = 0.0
    planned_cycles: float = 0.0
    stroke: float = 0.0
    paused: bool = False
    operator: str = ""
    specimen: str = ""
    report: str = ""
    """The file of the report that was written at its end, in its folder; empty where there is none."""
    report_state: str = ""
    """"writing", or why no report could be written."""


@dataclass(frozen=True)
class Queued:
    """A campaign that waits: ``number`` names it, ``name`` of its file, ``folder`` of its records, and who answers for it."""

    number: int
    name: str
    folder: str
    operator: str = ""
    specimen: str = ""
    note: str = ""


@dataclass(frozen=True)
class ChartLimits:
    """Of the rig, for its charts: force N, farthest position m, speed m/s, voltage V, temperature degC."""

    force: float
    travel: float
    speed: float
    voltage: float
    temperature: float


@dataclass(frozen=True)
class Live:
    """The last sample: position m, force N, voltage V at the coil, temperature degC (an estimate where none is measured)."""

    position: float
    force: float
    voltage: float
    temperature: float


@dataclass(frozen=True)
class ConnectedRig:
    """The rig that is connected."""

    name: str
    simulated: bool
    identity: str
    rate: float
    stroke: float
    scale: float
    zero: float
    calibrated: str
    jog_speed: float
    specimen: str
    limits: ChartLimits
    notice: str
    """What the page says above all, as its records will, where they are not measured."""
    velocity_lag: int
    """Bins by which the velocity of the strips is later than the bin that it is of."""


@dataclass(frozen=True)
class BenchState:
    """Everything that a page shows besides the strips. ``note`` is the last thing worth saying, ``fault`` whether it is bad.

    ``live_age`` is the age [s] of what ``live`` says, None where there is nothing. ``extremes`` are the least and the greatest
    readings since the last reset.
    """

    phase: Phase
    note: str
    fault: bool
    armed: bool
    homed: bool
    jogging: bool
    rig: ConnectedRig | None
    live: Live | None
    rings: tuple[Ring, ...]
    guided: Guided | None
    run: CampaignRun | None
    clients: int
    holder: str
    live_age: float | None = None
    extremes: dict[Reading, Extreme] = field(default_factory=dict)
    alarms: tuple[Alarm, ...] = ()
    alarm_limits: tuple[AlarmLimit, ...] = ()
    queue: tuple[Queued, ...] = ()
    comparison: Comparison | None = None
    events: int = 0
    """How many events were noted since the console began."""
    trouble: str = ""
    """What keeps the log of events from being written."""


def firmware_ring(status: Status | None) -> Ring:
    """The Uno's own limits and its watchdog."""
    if status is None:
        return Ring("firmware", "off", "no rig is connected")
    if status.state is State.FAULT and status.faults != Fault.RESTARTED:
        return Ring("firmware", "acted", f"{fault_in_words(status.faults)}; arm to go on")
    words = {State.FAULT: "started; the first arming clears it"}.get(status.state, status.state.name.lower())
    if status.enabled:
        return Ring("firmware", "watching", f"{words}, energy on")
    return Ring("firmware", "off", f"{words}, energy off; once armed it stops at its limits and without its host")


def interlock_ring(rig: RigSettings | None, armed: bool, acted: str) -> Ring:
    """The judge of every block of samples."""
    if acted:
        return Ring("interlock", "acted", acted)
    if rig is None:
        return Ring("interlock", "off", "watches while a rig is armed")
    limits = rig.limits
    words = f"{limits.force:g} N, ±{limits.stroke * 500:g} mm, {limits.speed * 1e3:g} mm/s, {limits.temperature:g} °C"
    return (
        Ring("interlock", "watching", words)
        if armed
        else Ring("interlock", "off", f"once armed it stops beyond {words}")
    )


def check_ring(checked: str, refused: str, runs: bool) -> Ring:
    """The check of a campaign before it moves, and of what is to come while one ``runs``."""
    if refused:
        return Ring("campaign check", "acted", refused)
    if runs and checked:
        return Ring("campaign check", "watching", checked)
    last = f"; the last one, {checked}" if checked else ""
    return Ring("campaign check", "off", f"checks a whole campaign before it moves{last}")
