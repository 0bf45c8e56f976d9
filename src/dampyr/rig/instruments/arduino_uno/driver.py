"""The Arduino Uno that drives the actuator: the host's end of docs/reference/protocol.md."""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable
from itertools import takewhile

from dampyr.errors import InputError, RigFault
from dampyr.rig.firmware.protocol import (
    EMERGENCY_WIRED,
    ENDS_WIRED,
    MAX_POINTS,
    VERSION,
    Reader,
    Reason,
    Reply,
    Request,
    SerialFrame,
    State,
    Status,
    encode,
    status_of,
)
from dampyr.rig.firmware.twin import FARTHEST, FASTEST, source_digest
from dampyr.rig.instruments.arduino_uno.wire import Wire, open_wire
from dampyr.rig.instruments.contract import Hello, Program
from dampyr.rig.settings import FULL_DUTY, RigSettings

REASONS = {
    Reason.STATE: "it is in another state",
    Reason.RANGE: "a value is out of range",
    Reason.NOT_HOMED: "its encoder is not homed; home the table first",
    Reason.NO_LIMITS: "no limits are set",
    Reason.QUEUE_FULL: "its queue is full",
    Reason.GAP: "set points are missing",
    Reason.VERSION: "its version of the protocol is another one",
    Reason.NO_HEARTBEAT: "it has seen no heartbeat",
    Reason.NO_HELLO: "it has seen no hello",
    Reason.OUTSIDE: "the table stands outside of its limits; move it slowly towards the middle",
    Reason.END: "an end switch is open; is the table at its end, or the switch's wire broken?",
    Reason.EMERGENCY: "the emergency stop is pressed, or its wire is broken; release it",
}
HELLO_INTERVAL = (
    0.25  # s between two requests to an Uno that has not answered yet: few bytes for a boot loader to misread
)
RESTARTED = (
    "the Uno started anew while it was in use (its power, its reset, its watchdog, or another program opened its port); "
    "its encoder is no longer homed: home the table again"
)
HOW = "make firmware; dampyr help firmware"
HEARD, SHOWN = 100, 8  # bytes of what a stranger answered


