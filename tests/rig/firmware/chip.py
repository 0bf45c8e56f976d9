"""The firmware's binary, in simavr: a test program of its own that runs it a millisecond at a time."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.rig.firmware.native_core import SOURCES

from dampyr.rig.firmware.protocol import Reader, Reply, Request, SerialFrame, Status, encode, status_of
from dampyr.rig.simulation import chip

NEEDED = ("avr-gcc", "avr-objcopy", "make", "gcc")
SIMAVR = Path("/usr/include/simavr/sim_avr.h")
GLITCH, RESET, HANG, SLIP = 1, 2, 4, 8


def build(folder: Path, *options: str, sources: Path = SOURCES) -> tuple[Path, Path]:
    """The binary, made with these options of make, and the program that runs it; a skip that says what is missing."""
    missing = [name for name in NEEDED if shutil.which(name) is None] + ["libsimavr-dev"] * (not SIMAVR.exists())
    if missing:
        pytest.skip(f"missing: {', '.join(missing)}; `make firmware-tools` installs Debian's packages")
    subprocess.run(["make", "-s", "-C", str(sources), f"OUT={folder}", *options], check=True, stdout=subprocess.DEVNULL)
    program = folder / "uno_in_simavr"
    source = Path(__file__).with_name("uno_in_simavr.c")
    subprocess.run(
        ["gcc", "-O2", "-std=gnu99", "-Wall", "-Wextra", "-Werror", str(source), "-o", str(program), "-lsimavr", "-lm"],
        check=True,
    )
    return folder / "dampyr-uno.elf", program


class Chip:
    """The Uno, and a table that moves as its motor is driven."""

    def __init__(self, built: tuple[Path, Path], mark: int = 10**6, baud: int = 250000) -> None:
        elf, program = built
        self.chip = chip.Chip(program, elf, mark, baud)
        self.reader, self.number, self.time, self.inputs = Reader(), 0, 0, 0
        self.place, self.gain, self.motor, self.seen = 0.0, 65.0, 0.0, b""
        self.sense = 0  # 16, 32: the bridge's current output at A0 or A1 has 2.5 V
        self.moving: Callable[[], float] | None = None  # counts/s at which the table is moved, whatever the motor does

    def close(self) -> None:
        """End it."""
        self.chip.close()

    @property
    def pins(self) -> chip.Pins:
        """What it shows."""
        return self.chip.pins

    def ms(self, data: bytes = b"", what: int = 0) -> bytes:
        """A millisecond; the bytes that the chip has sent in it."""
        wanted = self.gain * max(0, abs(self.pins.duty) - 15) * (1 if self.pins.duty > 0 else -1)
        self.motor += (wanted - self.motor) / 24.0
        speed = self.motor if self.moving is None else self.moving()
        old, self.place = self.place, self.place + speed / 1000.0
        move = int(self.place // 1) - int(old // 1)
        sent, self.time = self.chip.step(move, self.inputs, data, what | self.sense), self.time + 1
        self.seen += sent
        return sent

    def run(self, ms: int, beat: bool = True) -> None:
        """So many milliseconds, with heartbeats or without."""
        until = self.time + ms
        while self.time < until:
            if beat and (until - self.time) % 20 == 0:
                self.ask(Request.HEARTBEAT)
            else:
                self.ms()

    def ask(self, kind: Request, *values: int) -> SerialFrame:
        """A request, and its reply within 20 ms."""
        self.number = (self.number + 1) % 256
        return self.reply_to(encode(SerialFrame(kind, self.number, values)))

    def reply_to(self, data: bytes) -> SerialFrame:
        """The reply to what is sent."""
        for k in range(20):
            for frame in self.reader.feed(self.ms(b"" if k else data)):
                return frame
        raise AssertionError(f"the chip does not answer {data!r} within 20 ms: {self.pins}")

    def done(self, kind: Request, *values: int) -> None:
        """A request that is carried out."""
        reply = self.ask(kind, *values)
        assert (reply.kind, reply.values[0]) == (Reply.ACK, kind), reply

    @property
    def status(self) -> Status:
        """What it says of itself."""
        return status_of(self.ask(Request.HEARTBEAT))
