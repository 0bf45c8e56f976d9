"""Bring-up of a rig's first boards: steps from an Uno alone to homing, each measured and judged, in a file that can be sent.

Nothing is energised before the step that says so, and no energised step runs before those that it relies on have passed. The
operator is asked before each step, and may skip it. The file is written after each step; a further run goes on where it ends.
"""

from __future__ import annotations

import getpass
import json
import platform
import re
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from dampyr.atomic_write import write_whole
from dampyr.errors import DampyrError, FileError, RigFault
from dampyr.rig.acquisition import fault_in_words
from dampyr.rig.drive import Drive
from dampyr.rig.firmware.protocol import HIGH_END, LOW_END, PRESSED, Fault, State
from dampyr.rig.instruments.arduino_uno.driver import bridge_repair
from dampyr.rig.instruments.catalogue import is_folder
from dampyr.rig.interlock import Samples
from dampyr.rig.session import Rig
from dampyr.rig.settings import RigSettings
from dampyr.source_digest import full_version

Array = NDArray[np.float64]
Answer = Literal["go", "skip", "stop"]
SCHEMA = 1  # of the file
PATIENCE = 180.0  # s for what a person does by hand
BLOCK = 0.05  # s
REST = 0.3  # s of rest before and after a motion by hand
BY_HAND = 0.010  # m that the table is moved by hand, along a ruler
RULER = 0.0015  # m by which a hand misses that
AGREE = 2  # counts by which Uno and board may differ at rest
PULL = 10.0  # N: a pull that is no noise
LOUD = 3.0  # N rms of a load cell at rest
OFF_ZERO = 0.1  # of the board's range that an unloaded cell may show
COMMAND = 1.0  # V at the coil
SHARE = 0.1  # of that by which it may be off: the supply's gain is assumed until it is measured
DEAD = 0.1  # V that a coil which is off may show
HOLD = 60.0  # s for which the voltage is held while a person reads a voltmeter
READ = 1.0  # s of a reading
OFF_PLACE = 2e-4  # m by which the table may miss its place
LATE = 40.0  # ms of a heartbeat and its reply: the block in which they have to fit
LIBRARIES = ("dampyr", "numpy", "pyserial", "nidaqmx")
FIRMWARE = "make firmware, and flash it (dampyr help firmware)"


@dataclass(frozen=True)
class Reading:
    """A measured value with its limits, and the likely cause and repair where it is outside of them."""

    what: str
    value: float
    unit: str
    low: float
    high: float
    repair: str

    @property
    def passed(self) -> bool:
        """Whether it is within its limits."""
        return self.low <= self.value <= self.high

    def __str__(self) -> str:
        """The reading and its limits, as a person reads them."""
        unit = f" {self.unit}" if self.unit else ""
        if self.low == self.high:
            return f"{self.what} {self.value:g}{unit}, must be {self.low:g}"
        if np.isinf(self.high) or np.isinf(self.low):
            limits = f"{self.low:g} or more" if np.isinf(self.high) else f"{self.high:g} or less"
        else:
            limits = f"{self.low:g} to {self.high:g}"
        return f"{self.what} {self.value:.4g}{unit}, must be {limits}"


class Operator(Protocol):
    """The person at the rig, or a stand-in."""

    def begin(self, step: BringUpStep) -> Answer:
        """Ask before a step."""

    def act(self, action: str, words: str) -> None:
        """Tell what to do by hand now, and return at once; ``action`` names it for a stand-in."""

    def done(self, seconds: float) -> str | None:
        """What was typed once it has been done, after so many seconds; None while it has not."""

    def show(self, step: BringUpStep, verdict: str, readings: list[Reading], cause: str) -> None:
        """Show how a step has ended."""


