"""Diagnosis of a rig: which parts are connected, answer and are calibrated, and the repair of the others."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import numpy as np

from dampyr.errors import DampyrError
from dampyr.rig.acquisition import fault_in_words
from dampyr.rig.calibration import NAME, doubt, load_calibration
from dampyr.rig.connect import open_rig
from dampyr.rig.firmware.protocol import Fault, State
from dampyr.rig.session import Rig
from dampyr.rig.settings import RigSettings, load_settings

LOUD = 3.0  # N rms of a load cell at rest
LIBRARIES = {"pyserial": "the Uno", "nidaqmx": "the NI board", "grpcio": "the wires of the simulated rig"}


@dataclass(frozen=True)
class Finding:
    """One check: its result, and the repair (None: nothing to repair)."""

    what: str
    observed: str
    repair: str | None = None


def diagnose(settings: str | Path | None = None, in_process: bool = False) -> list[Finding]:
    """Check everything, in the order of the wires; nothing is armed, nothing moves, the coil stays at 0 V."""
    try:
        rig = RigSettings() if settings is None else load_settings(settings)
    except DampyrError as problem:
        return [Finding("rig", "its settings are wrong", str(problem))]
    return [*_libraries(), *_settings(rig, settings), *_instruments(rig, settings, in_process)]


def _libraries() -> Iterator[Finding]:
    for name, use in LIBRARIES.items():
        try:
            yield Finding(f"{name}, for {use}", metadata.version(name))
        except metadata.PackageNotFoundError:
            yield Finding(f"{name}, for {use}", "missing", "pip install 'dampyr[rig]'")


def _settings(rig: RigSettings, path: str | Path | None) -> Iterator[Finding]:
    kind = f"{rig.wires.serial}, board {rig.wires.board}" if rig.wires.serial else "simulated: no wires are named"
    yield Finding("rig", f"{rig.name}, {kind}")
    lines = "the Uno's enable line cuts the coil" if rig.supply.enable_line else "no enable line"
    repair = "wire the supply through pin 8 of the Uno: without it a dead host leaves the coil live"
    yield Finding("coil", lines, None if rig.supply.enable_line else repair)
    if rig.wires.serial:
        calibration = load_calibration(Path(path).parent) if path else None
        words = (
            "not calibrated: the settings' scale is used"
            if calibration is None
            else f"{calibration.scale:.5g} N/V, {calibration.how}"
        )
        yield Finding(
            "load cell", words, f"dampyr calibrate --rig {path} writes {NAME}" if calibration is None else None
        )
        if calibration is not None and (far := doubt(calibration.scale, rig.load_cell.scale)):
            yield Finding("load cell's scale", far, "calibrate it again, or correct load_cell.scale")


def _instruments(rig: RigSettings, path: str | Path | None, in_process: bool) -> Iterator[Finding]:
    try:
        opened = open_rig(path, in_process=in_process)
    except DampyrError as problem:
        yield Finding("connection", "none", str(problem))
        return
    with opened:
        for look in (_uno, _board):
            try:
                yield from look(opened)
            except DampyrError as problem:
                yield Finding(look.__name__.strip("_"), "does not answer", str(problem))


def _uno(rig: Rig) -> Iterator[Finding]:
    hello = rig.uno.hello()
    yield Finding("Uno", f"firmware {hello.firmware}, protocol {hello.version}, control at {hello.rate} Hz")
    status = rig.uno.heartbeat()
    words = status.state.name.lower()
    if status.state is State.FAULT:
        words += f": {fault_in_words(status.faults)}"
    expected = status.state is State.IDLE or status.faults is Fault.RESTARTED
    yield Finding("its state", words, None if expected else "arming clears it, once its cause is gone")
    yield Finding("encoder", "homed" if status.homed else "not homed; a campaign homes it first")


def _board(rig: Rig) -> Iterator[Finding]:
    yield Finding("board", rig.board.identity())
    volts, _ = rig.listen(0.5)
    calibration = rig.calibration
    assert calibration is not None
    force = calibration.force(volts[0])
    rail = np.abs(volts[0]).max() >= 0.995 * rig.settings.board.range
    loud = f"its noise is {force.std():.2g} N rms; look at its shield and ground" if force.std() > LOUD else None
    repair = "its signal is at the end of the range; look at its wire and its supply" if rail else loud
    yield Finding("load cell now", f"{force.mean():+.1f} N, {force.std():.2g} N rms", repair)
    if len(volts) > 1:
        yield Finding("thermocouple", f"{calibration.temperature(volts[1]).mean():.1f} degC")
