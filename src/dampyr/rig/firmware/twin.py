"""Twin of the firmware: requests in, replies out, and the registers that `dampyr.rig.firmware.control_core` works on."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dampyr.rig.firmware import control_core as c
from dampyr.rig.firmware.protocol import (
    EMERGENCY_WIRED,
    ENABLED,
    ENDS_WIRED,
    HOMED,
    INPUTS_AT,
    LIMITED,
    OUTSIDE,
    PRESSED,
    PROVEN,
    VERSION,
    Fault,
    Reader,
    Reason,
    Reply,
    Request,
    SerialFrame,
    State,
    encode,
)

FIRMWARE = (3, 0)  # major, minor
FARTHEST, FASTEST = 37000, 40000  # counts, counts/s: the firmware's own limits
FULL_SCALE = 1023  # of the Uno's converter
SHIPPED_FUSE = 0xFD  # the extended fuse of an Uno as it is sold: a brown-out below 2.7 V
SOURCES = ("core.c", "core.h", "frames.c", "frames.h", "main.c")
RESTING = tuple(State)
ALLOWED: dict[Request, tuple[State, ...]] = {
    Request.LIMITS: (State.IDLE,),
    Request.ARM: (State.IDLE,),
    Request.JOG: (State.ARMED, State.JOGGING),
    Request.SETPOINTS: (State.ARMED, State.FOLLOWING),
    Request.FOLLOW: (State.ARMED,),
    Request.REVERSE: (State.ARMED,),
    Request.CLEAR: (State.FAULT,),
}
"""The states in which a request is carried out; all where it is not named. HOME depends on its body."""
WITHOUT_HELLO = (Request.HELLO, Request.STOP, Request.ABORT, Request.DISARM)


def source_digest() -> int:
    """The first four bytes of the SHA-256 of the firmware's sources, as its Makefile takes them."""
    folder = Path(__file__).parent / "uno"
    data = b"".join((folder / name).read_bytes() for name in SOURCES)
    return int.from_bytes(hashlib.sha256(data).digest()[:4], "big")


