"""Settings of a rig, from its ``rig.toml``: the defaults are the parts of the original rig.

Each default says where it comes from: a table of the dissertation's Appendix A, what its measured records show (FACTS), or
"assumed" where nothing is known; what only the simulated rig needs says "simulated". SI throughout.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi
from pathlib import Path
from typing import Annotated, Any

from dampyr.config import fill, load_toml
from dampyr.errors import FileError, InputError
from dampyr.records.checks.certificates import Certificates
from dampyr.records.record import as_group
from dampyr.shown import Shown
from dampyr.units import Quantity

FILTERS = (
    6.425e-6,
    125e-9,
)  # s, of an M Series board, the longer one first; its third, 2.55 ms, is longer than any edge
FULL_DUTY = 255  # of the Uno's PWM
UNO_REFERENCE, UNO_STEPS = 5.0, 1023  # V at which the Uno's converter is full, and what it shows then
GAIN_MARGIN = 1.25  # of the highest command: more than a gain that was assumed is wrong by
FILTERS_IN_EDGES = 3.0  # filters between two edges of the encoder at limits.speed: its edges are not evenly spaced
Metre = Quantity("m", low=0.0)
Length = Quantity("m", low=0.0, open_low=True)
Speed = Quantity("m/s", low=0.0, open_low=True)
Force = Quantity("N", low=0.0, open_low=True)
Second = Quantity("s", low=0.0)
Time = Quantity("s", low=0.0, open_low=True)


@dataclass(frozen=True)
class Wires:
    """Which instruments the rig has and how they are reached; serial is empty for a rig that dampyr simulates itself."""

    acquisition: Annotated[str, "of dampyr's instruments, or the path of a folder beside this file"] = "ni-daqmx"
    drive: Annotated[str, "as above: the controller of the table's motor"] = "arduino-uno"
    supply: Annotated[str, "as above; analogue-output: it follows an output of the acquisition"] = "analogue-output"
    serial: Annotated[str, "the drive's wire, such as COM3, /dev/ttyACM0 or socket://127.0.0.1:5000"] = ""
    acquisition_address: Annotated[str, "of an acquisition of one's own, as its driver reads it"] = ""
    supply_address: Annotated[str, "of a supply of one's own, as its driver reads it"] = ""
    baud: Annotated[int, "assumed: the Uno divides its clock to this without error"] = 250000
    board: Annotated[str, "the NI board's name in NI MAX"] = "Dev1"
    grpc: Annotated[str, "host:port of an NI gRPC device server; empty for the board of this machine"] = ""
    force: Annotated[str, "analogue input of the load cell"] = "ai0"
    temperature: Annotated[str, "analogue input of the thermocouple's amplifier; empty without one"] = ""
    position: Annotated[str, "counter of the linear encoder"] = "ctr0"
    command: Annotated[str, "analogue output to the damper's supply"] = "ao0"
    coil_voltage: Annotated[
        str, "analogue input of the coil's voltage; empty: it is taken to be what was commanded"
    ] = ""
    coil_current: Annotated[str, "analogue input of a shunt in the coil's circuit; empty without one"] = ""
    index: Annotated[str, "counter and input that latch the position at the encoder's index; empty without"] = (
        "ctr1/PFI9"
    )
    shunt: Annotated[
        str, "digital output of a relay that puts a shunt across the load cell's bridge; empty without one"
    ] = ""
    end_switches: Annotated[bool, "whether both end switches are wired to the Uno; the original rig had none"] = False
    emergency_stop: Annotated[bool, "whether an emergency stop is wired to the Uno; the original rig had none"] = False
    direction_pin: Annotated[
        bool, "whether the bridge takes one PWM and a direction, for which the firmware is built with DIRECTION_PIN=1"
    ] = False
    bridge_current: Annotated[
        bool, "whether the bridge's two current outputs (R_IS, L_IS) are wired to A0 and A1 of the Uno"
    ] = False


@dataclass(frozen=True)
class Actuator:
    """H-bridge, motor and ball screw."""

    free_speed: Annotated[float, Speed, "measured: 78 mm/s at full PWM; Table A.2's 16.8 mm/s cannot be right"] = 0.078
    droop: Annotated[float, Quantity("m/(N s)", low=0.0), "measured: 0.02-0.03 mm/s per N"] = 2.0e-5
    max_load: Annotated[float, Force, "Table A.2"] = 4500.0
    stroke: Annotated[float, Length, "Table A.2"] = 0.457
    lag: Annotated[float, Time, "assumed: the motor's time constant with the screw's inertia"] = 0.025
    dead_band: Annotated[float, Quantity("", low=0.0, high=0.9), "assumed: duty that only overcomes friction"] = 0.06
    backlash: Annotated[float, Metre, "assumed: no more than the encoder sees"] = 5.0e-6
    max_duty: Annotated[
        float,
        Quantity("", low=0.1, high=1.0),
        "the original ran at full PWM; a bridge with bootstrap drivers cannot hold it: 0.98 there",
    ] = 1.0
    max_slew: Annotated[
        float,
        Quantity("1/s", low=4.0, high=1000.0),
        "of the duty; 1000: from rest to full within a millisecond, from full ahead to full astern within two",
    ] = 1000.0
    max_current: Annotated[
        float,
        Quantity("A", low=0.0, open_low=True),
        "where wires.bridge_current: above it for 20 ms the Uno stops; assumed: half as much again as at full load",
    ] = 20.0
    full_load_current: Annotated[float, Quantity("A", low=0.0, open_low=True), "Table A.2: at max_load"] = 13.2
    no_load_current: Annotated[float, Quantity("A", low=0.0), "Table A.2"] = 2.4
    current_scale: Annotated[
        float,
        Quantity("A/V", low=0.0, open_low=True),
        "assumed, where wired: amperes per volt at the Uno's input; 8500 of the BTS 7960's data sheet and 1 kohm",
    ] = 8.5

    @property
    def duty_steps(self) -> int:
        """`max_duty` in the Uno's whole numbers, of 255."""
        return max(1, int(self.max_duty * FULL_DUTY + 1e-9))

    @property
    def top_speed(self) -> float:
        """m/s of the unloaded actuator at `max_duty`; `free_speed` is that at full duty."""
        share = self.duty_steps / FULL_DUTY
        return self.free_speed * max(0.0, share - self.dead_band) / (1.0 - self.dead_band)


