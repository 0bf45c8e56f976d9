"""The model of the firmware against docs/reference/protocol.md: states, refusals, faults, and what no bytes can do to it."""

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dampyr.rig.firmware import control_core as c
from dampyr.rig.firmware.protocol import (
    BODIES,
    Fault,
    Frame,
    Reader,
    Reason,
    Reply,
    Request,
    State,
    Status,
    encode,
    status_of,
)
from dampyr.rig.firmware.twin import Twin

LIMITS = (-7000, 7000, 24000, 100, 255, 500)
RAMP = [20 * k for k in range(30)]


class Bench:
    """A twin with a motor that moves as told: ``speed`` counts per duty and second, or the position itself."""

    def __init__(self) -> None:
        self.twin, self.reader, self.number = Twin(), Reader(), 0
        self.counts, self.place, self.gain, self.latched, self.glitch = 0, 0.0, 60.0, False, False
        self.index = 10**9

    def ask(self, kind: Request, *values: int) -> Frame:
        self.number = (self.number + 1) % 256
        (reply,) = self.reader.feed(self.twin.receive(encode(Frame(kind, self.number, values))))
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
            old, self.place = self.place, self.place + self.gain * int(self.twin.registers[c.R_DUTY]) / 1000
            latched = min(old, self.place) < self.index <= max(old, self.place)
            self.counts = int(self.place // 1)
            c.tick(self.twin.registers, self.counts, latched, self.index, self.glitch)

    def at(self, place: float) -> None:
        """Put the table somewhere, slowly enough."""
        self.place, self.gain = place, 0.0


@pytest.fixture
def idle() -> Bench:
    bench = Bench()
    bench.ask(Request.HELLO, 1)
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
    assert bench.ask(Request.HELLO, 1).values == (1, 0x0100, 1000, 64)
    status = bench.status
    assert (status.state, status.faults) == (State.FAULT, Fault.RESTARTED)
    assert (status.enabled, status.homed, status.limited) == (False, False, False)


@pytest.mark.parametrize("version", [0, 2, 255])
def test_another_version_may_only_stop(version: int) -> None:
    bench = Bench()
    assert bench.refused(Request.HEARTBEAT) == Reason.VERSION  # before any HELLO
    assert bench.ask(Request.HELLO, version).kind == Reply.HELLO
    for kind, body in BODIES.items():
        if isinstance(kind, Request) and kind not in (Request.HELLO, Request.STOP, Request.ABORT, Request.DISARM):
            assert bench.refused(kind, *[1] * len(body.unpack(bytes(body.size)))) == Reason.VERSION
    bench.done(Request.STOP)
    bench.done(Request.ABORT)
    bench.done(Request.DISARM)


def test_a_repeated_request_is_answered_but_not_carried_out_again(armed: Bench) -> None:
    frame = encode(Frame(Request.SETPOINTS, 77, (0, 1, 2)))
    first = armed.twin.receive(frame)
    assert armed.twin.receive(frame) == first != b""
    jog = encode(Frame(Request.JOG, 77, (300, 20)))  # the same number, another type
    assert armed.reader.feed(armed.twin.receive(jog))[0].kind == Reply.ACK
    assert armed.twin.state == State.JOGGING
    armed.run(40, beat=False)
    assert armed.reader.feed(armed.twin.receive(jog))[0].kind == Reply.ACK
    assert armed.twin.state != State.JOGGING


def test_noise_is_counted_and_dropped(idle: Bench) -> None:
    good = encode(Frame(Request.STOP, 9, ()))
    assert idle.twin.receive(b"\x07rubbish\0" + good[:-2] + b"\x55\0" + encode(Frame(Reply.ACK, 1, (1, 1)))) == b""
    assert idle.status.bad_frames == 3
    assert idle.twin.receive(b"\x05half" + b"\0" + good) != b""


@pytest.mark.parametrize(
    "limits",
    [
        (-37001, 7000, 24000, 100, 255, 500), (-7000, 37001, 24000, 100, 255, 500), (10, 10, 24000, 100, 255, 500),
        (-7000, 7000, 40001, 100, 255, 500), (-7000, 7000, 0, 100, 255, 500), (-7000, 7000, 24000, 49, 255, 500),
        (-7000, 7000, 24000, 201, 255, 500), (-7000, 7000, 24000, 100, 0, 500), (-7000, 7000, 24000, 100, 255, 99),
        (-7000, 7000, 24000, 100, 255, 1001),
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
    idle.done(Request.HOME, 0, 7001)
    assert idle.refused(Request.ARM) == Reason.RANGE
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
        armed.twin.registers[c.R_PAST : c.R_PAST + c.WINDOW] = place
        armed.at(place)
        armed.run(1)
        assert armed.twin.faults == fault
        armed.done(Request.CLEAR)
        armed.done(Request.HOME, 0, 0)
        armed.done(Request.ARM)
    armed.run(12)
    armed.place = float(armed.counts + 241)  # 24100 counts/s over 10 ms
    armed.run(1)
    assert armed.twin.faults == Fault.SPEED


def test_a_stall_is_seen_in_its_time_and_not_before(armed: Bench) -> None:
    armed.gain = 0.0
    armed.done(Request.REVERSE, 255, 60000, 0, 1)
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
    armed.at(armed.place)
    here = armed.status.position
    feed(armed, [here, here + 1100])
    armed.done(Request.FOLLOW, 220, 2)
    armed.run(200)
    assert armed.twin.state == State.FOLLOWING
    armed.run(3)
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


def test_a_search_without_an_index_gives_up(armed: Bench) -> None:
    armed.done(Request.HOME, 1, 0)
    reached = []
    for _ in range(1400):
        armed.run(100)
        reached.append(armed.counts)
        if armed.twin.state == State.ARMED:
            break
    assert armed.twin.state == State.ARMED
    assert not armed.status.homed
    assert max(map(abs, reached)) < 7000


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
    armed.done(Request.LIMITS, -7000, 7000, 24000, 100, 60, 500)
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


@settings(max_examples=60, deadline=None)
@given(st.lists(st.binary(max_size=80), max_size=20), st.booleans())
def test_no_bytes_harm_it(blocks: list[bytes], awake: bool) -> None:
    bench = Bench()
    if awake:
        bench.ask(Request.HELLO, 1)
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
        Request.HELLO: st.tuples(st.just(1) | u8), Request.LIMITS: st.just(LIMITS) | st.tuples(i32, i32, u32, u16, u8, u16),
        Request.HOME: st.tuples(st.integers(0, 2), i32), Request.JOG: st.tuples(i32, u16), Request.FOLLOW: st.tuples(u16, u32),
        Request.REVERSE: st.tuples(u8, u16, u16, u16),
        Request.SETPOINTS: st.tuples(u32, i32) | st.tuples(st.just(0), *[st.integers(-90, 90)] * 16),
    }  # fmt: skip
    return st.sampled_from(list(Request)).flatmap(lambda k: st.tuples(st.just(k), bodies.get(k, st.just(()))))


@settings(max_examples=150, deadline=None)
@given(st.lists(st.tuples(requests(), st.integers(0, 130), st.booleans()), max_size=30), st.booleans())
def test_no_sequence_of_requests_harms_it(
    steps: list[tuple[tuple[Request, tuple[int, ...]], int, bool]], ready: bool
) -> None:
    bench = Bench()
    if ready:
        bench.ask(Request.HELLO, 1)
        bench.done(Request.CLEAR)
        bench.done(Request.LIMITS, *LIMITS)
        bench.done(Request.HOME, 0, 0)
        bench.ask(Request.HEARTBEAT)
        bench.done(Request.ARM)
    for (kind, values), ms, beat in steps:
        before = bench.twin.state
        reply = bench.ask(kind, *values)
        assert reply.kind in (Reply.ACK, Reply.NAK, Reply.HELLO, Reply.STATUS)
        if before == State.FAULT and kind != Request.CLEAR:
            assert bench.twin.state == State.FAULT
        safe(bench.twin)
        bench.run(ms, beat and bench.twin.handshake_done)
        safe(bench.twin)
