"""A damper that OpenSees talks to: the other end of its element ``genericClient``.

The element connects by TCP and sends 11 integers of 32 bits: the first is the number of its degrees of freedom, the last the
size of the messages. Then every message is that many numbers of 64 bits, of which the first says what it is: 3 a trial
(displacement, velocity, acceleration of each degree of freedom, then the time), 5 the trial is committed, 10 to 15 ask for a
matrix or a vector (`Message`), 99 the end. Trials and commitments have no answer.

With one degree of freedom the damper stands on the ground, with two between them; with a structure, the degrees of freedom are
its floors' displacements relative to the ground, and the damper stands in it where ``place`` says.
"""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.export import trial_step
from dampyr.ground_motions import GroundMotion
from dampyr.input_kinds import input_arguments
from dampyr.models import Damper
from dampyr.models.codegen.kernels import bind
from dampyr.structures import Building
from dampyr.structures.law_input import LawInput
from dampyr.structures.sites import connections, make_sites

Array = NDArray[np.float64]
HEADER = 11
# OpenSees sends a trial and then asks, and its socket holds the question back until the trial is acknowledged, which Linux
# otherwise does after 40 ms. The option lasts for one packet.
QUICK_ACK: int | None = getattr(socket, "TCP_QUICKACK", None)
SPIN = 0.002  # s that the next message is looked for without sleeping: waking up takes longer than OpenSees does
NOT_WAITING = getattr(socket, "MSG_DONTWAIT", 0)
LARGEST_MESSAGE = 1_000_000  # numbers; OpenSees' own size is 256


class Message(IntEnum):
    """What a message says, its first number."""

    TRIAL = 3
    COMMIT = 5
    FORCE = 10
    INITIAL_STIFFNESS = 12
    TANGENT = 13
    DAMPING = 14
    MASS = 15
    END = 99


@dataclass
class LiveSummary:
    """What a connection did: ``steps`` were committed after ``trials``; the largest ``force`` [N] and ``stroke`` [m], the
    last ``time`` [s] of OpenSees, the ``seconds`` that it took, and those of them in which the damper was computed; ``outside``
    names what went beyond the calibration."""

    degrees_of_freedom: int = 0
    steps: int = 0
    trials: int = 0
    force: float = 0.0
    stroke: float = 0.0
    speed: float = 0.0
    time: float = 0.0
    seconds: float = 0.0
    computing: float = 0.0
    ended: str = "the client ended it"
    outside: list[str] = field(default_factory=list)


class LiveDamper:
    """The damper at its committed state, and the trial from it.

    ``row`` (n,) gives the stroke of the degrees of freedom. The input is constant, or decided by a law of
    `dampyr.structures.control` at its period, from the committed states.
    """

    def __init__(self, damper: Damper, row: Array, u: Any, law: LawInput | None, allow_extrapolation: bool) -> None:
        self.damper, self.row, self.law = damper, row, law
        self.allow = allow_extrapolation
        self.u = float(u)
        self.values = damper.values(self.u, static=False, allow_extrapolation=allow_extrapolation)
        composition = damper.composition
        self.step: Callable[..., None] = bind(trial_step.try_step, (composition,))
        self.s = np.zeros(max(composition.n_states, 1))
        self.s[: len(composition.path0)] = composition.path0
        self.work, self.out = self.s.copy(), np.zeros(3)
        self.at = np.zeros(3)  # committed: time, stroke, rate
        self.now = np.zeros(3)
        self.begun = False

    def try_state(self, x: Array, v: Array, a: Array, t: float) -> None:
        """A trial at the time ``t`` from the committed state."""
        stroke, rate, acceleration = float(self.row @ x), float(self.row @ v), float(self.row @ a)
        if not self.begun:
            self.at[:] = t, stroke, rate
            self.begun = True
        self.now[:] = t, stroke, rate
        if self.law is not None and (u := self.law.input_at(t)) != self.u:
            self.u = u
            self.values = self.damper.values(u, static=False, allow_extrapolation=self.allow)
        self.step(
            self.s, self.work, self.at[1], self.at[2], stroke, rate, acceleration, t - self.at[0], self.values, self.out
        )
        self.x, self.v = x, v

    def commit(self) -> None:
        """The trial becomes the state; a law decides where its period has passed."""
        self.s[:] = self.work
        self.at[:] = self.now
        if self.law is not None:
            self.law.decide_at(self.now[0], self.x, self.v, float(self.out[0]))


def live_damper(
    degrees: int,
    damper: Damper,
    u: Any,
    law: Any = None,
    building: Building | None = None,
    place: Any = 1,
    motion: GroundMotion | None = None,
    allow_extrapolation: bool = False,
) -> LiveDamper:
    """The damper for an element with so many degrees of freedom; :class:`InputError` where these do not fit."""
    if building is None:
        if degrees not in (1, 2):
            raise InputError(
                f"the element has {degrees} degrees of freedom; give it one (the damper stands on the ground) or two, or "
                "the structure whose floors they are: --structure FILE"
            )
        row = np.array([1.0]) if degrees == 1 else np.array([-1.0, 1.0])
        return LiveDamper(damper, row, u, None, allow_extrapolation)
    if degrees != building.n:
        raise InputError(
            f"the element has {degrees} degrees of freedom and {building.name} has {building.n} floors; give it the "
            "horizontal displacement of each floor, from the ground up"
        )
    inputs = input_arguments(damper.input, u)
    sites = make_sites(building, {place: damper}, inputs.get("voltage"), inputs.get("current"), allow_extrapolation)
    row = connections(building, sites)[0]
    decided = None if law is None else LawInput(law, damper, building, row, motion)
    return LiveDamper(damper, row, u if law is None else law.low, decided, allow_extrapolation)


