"""The wire to the Uno: a serial port, a TCP socket, or a simulated rig in this process."""

from __future__ import annotations

import errno
import socket
import sys
import warnings
from collections.abc import Callable
from typing import Any, Protocol

from dampyr.errors import DampyrWarning, RigFault, install_line

LOST: tuple[type[Exception], ...] = (OSError,)
try:
    import termios
except ImportError:  # Windows has none
    pass
else:
    LOST = (OSError, termios.error)

PATIENCE = 0.02  # s of waiting for a reply: the Uno answers within a few ms
BOOT = (
    2.2  # s: opening a port resets an Uno, and its boot loader (0.5 to 2 s) takes what is sent meanwhile for a program
)
ANSWER = 6.0  # s after opening until an Uno has answered: more than 3 s of asking after the slowest boot loader
SLOW_PORT = 2  # ms of a port's latency timer: two of 16 ms and their replies do not fit between two blocks
FTDI = r"SYSTEM\CurrentControlSet\Enum\FTDIBUS"  # of HKEY_LOCAL_MACHINE
PULLED = "check its cable, connect again and home the table (the Uno has cut the coil by itself)"


class Wire(Protocol):
    """Bytes to the Uno and back.

    ``boot``: s after opening in which nothing is to be sent; ``answer``: s after opening for which a first HELLO is repeated.
    """

    boot: float
    answer: float

    def discard(self) -> None:
        """Drop what has come."""

    def send(self, data: bytes) -> None:
        """Send, or raise :class:`RigFault` where nothing is connected."""

    def receive(self) -> bytes:
        """What has come, after waiting a little; nothing where nothing came."""

    def close(self) -> None:
        """Let go of the wire."""


class InProcess:
    """A simulated rig in this process: ``serial`` gives the bytes that the Uno sends back."""

    boot = answer = 0.0  # it answers at once or never

    def __init__(self, serial: Callable[[bytes], bytes]) -> None:
        self._serial, self._waiting = serial, b""

    def discard(self) -> None:
        """Drop the answer."""
        self._waiting = b""

    def send(self, data: bytes) -> None:
        """Send, and take the answer."""
        self._waiting += self._serial(data)

    def receive(self) -> bytes:
        """The answer."""
        data, self._waiting = self._waiting, b""
        return data

    def close(self) -> None:
        """Nothing to close."""


class Tcp:
    """``socket://host:port``: the simulated rig's process, or a serial server, which may reset the Uno as a port does."""

    boot, answer = 0.0, ANSWER

    def __init__(self, address: str) -> None:
        host, _, port = address.removeprefix("socket://").rpartition(":")
        self.address = address
        try:
            self._socket = socket.create_connection((host, int(port)), timeout=2.0)
        except (OSError, ValueError) as problem:
            raise RigFault(f"{address}: cannot be reached ({problem}); is the rig's process running?") from problem
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.settimeout(PATIENCE)

    def discard(self) -> None:
        """Nothing: a new connection has nothing of an old one."""

    def send(self, data: bytes) -> None:
        """Send all of it."""
        try:
            self._socket.sendall(data)
        except OSError as problem:
            raise RigFault(f"{self.address}: the connection to the Uno is lost ({problem})") from problem

    def receive(self) -> bytes:
        """What comes within `PATIENCE`."""
        try:
            data = self._socket.recv(4096)
        except TimeoutError:
            return b""
        except OSError as problem:
            raise RigFault(f"{self.address}: the connection to the Uno is lost ({problem})") from problem
        if not data:
            raise RigFault(f"{self.address}: the Uno's end was closed; is the rig's process still running?")
        return data

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


class Serial:
    """A serial port, by pyserial."""

    boot, answer = BOOT, ANSWER

    def __init__(self, port: str, baud: int) -> None:
        self.port = port
        try:
            import serial
        except ImportError as problem:
            raise RigFault(f"the Uno needs pyserial; install it: {install_line('rig')}") from problem
        try:
            self._serial: Any = serial.Serial(port, baud, timeout=PATIENCE, write_timeout=0.5, exclusive=True)
        except (OSError, ValueError) as problem:
            raise RigFault(f"{port}: {_why_closed(problem)}") from problem
        latency = port_latency(port)
        if latency is not None and latency > SLOW_PORT:
            slow = f"{port}: its driver holds what the Uno sends for up to {latency} ms (FTDI's latency timer); set 1 ms in "
            slow += "the Device Manager: Ports, this port, Port Settings, Advanced"
            warnings.warn(slow, DampyrWarning, stacklevel=3)

    def discard(self) -> None:
        """Drop what has come: a boot loader's bytes, or replies to another host."""
        try:
            self._serial.reset_input_buffer()
        except LOST as problem:
            raise self._lost(problem) from problem

    def send(self, data: bytes) -> None:
        """Send all of it."""
        try:
            self._serial.write(data)
        except LOST as problem:
            raise self._lost(problem) from problem

    def receive(self) -> bytes:
        """What comes within `PATIENCE`."""
        try:
            return bytes(self._serial.read(max(1, self._serial.in_waiting)))
        except LOST as problem:
            raise self._lost(problem) from problem

    def _lost(self, problem: Exception) -> RigFault:
        return RigFault(f"{self.port}: the connection to the Uno is lost ({problem}); {PULLED}")

    def close(self) -> None:
        """Close the port."""
        self._serial.close()


def port_latency(port: str) -> int | None:
    """ms of the latency timer of an FTDI port on Windows, where its driver keeps it; None for another port or system."""
    if sys.platform != "win32":
        return None
    import winreg

    def names(key: Any) -> list[str]:
        return [winreg.EnumKey(key, k) for k in range(winreg.QueryInfoKey(key)[0])]

    def value(path: str, name: str) -> Any:
        with winreg.OpenKey(winreg.HKEY_LOCAL_MACHINE, path) as key:
            return winreg.QueryValueEx(key, name)[0]

    try:
        with winreg.OpenKey(winreg.HKEY_LOCAL_MACHINE, FTDI) as chips:
            paths = [rf"{FTDI}\{chip}\0000\Device Parameters" for chip in names(chips)]
    except OSError:  # no FTDI chip was ever plugged in
        return None
    for path in paths:
        try:
            if value(path, "PortName").upper() == port.upper():
                return int(value(path, "LatencyTimer"))
        except OSError:  # a chip without a port, or a driver that keeps no timer
            continue
    return None


def _why_closed(problem: Exception) -> str:
    """Why a serial port cannot be opened, and the repair; Windows' errors have only a text."""
    number, text = getattr(problem, "errno", None), str(problem)
    if number == errno.ENOENT or "FileNotFoundError" in text:
        return f"there is no such serial port; plug the Uno in and name its port in wires.serial ({_ports_here()})"
    if number == errno.EACCES:
        return (
            "the serial port cannot be opened by this user; join its group (sudo usermod -a -G dialout $USER on Debian) "
            "and log in again"
        )
    if number in (errno.EAGAIN, errno.EBUSY) or "PermissionError" in text:
        return "the serial port is in use by another program; close that (a serial monitor, another dampyr)"
    return f"the serial port cannot be opened ({text}); name the Uno's port in wires.serial ({_ports_here()})"


def _ports_here() -> str:
    """The serial ports of this computer."""
    from serial.tools.list_ports import comports

    names = [port.device for port in comports()]
    return f"here: {', '.join(names)}" if names else "this computer has none now"


def open_wire(address: str, baud: int) -> Wire:
    """The wire at a serial port or at ``socket://host:port``."""
    return Tcp(address) if address.startswith("socket://") else Serial(address, baud)