@dataclass(frozen=True)
class BringUpStep:
    """A step: what to do before it, what has to be seen, and what is measured."""

    name: str
    title: str
    do: str
    see: str
    measure: Callable[[Rig, Operator], Iterator[Reading]] = field(compare=False)
    energised: bool = False
    relies_on: tuple[str, ...] = ()
    needs: Callable[[RigSettings], str] = lambda _: ""
    """Why the step does not concern a rig; empty where it does."""


@dataclass(frozen=True)
class BringUpOutcome:
    """How a step ended: "passed", "failed", "skipped" or "not wired", with the cause."""

    step: str
    verdict: str
    readings: tuple[Reading, ...] = ()
    cause: str = ""
    ended: str = ""


def bring_up(rig: Rig, path: str | Path, operator: Operator) -> list[BringUpOutcome]:
    """Go through the steps that ``path`` does not hold as passed yet, and write each outcome into it.

    Ends at a step that fails, or where the operator stops. What an earlier run with other settings or another firmware has
    written does not count any more. Raises :class:`FileError` where the file is not of a bring-up or cannot be written.
    """
    path, head = Path(path), _head(rig)
    outcomes = {outcome.step: outcome for outcome in _read(path, head)}
    for step in STEPS:
        if step.name in outcomes and outcomes[step.name].verdict == "passed":
            continue
        outcome = _perform(rig, step, operator, outcomes)
        if outcome is None:
            break
        outcomes[step.name] = replace(outcome, ended=datetime.now(UTC).isoformat(timespec="seconds"))
        _write(path, head, list(outcomes.values()), rig.folder)
        operator.show(step, outcome.verdict, list(outcome.readings), outcome.cause)
        if outcome.verdict == "failed":
            break
    return [outcomes[step.name] for step in STEPS if step.name in outcomes]


def _perform(
    rig: Rig, step: BringUpStep, operator: Operator, outcomes: dict[str, BringUpOutcome]
) -> BringUpOutcome | None:
    """The outcome of a step; None where the operator stops."""
    if unwired := step.needs(rig.settings):
        return BringUpOutcome(step.name, "not wired", cause=unwired)
    missing = [name for name in step.relies_on if name not in outcomes or outcomes[name].verdict != "passed"]
    if missing:
        return BringUpOutcome(step.name, "skipped", cause=f"relies on {' and '.join(missing)}, which did not pass")
    answer = operator.begin(step)
    if answer != "go":
        return None if answer == "stop" else BringUpOutcome(step.name, "skipped", cause="by the operator")
    readings: list[Reading] = []
    try:
        for reading in step.measure(rig, operator):
            readings.append(reading)
    except DampyrError as problem:
        cause = "; ".join([str(problem), *getattr(problem, "__notes__", [])])
        return BringUpOutcome(step.name, "failed", tuple(readings), cause)
    wrong = [reading for reading in readings if not reading.passed]
    causes = "; ".join(dict.fromkeys(f"{reading}: {reading.repair}" for reading in wrong))
    return BringUpOutcome(step.name, "failed" if wrong else "passed", tuple(readings), causes)


# what each step measures


def _uno_alone(rig: Rig, _: Operator) -> Iterator[Reading]:
    hello = rig.uno.hello()
    yield Reading("control rate", hello.rate, "Hz", 1000, 1000, FIRMWARE)
    if (program := hello.program) is not None:
        yield Reading("built from the sources of this dampyr", program.up_to_date, "", 1, 1, FIRMWARE)
        wanted = rig.settings.wires.direction_pin
        yield Reading(
            "built for a direction pin", program.direction_pin, "", wanted, wanted, bridge_repair(rig.settings)
        )
    times, status = [], rig.uno.heartbeat()
    for __ in range(20):
        begin = time.monotonic()
        status = rig.uno.heartbeat()
        times.append(1e3 * (time.monotonic() - begin))
    if not rig.clocked_by_reads:  # else no time passes on the line
        late = "look at the port's latency (dampyr help windows), at its hub, and at what else this machine does"
        yield Reading("longest heartbeat of 20", max(times), "ms", 0.0, LATE, late)
    faults = status.faults & ~Fault.RESTARTED
    words = fault_in_words(faults) if faults else "another host has left it armed; switch it off and on"
    yield Reading("faults", int(faults), "", 0, 0, words)
    idle = status.state in (State.IDLE, State.FAULT)
    yield Reading("idle", idle, "", 1, 1, "another host has left it armed; switch it off and on")