def check_live(damper: Damper) -> None:
    """Raise :class:`InputError` for a damper that no step from a committed state can give."""
    if damper.composition.delay is not None:
        raise InputError(
            "the part delay is of the rig, and a step of OpenSees cannot look back; leave it out, --without delay"
        )


def listen(host: str, port: int) -> socket.socket:
    """A listening socket; :class:`InputError` where the port cannot be had."""
    if not 0 <= port <= 65535:
        raise InputError(f"port = {port} is not allowed; choose 1024 to 65535, or 0 for any that is free")
    server = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        server.bind((host, port))
    except OSError as problem:
        server.close()
        raise InputError(
            f"port {port} of {host} cannot be had ({problem.strerror or problem}); choose another one, or 0 for a free one"
        ) from problem
    server.listen(1)
    return server


def answer(connection: socket.socket, make: Callable[[int], LiveDamper]) -> LiveSummary:
    """Answer one client until it ends or leaves; ``make`` gives the damper for its number of degrees of freedom."""
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    summary, start = LiveSummary(), time.perf_counter()
    head = _receive(connection, 4 * HEADER)
    if head is None:
        summary.ended = "the client left before it said anything"
        return summary
    header = np.frombuffer(head, dtype="<i4")
    n, size = int(header[0]), int(header[-1])
    if not (n >= 1 and max(1 + 3 * n + 1, n * n) <= size <= LARGEST_MESSAGE):
        raise InputError(
            f"what connected is not a genericClient of OpenSees: its header is {header.tolist()}, where the first number "
            "counts degrees of freedom and the last is the size of messages"
        )
    live = make(n)
    summary.degrees_of_freedom = n
    try:
        _converse(connection, live, summary, n, size)
    except ConnectionError:
        summary.ended = "the connection broke"
    summary.seconds = time.perf_counter() - start
    summary.time = float(live.at[0])
    for what, unit, reached in (("displacement", "m", summary.stroke), ("velocity", "m/s", summary.speed)):
        limit = live.damper.ranges.get(what)
        if limit is not None and reached > 1.0001 * limit[1]:
            summary.outside.append(
                f"{what} reaches {reached:.4g} {unit}; the damper was calibrated up to {limit[1]:.4g} {unit}"
            )
    return summary


def _converse(connection: socket.socket, live: LiveDamper, summary: LiveSummary, n: int, size: int) -> None:
    message, clock = 8 * size, time.perf_counter
    reply = np.zeros(size)
    outer = np.outer(live.row, live.row)
    rest = np.zeros(n)
    live.try_state(rest, rest, rest, 0.0)
    live.try_state(1e-9 * live.row / (live.row @ live.row), rest, rest, 1e-6)  # a first, tiny way from rest
    initial, live.begun = float(live.out[1]), False
    while True:
        data = _receive(connection, message)
        if data is None:
            summary.ended = "the client left without a word"
            return
        numbers = np.frombuffer(data, dtype="<f8")
        kind = int(numbers[0])
        if kind == Message.TRIAL:
            begun = clock()
            live.try_state(
                numbers[1 : 1 + n].copy(), numbers[1 + n : 1 + 2 * n].copy(), numbers[1 + 2 * n : 1 + 3 * n],
                float(numbers[1 + 3 * n]),
            )  # fmt: skip
            summary.computing += clock() - begun
            summary.trials += 1
        elif kind == Message.COMMIT:
            live.commit()
            summary.steps += 1
            summary.force = max(summary.force, abs(float(live.out[0])))
            summary.stroke = max(summary.stroke, abs(float(live.at[1])))
            summary.speed = max(summary.speed, abs(float(live.at[2])))
        elif kind == Message.END:
            return
        else:
            reply[: max(n * n, n)] = 0.0
            if kind == Message.FORCE:
                # OpenSees adds the damping matrix times the velocities to this, so that the sum is the force.
                reply[:n] = live.row * (live.out[0] - live.out[2] * live.now[2])
            elif kind == Message.TANGENT:
                reply[: n * n] = (live.out[1] * outer).ravel()
            elif kind == Message.INITIAL_STIFFNESS:
                reply[: n * n] = (initial * outer).ravel()
            elif kind == Message.DAMPING:
                reply[: n * n] = (live.out[2] * outer).ravel()
            elif kind != Message.MASS:
                raise InputError(f"the client sent {numbers[0]:g}, which no genericClient of OpenSees sends")
            connection.sendall(reply.tobytes())


def _receive(connection: socket.socket, size: int) -> bytes | None:
    """So many bytes, or None where the client has left."""
    parts, left = [], size
    until = time.perf_counter() + SPIN
    while left:
        try:
            part = connection.recv(left, NOT_WAITING if time.perf_counter() < until else 0)
        except BlockingIOError:
            continue
        if QUICK_ACK is not None:
            connection.setsockopt(socket.IPPROTO_TCP, QUICK_ACK, 1)
        if not part:
            return None
        if len(part) == size:
            return part
        parts.append(part)
        left -= len(part)
    return b"".join(parts)
