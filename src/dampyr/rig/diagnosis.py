"""Diagnosis of a rig: which parts are connected, answer and are calibrated, and the repair of the others."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date
from importlib import metadata
from pathlib import Path
from typing import cast

import numpy as np

from dampyr.errors import DampyrError, install_line
from dampyr.rig.acquisition import fault_in_words
from dampyr.rig.calibration import NAME, Array, Calibration, doubt, load_calibration
from dampyr.rig.connecting import open_rig
from dampyr.rig.firmware.protocol import HIGH_END, LOW_END, PRESSED, Fault, State
from dampyr.rig.instruments.arduino_uno.driver import bridge_in_words, bridge_repair
from dampyr.rig.instruments.arduino_uno.wire import SLOW_PORT, port_latency
from dampyr.rig.instruments.catalogue import OUTPUT, ROLES, part, with_absolute_folders
from dampyr.rig.instruments.contract import Program
from dampyr.rig.instruments.ni_daqmx.boards import family_of
from dampyr.rig.instruments.ni_daqmx.driver import NiBoard
from dampyr.rig.session import Rig
from dampyr.rig.settings import RigSettings, load_settings
from dampyr.rig.shunt import READ, SETTLED, expected_step, switch_shunt
from dampyr.rig.uncertainty_budget import shunt_error

BROWN_OUT = {
    7: 0.0,
    6: 1.8,
    5: 2.7,
    4: 4.3,
}  # V, of the low three bits of the extended fuse; 0: off; data sheet, BODLEVEL
LOUD = 3.0  # N rms of a load cell at rest
AT_ZERO = {"V": 0.05, "A": 0.01}  # what the coil's readings may say while it is off
LIBRARIES = {"pyserial": "the Uno", "nidaqmx": "the NI board", "grpcio": "the wires of the simulated rig"}


@dataclass(frozen=True)
class RigCheck:
    """One check: its result, and the repair (None: nothing to repair)."""

    what: str
    observed: str
    repair: str | None = None


def diagnose(settings: str | Path | None = None) -> list[RigCheck]:
    """Check everything, in the order of the wires; nothing is armed, nothing moves, the coil stays at 0 V."""
    try:
        rig = RigSettings() if settings is None else load_settings(settings)
    except DampyrError as problem:
        return [RigCheck("rig", "its settings are wrong", str(problem))]
    return [*_libraries(), *_settings(rig, settings), *_instruments(settings)]


def _libraries() -> Iterator[RigCheck]:
    for name, use in LIBRARIES.items():
        try:
            yield RigCheck(f"{name}, for {use}", metadata.version(name))
        except metadata.PackageNotFoundError:
            yield RigCheck(f"{name}, for {use}", "missing", install_line("rig"))


def _settings(rig: RigSettings, path: str | Path | None) -> Iterator[RigCheck]:
    kind = f"{rig.wires.serial}, board {rig.wires.board}" if rig.wires.serial else "simulated: no wires are named"
    yield RigCheck("rig", f"{rig.name}, {kind}")
    yield from _named(rig, path)
    yield from _port(rig)
    lines = "the Uno's enable line cuts the coil" if rig.supply.enable_line else "no enable line"
    repair = "wire the supply through pin 8 of the Uno: without it a dead host leaves the coil live"
    yield RigCheck("coil", lines, None if rig.supply.enable_line else repair)
    read = [name for name in ("coil_voltage", "coil_current") if name in rig.inputs]
    guards = (
        "what a record says of the coil is what was commanded, so that a dead supply or a broken wire is not seen; "
    )
    guards += "wire its voltage and a shunt to free inputs, and name them in wires.coil_voltage and wires.coil_current"
    readings = " and ".join(name.partition("_")[2] for name in read)
    yield RigCheck("coil's readings", readings or "none", None if len(read) == 2 else guards)
    yield from _motor(rig)
    yield from _switches(rig)
    shunt = (
        "put a resistor across an arm of its bridge through a relay at a digital output, and name that in wires.shunt, "
    )
    shunt += (
        "such as port0/line0, and the resistor in load_cell.shunt: without one friction alone tells a gain that changes"
    )
    yield RigCheck("load cell's shunt", rig.wires.shunt or "none", None if rig.wires.shunt else shunt)
    for name, certificate in rig.certificates.stated():
        ended = (
            "have it calibrated: records of today say that it has expired"
            if certificate.expired(date.today())
            else None
        )
        yield RigCheck(f"{name}'s certificate", certificate.in_words(), ended)
    if rig.wires.serial:
        calibration = load_calibration(Path(path).parent) if path else None
        if calibration is None:
            repair = f"dampyr calibrate --rig {path} writes {NAME}"
            yield RigCheck("load cell", "not calibrated: the settings' scale is used", repair)
            return
        yield RigCheck("load cell", f"{calibration.scale:.5g} N/V, {calibration.how}")
        if deviation := doubt(calibration.scale, rig.load_cell.scale):
            yield RigCheck("load cell's scale", deviation, "calibrate it again, or correct load_cell.scale")


def _named(rig: RigSettings, path: str | Path | None) -> Iterator[RigCheck]:
    """The instruments that the rig names."""
    absolute = with_absolute_folders(rig, Path(path).parent if path else None)
    for role in ROLES:
        name = getattr(rig.wires, role)
        try:
            if name != OUTPUT:
                part(absolute, role, "driver")
            yield RigCheck(role, "an output of the acquisition" if name == OUTPUT else name)
        except DampyrError as problem:
            yield RigCheck(role, name, str(problem))


def _port(rig: RigSettings) -> Iterator[RigCheck]:
    """The latency of the Uno's port, where its driver keeps one: on Windows, of an FTDI chip."""
    latency = port_latency(rig.wires.serial) if rig.wires.serial else None
    if latency is not None:
        slow = "set 1 ms in the Device Manager: Ports, this port, Port Settings, Advanced, Latency Timer"
        yield RigCheck("serial port's latency", f"{latency} ms", slow if latency > SLOW_PORT else None)


