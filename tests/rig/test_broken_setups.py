"""A list of broken set-ups: doctor names the missing piece of each with a repair, and a whole set-up has none."""

from __future__ import annotations

from dataclasses import replace
from importlib import metadata

import pytest
from tests.rig.table import settings

from dampyr.errors import RigFault
from dampyr.rig import RigSettings, diagnosis, simulated
from dampyr.rig.diagnosis import RigCheck, _board, _libraries, _settings, _uno
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import open_wire
from dampyr.rig.instruments.contract import Program

WHOLE = settings(
    True,
    True,
    index="ctr1/PFI9",
    coil_voltage="ai2",
    coil_current="ai3",
    temperature="ai1",
    shunt="port0/line0",
    bridge_current=True,
)


def asked(*faults: str, rig: RigSettings = WHOLE, parts: RigSettings | None = None) -> list[RigCheck]:
    """What doctor says of the settings and the boards of a simulated rig; a board that does not answer is a finding."""
    checks = list(_settings(rig, None))
    with simulated(rig, faults=faults, parts=parts) as opened:
        for look in (_uno, _board):
            try:
                checks += [check for check in look(opened) if check.what != "Uno's brown-out"]
            except RigFault as problem:
                checks.append(RigCheck(look.__name__.strip("_"), "does not answer", str(problem)))
    return checks


def wrong(checks: list[RigCheck]) -> list[str]:
    return [f"{check.what}: {check.repair}" for check in checks if check.repair]


def test_a_whole_set_up_lacks_nothing() -> None:
    assert wrong(asked()) == []


WIRES = {
    "no enable line": (replace(WHOLE, supply=replace(WHOLE.supply, enable_line=False)), "pin 8 of the Uno"),
    "no end switches": (replace(WHOLE, wires=replace(WHOLE.wires, end_switches=False)), "pins 5 and 6"),
    "no emergency stop": (replace(WHOLE, wires=replace(WHOLE.wires, emergency_stop=False)), "pin 11"),
    "no index": (replace(WHOLE, wires=replace(WHOLE.wires, index="")), "encoder's Z"),
    "no reading of the coil's current": (
        replace(WHOLE, wires=replace(WHOLE.wires, coil_current="")),
        "wires.coil_current",
    ),
    "no shunt": (replace(WHOLE, wires=replace(WHOLE.wires, shunt="")), "wires.shunt"),
    "no reading of the motor's current": (
        replace(WHOLE, wires=replace(WHOLE.wires, bridge_current=False)),
        "R_IS and L_IS",
    ),
    "an instrument that is not there": (replace(WHOLE, wires=replace(WHOLE.wires, drive="arduino-due")), "wires.drive"),
}
FAULTS = {
    "no Uno": ("unplugged-serial@0s", "check its cable"),
    "no board": ("board-timeout@0s", "-200284"),
    "load cell's wire broken": ("broken-cell=10@0s", "look at its wire and its supply"),
    "load cell dead": ("cell-gain=0@0s", "relay does nothing"),
    "load cell inverted": ("inverted-cell@0s", "load_cell.shunt, bridge and sensitivity"),
    "load cell's gain wrong": ("cell-gain=0.9@0s", "calibrate the cell again"),
    "emergency stop pressed": ("emergency-stop@0s", "release it"),
}


@pytest.mark.parametrize("name", WIRES)
def test_what_is_not_wired_is_named_with_the_repair(name: str) -> None:
    rig, words = WIRES[name]
    (sentence,) = wrong(list(_settings(rig, None)))
    assert words in sentence


@pytest.mark.parametrize("name", FAULTS)
def test_what_does_not_answer_right_is_named_with_the_repair(name: str) -> None:
    fault, words = FAULTS[name]
    sentences = wrong(asked(fault))
    assert len(sentences) == 1
    assert words in sentences[0]


@pytest.mark.parametrize("library", ["pyserial", "nidaqmx"])
def test_a_library_that_is_missing_is_named_with_the_line_that_installs_it(library: str, monkeypatch) -> None:
    real = metadata.version

    def version(name: str) -> str:
        if name == library:
            raise metadata.PackageNotFoundError(name)
        return real(name)

    monkeypatch.setattr(metadata, "version", version)
    (sentence,) = [sentence for sentence in wrong(list(_libraries())) if library in sentence]
    assert "pip install" in sentence


def test_a_wrong_port_is_named() -> None:
    pytest.importorskip("serial")
    with pytest.raises(
        RigFault, match=r"there is no such serial port; plug the Uno in and name its port in wires.serial"
    ):
        open_wire("/dev/ttyACM77", 250000)


class Wire:
    """A line that answers with these bytes."""

    boot = answer = 0.0

    def __init__(self, answer: bytes) -> None:
        self.bytes = answer

    def discard(self) -> None: ...

    def send(self, data: bytes) -> None: ...

    def receive(self) -> bytes:
        return self.bytes

    def close(self) -> None: ...


def test_a_wrong_speed_of_the_line_is_named() -> None:
    with pytest.raises(RigFault, match=r"its line has another speed than wires.baud"):
        Uno(Wire(b"\x80\xf3\x00\x1c"), wait=0.0).hello()


@pytest.mark.parametrize(
    ("program", "words"),
    [
        (Program(False, 250000, "0badf00d", False, 0xFC), "make firmware, and flash it"),
        (Program(True, 250000, "00", True, 0xFC), "wires.direction_pin = false means another bridge"),
        (Program(False, 250000, "00", True, 0xFD), "set the extended fuse to FC"),
    ],
    ids=["old firmware", "wrong bridge", "brown-out"],
)
def test_a_wrong_build_of_the_firmware_is_named(program: Program, words: str) -> None:
    (sentence,) = wrong(list(diagnosis._program(WHOLE, program)))
    assert words in sentence


def test_the_latency_of_a_windows_port_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(diagnosis, "port_latency", lambda port: 16)
    (check,) = diagnosis._port(replace(WHOLE, wires=replace(WHOLE.wires, serial="COM3")))
    assert "set 1 ms" in (check.repair or "")
    monkeypatch.setattr(diagnosis, "port_latency", lambda port: 1)
    (check,) = diagnosis._port(replace(WHOLE, wires=replace(WHOLE.wires, serial="COM3")))
    assert check.repair is None
    monkeypatch.setattr(diagnosis, "port_latency", lambda port: None)
    assert list(diagnosis._port(WHOLE)) == []