def _bridge_unpowered(rig: Rig, _: Operator) -> Iterator[Reading]:
    before = rig.uno.heartbeat().position
    volts, counts = rig.listen(READ)
    after = rig.uno.heartbeat()
    yield Reading(
        "samples in a second", volts.shape[1], "", rig.settings.board.rate * READ, np.inf, "look at the board's clock"
    )
    noise = "the encoder's lines pick up noise: look at its shield, its ground and its filter (dampyr help power)"
    yield Reading("the board's counts of a table at rest", float(np.ptp(counts)), "counts", 0, AGREE, noise)
    yield Reading("the Uno's counts of a table at rest", abs(after.position - before), "counts", 0, AGREE, noise)
    yield Reading("duty", abs(after.duty), "", 0, 0, FIRMWARE)
    yield Reading("enable line", after.enabled, "", 0, 0, FIRMWARE)


def _encoder_by_hand(rig: Rig, operator: Operator) -> Iterator[Reading]:
    count, index = rig.settings.encoder.count, rig.settings.wires.index
    ways = {
        "out": "move the table by hand 10 mm along a ruler in the direction that extends the damper, over the encoder's index",
        "back": "move it 10 mm back to where it was",
    }
    total = np.zeros(2)
    for way, words in ways.items():
        blocks, passes = _while_by_hand(rig, operator, f"turn {way}", words)
        uno, board = (
            blocks[-1].status.position - blocks[0].status.position,
            int(blocks[-1].counts[-1] - blocks[0].counts[0]),
        )
        wanted = BY_HAND if way == "out" else -BY_HAND
        sign = 1.0 if way == "out" else -1.0
        total += uno, board
        dead = "no counts come: look at its supply and its lines A and B at"
        turned = "it counts the other way: swap its lines A and B at both ends, or turn it round"
        scale = "look at encoder.count: the lines' spacing, read four times, of its data sheet"
        for who, moved, pins in (
            ("Uno", uno, "D2 and D3 of the Uno"),
            ("board", board, f"the counter {rig.settings.wires.position}"),
        ):
            cause = f"{dead} {pins}" if abs(moved) <= AGREE else (turned if moved * sign < 0.0 else scale)
            near, far = sorted((wanted - RULER, wanted + RULER))
            yield Reading(f"{way}: moved, by the {who}", 1e3 * moved * count, "mm", 1e3 * near, 1e3 * far, cause)
        differ = "one of them loses counts, or has A and B the other way: look at the lines of the one that is off by the ruler"
        yield Reading(f"{way}: Uno less board", uno - board, "counts", -AGREE, AGREE, differ)
        if index:  # an Uno that is not homed says nothing of the index: homing shows whether it sees it
            unseen = f"the board does not see it: look at line Z at {index}, and whether the way has led over it"
            yield Reading(f"{way}: passes of the index, by the board", passes, "", 1, np.inf, unseen)
    yield Reading(
        "Uno and board after both ways", float(np.ptp(total)), "counts", 0, AGREE, "counts are lost; look at the lines"
    )