class Twin:
    """The Uno: `receive` takes the host's bytes, `tick` is to be run every millisecond.

    ``on_heartbeat`` is called when a HEARTBEAT has been carried out, before its status is made.
    """

    def __init__(self, on_heartbeat: Callable[[], None] = lambda: None) -> None:
        self.registers: NDArray[np.int64] = np.zeros(c.REGISTERS, dtype=np.int64)
        self.on_heartbeat = on_heartbeat
        self.build = (0, 250000, source_digest(), SHIPPED_FUSE)  # direction pin, baud, digest, extended fuse
        self.restart()

    def restart(self) -> None:
        """As after power-on or the watchdog: FAULT with RESTARTED, all else cleared but the encoder's count."""
        counts = self.registers[c.R_COUNTS]
        self.registers[:] = 0
        self.registers[[c.R_COUNTS, c.R_POSITION]] = counts
        self.registers[c.R_ORIGIN] = counts
        self.registers[c.R_STATE], self.registers[c.R_FAULTS] = State.FAULT, Fault.RESTARTED
        self.registers[c.R_SINCE] = 1000000
        self.other_version = False
        self.reader, self.handshake_done, self.last_request, self.last_reply = Reader(), False, (-1, -1), b""

    @property
    def state(self) -> State:
        """The Uno's state."""
        return State(int(self.registers[c.R_STATE]))

    @property
    def faults(self) -> Fault:
        """Why it stopped by itself."""
        return Fault(int(self.registers[c.R_FAULTS]))

    @property
    def enabled(self) -> bool:
        """The enable line."""
        return State.ARMED <= self.state <= State.STOPPING

    @property
    def free(self) -> int:
        """Free places in the queue."""
        return c.QUEUE - int(self.registers[c.R_NEXT] - self.registers[c.R_HEAD])

    def tick(self, counts: int, latched: bool, index: int, glitch: bool, inputs: int = 0, current: int = 0) -> None:
        """One millisecond; see `dampyr.rig.firmware.control_core.tick`."""
        c.tick(self.registers, counts, latched, index, glitch, inputs, current)

    def receive(self, data: bytes) -> bytes:
        """Bytes from the host -> the replies to what is whole with them."""
        return b"".join(map(self.answer, self.reader.feed(data)))

    def answer(self, frame: SerialFrame) -> bytes:
        """The reply to one request; a repeated request is answered again and not carried out again."""
        if not isinstance(frame.kind, Request):
            self.reader.bad += 1
            return b""
        if (frame.kind, frame.number) != self.last_request:
            self.last_reply = encode(self._reply(frame))
            self.last_request = (frame.kind, frame.number)
        return self.last_reply

    def _reply(self, frame: SerialFrame) -> SerialFrame:
        kind = Request(frame.kind)
        reason = self._refused(kind, frame.values)
        if reason is not None:
            return SerialFrame(Reply.NAK, frame.number, (kind, reason))
        getattr(self, f"_{kind.name.lower()}")(*frame.values)
        if kind == Request.HELLO:
            return SerialFrame(Reply.HELLO, frame.number, (VERSION, FIRMWARE[0] << 8 | FIRMWARE[1], c.RATE, c.QUEUE))
        if kind == Request.HEARTBEAT:
            return SerialFrame(Reply.STATUS, frame.number, self._status())
        if kind == Request.BUILD:
            return SerialFrame(Reply.BUILD, frame.number, self.build)
        return SerialFrame(Reply.ACK, frame.number, (kind, self.free))

    def _refused(self, kind: Request, values: tuple[int, ...]) -> Reason | None:
        """Why a request cannot be carried out; the first reason of the order in the document."""
        if not self.handshake_done and kind not in WITHOUT_HELLO:
            return Reason.VERSION if self.other_version else Reason.NO_HELLO
        allowed = ALLOWED.get(kind, RESTING)
        if kind == Request.HOME:
            allowed = {0: (State.IDLE,), 1: (State.ARMED,)}.get(values[0], RESTING)
        if self.state not in allowed:
            return Reason.STATE
        check: Callable[..., Reason | None] = getattr(self, f"_check_{kind.name.lower()}", lambda *_: None)
        return check(*values)

    def _check_limits(
        self, low: int, high: int, speed: int, beat: int, duty: int, stall: int, wired: int, slew: int, current: int
    ) -> Reason | None:
        fine = wired <= ENDS_WIRED | EMERGENCY_WIRED and -FARTHEST <= low < high <= FARTHEST and 1 <= speed <= FASTEST
        fine = fine and slew >= 1 and current < FULL_SCALE
        return None if fine and 50 <= beat <= 200 and duty >= 1 and 100 <= stall <= 1000 else Reason.RANGE

    def _check_arm(self) -> Reason | None:
        r = self.registers
        if not r[c.R_LIMITED]:
            return Reason.NO_LIMITS
        if r[c.R_WIRED] & EMERGENCY_WIRED and r[c.R_INPUTS] & PRESSED:
            return Reason.EMERGENCY
        if c.both_ends(r):
            return Reason.END
        return Reason.NO_HEARTBEAT if r[c.R_SINCE] > r[c.R_HEARTBEAT] else None

    def _check_home(self, how: int, counts: int) -> Reason | None:
        if how not in (0, 1) or abs(counts) > FARTHEST:
            return Reason.RANGE
        return Reason.OUTSIDE if how == 1 and self.registers[c.R_OUTSIDE] else None

    def _check_jog(self, speed: int, time: int) -> Reason | None:
        if not 1 <= time <= 500 or abs(speed) > self.registers[c.R_MAX_SPEED]:
            return Reason.RANGE
        if abs(speed) > c.SLOW and not self.registers[c.R_HOMED]:
            return Reason.NOT_HOMED
        outside = self.registers[c.R_OUTSIDE]
        if outside and (abs(speed) > c.SLOW or speed * outside > 0):
            return Reason.OUTSIDE
        return Reason.END if c.at_end(self.registers, speed) else None

    def _check_setpoints(self, first: int, *points: int) -> Reason | None:
        r = self.registers
        if not all(r[c.R_LOW] <= p <= r[c.R_HIGH] for p in points):
            return Reason.RANGE
        if not r[c.R_HOMED]:
            return Reason.NOT_HOMED
        at = int(r[c.R_NEXT])
        if first > at or (first + len(points) - 1 > r[c.R_LAST] and self.state == State.FOLLOWING):
            return Reason.GAP if first > at else Reason.RANGE
        return Reason.QUEUE_FULL if first + len(points) - at > self.free else None

    def _check_follow(self, period: int, n: int) -> Reason | None:
        r = self.registers
        if not 1 <= period <= 1000 or n < max(1, r[c.R_NEXT]):
            return Reason.RANGE
        if not r[c.R_HOMED]:
            return Reason.NOT_HOMED
        if r[c.R_OUTSIDE]:
            return Reason.OUTSIDE
        if r[c.R_NEXT] == 0:
            return Reason.GAP
        return Reason.RANGE if abs(r[c.R_QUEUE] - r[c.R_POSITION]) > 100 else None

    def _check_reverse(self, duty: int, half: int, pause: int, n: int) -> Reason | None:
        if not (1 <= duty <= self.registers[c.R_MAX_DUTY] and 20 <= half <= 60000 and pause <= 5000 and n >= 1):
            return Reason.RANGE
        if not self.registers[c.R_HOMED]:
            return Reason.NOT_HOMED
        return Reason.OUTSIDE if self.registers[c.R_OUTSIDE] else None

    def _hello(self, version: int) -> None:
        self.handshake_done, self.other_version = version == VERSION, version != VERSION
        if self.other_version and self.enabled:
            self._abort()

    def _limits(self, *values: int) -> None:
        self.registers[c.R_LOW : c.R_MAX_CURRENT + 1] = values
        self.registers[c.R_LIMITED] = 1

    def _heartbeat(self) -> None:
        self.registers[c.R_SINCE] = 0
        self.on_heartbeat()

    def _arm(self) -> None:
        r = self.registers
        c.empty(r)
        r[[c.R_STALLED, c.R_FREE, c.R_OVER, c.R_DUTY, c.R_WAY, c.R_OUTSIDE]] = 0
        r[c.R_STATE] = State.ARMED
        if r[c.R_HOMED] and not r[c.R_LOW] <= r[c.R_POSITION] <= r[c.R_HIGH]:
            r[c.R_OUTSIDE] = -1 if r[c.R_POSITION] < r[c.R_LOW] else 1
            r[c.R_EDGE] = r[c.R_POSITION] + r[c.R_OUTSIDE] * c.EDGE

    def _disarm(self) -> None:
        if self.state != State.FAULT:
            c.empty(self.registers)
            self.registers[[c.R_STATE, c.R_DUTY]] = State.IDLE, 0

    def _home(self, how: int, counts: int) -> None:
        r = self.registers
        if how == 0:
            r[c.R_OFFSET] = counts - r[c.R_COUNTS]
            r[c.R_POSITION], r[c.R_HOMED] = counts, 1
            r[[c.R_INDEX_SET, c.R_SHIFT, c.R_PASSES]] = 0
            return
        if r[c.R_HOMED]:
            c.lose_place(r)
        start = r[c.R_POSITION]
        r[[c.R_INDEX, c.R_START, c.R_TARGET, c.R_TURN]] = counts, start, start * c.RATE, c.FIRST_SWEEP
        r[[c.R_STATE, c.R_SIGN, c.R_RATE]] = State.HOMING, 1, c.SLOW
        r[[c.R_ENDS, c.R_INDEX_SET, c.R_SHIFT, c.R_PASSES]] = 0
        c.empty(r)

    def _jog(self, speed: int, time: int) -> None:
        r = self.registers
        if self.state != State.JOGGING:
            r[c.R_TARGET] = r[c.R_POSITION] * c.RATE
            c.empty(r)
        r[[c.R_STATE, c.R_RATE, c.R_LEFT]] = State.JOGGING, speed, time

    def _setpoints(self, first: int, *points: int) -> None:
        r = self.registers
        if first == 0 and self.state == State.ARMED:
            c.empty(r)
        for number, value in enumerate(points, first):
            if number >= r[c.R_NEXT]:
                r[c.R_QUEUE + number % c.QUEUE] = value
                r[c.R_NEXT] = number + 1

    def _follow(self, period: int, n: int) -> None:
        r = self.registers
        r[[c.R_STATE, c.R_PERIOD, c.R_LAST, c.R_PHASE]] = State.FOLLOWING, period, n - 1, 0
        r[c.R_TARGET] = r[c.R_QUEUE]

    def _reverse(self, duty: int, half: int, pause: int, n: int) -> None:
        r = self.registers
        r[[c.R_STATE, c.R_RATE, c.R_HALF, c.R_PAUSE]] = State.REVERSING, duty, half, pause
        r[[c.R_STROKES, c.R_PHASE, c.R_SIGN]] = n, 0, 1
        c.empty(r)

    def _stop(self) -> None:
        if State.FOLLOWING <= self.state <= State.HOMING:
            c.rest(self.registers)

    def _abort(self) -> None:
        c.fail(self.registers, int(Fault.ABORTED))

    def _build(self) -> None:
        """Nothing: its reply says what the program was built with."""

    def _clear(self) -> None:
        self.registers[[c.R_STATE, c.R_FAULTS]] = State.IDLE, 0

    def _status(self) -> tuple[int, ...]:
        r = self.registers
        flags = ENABLED * self.enabled | HOMED * bool(r[c.R_HOMED]) | LIMITED * bool(r[c.R_LIMITED])
        flags |= OUTSIDE * bool(r[c.R_OUTSIDE]) | int(r[c.R_INPUTS]) << INPUTS_AT | PROVEN * bool(r[c.R_PROVEN])
        shown = (r[c.R_TIME] & 0xFFFFFFFF, r[c.R_STATE], r[c.R_FAULTS], r[c.R_POSITION], r[c.R_SPEED], r[c.R_DUTY])
        shift = max(-32768, min(int(r[c.R_SHIFT]), 32767))
        rest = (flags, self.free, r[c.R_NEXT], self.reader.bad & 0xFFFF, shift, r[c.R_PASSES] & 0xFFFF, r[c.R_CURRENT])
        return tuple(int(value) for value in (*shown, *rest))