@dataclass(frozen=True)
class TableSettings:
    """The sliding table."""

    friction: Annotated[float, Quantity("N", low=0.0), "assumed: linear guides, before the load cell"] = 15.0
    end_switch: Annotated[float, Length, "simulated, where wired: each end switch, from the middle"] = 0.03675


@dataclass(frozen=True)
class Encoder:
    """The linear encoder; its counts go to the NI board and to the Uno."""

    count: Annotated[float, Length, "Table A.5: 20 um lines, read four times"] = 5.0e-6
    range: Annotated[float, Length, "Table A.5"] = 0.370
    max_speed: Annotated[float, Speed, "Table A.5: 60 m/min"] = 1.0
    index: Annotated[float, Quantity("m"), "assumed: the index mark, from the middle of the damper's stroke"] = 0.002
    accuracy: Annotated[float, Metre, "Table A.5: so far off at most"] = 5.0e-6


@dataclass(frozen=True)
class LoadCell:
    """The load cell and its amplifier: volts = zero + force/scale."""

    capacity: Annotated[float, Force, "Table A.4: 500 kg"] = 4903.325
    safe: Annotated[float, Quantity("", low=1.0), "Table A.4: 150 % of the capacity"] = 1.5
    sensitivity: Annotated[float, Quantity("V/V", low=0.0, open_low=True), "Table A.4: 1.955 mV/V"] = 1.955e-3
    bridge: Annotated[float, Quantity("ohm", low=0.0, open_low=True), "assumed: the usual full bridge"] = 350.0
    shunt: Annotated[
        float,
        Quantity("ohm", low=0.0, open_low=True),
        "assumed, where wired: the resistor that the relay of wires.shunt puts across an arm of the bridge, as 562 N would",
    ] = 390.0e3
    mass: Annotated[
        float,
        Quantity("kg", low=0.0, high=1000.0),
        "what hangs between the cell and the damper and moves with the table; its inertia is taken off the force",
    ] = 0.0
    scale: Annotated[float, Quantity("N/V", low=0.0, open_low=True), "measured: steps of 0.187 N of 16 bit"] = 613.0
    zero: Annotated[float, Quantity("V", low=-10.0, high=10.0), "to be measured: `dampyr calibrate`"] = 0.0
    bandwidth: Annotated[float, Quantity("Hz", low=0.0, open_low=True), "assumed: the amplifier's filter"] = 1000.0
    linearity: Annotated[
        float, Quantity("", low=0.0), "Table A.4: of the capacity, at most; its hysteresis is as much"
    ] = 2.0e-4
    scale_uncertainty: Annotated[float, Quantity("", low=0.0), "assumed: of the scale, until `dampyr calibrate`"] = 0.01
    zero_uncertainty: Annotated[float, Quantity("N", low=0.0), "assumed: until `dampyr calibrate`"] = 5.0
    delay_uncertainty: Annotated[float, Second, "assumed: 100 Hz or more, until `dampyr calibrate --amplifier`"] = (
        9.0e-4
    )
    noise: Annotated[float, Quantity("N", low=0.0), "simulated: rms"] = 0.4
    wander: Annotated[
        float,
        Quantity("N", low=0.0),
        "simulated: rms of slow errors; Table A.4: linearity and hysteresis, 1 N at most each",
    ] = 0.8