def _motor(rig: RigSettings) -> Iterator[RigCheck]:
    """Limits of the motor, and whether its current is read."""
    actuator, wired = rig.actuator, rig.wires.bridge_current
    limits = f"duty {actuator.max_duty:.0%} at most, {actuator.top_speed * 1e3:.3g} mm/s without load"
    yield RigCheck("motor", limits)
    unread = "nothing but its fuse stops a motor that draws too much; wire the bridge's R_IS and L_IS to A0 and A1 of the Uno, "
    unread += "each with its resistor, and set wires.bridge_current (dampyr help power)"
    read = f"read, stops above {actuator.max_current:g} A" if wired else "not read"
    yield RigCheck("motor's current", read, None if wired else unread)


def _switches(rig: RigSettings) -> Iterator[RigCheck]:
    """Which of the encoder's guards are wired."""
    wires = rig.wires
    ends = "wire one before each end to pins 5 and 6 of the Uno and set wires.end_switches: without them nothing but force and "
    ends += "the damper's own stops ends a motion while the table is not homed or its encoder is dead"
    stop = "wire one to pin 11 of the Uno and into the supplies of motor and coil, and set wires.emergency_stop"
    index = "wire the encoder's Z to the board and name its counter and input in wires.index, such as ctr1/PFI9"
    yield RigCheck("end switches", "wired" if wires.end_switches else "none", None if wires.end_switches else ends)
    yield RigCheck(
        "emergency stop", "wired" if wires.emergency_stop else "none", None if wires.emergency_stop else stop
    )
    yield RigCheck("encoder's index", wires.index or "not read by the board", None if wires.index else index)


def _instruments(path: str | Path | None) -> Iterator[RigCheck]:
    try:
        opened = open_rig(path)
    except DampyrError as problem:
        yield RigCheck("connection", "none", str(problem))
        return
    with opened:
        for check in (_uno, _board):
            try:
                yield from check(opened)
            except DampyrError as problem:
                yield RigCheck(check.__name__.strip("_"), "does not answer", str(problem))


def _uno(rig: Rig) -> Iterator[RigCheck]:
    hello = rig.uno.hello()
    yield RigCheck("Uno", f"firmware {hello.firmware}, protocol {hello.version}, control at {hello.rate} Hz")
    if hello.program is not None:
        yield from _program(rig.settings, hello.program)
    status = rig.uno.heartbeat()
    state = status.state.name.lower()
    if status.state is State.FAULT:
        state += f": {fault_in_words(status.faults)}"
    expected = status.state is State.IDLE or status.faults is Fault.RESTARTED
    yield RigCheck("its state", state, None if expected else "arming clears it, once its cause is gone")
    yield RigCheck("encoder", "homed" if status.homed else "not homed; a campaign homes it first")
    wires = rig.settings.wires
    if wires.end_switches and status.inputs & (LOW_END | HIGH_END):
        both = status.inputs & LOW_END and status.inputs & HIGH_END
        where = "both open" if both else ("the lower one open" if status.inputs & LOW_END else "the upper one open")
        repair = "look at their wires" if both else "homing or a jog moves the table away from it"
        yield RigCheck("end switches now", where, repair)
    if wires.emergency_stop and status.inputs & PRESSED:
        yield RigCheck("emergency stop now", "open", "release it, or look at its wire")


