"""The frames between host and Uno, version 3 (docs/reference/protocol.md): COBS, CRC-16/CCITT-FALSE, little-endian bodies."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum, IntFlag

VERSION = 3  # of the frames; both ends must speak the same
MAX_BODY = 70  # bytes: the longest body is that of 16 set points (5 + 4 * 16), with one to spare
MAX_POINTS = 16  # in one frame: 0.16 s of motion where they are 10 ms apart
QUEUE = 64  # set points that the Uno holds


class Request(IntEnum):
    """What the host asks for."""

    HELLO = 0x01
    LIMITS = 0x02
    HEARTBEAT = 0x03
    ARM = 0x04
    DISARM = 0x05
    HOME = 0x06
    JOG = 0x07
    SETPOINTS = 0x08
    FOLLOW = 0x09
    REVERSE = 0x0A
    STOP = 0x0B
    ABORT = 0x0C
    CLEAR = 0x0D
    BUILD = 0x0E


class Reply(IntEnum):
    """What the Uno answers."""

    HELLO = 0x81
    ACK = 0x82
    NAK = 0x83
    STATUS = 0x84
    BUILD = 0x85


class State(IntEnum):
    """What the Uno is doing."""

    IDLE = 0
    ARMED = 1
    FOLLOWING = 2
    REVERSING = 3
    JOGGING = 4
    HOMING = 5
    STOPPING = 6
    FAULT = 7


class Fault(IntFlag):
    """Why the Uno stopped by itself."""

    HEARTBEAT = 1
    LOW = 2
    HIGH = 4
    SPEED = 8
    STALL = 16
    FOLLOWING = 32
    UNDERRUN = 64
    ENCODER = 128
    ABORTED = 256
    RESTARTED = 512
    INDEX = 1024
    END = 2048
    EMERGENCY = 4096
    DIRECTION = 8192
    CURRENT = 16384


class Reason(IntEnum):
    """Why a request was refused."""

    STATE = 1
    RANGE = 2
    NOT_HOMED = 3
    NO_LIMITS = 4
    QUEUE_FULL = 5
    GAP = 6
    VERSION = 7
    NO_HEARTBEAT = 8
    NO_HELLO = 9
    OUTSIDE = 10
    END = 11
    EMERGENCY = 12


ENABLED, HOMED, LIMITED, OUTSIDE = 1, 2, 4, 8  # flags of a status
LOW_END, HIGH_END, PRESSED = 1, 2, 4  # inputs that are open; four bits higher in the flags of a status
INPUTS_AT = 4
PROVEN = 128
ENDS_WIRED, EMERGENCY_WIRED = 1, 2  # which inputs LIMITS say are wired

BODIES: dict[Request | Reply, struct.Struct] = {
    Request.HELLO: struct.Struct("<B"),
    Request.LIMITS: struct.Struct("<iiIHBHBBH"),
    Request.HEARTBEAT: struct.Struct("<"),
    Request.ARM: struct.Struct("<"),
    Request.DISARM: struct.Struct("<"),
    Request.HOME: struct.Struct("<Bi"),
    Request.JOG: struct.Struct("<iH"),
    Request.FOLLOW: struct.Struct("<HI"),
    Request.REVERSE: struct.Struct("<BHHH"),
    Request.STOP: struct.Struct("<"),
    Request.ABORT: struct.Struct("<"),
    Request.CLEAR: struct.Struct("<"),
    Request.BUILD: struct.Struct("<"),
    Reply.HELLO: struct.Struct("<BHHB"),
    Reply.ACK: struct.Struct("<BB"),
    Reply.NAK: struct.Struct("<BB"),
    Reply.STATUS: struct.Struct("<IBHiihBBIHhHH"),
    Reply.BUILD: struct.Struct("<BIIB"),
}
"""The body of each type; SETPOINTS has one of its own."""


@dataclass(frozen=True)
class SerialFrame:
    """One request or reply: its type, its number, and the values of its body."""

    kind: Request | Reply
    number: int
    values: tuple[int, ...] = ()


@dataclass(frozen=True)
class Status:
    """What the Uno says of itself: time [ms], state, faults, position [counts], speed [counts/s], duty (-255..255).

    ``outside`` of the limits, where it was armed; ``inputs`` that are open; ``proven``: it has moved as its duty says;
    ``index_shift`` counts by which the index was away from its place at the last of ``index_passes``; ``current`` of the motor
    [steps of the Uno's converter], 0 where LIMITS say that its sense is not wired.
    """

    time: int
    state: State
    faults: Fault
    position: int
    speed: int
    duty: int
    enabled: bool
    homed: bool
    limited: bool
    free: int
    next: int
    bad_frames: int
    index_shift: int = 0
    index_passes: int = 0
    outside: bool = False
    inputs: int = 0
    proven: bool = False
    current: int = 0


def status_of(frame: SerialFrame) -> Status:
    """The status in a STATUS reply."""
    time, state, faults, position, speed, duty, flags, free, nxt, bad, shift, passes, current = frame.values
    enabled, homed, limited = bool(flags & ENABLED), bool(flags & HOMED), bool(flags & LIMITED)
    moving = (time, State(state), Fault(faults), position, speed, duty)
    return Status(
        *moving, enabled, homed, limited, free, nxt, bad,
        index_shift=shift, index_passes=passes, outside=bool(flags & OUTSIDE), inputs=flags >> INPUTS_AT & 7,
        proven=bool(flags & PROVEN), current=current,
    )  # fmt: skip


def encode(frame: SerialFrame) -> bytes:
    """The bytes of a frame with its closing 0."""
    if frame.kind == Request.SETPOINTS:
        first, *points = frame.values
        body = struct.pack(f"<IB{len(points)}i", first, len(points), *points)
    else:
        body = BODIES[frame.kind].pack(*frame.values)
    payload = bytes((frame.kind, frame.number)) + body
    return stuffed(payload + struct.pack("<H", crc(payload))) + b"\0"


def decode(block: bytes) -> SerialFrame | None:
    """The frame in the bytes before a 0; None where they do not make one."""
    raw = unstuffed(block)
    if raw is None or not 4 <= len(raw) <= MAX_BODY + 4 or crc(raw[:-2]) != int.from_bytes(raw[-2:], "little"):
        return None
    return _frame(raw[0], raw[1], raw[2:-2])


def _frame(kind: int, number: int, body: bytes) -> SerialFrame | None:
    if kind == Request.SETPOINTS:
        count = body[4] if len(body) > 4 else 0
        if not 1 <= count <= MAX_POINTS or len(body) != 5 + 4 * count:
            return None
        return SerialFrame(
            Request.SETPOINTS, number, (int.from_bytes(body[:4], "little"), *struct.unpack(f"<{count}i", body[5:]))
        )
    frame_kind = next((request for request in BODIES if request == kind), None)
    if frame_kind is None or len(body) != BODIES[frame_kind].size:
        return None
    return SerialFrame(frame_kind, number, BODIES[frame_kind].unpack(body))


class Reader:
    """Bytes in, frames out; ``bad`` counts what was dropped."""

    def __init__(self) -> None:
        self.bad = 0
        self._waiting = bytearray()

    def feed(self, data: bytes) -> list[SerialFrame]:
        """The frames that are whole with these bytes."""
        *blocks, unfinished = (bytes(self._waiting) + data).split(b"\0")
        self._waiting = bytearray(unfinished[-2 * MAX_BODY :])
        frames = [decode(block) for block in blocks if block]
        self.bad += frames.count(None)
        return [frame for frame in frames if frame is not None]


def crc(data: bytes) -> int:
    """CRC-16/CCITT-FALSE; of b"123456789" it is 0x29B1."""
    value = 0xFFFF
    for byte in data:
        value = (value << 8 & 0xFFFF) ^ _TABLE[value >> 8 ^ byte]
    return value


def _entry(byte: int) -> int:
    value = byte << 8
    for _ in range(8):
        value = (value << 1 ^ 0x1021 if value & 0x8000 else value << 1) & 0xFFFF
    return value


_TABLE = tuple(map(_entry, range(256)))


def stuffed(data: bytes) -> bytes:
    """COBS of at most 254 bytes: no zeros; each run is led by its length plus 1."""
    return b"".join(bytes((len(run) + 1,)) + run for run in data.split(b"\0"))


def unstuffed(data: bytes) -> bytes | None:
    """What was `stuffed`; None where it cannot have been."""
    runs, at = [], 0
    while at < len(data):
        code = data[at]
        if code == 0 or at + code > len(data):
            return None
        runs.append(data[at + 1 : at + code])
        at += code
    return b"\0".join(runs) if runs else None
