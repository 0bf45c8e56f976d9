"""The Uno's serial port: what goes wrong when it is opened is one line with the repair."""

from __future__ import annotations

import sys
from types import SimpleNamespace
from typing import Any

import pytest
from tests.rig.firmware.pseudo_terminal import one_line, posix, terminal

from dampyr.errors import DampyrWarning, RigFault
from dampyr.rig.instruments.arduino_uno.wire import FTDI, Serial, port_latency


def opened(port: str) -> RigFault:
    with pytest.raises(RigFault) as raised:
        Serial(port, 250000)
    return raised.value


@posix
def test_a_port_that_is_not_there() -> None:
    one_line(
        opened("/dev/ttyACM77"), "^/dev/ttyACM77: ", "plug the Uno in and name its port in wires.serial", "here|none"
    )


@posix
@pytest.mark.parametrize("path", ["/dev/null", "/", __file__])
def test_a_file_that_is_no_port(path: str) -> None:
    one_line(opened(path), f"^{path}: ", "name the Uno's port in wires.serial")


@posix
def test_a_port_that_another_program_has() -> None:
    with terminal(lambda _: b"") as port:
        first = Serial(port, 250000)
        one_line(opened(port), "close that")
        first.close()
        Serial(port, 250000).close()


@pytest.mark.parametrize(
    ("number", "text", "words"),
    [
        (
            13,
            "[Errno 13] could not open port /dev/ttyACM0: [Errno 13] Permission denied: '/dev/ttyACM0'",
            "usermod -a -G dialout",
        ),
        (16, "[Errno 16] could not open port /dev/ttyACM0: [Errno 16] Device or resource busy", "close that"),
        (None, "could not open port 'COM3': PermissionError(13, 'Access is denied.', None, 5)", "close that"),
        (
            None,
            "could not open port 'COM3': FileNotFoundError(2, 'The system cannot find ...', None, 2)",
            "plug the Uno in",
        ),
    ],
)
def test_a_port_that_the_system_refuses(
    monkeypatch: pytest.MonkeyPatch, number: int | None, text: str, words: str
) -> None:
    """The words of Linux and of Windows, as pyserial hands them on."""
    serial = pytest.importorskip("serial")

    def refuse(*_: object, **__: object) -> None:
        problem = serial.SerialException(text)
        problem.errno = number
        raise problem

    monkeypatch.setattr(serial, "Serial", refuse)
    one_line(opened("COM3"), words)


class Key:
    """A key of a registry that is a dictionary of paths, each with its values."""

    def __init__(self, tree: dict[str, dict[str, Any]], path: str) -> None:
        self.tree, self.path = tree, path
        if not any(name == path or name.startswith(path + "\\") for name in tree):
            raise FileNotFoundError(2, path)

    def __enter__(self) -> Key:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    @property
    def below(self) -> list[str]:
        """The keys below it."""
        begin = self.path + "\\"
        return sorted({name.removeprefix(begin).split("\\")[0] for name in self.tree if name.startswith(begin)})

    def value(self, name: str) -> tuple[Any, int]:
        """A value, as winreg gives it."""
        if name not in self.tree.get(self.path, {}):
            raise FileNotFoundError(2, name)
        return self.tree[self.path][name], 1


def windows(monkeypatch: pytest.MonkeyPatch, tree: dict[str, dict[str, Any]]) -> None:
    """A stand-in for winreg."""
    registry = SimpleNamespace(
        HKEY_LOCAL_MACHINE=None,
        OpenKey=lambda _, path: Key(tree, path),
        EnumKey=lambda key, k: key.below[k],
        QueryInfoKey=lambda key: (len(key.below), 0, 0),
        QueryValueEx=lambda key, name: key.value(name),
    )
    monkeypatch.setitem(sys.modules, "winreg", registry)
    monkeypatch.setattr(sys, "platform", "win32")


def parameters(chip: str) -> str:
    return rf"{FTDI}\VID_0403+PID_6001+{chip}\0000\Device Parameters"


CHIPS = {
    parameters("A1"): {"PortName": "COM7", "LatencyTimer": 16},
    parameters("A2"): {"LatencyTimer": 1},
    parameters("A3"): {"PortName": "COM3", "LatencyTimer": 1},
}


def test_the_latency_of_an_ftdi_port_is_read_from_the_registry_of_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    windows(monkeypatch, CHIPS)
    assert [port_latency(port) for port in ("COM7", "com3", "COM4")] == [16, 1, None]
    windows(monkeypatch, {})
    assert port_latency("COM7") is None


def test_other_systems_have_no_registry() -> None:
    assert sys.platform == "win32" or port_latency("/dev/ttyUSB0") is None


def test_a_port_that_holds_bytes_for_16_ms_is_told_with_the_repair(monkeypatch: pytest.MonkeyPatch) -> None:
    serial = pytest.importorskip("serial")
    monkeypatch.setattr(serial, "Serial", lambda *_, **__: None)
    windows(monkeypatch, CHIPS)
    with pytest.warns(DampyrWarning, match=r"COM7: .* up to 16 ms .* set 1 ms in the Device Manager"):
        Serial("COM7", 250000)
    Serial("COM3", 250000)  # a warning is an error in tests