class Uno:
    """The Uno at the end of a wire; every call waits for its answer, ``wait`` s at a time, or raises :class:`RigFault`.

    Opening a serial port resets an Uno: the first HELLO waits in silence for as long as ``wire.boot`` says, and is repeated
    until ``wire.answer`` s after opening. ``clock`` and ``sleep`` as in `time`.
    """

    def __init__(
        self,
        wire: Wire,
        wait: float = 0.02,
        tries: int = 4,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], object] = time.sleep,
    ) -> None:
        self.wait, self.tries = wait, tries
        self._clock, self._sleep, self._opened = clock, sleep, clock()
        self._answered, self._heard = False, b""
        self._build: tuple[int, ...] | None = None
        self._wire, self._reader = wire, Reader()
        self._lock = threading.Lock()
        self._number = random.randrange(256)  # so that a new host is not taken for the one before it

    @property
    def bad_frames(self) -> int:
        """Frames of the Uno's that arrived broken."""
        return self._reader.bad

    def hello(self) -> Hello:
        """Say hello; :class:`RigFault` where the firmware speaks another version."""
        reply = self._ask(Request.HELLO, VERSION) if self._answered else self._first_hello()
        version, firmware, rate, queue = reply.values
        if version != VERSION:
            raise RigFault(
                f"the Uno's firmware has version {version} of the protocol and this dampyr {VERSION}; flash it with this "
                f"dampyr's program ({HOW})",
                "firmware",
            )
        pin, baud, digest, fuse = self._build = self._ask(Request.BUILD).values
        program = Program(bool(pin), baud, f"{digest:08x}", digest == source_digest(), fuse)
        return Hello(version, f"{firmware >> 8}.{firmware & 255}", rate, queue, program)

    def configure(self, rig: RigSettings) -> None:
        """Give the Uno its limits, those of ``rig``."""
        count, limits = rig.encoder.count, rig.limits
        half = int(rig.travel / count)
        if limits.speed / count > FASTEST or half > FARTHEST:
            raise InputError(
                f"encoder.count = {1e6 * count:g} um is too fine for the Uno's firmware, which counts {FASTEST} a second and "
                f"{FARTHEST} from the middle at most: give limits.speed of at most {1e3 * FASTEST * count:.4g} mm/s "
                f"(now {1e3 * limits.speed:g}) and limits.stroke of at most {2e3 * FARTHEST * count:.4g} mm "
                f"(now {1e3 * limits.stroke:g})"
            )
        if self._build is not None and bool(self._build[0]) is not rig.wires.direction_pin:
            raise RigFault(f"{bridge_in_words(bool(self._build[0]))}; {bridge_repair(rig)}", "firmware")
        actuator, heartbeat = rig.actuator, round(limits.heartbeat * 1000)
        slew = max(1, min(FULL_DUTY, int(actuator.max_slew * FULL_DUTY / 1000 + 1e-9)))  # of 255, in a millisecond
        wired = ENDS_WIRED * rig.wires.end_switches | EMERGENCY_WIRED * rig.wires.emergency_stop
        motor = (actuator.duty_steps, 300, wired, slew, rig.max_current_steps)
        self._ask(Request.LIMITS, -half, half, int(limits.speed / count), heartbeat, *motor)

    def heartbeat(self) -> Status:
        """Send a heartbeat; the Uno's status."""
        return status_of(self._ask(Request.HEARTBEAT))

    def arm(self) -> None:
        """Arm: enable line high."""
        self._ask(Request.ARM)

    def disarm(self) -> None:
        """Enable line low, motor shorted."""
        self._ask(Request.DISARM)

    def home(self, how: int, counts: int) -> None:
        """Take the table to be at ``counts`` (`HERE`), or look for the index, which is there (`INDEX`)."""
        self._ask(Request.HOME, how, counts)

    def jog(self, speed: int, time_ms: int) -> None:
        """Move at ``speed`` counts/s for a while, at most 500 ms."""
        self._ask(Request.JOG, speed, time_ms)

    def points(self, first: int, positions: list[int]) -> int:
        """Send set points [counts], numbered from ``first``; how many places are free then.

        Frames of 16 leave together and are answered together: a line that holds each answer for up to 16 ms holds them once.
        """
        if not positions:
            raise InputError("positions = [] is not allowed; send at least one set point")
        bodies = [(first + k, *positions[k : k + MAX_POINTS]) for k in range(0, len(positions), MAX_POINTS)]
        with self._lock:
            return self._exchange(Request.SETPOINTS, *bodies)[-1].values[1]

    def follow(self, period_ms: int, n: int) -> None:
        """Follow the set points."""
        self._ask(Request.FOLLOW, period_ms, n)

    def reverse(self, duty: int, half_ms: int, pause_ms: int, n: int) -> None:
        """Constant duty whose sign changes every half period."""
        self._ask(Request.REVERSE, duty, half_ms, pause_ms, n)

    def stop(self) -> None:
        """Decelerate to rest."""
        self._ask(Request.STOP)

    def abort(self) -> None:
        """Brake and cut the coil, now."""
        self._ask(Request.ABORT)

    def clear(self) -> None:
        """Leave FAULT."""
        self._ask(Request.CLEAR)

    def close(self) -> None:
        """Close the wire."""
        self._wire.close()

    def _first_hello(self) -> SerialFrame:
        """The reply to the first HELLO after opening, once the boot loader has left."""
        with self._lock:
            quiet = self._opened + self._wire.boot - self._clock()
            if quiet > 0.0:
                self._sleep(quiet)
            self._number = (self._number + 1) % 256
            request = b"\0" + encode(
                SerialFrame(Request.HELLO, self._number, (VERSION,))
            )  # the 0 ends what was sent before
            wait = max(self.wait, HELLO_INTERVAL) if self._wire.answer else self.wait
            tries = 0
            self._heard = b""
            while tries < self.tries or self._clock() < self._opened + self._wire.answer:
                self._wire.discard()  # a boot loader's bytes, or what an earlier host was sent
                self._reader = Reader()
                self._wire.send(request)
                tries += 1
                reply = self._reply(wait)
                if reply is not None:
                    self._answered = True
                    return self._checked(Request.HELLO, reply)
            raise RigFault(self._no_hello(request, f"asked {tries} times in {self._clock() - self._opened:.1f} s"))

    def _no_hello(self, request: bytes, how_often: str) -> str:
        """Who is there instead of an Uno with dampyr's firmware, and the repair."""
        repair = f"name the Uno's port in wires.serial, or flash dampyr's program ({HOW})"
        if not self._heard:
            return (
                f"the Uno does not answer HELLO, {how_often}; check its cable, its power and that wires.serial is its port, or "
                f"flash dampyr's program ({HOW})"
            )
        if self._heard.startswith(request[1:]) or self._heard.startswith(request):
            return f"what is connected only sends back what it is sent, {how_often}; {repair}"
        return (
            f"what is connected is not an Uno with dampyr's program, or its line has another speed than wires.baud: {how_often}"
            f", it sends {self._heard[:SHOWN].hex(' ')}; {repair}"
        )

    def _ask(self, kind: Request, *values: int) -> SerialFrame:
        with self._lock:  # one question at a time: an abort comes from any thread
            return self._exchange(kind, values)[0]

    def _exchange(self, kind: Request, *bodies: tuple[int, ...]) -> list[SerialFrame]:
        """The replies to requests of one kind that are sent together; from the first on that has none they are sent again."""
        frames = [SerialFrame(kind, (self._number + k) % 256, values) for k, values in enumerate(bodies, 1)]
        self._number = frames[-1].number
        replies: list[SerialFrame] = []
        for _ in range(self.tries):
            missing = frames[len(replies) :]
            self._wire.send(b"".join(map(encode, missing)))
            for reply in self._replies([frame.number for frame in missing], self.wait):
                if replies and reply.kind is Reply.NAK and reply.values[1] == Reason.GAP:
                    break  # refused before the frame ahead of it had come
                replies.append(self._checked(kind, reply))
            if len(replies) == len(frames):
                return replies
        raise RigFault(f"the Uno does not answer {kind.name}, asked {self.tries} times; check its cable and its power")

    def _reply(self, wait: float) -> SerialFrame | None:
        return next(iter(self._replies([self._number], wait)), None)

    def _replies(self, numbers: list[int], wait: float) -> list[SerialFrame]:
        """The replies to requests of these numbers in their order, until all have come or ``wait`` s are over; those before the
        first that is missing: one after it may be refused for that alone."""
        until = self._clock() + wait
        received: dict[int, SerialFrame] = {}
        while True:
            data = self._wire.receive()
            self._heard = (self._heard + data)[:HEARD]
            for frame in self._reader.feed(data):
                if frame.number in numbers and isinstance(frame.kind, Reply):
                    received[frame.number] = frame
            if len(received) == len(numbers) or self._clock() >= until:
                return [received[number] for number in takewhile(received.__contains__, numbers)]

    def _checked(self, kind: Request, reply: SerialFrame) -> SerialFrame:
        if reply.kind is not Reply.NAK:
            return reply
        if (
            reply.values[1] in (Reason.VERSION, Reason.NO_HELLO) and kind is not Request.HELLO
        ):  # HELLO was answered: it has forgotten it
            raise RigFault(RESTARTED, "firmware")
        reason = (
            REASONS.get(Reason(reply.values[1])) if reply.values[1] in list(Reason) else f"reason {reply.values[1]}"
        )
        raise RigFault(f"the Uno refused {kind.name}: {reason}", "firmware")


def bridge_in_words(direction_pin: bool) -> str:
    """What the program on the Uno was built for."""
    kind = "one PWM and a direction (DIRECTION_PIN=1)" if direction_pin else "two PWMs (DIRECTION_PIN=0)"
    return f"the Uno's program drives a bridge with {kind}"


def bridge_repair(rig: RigSettings) -> str:
    """What to do where the program and ``rig`` mean different bridges."""
    stated, wanted = str(rig.wires.direction_pin).lower(), int(rig.wires.direction_pin)
    return (
        f"wires.direction_pin = {stated} means another bridge: correct it, or flash what `make firmware DIRECTION_PIN={wanted}`"
        " makes (dampyr help firmware)"
    )


def connect(rig: RigSettings) -> Uno:
    """The Uno at the serial wire of ``rig``."""
    return Uno(open_wire(rig.wires.serial, rig.wires.baud))


def moving(status: Status) -> bool:
    """Whether the table moves or may move at once."""
    return status.state in (State.FOLLOWING, State.REVERSING, State.JOGGING, State.HOMING, State.STOPPING)