@dataclass(frozen=True)
class Supply:
    """From the command voltage to the coil: amplifier, enable line and coil."""

    gain: Annotated[
        float, Quantity("V/V", low=0.0, open_low=True), "assumed: volts at the coil per volt of command"
    ] = 1.0
    resistance: Annotated[float, Quantity("ohm", low=0.0, open_low=True), "measured: 0.495 A at 2.178 V"] = 4.4
    inductance: Annotated[float, Quantity("H", low=0.0), "assumed: 10 ms with the resistance"] = 0.044
    gain_uncertainty: Annotated[
        float, Quantity("", low=0.0), "assumed: of the gain, until `dampyr calibrate --coil`"
    ] = 0.05
    resistance_uncertainty: Annotated[
        float, Quantity("", low=0.0), "assumed: of the resistance, until `dampyr calibrate --coil`"
    ] = 0.05
    reading_uncertainty: Annotated[
        float, Quantity("", low=0.0), "assumed: of the coil's readings, by divider, shunt and board"
    ] = 0.003
    max_voltage: Annotated[float, Quantity("V", low=0.0, open_low=True), "1 A of Table A.1 through the coil"] = 4.4
    voltage_scale: Annotated[
        float,
        Quantity("V/V", low=0.0, open_low=True),
        "assumed, where wired: volts at the coil per volt at the board's input",
    ] = 1.0
    current_scale: Annotated[
        float,
        Quantity("A/V", low=0.0, open_low=True),
        "assumed, where wired: a shunt of 0.1 ohm and an amplifier of 10",
    ] = 1.0
    compensated: Annotated[
        bool, "whether the command rises with the coil's warmth, so that the current is that of a coil at 20 degC"
    ] = True
    enable_line: Annotated[
        bool, "whether the Uno's enable line cuts the coil; without it a dead host leaves it live"
    ] = True


