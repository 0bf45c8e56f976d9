"""The wire to the Uno: a serial port, a TCP socket, or a simulated rig in this process."""

from __future__ import annotations

import socket
from collections.abc import Callable
from typing import Any, Protocol

from dampyr.errors import RigFault

PATIENCE = 0.02  # s of waiting for a reply: the Uno answers within a few ms


class Wire(Protocol):
    """Bytes to the Uno and back."""

    def send(self, data: bytes) -> None:
        """Send, or raise :class:`RigFault` where nothing is connected."""

    def receive(self) -> bytes:
        """What has come, after waiting a little; nothing where nothing came."""

    def close(self) -> None:
        """Let go of the wire."""


class InProcess:
    """A simulated rig in this process: ``answer`` gives the bytes that the Uno sends back."""

    def __init__(self, answer: Callable[[bytes], bytes]) -> None:
        self._answer, self._waiting = answer, b""

    def send(self, data: bytes) -> None:
        """Send, and take the answer."""
        self._waiting += self._answer(data)

    def receive(self) -> bytes:
        """The answer."""
        data, self._waiting = self._waiting, b""
        return data

    def close(self) -> None:
        """Nothing to close."""


class Tcp:
    """``socket://host:port``: the simulated rig's process, or a serial server."""

    def __init__(self, address: str) -> None:
        host, _, port = address.removeprefix("socket://").rpartition(":")
        self.address = address
        try:
            self._socket = socket.create_connection((host, int(port)), timeout=2.0)
        except (OSError, ValueError) as problem:
            raise RigFault(f"{address}: cannot be reached ({problem}); is the rig's process running?") from problem
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.settimeout(PATIENCE)

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

    def __init__(self, port: str, baud: int) -> None:
        self.port = port
        try:
            import serial
        except ImportError as problem:
            raise RigFault("the Uno needs pyserial; install it: pip install 'dampyr[rig]'") from problem
        try:
            self._serial: Any = serial.Serial(port, baud, timeout=PATIENCE, write_timeout=0.5, exclusive=True)
        except (OSError, ValueError) as problem:
            raise RigFault(f"{port}: the serial port cannot be opened ({problem}); is the Uno plugged in?") from problem

    def send(self, data: bytes) -> None:
        """Send all of it."""
        try:
            self._serial.write(data)
        except OSError as problem:
            raise RigFault(f"{self.port}: the connection to the Uno is lost ({problem}); check its cable") from problem

    def receive(self) -> bytes:
        """What comes within `PATIENCE`."""
        try:
            return bytes(self._serial.read(max(1, self._serial.in_waiting)))
        except OSError as problem:
            raise RigFault(f"{self.port}: the connection to the Uno is lost ({problem}); check its cable") from problem

    def close(self) -> None:
        """Close the port."""
        self._serial.close()


def open_wire(address: str, baud: int) -> Wire:
    """The wire at a serial port or at ``socket://host:port``."""
    return Tcp(address) if address.startswith("socket://") else Serial(address, baud)
