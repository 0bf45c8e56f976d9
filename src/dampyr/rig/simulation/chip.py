"""The Uno's firmware as a binary in the simulated rig, in place of its model.

A program runs it in a simulator of the chip, a millisecond at a time (``tests/rig/firmware/uno_in_simavr.c``; it is linked with
simavr, which is under GPL-3, and so it is a test program of its own and no part of dampyr). Here are the pipes to that
program, and what the simulated rig asks of a firmware.
"""

from __future__ import annotations

import struct
import subprocess
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dampyr.errors import RigFault
from dampyr.rig.firmware import control_core as c
from dampyr.rig.firmware.protocol import Fault, Reply, Request, State, decode, status_of

QUESTION, ANSWER = struct.Struct("<hBBH"), struct.Struct("<5BHHIH")
LATE = 20  # ms within which the firmware answers


@dataclass
class Pins:
    """What the chip shows after a millisecond: both PWM, its ports, and what the program counted."""

    extend: int = 0
    retract: int = 0
    port_b: int = 0
    port_d: int = 0
    running: int = 1
    work: int = 0
    """Cycles, of the work of a millisecond that took the most so far."""
    stack: int = 0
    """The least stack pointer so far."""
    resets: int = 0

    @property
    def duty(self) -> int:
        """The duty, -255 to 255; where D10 has no PWM it is the direction (built with DIRECTION_PIN=1)."""
        return -self.extend if self.port_b & 4 else self.extend - self.retract

    @property
    def enabled(self) -> bool:
        """The enable line of the coil's supply."""
        return bool(self.port_b & 1)


class Chip:
    """The binary ``elf`` in ``program``; ``mark``: the count, from where the table stands, at which the encoder's index is;
    ``baud``: of the host's end of the line.

    Raises :class:`~dampyr.errors.RigFault` where the program cannot be started.
    """

    def __init__(self, program: str | Path, elf: str | Path, mark: int, baud: int = 250000) -> None:
        pipe = subprocess.PIPE
        try:
            self._process = subprocess.Popen(
                [str(program), str(elf), str(mark), str(baud)], stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL
            )
        except OSError as problem:
            raise RigFault(f"{program}: the program that runs the firmware cannot be started: {problem}") from None
        self.pins = Pins()

    def step(self, move: int = 0, inputs: int = 0, data: bytes = b"", what: int = 0) -> bytes:
        """A millisecond in which the encoder moves by ``move`` counts and the line brings ``data``; what comes back."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            self._process.stdin.write(QUESTION.pack(move, inputs, what, len(data)) + data)
            self._process.stdin.flush()
            head = self._process.stdout.read(ANSWER.size)
        except OSError:
            head = b""
        if len(head) < ANSWER.size:
            raise RigFault("the program that runs the firmware has ended; is the binary one for the ATmega328P?")
        *shown, n = ANSWER.unpack(head)
        self.pins = Pins(*shown)
        return self._process.stdout.read(n)

    def close(self) -> None:
        """End it."""
        self._process.kill()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with suppress(BrokenPipeError):  # a program that has ended takes no more of what was written
                    stream.close()


class ChipFirmware:
    """What `dampyr.rig.firmware.twin.Twin` is to a simulated rig, of a `Chip`.

    ``registers`` hold what the plant needs, the duty and whether the enable line is high. State and faults are those of the
    last STATUS; before one, as the enable line says.
    """

    def __init__(self, chip: Chip) -> None:
        self.chip, self.registers = chip, np.zeros(c.REGISTERS, np.int64)
        self._place, self._sent, self._received = 0, b"", b""
        self._state, self.faults = State.FAULT, Fault(0)
        self.show()

    def show(self) -> None:
        """Put what the pins show into the registers."""
        r = self.registers
        r[:] = 0
        r[[c.R_DUTY, c.R_FAULTS]] = self.chip.pins.duty, self.faults
        r[c.R_STATE] = State.ARMED if self.enabled else State.IDLE if self.state == State.IDLE else State.FAULT
        # the model's tick, compiled with the plant, is to do nothing by itself
        r[[c.R_HOMED, c.R_PROVEN]] = 1
        r[[c.R_HEARTBEAT, c.R_MAX_SPEED, c.R_STALL, c.R_HIGH]] = 2**30
        r[c.R_LOW] = -(2**30)

    @property
    def enabled(self) -> bool:
        """The enable line."""
        return self.chip.pins.enabled

    @property
    def state(self) -> State:
        """The Uno's state."""
        if self.enabled is (State.ARMED <= self._state <= State.STOPPING):
            return self._state
        return State.ARMED if self.enabled else State.FAULT

    def tick(self, counts: int, inputs: int) -> None:
        """A millisecond at the end of which the encoder has these counts."""
        self._received += self.chip.step(counts - self._place, inputs, self._sent)
        self._place, self._sent = counts, b""
        self.show()

    def exchange(self, data: bytes, wait: Callable[[], object]) -> bytes:
        """Bytes from the host -> the reply; ``wait`` lets a millisecond pass, at most `LATE` times."""
        self._sent, self._received = data, b""
        for _ in range(LATE):
            wait()
            if self._received.endswith(b"\0"):
                break
        for block in self._received.split(b"\0"):
            frame = decode(block) if block else None
            if frame is not None and frame.kind is Reply.STATUS:
                status = status_of(frame)
                self._state, self.faults = status.state, status.faults
            elif frame is not None and frame.kind is Reply.ACK and frame.values[0] == Request.CLEAR:
                self._state, self.faults = State.IDLE, Fault(0)
        self.show()
        return self._received