def _load_cell(rig: Rig, operator: Operator) -> Iterator[Reading]:
    calibration, span = rig.calibration, rig.settings.board.range
    assert calibration is not None
    volts = rig.listen(READ)[0][0]
    off = "set the amplifier's zero, take what loads the cell off, and look at its wire: an open input floats"
    zero = float(np.mean(volts))
    yield Reading("signal without load", zero, "V", -OFF_ZERO * span, OFF_ZERO * span, off)
    force = calibration.force(volts)
    yield Reading("noise", float(np.std(force)), "N rms", 0.0, LOUD, "look at its shield and ground")
    blocks, _ = _while_by_hand(
        rig, operator, "pull", "pull at the load cell by hand, as a damper does that is being extended"
    )
    pulled = np.concatenate([calibration.force(block.volts[0]) for block in blocks]) - float(np.mean(force))
    smooth = np.convolve(pulled, np.ones(50) / 50.0, "valid")
    largest = float(smooth[np.argmax(np.abs(smooth))])
    cause = "nothing is felt: look at the cell's wires, its supply and its amplifier, or pull harder"
    if largest < -PULL:
        cause = "its sign is inverted: swap the two wires of its signal, or calibrate it with a negative load"
    yield Reading("largest force of the pull", largest, "N", PULL, rig.settings.limits.force, cause)


def _switches(rig: Rig, operator: Operator) -> Iterator[Reading]:
    wires = rig.settings.wires
    rows = []
    if wires.end_switches:
        rows += [
            ("low switch", LOW_END, "the end switch before the lower end", "pin 5"),
            ("high switch", HIGH_END, "the end switch before the upper end", "pin 6"),
        ]
    if wires.emergency_stop:
        rows.append(("stop", PRESSED, "the emergency stop", "pin 11"))
    mask = (LOW_END | HIGH_END) * wires.end_switches | PRESSED * wires.emergency_stop
    closed = (
        f"a switch is open or its wire is broken: look at {', '.join(row[3] for row in rows)} of the Uno and at ground"
    )
    # Before LIMITS have told the Uno what is wired it says of its inputs what its pins show.
    yield Reading("inputs that are open at rest", rig.uno.heartbeat().inputs & mask, "", 0, 0, closed)
    for action, bit, name, pin in rows:
        blocks, _ = _while_by_hand(rig, operator, action, f"open {name} with a finger, and let it go again")
        seen = {block.status.inputs & mask for block in blocks}
        other = f"another input opened: the wires of {name} and of the other switch are exchanged"
        cause = other if seen - {0, bit} else f"nothing opened: look at the wire of {name} to {pin} of the Uno"
        yield Reading(f"{name} opened, and no other", seen == {0, bit}, "", 1, 1, cause)


def _coil(rig: Rig, operator: Operator) -> Iterator[Reading]:
    supply = rig.settings.supply
    enable = "without it a dead host leaves the coil live: wire the supply through pin 8 of the Uno (dampyr help power)"
    yield Reading("enable line wired", supply.enable_line, "", 1, 1, enable)
    low, high = COMMAND * (1.0 - SHARE), COMMAND * (1.0 + SHARE)
    live = "the enable line does not cut the supply: look at pin 8 of the Uno, and at its resistor to ground"
    volts, _ = _coil_while(_commanded(rig), rig, operator)
    yield Reading("disarmed, 1 V commanded: at the coil", volts, "V", -DEAD, DEAD, live)
    with rig.armed() as table:
        n = round(HOLD / 0.01)
        drive = Drive(0.01, np.full(n, table.position), np.full(n, COMMAND), standing=True)
        armed = (samples.volts for samples, _ in table.play(drive))
        volts, current = _coil_while(armed, rig, operator)
    nothing = "the supply gives nothing: look at its power, its fuse, its enable line and the wire of its command"
    cause = nothing if abs(volts) < DEAD else "look at supply.gain, and at the input's wires and supply.voltage_scale"
    yield Reading("armed, 1 V commanded: at the coil", volts, "V", low, high, cause)
    if current is not None:
        wanted = COMMAND / supply.resistance
        broken = f"no current flows: the resistor ({supply.resistance:g} ohm) or a wire is open"
        cause = (
            broken
            if abs(current) < 0.1 * wanted
            else "look at the resistor, supply.resistance and supply.current_scale"
        )
        yield Reading("armed: current", current, "A", wanted * (1.0 - 2 * SHARE), wanted * (1.0 + 2 * SHARE), cause)
    volts, _ = _coil_while(_commanded(rig), rig, operator)
    yield Reading("disarmed again: at the coil", volts, "V", -DEAD, DEAD, live)