@dataclass(frozen=True)
class SpecimenSettings:
    """The damper on the table; all but its name, card and data sheet is for the simulated rig only."""

    name: Annotated[str, "which damper it is, such as its serial number; kept with every record"] = ""
    card: Annotated[
        str,
        "a card of dampyr, beside this file, or a published set's name; empty: the fit to the original rig's damper",
    ] = ""
    data_sheet: Annotated[str, "whose promises a fit is held against: RD-8041-1 (Table A.1), or empty"] = "RD-8041-1"
    free_play: Annotated[float, Metre, "simulated: the play of the pins"] = 0.0
    stroke: Annotated[float, Metre, "simulated: from stop to stop; 0 for limits.stroke"] = 0.0
    heat_capacity: Annotated[float, Quantity("J/K", low=0.0, open_low=True), "assumed: 0.9 kg of steel and fluid"] = (
        450.0
    )
    cooling: Annotated[float, Quantity("W/K", low=0.0), "assumed: still air"] = 1.0
    softening: Annotated[float, Quantity("1/K", low=0.0), "assumed: force lost per kelvin above the room"] = 0.0
    room: Annotated[float, Quantity("degC"), "assumed"] = 20.0

    def __post_init__(self) -> None:
        if self.name:
            object.__setattr__(self, "name", as_group("name", self.name))


@dataclass(frozen=True)
class BoardSettings:
    """How the NI board samples."""

    rate: Annotated[float, Quantity("Hz", low=10.0, high=250000.0), "assumed; the original took 100 samples/s"] = 1000.0
    block: Annotated[float, Quantity("s", low=0.005, high=0.2), "what is read at once: the interlock's reaction"] = 0.04
    velocity_bandwidth: Annotated[
        float, Quantity("Hz", low=1.0), "of the velocity in a record: above, 5 um of the encoder are noise"
    ] = 70.0
    bits: Annotated[int, "PCI-6221"] = 16
    range: Annotated[float, Quantity("V", low=0.1, high=10.0), "PCI-6221: +-10 V"] = 10.0
    encoder_filter: Annotated[
        float,
        Quantity("s", low=0.0),
        "pulses on the encoder's lines that are shorter are ignored; M Series manual p. 7-32: 125 ns, 6.425 us or 2.55 ms; "
        "0 for none",
    ] = 6.425e-6
    clock_accuracy: Annotated[float, Quantity("", low=0.0), "PCI-6221: 50 ppm of the time base"] = 5.0e-5


@dataclass(frozen=True)
class UnoSettings:
    """The Uno's clock and its line, as the simulated rig has them; those of a real one are measured while it is read."""

    clock_ppm: Annotated[
        float,
        Quantity("ppm", low=-2e4, high=2e4),
        "simulated: by which a cold Uno's clock is slower than the board's; a resonator may be 5000 off",
    ] = 1500.0
    clock_drift: Annotated[
        float,
        Quantity("ppm/K"),
        "simulated: slower by so much when warmer; measured on one: forum.arduino.cc, topic 69316",
    ] = 10.0
    warming: Annotated[
        float, Quantity("K", low=0.0), "simulated: by which it warms after it was switched on; assumed"
    ] = 5.0
    warming_time: Annotated[float, Time, "simulated: time constant of that; assumed"] = 300.0
    shortest_latency: Annotated[float, Second, "simulated: of a request and its reply together, at least; assumed"] = (
        0.001
    )
    longest_latency: Annotated[
        float, Second, "simulated: at most, uneven; a serial adapter hands over what has come every 16 ms"
    ] = 0.016

    def __post_init__(self) -> None:
        if self.longest_latency < self.shortest_latency:
            raise InputError(
                f"uno.longest_latency = {self.longest_latency * 1e3:g} ms is less than "
                f"uno.shortest_latency = {self.shortest_latency * 1e3:g} ms; give at least as much"
            )


@dataclass(frozen=True)
class Limits:
    """The limits of every test: the limits of all three safety layers."""

    stroke: Annotated[float, Length, "Table A.1: peak to peak, about the middle"] = 0.074
    braking: Annotated[
        float, Metre, "measured, simulated: the path of braking from 73 mm/s, by which travel ends before stroke does"
    ] = 0.0006
    force: Annotated[float, Force, "Table A.2: the least of actuator, load cell and damper"] = 4500.0
    speed: Annotated[float, Speed, "assumed: half as much again as the actuator's free speed"] = 0.120
    temperature: Annotated[float, Quantity("degC"), "Table A.1"] = 71.0
    voltage: Annotated[float, Quantity("V", low=0.0, open_low=True), "1 A of Table A.1 through the coil"] = 4.4
    heartbeat: Annotated[float, Quantity("s", low=0.05, high=0.2), "after which the Uno stops by itself"] = 0.15


