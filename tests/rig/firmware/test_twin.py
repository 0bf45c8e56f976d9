"""The firmware's core in C, and its model, against docs/reference/protocol.md: states, refusals, faults, and what no bytes can
do to them.
"""

import shutil
from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.rig.firmware.native_core import Native, compiled

from dampyr.rig.firmware import control_core as c
from dampyr.rig.firmware.protocol import (
    BODIES,
    Fault,
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
from dampyr.rig.firmware.twin import Twin

LIMITS = (-7000, 7000, 24000, 100, 255, 500, 0, 255, 0)
RAMP = [20 * k for k in range(30)]


def firmware() -> Twin:
    """What is tested; the fixture `which` puts the core in C in its place."""
    return Twin()


@pytest.fixture(params=["model", "C"], scope="module", autouse=True)
def which(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Every test runs with the model and with the C."""
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "C":
            if shutil.which("gcc") is None:
                pytest.skip("no gcc was found; `make compiler` installs Debian's")
            library = compiled(tmp_path_factory.mktemp("core"))
            patch.setitem(globals(), "firmware", lambda: Native(library))
        yield


class Bench:
    """A twin with a motor that moves as it is driven: ``gain`` counts/s for each duty beyond the dead one, between ``ends``."""

    def __init__(self) -> None:
        self.twin, self.reader, self.number = firmware(), Reader(), 0
        self.counts, self.place, self.gain, self.latched, self.glitch = 0, 0.0, 65.0, False, False
        self.index, self.inputs, self.ends = 10**9, 0, (-(10**9), 10**9)
        self.dead = self.swapped = False  # the encoder
        self.current = 0  # of the motor, steps of the converter

    def ask(self, kind: Request, *values: int) -> SerialFrame:
        self.number = (self.number + 1) % 256
        (reply,) = self.reader.feed(self.twin.receive(encode(SerialFrame(kind, self.number, values))))
        assert reply.number == self.number
        return reply

    def done(self, kind: Request, *values: int) -> int:
        reply = self.ask(kind, *values)
        assert (reply.kind, reply.values[0]) == (Reply.ACK, kind), reply
        return reply.values[1]

    def refused(self, kind: Request, *values: int) -> Reason:
        before = self.twin.registers.copy()
        reply = self.ask(kind, *values)
        assert (reply.kind, reply.values[0]) == (Reply.NAK, kind), reply
        assert (self.twin.registers == before).all()
        return Reason(reply.values[1])

    @property
    def status(self) -> Status:
        return status_of(self.ask(Request.HEARTBEAT))

    def run(self, ms: int, beat: bool = True) -> None:
        """So many milliseconds, with heartbeats or without."""
        for k in range(ms):
            if beat and k % 20 == 0:
                self.ask(Request.HEARTBEAT)
            duty = int(self.twin.registers[c.R_DUTY])
            speed = self.gain * max(0, abs(duty) - c.DEAD_DUTY) * (1 if duty > 0 else -1)
            old, low, high = self.place, *self.ends
            self.place = max(min(low, old), min(old + speed / 1000, max(high, old)))
            latched = min(old, self.place) < self.index <= max(old, self.place)
            if not self.dead:
                self.counts += (int(self.place // 1) - int(old // 1)) * (-1 if self.swapped else 1)
            index = self.index - int(self.place // 1) + self.counts
            self.twin.tick(self.counts, latched, index, self.glitch, self.inputs, self.current)

    def at(self, place: float) -> None:
        """Put the table somewhere, where it stays."""
        self.counts += int(place // 1) - int(self.place // 1)
        self.place, self.gain = place, 0.0


@pytest.fixture
def idle() -> Bench:
    bench = Bench()
    bench.ask(Request.HELLO, 3)
    bench.done(Request.CLEAR)
    return bench


@pytest.fixture
def armed(idle: Bench) -> Bench:
    idle.done(Request.LIMITS, *LIMITS)
    idle.done(Request.HOME, 0, 0)
    idle.ask(Request.HEARTBEAT)
    idle.done(Request.ARM)
    return idle


def feed(bench: Bench, points: list[int], first: int = 0) -> None:
    for k in range(0, len(points), 16):
        bench.done(Request.SETPOINTS, first + k, *points[k : k + 16])


MOVING: dict[State, Callable[[Bench], object]] = {
    State.ARMED: lambda b: None,
    State.FOLLOWING: lambda b: (feed(b, RAMP), b.done(Request.FOLLOW, 100, 30)),
    State.REVERSING: lambda b: b.done(Request.REVERSE, 100, 200, 50, 5),
    State.JOGGING: lambda b: b.done(Request.JOG, 300, 500),
    State.HOMING: lambda b: b.done(Request.HOME, 1, 400),
    State.STOPPING: lambda b: (b.done(Request.JOG, 300, 500), b.run(100), b.done(Request.STOP)),
}


def into(bench: Bench, state: State) -> Bench:
    MOVING[state](bench)
    assert bench.twin.state == state
    return bench


def test_it_starts_in_fault_and_says_so() -> None:
    bench = Bench()
    assert bench.ask(Request.HELLO, 3).values == (3, 0x0300, 1000, 64)
    status = bench.status
    assert (status.state, status.faults) == (State.FAULT, Fault.RESTARTED)
    assert (status.enabled, status.homed, status.limited) == (False, False, False)


@pytest.mark.parametrize("version", [0, 1, 255])
def test_another_version_may_only_stop(version: int) -> None:
    bench = Bench()
    assert bench.refused(Request.HEARTBEAT) == Reason.NO_HELLO
    assert bench.ask(Request.HELLO, version).kind == Reply.HELLO
    for kind, body in BODIES.items():
        if isinstance(kind, Request) and kind not in (Request.HELLO, Request.STOP, Request.ABORT, Request.DISARM):
            assert bench.refused(kind, *[1] * len(body.unpack(bytes(body.size)))) == Reason.VERSION
    bench.done(Request.STOP)
    bench.done(Request.ABORT)
    bench.done(Request.DISARM)


def test_a_repeated_request_is_answered_but_not_carried_out_again(armed: Bench) -> None:
    frame = encode(SerialFrame(Request.SETPOINTS, 77, (0, 1, 2)))
    first = armed.twin.receive(frame)
    assert armed.twin.receive(frame) == first != b""
    jog = encode(SerialFrame(Request.JOG, 77, (300, 20)))  # the same number, another type
    assert armed.reader.feed(armed.twin.receive(jog))[0].kind == Reply.ACK
    assert armed.twin.state == State.JOGGING
    armed.run(40, beat=False)
    assert armed.reader.feed(armed.twin.receive(jog))[0].kind == Reply.ACK
    assert armed.twin.state != State.JOGGING


def test_noise_is_counted_and_dropped(idle: Bench) -> None:
    good = encode(SerialFrame(Request.STOP, 9, ()))
    assert (
        idle.twin.receive(b"\x07rubbish\0" + good[:-2] + b"\x55\0" + encode(SerialFrame(Reply.ACK, 1, (1, 1)))) == b""
    )
    assert idle.status.bad_frames == 3
    assert idle.twin.receive(b"\x05half" + b"\0" + good) != b""


@pytest.mark.parametrize(
    "limits",
    [
        (-37001, 7000, 24000, 100, 255, 500, 0, 255, 0), (-7000, 37001, 24000, 100, 255, 500, 0, 255, 0),
        (10, 10, 24000, 100, 255, 500, 0, 255, 0),
        (-7000, 7000, 24000, 100, 255, 500, 0, 0, 0), (-7000, 7000, 24000, 100, 255, 500, 0, 255, 1023),
        (-7000, 7000, 40001, 100, 255, 500, 0, 255, 0), (-7000, 7000, 0, 100, 255, 500, 0, 255, 0),
        (-7000, 7000, 24000, 49, 255, 500, 0, 255, 0),
        (-7000, 7000, 24000, 201, 255, 500, 0, 255, 0), (-7000, 7000, 24000, 100, 0, 500, 0, 255, 0),
        (-7000, 7000, 24000, 100, 255, 99, 0, 255, 0),
        (-7000, 7000, 24000, 100, 255, 1001, 0, 255, 0),
    ],
)  # fmt: skip
def test_limits_beyond_its_own_are_refused(idle: Bench, limits: tuple[int, ...]) -> None:
    assert idle.refused(Request.LIMITS, *limits) == Reason.RANGE


def test_arming_needs_limits_a_heartbeat_and_a_place_within_them(idle: Bench) -> None:
    idle.ask(Request.HEARTBEAT)
    assert idle.refused(Request.ARM) == Reason.NO_LIMITS
    idle.done(Request.LIMITS, *LIMITS)
    idle.run(101, beat=False)
    assert idle.refused(Request.ARM) == Reason.NO_HEARTBEAT
    idle.ask(Request.HEARTBEAT)
    idle.done(Request.HOME, 0, 7000)
    idle.done(Request.ARM)
    assert idle.status.enabled
    assert idle.refused(Request.LIMITS, *LIMITS) == Reason.STATE
    assert idle.refused(Request.HOME, 0, 0) == Reason.STATE
    assert idle.refused(Request.HOME, 2, 0) == Reason.RANGE
    idle.done(Request.DISARM)
    assert not idle.status.enabled


ALLOWED = {
    Request.LIMITS: {State.IDLE}, Request.ARM: {State.IDLE}, Request.JOG: {State.ARMED, State.JOGGING},
    Request.SETPOINTS: {State.ARMED, State.FOLLOWING}, Request.FOLLOW: {State.ARMED}, Request.REVERSE: {State.ARMED},
    Request.CLEAR: {State.FAULT},
}  # fmt: skip
BODY = {Request.LIMITS: LIMITS, Request.JOG: (100, 50), Request.SETPOINTS: (0, 0), Request.FOLLOW: (10, 5),
        Request.REVERSE: (50, 100, 0, 2)}  # fmt: skip


@pytest.mark.parametrize("kind", ALLOWED)
@pytest.mark.parametrize("state", list(State))
def test_each_request_is_refused_outside_its_states(armed: Bench, kind: Request, state: State) -> None:
    if state == State.IDLE:
        armed.done(Request.DISARM)
    elif state == State.FAULT:
        armed.done(Request.ABORT)
    else:
        into(armed, state)
    reply = armed.ask(kind, *BODY.get(kind, ()))
    refused = reply.kind == Reply.NAK and reply.values[1] == Reason.STATE
    assert refused == (state not in ALLOWED[kind])


@pytest.mark.parametrize("state", list(MOVING))
def test_from_every_armed_state_abort_and_disarm_cut_the_coil(armed: Bench, state: State) -> None:
    into(armed, state).done(Request.ABORT)
    status = armed.status
    assert (status.state, status.faults, status.duty, status.enabled) == (State.FAULT, Fault.ABORTED, 0, False)
    armed.done(Request.DISARM)
    armed.done(Request.STOP)
    assert armed.twin.state == State.FAULT
    armed.done(Request.CLEAR)
    assert armed.status.homed == (state != State.HOMING)
    again = into_again(armed, state)
    again.done(Request.DISARM)
    assert (again.twin.state, again.status.duty, again.status.enabled) == (State.IDLE, 0, False)


def into_again(bench: Bench, state: State) -> Bench:
    bench.done(Request.HOME, 0, 0)
    bench.place = 0.0
    bench.run(30)
    bench.done(Request.HOME, 0, 0)
    bench.done(Request.ARM)
    return into(bench, state)


@pytest.mark.parametrize("state", list(MOVING))
def test_without_heartbeats_it_stops_by_itself(armed: Bench, state: State) -> None:
    into(armed, state)
    if state == State.STOPPING:
        armed.twin.registers[c.R_LEFT] = 1000
        armed.gain = 60.0
    armed.ask(Request.HEARTBEAT)
    armed.run(100, beat=False)
    assert armed.twin.enabled
    armed.run(1, beat=False)
    assert (armed.twin.state, armed.twin.faults) == (State.FAULT, Fault.HEARTBEAT)
    assert armed.status.duty == 0


def test_limits_of_place_and_speed(armed: Bench) -> None:
    for place, fault in ((-7001, Fault.LOW), (7001, Fault.HIGH)):
        armed.twin.registers[c.R_PAST : c.R_PAST + c.WINDOW] = armed.twin.registers[c.R_COUNTS] = place
        armed.at(place)
        armed.run(1)
        assert armed.twin.faults == fault
        armed.done(Request.CLEAR)
        armed.done(Request.HOME, 0, 0)
        armed.done(Request.ARM)
    armed.run(12)
    for far in (60, 60, 60, 60, 1):  # 24100 counts/s over 10 ms
        assert armed.twin.faults == Fault(0)
        armed.at(armed.place + far)
        armed.run(1)
    assert armed.twin.faults == Fault.SPEED


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_count_that_leaps_farther_than_a_motor_moves_is_the_encoder_and_no_speed(armed: Bench, sign: int) -> None:
    """5 mm of a scale that slipped were told as a table that was too fast."""
    armed.run(12)
    armed.at(armed.place + sign * 61)
    armed.run(1)
    assert armed.twin.faults == Fault.ENCODER
    assert not armed.status.homed


@pytest.mark.parametrize("homed", [True, False])
def test_a_leap_of_many_speeds_is_still_the_encoder(idle: Bench, homed: bool) -> None:
    idle.done(Request.LIMITS, *LIMITS)
    if homed:
        idle.done(Request.HOME, 0, 0)
    idle.ask(Request.HEARTBEAT)
    idle.done(Request.ARM)
    idle.run(12)
    idle.at(1000)
    idle.run(1)
    assert idle.twin.faults == Fault.ENCODER


def test_a_leap_away_from_the_set_points_is_the_encoder_and_no_lag(armed: Bench) -> None:
    feed(armed, RAMP)
    armed.done(Request.FOLLOW, 100, 30)
    armed.run(20)
    armed.at(armed.place + 1100)
    armed.run(1)
    assert armed.twin.faults == Fault.ENCODER


def limited(bench: Bench, duty: int = 255, slew: int = 255, current: int = 0) -> Bench:
    """Armed anew, with limits of the motor."""
    bench.done(Request.DISARM)
    bench.done(Request.LIMITS, *LIMITS[:4], duty, 500, 0, slew, current)
    bench.done(Request.ARM)
    return bench


def test_the_duty_changes_by_its_slew_and_the_brake_comes_at_once(armed: Bench) -> None:
    """Half a millimetre away asks for 48 on top of the dead 15 and more, at once: it comes in steps, there and back."""
    limited(armed, slew=7)
    feed(armed, [95] * 2 + [-95] * 2)
    armed.gain, duties = 0.0, [0]
    armed.done(Request.FOLLOW, 30, 4)
    for _ in range(85):
        armed.run(1)
        duties.append(int(armed.twin.registers[c.R_DUTY]))
    assert max(abs(now - before) for before, now in pairwise(duties) if now != 0) == 7
    assert (max(duties), min(duties)) == (35, -73)
    armed.done(Request.STOP)
    armed.run(1)
    assert armed.status.duty == 0


def test_the_duty_keeps_to_its_largest(armed: Bench) -> None:
    limited(armed, duty=40)
    feed(armed, [95] * 3)
    armed.gain = 0.0
    armed.done(Request.FOLLOW, 40, 3)
    armed.run(60)
    assert armed.status.duty == 40
    armed.run(60)
    assert armed.refused(Request.REVERSE, 41, 100, 0, 1) == Reason.RANGE


def test_a_current_above_its_largest_stops_the_motor_after_20_ms(armed: Bench) -> None:
    limited(armed, current=480)
    armed.done(Request.JOG, 300, 500)
    armed.current = 480
    armed.run(50)
    assert (armed.twin.state, armed.status.current) == (State.JOGGING, 480)
    armed.current = 481
    armed.run(20)
    armed.current = 480  # a moment under it, and the time begins anew
    armed.run(1)
    armed.current = 481
    armed.run(20)
    assert armed.twin.state == State.JOGGING
    armed.run(1)
    assert armed.twin.faults == Fault.CURRENT
    assert (armed.status.duty, armed.twin.enabled) == (0, False)


def test_a_current_that_is_not_wired_is_not_looked_at(armed: Bench) -> None:
    armed.current = 1023
    armed.done(Request.JOG, 300, 500)
    armed.run(100)
    assert (armed.twin.state, armed.status.current) == (State.JOGGING, 0)


def test_it_says_what_it_was_built_with(idle: Bench) -> None:
    reply = idle.ask(Request.BUILD)
    assert (reply.kind, reply.values[:2]) == (Reply.BUILD, (0, 250000))


def test_a_stall_is_seen_in_its_time_and_not_before(armed: Bench) -> None:
    armed.gain = 0.0
    armed.done(Request.REVERSE, 255, 12000, 0, 1)
    while abs(int(armed.twin.registers[c.R_DUTY])) < 64:
        armed.run(1)
    armed.run(499)
    assert armed.twin.state == State.REVERSING
    armed.run(2)
    assert armed.twin.faults == Fault.STALL


def test_a_glitch_of_the_encoder_is_a_fault_and_its_place_is_lost(armed: Bench) -> None:
    armed.glitch = True
    armed.run(1)
    assert armed.twin.faults == Fault.ENCODER
    assert not armed.status.homed


def test_following_reaches_each_set_point_and_ends_armed(armed: Bench) -> None:
    feed(armed, RAMP)
    armed.done(Request.FOLLOW, 50, 30)
    armed.run(29 * 50 - 1)
    assert armed.status.state == State.FOLLOWING
    assert abs(armed.status.position - RAMP[-1]) < 30
    armed.run(1)
    status = armed.status
    assert (status.state, status.free, status.next, status.duty) == (State.ARMED, 64, 0, 0)


def test_a_queue_that_runs_empty_and_a_table_left_behind_are_faults(armed: Bench) -> None:
    feed(armed, RAMP)
    armed.done(Request.FOLLOW, 50, 31)
    armed.run(29 * 50 - 1)
    assert armed.twin.state == State.FOLLOWING
    armed.run(1)
    assert armed.twin.faults == Fault.UNDERRUN
    armed.done(Request.CLEAR)
    armed.done(Request.ARM)
    armed.gain = 1.0  # too weak to follow
    here = armed.status.position
    feed(armed, [here, here + 1100])
    armed.done(Request.FOLLOW, 220, 2)
    armed.run(200)
    assert armed.twin.state == State.FOLLOWING
    armed.run(19)
    assert armed.twin.faults == Fault.FOLLOWING


def test_set_points_that_do_not_fit_are_refused_whole(armed: Bench) -> None:
    assert armed.refused(Request.FOLLOW, 10, 5) == Reason.GAP
    assert armed.refused(Request.SETPOINTS, 1, 0) == Reason.GAP
    assert armed.refused(Request.SETPOINTS, 0, 0, 7001) == Reason.RANGE
    feed(armed, [0] * 56)
    assert armed.refused(Request.SETPOINTS, 56, *[0] * 9) == Reason.QUEUE_FULL
    assert armed.done(Request.SETPOINTS, 56, *[0] * 8) == 0
    assert armed.done(Request.SETPOINTS, 55, 0, 0) == 0  # repeated ones are skipped
    assert armed.refused(Request.FOLLOW, 10, 63) == Reason.RANGE
    assert armed.refused(Request.FOLLOW, 0, 64) == Reason.RANGE
    armed.done(Request.FOLLOW, 10, 64)
    assert armed.refused(Request.SETPOINTS, 64, 0) in (Reason.RANGE, Reason.QUEUE_FULL)  # beyond the n-th


def test_set_points_from_zero_begin_anew_while_armed(armed: Bench) -> None:
    feed(armed, [0] * 32)
    assert armed.done(Request.SETPOINTS, 0, 101) == 63
    assert armed.refused(Request.FOLLOW, 10, 1) == Reason.RANGE  # too far from the table
    armed.done(Request.SETPOINTS, 0, 100)
    armed.done(Request.FOLLOW, 10, 1)
    armed.run(1)
    assert armed.twin.state == State.ARMED


def test_unhomed_it_moves_slowly_only(idle: Bench) -> None:
    idle.done(Request.LIMITS, *LIMITS)
    idle.ask(Request.HEARTBEAT)
    idle.done(Request.ARM)
    assert idle.refused(Request.SETPOINTS, 0, 0) == Reason.NOT_HOMED
    assert idle.refused(Request.REVERSE, 100, 100, 0, 1) == Reason.NOT_HOMED
    assert idle.refused(Request.JOG, 401, 100) == Reason.NOT_HOMED
    assert idle.refused(Request.JOG, 400, 501) == Reason.RANGE
    idle.done(Request.JOG, -400, 500)
    idle.run(500)
    assert idle.counts == pytest.approx(-200, abs=15)


def test_a_jog_ends_at_rest(armed: Bench) -> None:
    armed.done(Request.JOG, 2000, 300)
    armed.run(300)
    assert armed.counts == pytest.approx(600, abs=40)
    armed.run(62)
    assert armed.twin.state == State.ARMED
    assert armed.status.speed == 0


def test_the_index_is_found_on_either_side_and_gives_the_place(idle: Bench) -> None:
    idle.index = -900
    idle.done(Request.LIMITS, *LIMITS)
    idle.ask(Request.HEARTBEAT)
    idle.done(Request.ARM)
    idle.done(Request.HOME, 1, 400)
    for _ in range(200):
        idle.run(100)
        if idle.twin.state == State.ARMED:
            break
    status = idle.status
    assert (status.state, status.homed) == (State.ARMED, True)
    assert status.position == idle.counts + 900 + 400


@pytest.mark.parametrize("half", [500, pytest.param(1300, marks=pytest.mark.prove)])
def test_a_search_without_an_index_gives_up(armed: Bench, half: int) -> None:
    armed.done(Request.DISARM)
    armed.done(Request.LIMITS, -half, half, *LIMITS[2:])
    armed.done(Request.ARM)
    armed.done(Request.HOME, 1, 0)
    reached = []
    for _ in range(1400):
        armed.run(100)
        reached.append(armed.counts)
        if armed.twin.state == State.ARMED:
            break
    assert armed.twin.state == State.ARMED
    assert not armed.status.homed
    assert (
        max(map(abs, reached)) <= half + c.SPARE + 50
    )  # half of the limits' distance, for it may stand at one of them
    assert min(reached) == pytest.approx(-half - 200, abs=50)


def test_reversals_rise_pause_and_fall(armed: Bench) -> None:
    armed.gain = 10.0
    armed.done(Request.REVERSE, 200, 400, 50, 2)
    duties = []
    for _ in range(900):
        armed.run(1)
        duties.append(int(armed.twin.registers[c.R_DUTY]))
    assert max(duties) == 200
    assert min(duties) == -200
    assert duties.count(200) == pytest.approx(51, abs=1)
    assert duties[99] == 100
    assert sum(duties[:450]) == -sum(duties[450:])
    assert sum(duties[:450]) == pytest.approx(200 * (200 + 50), rel=0.01)
    armed.run(70)
    assert armed.twin.state == State.ARMED


def test_what_it_asks_for_never_passes_the_limit_of_duty(armed: Bench) -> None:
    armed.done(Request.DISARM)
    armed.done(Request.LIMITS, -7000, 7000, 24000, 100, 60, 500, 0, 255, 0)
    armed.done(Request.ARM)
    assert armed.refused(Request.REVERSE, 61, 100, 0, 1) == Reason.RANGE
    armed.done(Request.JOG, 20000, 500)
    armed.run(100)
    assert armed.status.duty == 60


def test_the_clock_and_the_count_of_bad_frames_wrap(idle: Bench) -> None:
    idle.twin.registers[c.R_TIME] = 2**32 + 5
    idle.twin.reader.bad = 2**16 + 7
    assert (idle.status.time, idle.status.bad_frames) == (5, 7)


def safe(twin: Twin) -> None:
    """What holds after anything."""
    assert twin.enabled == (twin.state not in (State.IDLE, State.FAULT))
    assert twin.enabled or twin.registers[c.R_DUTY] == 0
    assert 0 <= twin.free <= c.QUEUE
    assert (twin.state == State.FAULT) == bool(twin.faults)
    r = twin.registers
    if not r[c.R_HOMED] or r[c.R_OUTSIDE]:
        assert abs(r[c.R_DUTY]) <= c.SLOW_DUTY
        assert twin.state not in (State.FOLLOWING, State.REVERSING)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.binary(max_size=80), max_size=20), st.booleans())
def test_no_bytes_harm_it(blocks: list[bytes], awake: bool) -> None:
    bench = Bench()
    if awake:
        bench.ask(Request.HELLO, 3)
        bench.done(Request.CLEAR)
    for block in blocks:
        bench.twin.receive(block + b"\0")
        bench.run(3, beat=False)
        safe(bench.twin)


def requests() -> st.SearchStrategy[tuple[Request, tuple[int, ...]]]:
    """Any request with any body, some of them sensible."""
    i32 = st.one_of(st.integers(-800, 800), st.integers(-(2**31), 2**31 - 1))
    u32, u16, u8 = (
        st.integers(0, 2**32 - 1) | st.integers(0, 70),
        st.integers(0, 2**16 - 1) | st.integers(20, 300),
        st.integers(0, 255),
    )
    bodies: dict[Request, st.SearchStrategy[tuple[int, ...]]] = {
        Request.HELLO: st.tuples(st.just(3) | u8),
        Request.LIMITS: st.just(LIMITS) | st.tuples(i32, i32, u32, u16, u8, u16, u8, u8, u16),
        Request.HOME: st.tuples(st.integers(0, 2), i32), Request.JOG: st.tuples(i32, u16), Request.FOLLOW: st.tuples(u16, u32),
        Request.REVERSE: st.tuples(u8, u16, u16, u16),
        Request.SETPOINTS: st.tuples(u32, i32) | st.tuples(st.just(0), *[st.integers(-90, 90)] * 16),
    }  # fmt: skip
    return st.sampled_from(list(Request)).flatmap(lambda k: st.tuples(st.just(k), bodies.get(k, st.just(()))))


Steps = list[tuple[tuple[Request, tuple[int, ...]], int, bool]]
STEPS = st.lists(st.tuples(requests(), st.integers(0, 130), st.booleans()), max_size=30)


@settings(max_examples=60, deadline=None)
@given(STEPS, st.booleans())
def test_no_sequence_of_requests_harms_it(steps: Steps, ready: bool) -> None:
    unharmed(steps, ready)


@pytest.mark.prove
@settings(max_examples=150, deadline=None)
@given(STEPS, st.booleans())
def test_no_longer_row_of_sequences_harms_it(steps: Steps, ready: bool) -> None:
    unharmed(steps, ready)


def unharmed(steps: Steps, ready: bool) -> None:
    bench = Bench()
    if ready:
        bench.ask(Request.HELLO, 3)
        bench.done(Request.CLEAR)
        bench.done(Request.LIMITS, *LIMITS)
        bench.done(Request.HOME, 0, 0)
        bench.ask(Request.HEARTBEAT)
        bench.done(Request.ARM)
    for (kind, values), ms, beat in steps:
        before = bench.twin.state
        reply = bench.ask(kind, *values)
        assert reply.kind in tuple(Reply)
        if before == State.FAULT and kind != Request.CLEAR:
            assert bench.twin.state == State.FAULT
        safe(bench.twin)
        bench.run(ms, beat and bench.twin.handshake_done)
        safe(bench.twin)


# the stroke has ends without homing, too


def unhomed(idle: Bench, wired: int = 0, half: int = 7000) -> Bench:
    idle.done(Request.LIMITS, -half, half, *LIMITS[2:6], wired, *LIMITS[7:])
    idle.ask(Request.HEARTBEAT)
    idle.done(Request.ARM)
    return idle


def until(bench: Bench, state: State, ms: int = 400000) -> list[float]:
    """Run until a state; the places of the table."""
    places = []
    for _ in range(ms // 20):
        bench.run(20)
        places.append(bench.place)
        if bench.twin.state == state:
            return places
    raise AssertionError(f"{bench.twin.state!r}, {bench.twin.faults!r}")


@pytest.mark.parametrize("switches", [True, False])
@pytest.mark.parametrize(
    "start", [-1399, 600, 1399, *(pytest.param(place, marks=pytest.mark.prove) for place in (-1390, -800, 100))]
)
@pytest.mark.parametrize("index", [200, -900])
def test_a_search_from_anywhere_stays_between_the_ends_and_ends_at_the_index(
    idle: Bench, start: int, index: int, switches: bool
) -> None:
    idle.place, idle.index, idle.ends = float(start), index, (-1400.0, 1400.0)
    run = idle.run

    def with_switches(ms: int, beat: bool = True) -> None:
        for k in range(ms):
            idle.inputs = (idle.place <= -1350) | (idle.place >= 1350) << 1
            if k % 20 == 0 and beat:
                idle.ask(Request.HEARTBEAT)
            run(1, False)

    idle.run = with_switches if switches else run  # type: ignore[method-assign]
    unhomed(idle, int(switches), 1300).done(Request.HOME, 1, index)
    places = until(idle, State.ARMED)
    assert idle.status.homed
    assert idle.status.position == pytest.approx(idle.place, abs=2)
    if switches:
        assert max(map(abs, places)) <= max(1360, abs(start))


def test_a_search_between_end_switches_without_an_index_gives_up(idle: Bench) -> None:
    idle.ends = (-1400.0, 1400.0)
    unhomed(idle, half=1300).done(Request.HOME, 1, 0)
    until(idle, State.ARMED)
    assert not idle.status.homed


def test_a_search_that_cannot_move_is_a_stall(idle: Bench) -> None:
    idle.gain = 0.0
    unhomed(idle).done(Request.HOME, 1, 0)
    until(idle, State.FAULT)
    assert idle.twin.faults == Fault.STALL


@pytest.mark.parametrize("kind", [Request.JOG, Request.HOME])
def test_a_dead_encoder_is_seen_within_two_millimetres(idle: Bench, kind: Request) -> None:
    idle.dead = True
    unhomed(idle).done(kind, *((400, 500) if kind == Request.JOG else (1, 0)))
    for _ in range(100):
        if idle.twin.state == State.FAULT:
            break
        idle.run(20)
        if kind == Request.JOG and idle.twin.state in (State.ARMED, State.JOGGING):
            idle.done(Request.JOG, 400, 500)
        assert abs(idle.place) <= c.FREE_TRAVEL + 60
    assert idle.twin.faults == Fault.STALL


def test_a_dead_encoder_is_seen_on_a_stroke_too(armed: Bench) -> None:
    feed(armed, [60 * k for k in range(60)])
    armed.done(Request.FOLLOW, 40, 60)
    armed.run(1000)
    armed.dead, before = True, armed.place
    armed.run(1000)
    assert armed.twin.faults == Fault.STALL
    assert armed.place - before < c.FREE_TRAVEL + 160


def test_a_load_that_holds_the_table_near_a_resting_set_point_is_no_stall(armed: Bench) -> None:
    armed.gain = 0.0
    feed(armed, [10] * 60)
    armed.done(Request.FOLLOW, 100, 60)
    armed.run(5000)
    assert (armed.twin.state, armed.twin.registers[c.R_DUTY] > c.DEAD_DUTY) == (State.FOLLOWING, True)


@pytest.mark.parametrize("kind", [Request.JOG, Request.HOME, Request.FOLLOW])
def test_swapped_leads_are_seen_at_once(idle: Bench, kind: Request) -> None:
    idle.swapped = True
    unhomed(idle)
    if kind == Request.FOLLOW:
        idle.done(Request.DISARM)
        idle.done(Request.HOME, 0, 0)
        idle.done(Request.ARM)
        feed(idle, RAMP)
        idle.done(Request.FOLLOW, 50, 30)
    else:
        idle.done(kind, *((400, 500) if kind == Request.JOG else (1, 0)))
    idle.run(400)
    assert idle.twin.faults & Fault.DIRECTION
    assert abs(idle.place) < 100


@pytest.mark.parametrize("stalled", [100, 150, 190])
def test_slow_is_kept_when_a_motor_that_stood_comes_free(idle: Bench, stalled: int) -> None:
    unhomed(idle).done(Request.JOG, 400, 500)
    gain, idle.gain = idle.gain, 0.0
    idle.run(stalled)
    idle.gain = gain
    fastest, before = 0.0, idle.place
    for _ in range(300):
        idle.run(10)
        fastest, before = max(fastest, abs(idle.place - before) * 100), idle.place
    assert fastest <= 1.5 * c.SLOW_FAULT  # a motor without inertia; 7.5 mm/s for 10 ms
    assert idle.twin.faults in (Fault(0), Fault.SPEED)


def test_jogging_ends_a_stroke_from_where_it_began(idle: Bench) -> None:
    """It does not help to arm anew."""
    unhomed(idle, half=1000)
    while idle.twin.state != State.FAULT:
        idle.done(Request.JOG, 400, 500)
        idle.run(480)
        if idle.twin.state == State.JOGGING and idle.place % 3 < 1:
            idle.done(Request.DISARM)
            idle.done(Request.ARM)
        assert idle.place < 2500
    assert idle.twin.faults == Fault.HIGH
    assert idle.place == pytest.approx(2400, abs=20)
    assert not idle.status.homed


# switches


def test_inputs_are_shown_whether_they_are_wired_or_not(armed: Bench) -> None:
    armed.inputs = 5
    armed.run(1)
    assert (armed.status.inputs, armed.twin.state) == (5, State.ARMED)


@pytest.mark.parametrize(("speed", "inputs"), [(-400, 1), (400, 2)])
def test_an_end_switch_stops_and_lets_the_table_go_back(armed: Bench, speed: int, inputs: int) -> None:
    armed.done(Request.DISARM)
    armed.done(Request.LIMITS, *LIMITS[:6], 1, *LIMITS[7:])
    armed.done(Request.ARM)
    armed.done(Request.JOG, speed, 500)
    armed.run(100)
    armed.inputs = inputs
    armed.run(1)
    assert armed.twin.faults == Fault.END
    armed.done(Request.CLEAR)
    armed.run(20)
    armed.done(Request.ARM)
    assert armed.refused(Request.JOG, speed, 500) == Reason.END
    armed.done(Request.JOG, -speed, 500)
    armed.run(100)
    assert armed.twin.state == State.JOGGING
    armed.inputs = 3  # a broken wire
    armed.run(1)
    assert armed.twin.faults == Fault.END
    armed.done(Request.CLEAR)
    assert armed.refused(Request.ARM) == Reason.END


@pytest.mark.parametrize("state", list(MOVING))
def test_an_emergency_stop_is_a_fault_everywhere(armed: Bench, state: State) -> None:
    armed.done(Request.DISARM)
    armed.done(Request.LIMITS, *LIMITS[:6], 2, *LIMITS[7:])
    armed.done(Request.ARM)
    into(armed, state)
    armed.inputs = 4
    armed.run(1)
    assert armed.twin.faults == Fault.EMERGENCY
    armed.done(Request.CLEAR)
    assert armed.refused(Request.ARM) == Reason.EMERGENCY
    armed.inputs = 0
    armed.run(1)
    armed.done(Request.ARM)


# the index


def pass_index(bench: Bench, at: int) -> None:
    """One tick in which the index is seen at a count."""
    bench.twin.tick(bench.counts, True, at, False, 0)


@pytest.mark.parametrize("by_hand", [True, False])
@pytest.mark.parametrize("shift", [-3, -2, 0, 2, 3])
def test_the_index_is_compared_at_each_pass(idle: Bench, shift: int, by_hand: bool) -> None:
    unhomed(idle)
    if by_hand:
        idle.done(Request.DISARM)
        idle.done(Request.HOME, 0, 1000)
        idle.done(Request.ARM)
    else:
        idle.done(Request.HOME, 1, 400)
        idle.run(20)
    pass_index(idle, 77)
    idle.run(20 if by_hand else 80)
    assert idle.twin.state == State.ARMED
    pass_index(idle, 77 + shift)
    status = idle.status
    assert (status.index_shift, status.index_passes) == (shift, 2)
    moved = abs(shift) > 2
    assert idle.twin.faults == (Fault.INDEX if moved else Fault(0))
    assert status.homed != moved


def test_an_index_that_moved_while_nothing_was_armed_ends_the_homing(armed: Bench) -> None:
    pass_index(armed, 77)
    armed.done(Request.DISARM)
    pass_index(armed, 100)
    assert (armed.twin.state, armed.status.homed) == (State.IDLE, False)


# outside of the limits


@pytest.mark.parametrize("side", [-1, 1])
def test_there_is_a_way_back_from_outside(idle: Bench, side: int) -> None:
    idle.done(Request.LIMITS, *LIMITS)
    idle.ask(Request.HEARTBEAT)
    idle.done(Request.HOME, 0, side * 7300)
    idle.done(Request.ARM)
    assert idle.status.outside
    assert idle.refused(Request.JOG, side * 100, 500) == Reason.OUTSIDE
    assert idle.refused(Request.JOG, -side * 401, 500) == Reason.OUTSIDE
    assert idle.refused(Request.HOME, 1, 0) == Reason.OUTSIDE
    assert idle.refused(Request.FOLLOW, 10, 5) == Reason.OUTSIDE
    assert idle.refused(Request.REVERSE, 100, 100, 0, 1) == Reason.OUTSIDE
    for _ in range(5):
        idle.done(Request.JOG, -side * 400, 500)
        idle.run(400)
    idle.run(300)
    status = idle.status
    assert (status.state, status.outside) == (State.ARMED, False)
    assert abs(status.position) < 7000
    while idle.twin.state != State.FAULT:
        idle.done(Request.JOG, side * 400, 500)
        idle.run(400)
    assert idle.twin.faults == (Fault.HIGH if side > 0 else Fault.LOW)  # and none out again


@pytest.mark.parametrize("side", [-1, 1])
def test_outside_it_goes_no_farther_out(idle: Bench, side: int) -> None:
    idle.done(Request.LIMITS, *LIMITS)
    idle.ask(Request.HEARTBEAT)
    idle.done(Request.HOME, 0, side * 7300)
    idle.done(Request.ARM)
    for far in (60, 40):
        idle.at(idle.place + side * far)
        idle.run(1)
    assert idle.twin.state == State.ARMED
    idle.at(idle.place + side)
    idle.run(1)
    assert idle.twin.faults == (Fault.HIGH if side > 0 else Fault.LOW)


# what a stranger who writes the firmware in C may do otherwise


def test_whole_numbers_are_divided_as_in_c() -> None:
    assert [c.quotient(a, 3) for a in (7, -7, 6, -6, 2, -2, 0)] == [2, -2, 2, -2, 0, 0, 0]


@pytest.mark.parametrize("sign", [-1, 1])
def test_between_set_points_both_directions_are_alike(armed: Bench, sign: int) -> None:
    armed.gain = 0.0
    feed(armed, [0, sign * 10])
    armed.done(Request.FOLLOW, 7, 2)
    targets = []
    for _ in range(6):
        armed.run(1)
        targets.append(sign * int(armed.twin.registers[c.R_TARGET]))
    assert targets == [1, 2, 4, 5, 7, 8]


def test_set_points_faster_than_the_limit_are_a_fault(armed: Bench) -> None:
    feed(armed, [0, 241])
    armed.done(Request.FOLLOW, 10, 2)
    armed.run(1)
    assert armed.twin.faults == Fault.SPEED


def test_a_hello_of_another_version_stops_what_moves(armed: Bench) -> None:
    into(armed, State.JOGGING).ask(Request.HELLO, 1)
    assert armed.twin.faults == Fault.ABORTED
    assert armed.refused(Request.HEARTBEAT) == Reason.VERSION


def test_all_numbers_fit_into_32_bits(armed: Bench) -> None:
    """The largest set points at the shortest period."""
    armed.done(Request.DISARM)
    armed.done(Request.LIMITS, -37000, 37000, 40000, 200, 255, 1000, 0, 255, 0)
    armed.done(Request.ARM)
    largest = max(37000 * 2 * 1000, (40000 + c.GAIN * (c.AWAY + 40)) * 240, 255 * 60000, 37000 * c.RATE)
    assert largest < 2**31
    feed(armed, [0, 37000])
    armed.done(Request.FOLLOW, 1000, 2)
    while armed.twin.state == State.FOLLOWING:
        armed.run(1)
        assert np.abs(armed.twin.registers).max() < 2**31


def test_speed_is_zero_until_ten_positions_are_there() -> None:
    bench = Bench()
    bench.ask(Request.HELLO, 3)
    for k in range(12):
        bench.at(100.0 * (k + 1))
        bench.run(1, beat=False)
        assert bench.status.speed == (0 if k < 10 else 100 * 1000)


def test_empty_frames_are_no_bad_frames(idle: Bench) -> None:
    bad = idle.status.bad_frames
    idle.twin.receive(b"\0\0\0")
    assert idle.status.bad_frames == bad
    idle.twin.receive(b"\x01" * 400 + b"\0")  # longer than any frame: one bad frame
    assert idle.status.bad_frames == bad + 1


def test_a_repeat_is_known_by_type_and_number_alone(armed: Bench) -> None:
    first = armed.twin.receive(encode(SerialFrame(Request.JOG, 9, (300, 20))))
    assert armed.twin.receive(encode(SerialFrame(Request.JOG, 9, (-300, 500)))) == first
    assert armed.twin.registers[c.R_RATE] == 300