def _one_millimetre(rig: Rig, _: Operator) -> Iterator[Reading]:
    yield from _moved(rig, 1e-3)


def _five_millimetres(rig: Rig, _: Operator) -> Iterator[Reading]:
    yield from _moved(rig, 5e-3)


def _moved(rig: Rig, distance: float) -> Iterator[Reading]:
    """Out, to the other side and back, from where the table stands, which is taken for the middle."""
    blocks: list[Samples] = []
    places: list[tuple[float, float, float]] = []
    rig.watchers.append(blocks.append)
    try:
        with rig.armed() as table:
            table.home(here=True)
            blocks.clear()
            for place in (distance, -distance, 0.0):
                table.go(place)
                places.append((place, table.position, float(blocks[-1].displacement[-1])))
    finally:
        rig.watchers.remove(blocks.append)
    mm, tolerance = f"{1e3 * distance:g} mm", 1e3 * OFF_PLACE
    for place, uno, board in places[:2]:
        missed = "look at the motor, its driver and the screw, and at actuator.free_speed and dead_band"
        where, wanted = f"{1e3 * place:+g} mm", 1e3 * place
        yield Reading(f"at {where}, by the Uno", 1e3 * uno, "mm", wanted - tolerance, wanted + tolerance, missed)
        apart = "the board and the Uno disagree: look at the encoder's lines to both"
        yield Reading(f"at {where}, by the board", 1e3 * board, "mm", wanted - tolerance, wanted + tolerance, apart)
    x = np.concatenate([block.displacement for block in blocks])
    force = np.concatenate([block.force for block in blocks])
    work = float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(x)))
    inverted = "the damper gives work instead of taking it: the force's sign is inverted"
    yield Reading(f"work taken over {mm} to either side", work, "J", -0.01, np.inf, inverted)
    felt = "stop, and look at what the table runs against"
    yield Reading("largest force", float(np.max(np.abs(force))), "N", 0.0, rig.settings.limits.force, felt)


def _homing(rig: Rig, _: Operator) -> Iterator[Reading]:
    with rig.armed() as table:
        table.home()
        yield Reading("homed", table.homed, "", 1, 1, "the Uno does not see the index: look at line Z at D4")
        table.verify_index()
        travel = 1e3 * rig.settings.travel
        yield Reading("stands at", 1e3 * table.position, "mm", -travel, travel, "look at encoder.index")


def _while_by_hand(rig: Rig, operator: Operator, action: str, words: str) -> tuple[list[Samples], int]:
    """The blocks from before a person does something until after, and the passes of the index that the board has seen."""
    blocks: list[Samples] = []
    latched, began, ended = 0, -1.0, np.inf
    monitor = rig.monitor(BLOCK)
    try:
        for samples in monitor:
            blocks.append(samples)
            latched += len(rig.board.index_counts())
            now = float(samples.time[-1])
            if began < 0.0 and now >= REST:
                operator.act(action, words)
                began = now
            elif began >= 0.0 and np.isinf(ended) and operator.done(now - began) is not None:
                ended = now
            elif now - began > PATIENCE and np.isinf(ended):
                raise RigFault(f"nothing was done within {PATIENCE:g} s; run it again: it goes on", "operator")
            if now >= ended + REST:
                break
    finally:
        monitor.close()
    return blocks, latched