@dataclass(frozen=True, repr=False)
class RigSettings(Shown):
    """A rig: its parts and its limits."""

    name: str = "shaking table, UTFPR 2020"
    wires: Wires = field(default_factory=Wires)
    actuator: Actuator = field(default_factory=Actuator)
    table: TableSettings = field(default_factory=TableSettings)
    encoder: Encoder = field(default_factory=Encoder)
    load_cell: LoadCell = field(default_factory=LoadCell)
    supply: Supply = field(default_factory=Supply)
    specimen: SpecimenSettings = field(default_factory=SpecimenSettings)
    board: BoardSettings = field(default_factory=BoardSettings)
    uno: UnoSettings = field(default_factory=UnoSettings)
    limits: Limits = field(default_factory=Limits)
    certificates: Certificates = field(default_factory=Certificates)

    def __post_init__(self) -> None:
        check(self)

    @property
    def inputs(self) -> dict[str, str]:
        """The analogue inputs that are wired, in the order in which they are read: force, temperature, coil_voltage and
        coil_current, each with its terminal."""
        wires = self.wires
        terminals = {
            "force": wires.force,
            "temperature": wires.temperature,
            "coil_voltage": wires.coil_voltage,
            "coil_current": wires.coil_current,
        }
        return {name: terminal for name, terminal in terminals.items() if terminal}

    @property
    def command_range(self) -> tuple[float, float]:
        """V that the supply may be commanded, lowest and highest: 0 to supply.max_voltage at the coil and a quarter more, since
        a gain that is calibrated may be lower than the one of the settings; within the board's range."""
        return 0.0, min(GAIN_MARGIN * self.supply.max_voltage / self.supply.gain, self.board.range)

    @property
    def max_current_steps(self) -> int:
        """`actuator.max_current` in steps of the Uno's converter; 0 where the bridge's current outputs are not wired."""
        if not self.wires.bridge_current:
            return 0
        return int(self.actuator.max_current / self.actuator.current_scale / UNO_REFERENCE * UNO_STEPS)

    def motor_current(self, steps: int) -> float:
        """A of the motor at a reading of the Uno's converter."""
        return steps / UNO_STEPS * UNO_REFERENCE * self.actuator.current_scale

    @property
    def force_delay(self) -> float:
        """s by which the load cell's filter delays the force: 1/(2 pi f) of its bandwidth f."""
        return 1.0 / (2.0 * pi * self.load_cell.bandwidth)

    @property
    def step(self) -> float:
        """V of the board's converter from one reading to the next."""
        return 2.0 * self.board.range / 2.0**self.board.bits

    @property
    def travel(self) -> float:
        """m from the middle to which the table may go: half of the stroke, less the path that braking takes."""
        return round(0.5 * self.limits.stroke - self.limits.braking, 9)  # nm: so that a difference of decimals is one

    @property
    def block_samples(self) -> int:
        """Samples of a block."""
        return max(1, round(self.board.rate * self.board.block))


def load_settings(path: str | Path) -> RigSettings:
    """The settings in a ``rig.toml``; what it leaves out keeps its default. :class:`FileError` says what is wrong."""
    document = load_toml(path)
    try:
        return fill(RigSettings, _with_filter(document))
    except FileError:
        raise
    except InputError as problem:
        raise FileError(path, str(problem)) from None


