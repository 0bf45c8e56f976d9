"""The Uno's serial port: what goes wrong when it is opened is one line with the repair."""

from __future__ import annotations

import pytest
from tests.rig.firmware.pseudo_terminal import one_line, posix, terminal

from dampyr.errors import RigFault
from dampyr.rig.instruments.arduino_uno.wire import Serial


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