def _commanded(rig: Rig) -> Iterator[Array]:
    """The volts of all inputs while the board commands `COMMAND` and nothing is armed."""
    n = max(2, round(BLOCK * rig.settings.board.rate))
    command = COMMAND / rig.settings.supply.gain
    rig.board.start(rig.settings.board.rate, np.full(4 * n, command))
    try:
        while True:
            yield rig.board.read(n)[0]
            rig.board.queue(np.full(n, command))
    finally:
        rig.board.write(0.0)
        rig.board.stop()


def _coil_while(blocks: Iterator[Array], rig: Rig, operator: Operator) -> tuple[float, float | None]:
    """The coil's voltage, read back or by a person's voltmeter, and its current where that is read, after `READ` s."""
    names, supply, rate = list(rig.settings.inputs), rig.settings.supply, rig.settings.board.rate
    by_hand = "coil_voltage" not in names
    seconds, asked = 0.0, 0.0
    typed: str | None = None if by_hand else ""
    for volts in blocks:
        seconds += volts.shape[1] / rate
        if seconds < READ:
            continue
        if by_hand and not asked:
            asked = seconds
            operator.act(
                "voltmeter", f"measure the voltage at the coil's resistor, and type the volts (within {HOLD:g} s)"
            )
        elif by_hand:
            typed = operator.done(seconds - asked)
        if typed is not None:
            break
    blocks.close()  # type: ignore[attr-defined]
    current = (
        float(np.mean(volts[names.index("coil_current")])) * supply.current_scale if "coil_current" in names else None
    )
    if not by_hand:
        return float(np.mean(volts[names.index("coil_voltage")])) * supply.voltage_scale, current
    try:
        return float((typed or "").replace(",", ".").removesuffix("V")), current
    except ValueError:
        raise RigFault(f"{typed or 'nothing'!r} is no voltage; run it again: it goes on", "operator") from None


def _no_switches(rig: RigSettings) -> str:
    wired = rig.wires.end_switches or rig.wires.emergency_stop
    return "" if wired else "wires.end_switches and wires.emergency_stop are false"


STEPS = (
    BringUpStep(
        "uno", "The Uno alone",
        "connect the Uno by its USB cable only; nothing else is wired to it",
        "it answers, was built from this dampyr's sources for your bridge, and has no fault",
        _uno_alone,
    ),
    BringUpStep(
        "bridge-unpowered", "Bridge and board, unpowered",
        "wire bridge, encoder, load cell and board as in the wiring table; leave the supplies of motor and coil OFF",
        "the board samples, nothing counts while the table rests, duty and enable line are 0",
        _bridge_unpowered, relies_on=("uno",),
    ),
    BringUpStep(
        "encoder", "The encoder, moved by hand",
        "lay a ruler beside the table; its encoder's index lies within the next 10 mm of extension",
        "Uno and board count the same, up where the damper is extended, 10 mm for 10 mm, and the board sees the index",
        _encoder_by_hand, relies_on=("uno", "bridge-unpowered"),
    ),
    BringUpStep(
        "load-cell", "The load cell, pulled by hand",
        "take the damper off the cell, and leave the cell alone until you are asked",
        "its signal is near 0 V and quiet, and a pull as of a damper that is being extended is positive",
        _load_cell, relies_on=("bridge-unpowered",),
    ),
    BringUpStep(
        "switches", "End switches and emergency stop",
        "leave the supplies OFF; let go of all switches",
        "each opens its own input, and none is open at rest",
        _switches, relies_on=("uno",), needs=_no_switches,
    ),
    BringUpStep(
        "coil", "The coil's supply on a resistor",
        "wire a resistor of the coil's resistance, 5 W or more, in the place of the coil; motor supply OFF, coil supply ON",
        "1 V at the resistor while armed, and 0 V while not, though the board commands 1 V",
        _coil, energised=True, relies_on=("uno", "bridge-unpowered"),
    ),
    BringUpStep(
        "1-mm", "The motor: 1 mm",
        "no damper on the table; put it into the middle of its stroke; a hand on the emergency stop or the supply's switch; "
        "motor supply ON",
        "the table goes 1 mm to either side and back, and both counters agree",
        _one_millimetre, energised=True, relies_on=("uno", "bridge-unpowered", "encoder"),
    ),
    BringUpStep(
        "5-mm", "The motor: 5 mm",
        "mount the damper, the table in the middle of its stroke",
        "the table goes 5 mm to either side and back, and the damper takes work",
        _five_millimetres, energised=True, relies_on=("1-mm", "load-cell"),
    ),
    BringUpStep(
        "homing", "Homing",
        "leave everything as it is; the table will go to and fro at 2 mm/s, at most over the whole stroke",
        "the index is found, and found again where it was",
        _homing, energised=True, relies_on=("5-mm",),
    ),
)  # fmt: skip