def _program(rig: RigSettings, program: Program) -> Iterator[RigCheck]:
    """What the Uno's program was built with, and the brown-out level of its chip."""
    sources = "of this dampyr" if program.up_to_date else "not of this dampyr"
    flash = None if program.up_to_date else "make firmware, and flash it (dampyr help firmware)"
    yield RigCheck("Uno's program", f"{program.baud} baud, sources {program.digest}, {sources}", flash)
    differs = program.direction_pin is not rig.wires.direction_pin
    yield RigCheck("bridge", bridge_in_words(program.direction_pin), bridge_repair(rig) if differs else None)
    level = BROWN_OUT.get(program.extended_fuse & 7)
    if level is None:
        cannot = "its program could not read it; read it with a programmer (dampyr help power)"
        yield RigCheck("Uno's brown-out", f"extended fuse {program.extended_fuse:02X}", cannot)
        return
    low = "at 16 MHz the chip needs 4.5 V: below that it may do anything, with the bridge on; set the extended fuse to FC with "
    low += "a programmer (dampyr help power)"
    words = f"resets below {level} V" if level else "off"
    yield RigCheck(
        "Uno's brown-out", f"extended fuse {program.extended_fuse:02X}: {words}", None if level == 4.3 else low
    )


def _board(rig: Rig) -> Iterator[RigCheck]:
    yield RigCheck("board", rig.board.identity())
    if rig.settings.wires.acquisition == "ni-daqmx" and not rig.simulated:
        yield _board_type(rig)
    volts, _ = rig.listen(0.5)
    calibration = rig.calibration
    assert calibration is not None
    force = calibration.force(volts[0])
    rail = np.abs(volts[0]).max() >= 0.995 * rig.settings.board.range
    loud = f"its noise is {force.std():.2g} N rms; look at its shield and ground" if force.std() > LOUD else None
    repair = "its signal is at the end of the range; look at its wire and its supply" if rail else loud
    yield RigCheck("load cell now", f"{force.mean():+.1f} N, {force.std():.2g} N rms", repair)
    if rig.settings.wires.shunt and not rail:  # a wire that is broken shows no step either
        yield _shunt(rig, calibration, force)
    readings = dict(zip(rig.settings.inputs, volts, strict=True))
    if "temperature" in readings:
        yield RigCheck("thermocouple", f"{calibration.temperature(readings['temperature']).mean():.1f} degC")
    supply = rig.settings.supply
    for name, scale, unit in (("coil_voltage", supply.voltage_scale, "V"), ("coil_current", supply.current_scale, "A")):
        if name in readings:
            value, dead = float(readings[name].mean()) * scale, AT_ZERO[unit]
            repair = f"it is not 0 while the coil is off; look at the input's wires and at supply.{name[5:]}_scale"
            yield RigCheck(
                name.replace("_", " ") + " now", f"{value:+.3f} {unit}", repair if abs(value) > dead else None
            )


def _board_type(rig: Rig) -> RigCheck:
    """The product of a connected NI board, and what it lacks of what this rig asks for."""
    what = "board's type"
    try:
        product, lacks = cast(NiBoard, rig.board).type_and_lacks()  # by name, where another process has it
    except DampyrError as problem:  # the board's other checks go on
        return RigCheck(what, "what it has could not be asked", str(problem))
    unknown = "" if family_of(product) else " (not in the table of dampyr help ni-boards: unknown)"
    missing = f"lacks {', '.join(lack.what for lack in lacks)}" if lacks else "lacks nothing that this rig asks for"
    repair = "; ".join(f"{lack.what}: {lack.repair}" for lack in lacks)
    return RigCheck(what, f"{product}{unknown}, {missing}", repair or None)


def _shunt(rig: Rig, calibration: Calibration, before: Array) -> RigCheck:
    """Switch the shunt in, and compare its step with what the settings promise."""
    expected = expected_step(rig.settings)
    try:
        switch_shunt(rig.board, True)
        rig.listen(SETTLED)
        after = calibration.force(rig.listen(READ)[0][0])
    finally:
        switch_shunt(rig.board, False)
    step = float(np.mean(after) - np.mean(before))
    wrong = None
    if abs(step) < 0.1 * abs(expected):
        wrong = "its relay does nothing: look at its line, its supply and the resistor, or correct wires.shunt"
    elif abs(step - expected) > 3.0 * shunt_error(rig.settings):
        wrong = "look at the resistor and at load_cell.shunt, bridge and sensitivity, and calibrate the cell again"
    return RigCheck("load cell's shunt now", f"{step:+.1f} N, {expected:.1f} N expected", wrong)