def _with_filter(document: dict[str, Any]) -> dict[str, Any]:
    """A file that does not name the encoder's filter has the shorter one where the default is too long for its edges."""
    board, encoder, limits = (document.get(name, {}) for name in ("board", "encoder", "limits"))
    if not all(isinstance(table, dict) for table in (board, encoder, limits)) or "encoder_filter" in board:
        return document
    edges = fill(Encoder, encoder, "encoder").count / fill(Limits, limits, "limits").speed
    fitting = next(width for width in (*FILTERS, 0.0) if edges >= FILTERS_IN_EDGES * width)
    return document | {"board": board | {"encoder_filter": fitting}}


def check(rig: RigSettings) -> None:
    """Raise :class:`InputError` where parts and limits contradict each other."""
    limits, maximum = rig.limits, rig.load_cell.capacity * rig.load_cell.safe
    if limits.force > min(maximum, rig.actuator.max_load):
        least = min(maximum, rig.actuator.max_load)
        raise InputError(
            f"limits.force = {limits.force:g} N is more than the parts are rated for; give at most {least:g} N"
        )
    if limits.stroke > min(rig.encoder.range, rig.actuator.stroke):
        least = min(rig.encoder.range, rig.actuator.stroke)
        raise InputError(
            f"limits.stroke = {limits.stroke * 1e3:g} mm is longer than the parts allow; give at most {least * 1e3:g} mm"
        )
    actuator, range_ = rig.actuator, UNO_REFERENCE * rig.actuator.current_scale
    if actuator.top_speed <= 0.0:
        raise InputError(
            f"actuator.max_duty = {actuator.max_duty:g} moves nothing: the first {actuator.dead_band:g} only overcomes "
            "friction (actuator.dead_band); give more"
        )
    if actuator.no_load_current >= actuator.full_load_current:
        raise InputError(
            f"actuator.no_load_current = {actuator.no_load_current:g} A is not less than actuator.full_load_current = "
            f"{actuator.full_load_current:g} A; give the motor's currents without load and at max_load"
        )
    if rig.wires.bridge_current and not 1 <= rig.max_current_steps < UNO_STEPS:
        raise InputError(
            f"actuator.max_current = {actuator.max_current:g} A is outside of what the Uno reads of the bridge, "
            f"{range_ / UNO_STEPS:.2g} to {range_:.4g} A at actuator.current_scale = {actuator.current_scale:g} A/V; lower it, "
            "or give the bridge's outputs smaller resistors"
        )
    if rig.travel <= 0.0:
        raise InputError(
            f"limits.braking = {limits.braking * 1e3:g} mm leaves nothing of limits.stroke = {limits.stroke * 1e3:g} mm; "
            f"give less than {limits.stroke * 500:g} mm"
        )
    if limits.speed > rig.encoder.max_speed:
        raise InputError(
            f"limits.speed = {limits.speed:g} m/s exceeds the encoder's speed; give at most {rig.encoder.max_speed:g} m/s"
        )
    if limits.voltage > rig.supply.max_voltage:
        raise InputError(
            f"limits.voltage = {limits.voltage:g} V is more than supply.max_voltage = {rig.supply.max_voltage:g} V; lower it"
        )
    if rig.board.velocity_bandwidth > rig.board.rate / 4:
        maximum = rig.board.rate / 4
        raise InputError(
            f"board.velocity_bandwidth = {rig.board.velocity_bandwidth:g} Hz is too much for "
            f"board.rate = {rig.board.rate:g} Hz; give at most {maximum:g} Hz"
        )
    edges = rig.encoder.count / limits.speed
    if edges < FILTERS_IN_EDGES * rig.board.encoder_filter:
        raise InputError(
            f"board.encoder_filter = {rig.board.encoder_filter * 1e6:g} us is too long for edges of the encoder that are "
            f"{edges * 1e6:.3g} us apart at limits.speed; give at most {edges / FILTERS_IN_EDGES * 1e6:.3g} us, such as "
            "125 ns, or 0 for none"
        )
    if limits.heartbeat < 2 * rig.board.block:
        raise InputError(
            f"limits.heartbeat = {limits.heartbeat:g} s must be two blocks or more; shorten board.block = {rig.board.block:g} s"
        )