# the file


def _head(rig: Rig) -> dict[str, Any]:
    """What the file says of machine, rig and boards."""
    versions = {}
    for name in LIBRARIES:
        with suppress(metadata.PackageNotFoundError):
            versions[name] = metadata.version(name)
    settings = asdict(rig.settings)
    for role, value in settings["wires"].items():
        if isinstance(value, str) and is_folder(value) and not value.startswith("/dev/") and "//" not in value:
            settings["wires"][role] = Path(value).name
    settings["specimen"]["card"] = Path(settings["specimen"]["card"]).name
    try:
        hello = rig.uno.hello()
        firmware: Any = asdict(hello)
    except RigFault as problem:
        firmware = str(problem)
    try:
        board = rig.board.identity()
    except RigFault as problem:
        board = str(problem)
    system = {"python": platform.python_version(), "system": platform.system(), "machine": platform.machine()}
    return {
        "schema": SCHEMA,
        "dampyr": full_version(),
        "versions": versions | system,
        "simulated": rig.simulated,
        "settings": settings,
        "firmware": firmware,
        "board": board,
    }


def _read(path: Path, head: dict[str, Any]) -> list[BringUpOutcome]:
    """The outcomes that still count: those with these settings and boards."""
    if not path.exists():
        return []
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        before = {key: document[key] for key in ("schema", "settings", "firmware", "simulated")}
        rows = document["steps"]
        outcomes = [
            BringUpOutcome(**(row | {"readings": tuple(_reading(reading) for reading in row["readings"])}))
            for row in rows
        ]
    except (OSError, ValueError, KeyError, TypeError) as problem:
        raise FileError(path, f"is not the file of a bring-up ({problem}); give another name with --out") from None
    now = json.loads(json.dumps({key: head[key] for key in before}))
    return outcomes if before == now else []


def _reading(row: dict[str, Any]) -> Reading:
    low, high = (-np.inf if row["low"] is None else row["low"], np.inf if row["high"] is None else row["high"])
    return Reading(row["what"], row["value"], row["unit"], low, high, row["repair"])


def _write(path: Path, head: dict[str, Any], outcomes: list[BringUpOutcome], folder: Path | None) -> None:
    """Write the file, whole or not at all."""
    rows = [asdict(outcome) for outcome in outcomes]
    for row in rows:
        for reading in row["readings"]:
            reading["value"] = float(reading["value"])
            for end in ("low", "high"):
                reading[end] = None if np.isinf(reading[end]) else float(reading[end])
    text = json.dumps(head | {"steps": rows}, indent=1, default=str, ensure_ascii=False)
    write_whole(path, without_private(text, folder) + "\n")


def without_private(text: str, folder: Path | None) -> str:
    """The text without the folders of this machine and the name of its user."""
    for private in {str(Path.home()), str((folder or Path()).resolve())} - {"/", ""}:
        for form in (private, json.dumps(private)[1:-1]):
            text = text.replace(form, "...")
    with suppress(OSError, KeyError, ImportError):
        user = getpass.getuser()
        text = re.sub(rf"(/home/|/Users/|\\\\Users\\\\){re.escape(user)}\b", r"\1...", text)
    return text
