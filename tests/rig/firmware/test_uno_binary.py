"""The firmware's binary in simavr: the dialogue of its model, every limit alone, no harm by any byte, its time, its memory."""

import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from tests.rig.firmware.chip import GLITCH, HANG, RESET, SLIP, Chip, build
from tests.rig.firmware.test_twin import LIMITS

from dampyr.rig.firmware.protocol import Fault, Reader, Reason, Reply, Request, SerialFrame, State, encode
from dampyr.rig.firmware.twin import Twin, source_digest

pytestmark = pytest.mark.prove
RAM_END, RAM = 0x08FF, 2048
WIRED = (*LIMITS[:6], 3, *LIMITS[7:])
START_UP = 3  # ms
DOCS = Path(__file__).parents[3] / "docs"
PAGE, PROTOCOL = ((DOCS / name).read_text("utf-8") for name in ("how-to/firmware.md", "reference/protocol.md"))


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return build(tmp_path_factory.mktemp("firmware"))


@pytest.fixture
def make(built: tuple[Path, Path]) -> Iterator[Callable[..., Chip]]:
    chips: list[Chip] = []

    def one(mark: int = 10**6) -> Chip:
        chips.append(Chip(built, mark))
        for _ in range(START_UP):
            chips[-1].ms()
        return chips[-1]

    yield one
    for chip in chips:
        chip.close()


@pytest.fixture
def armed(make: Callable[..., Chip]) -> Chip:
    return ready(make())


def ready(chip: Chip, limits: tuple[int, ...] = LIMITS, homed: bool = True) -> Chip:
    chip.ask(Request.HELLO, 3)
    chip.done(Request.CLEAR)
    chip.done(Request.LIMITS, *limits)
    if homed:
        chip.done(Request.HOME, 0, 0)
    chip.ask(Request.HEARTBEAT)
    chip.done(Request.ARM)
    assert chip.pins.enabled
    return chip


def feed(chip: Chip, points: list[int]) -> None:
    for k in range(0, len(points), 16):
        chip.done(Request.SETPOINTS, k, *points[k : k + 16])


def test_it_starts_in_fault_with_everything_off(make: Callable[..., Chip]) -> None:
    chip = make()
    assert (chip.pins.enabled, chip.pins.duty, chip.pins.port_d & 0x80) == (False, 0, 0x80)
    assert chip.ask(Request.HELLO, 3).values == (3, 0x0300, 1000, 64)
    status = chip.status
    assert (status.state, status.faults, status.homed) == (State.FAULT, Fault.RESTARTED, False)


def test_it_moves_to_where_it_is_sent(armed: Chip) -> None:
    points = [round(1000 * (1 - np.cos(2 * np.pi * k / 60))) for k in range(61)]
    feed(armed, points)
    armed.done(Request.FOLLOW, 20, len(points))
    seen = []
    while armed.status.state == State.FOLLOWING:
        seen.append(armed.place)
        armed.run(10)
    assert max(seen) == pytest.approx(2000, rel=0.03)
    armed.run(200)
    assert abs(armed.status.position - int(armed.place // 1)) <= 1
    assert armed.status.state == State.ARMED


def test_it_finds_its_index_from_both_sides_at_one_count(make: Callable[..., Chip]) -> None:
    for mark in (333, -333):
        chip = ready(make(mark), homed=False)
        chip.done(Request.HOME, 1, 500)
        chip.run(7000)
        status = chip.status
        assert (status.state, status.homed) == (State.ARMED, True)
        assert status.position - int(chip.place // 1) == 500 - mark
        for way in np.array([-1, 1, -1, 1]) * (1 if mark > 0 else -1):  # passes of the mark from both sides
            for _ in range(4):
                chip.ask(Request.HEARTBEAT)
                chip.done(Request.JOG, int(300 * way), 500)
                chip.run(260)
        assert abs(chip.status.index_shift) <= 1
        assert chip.status.index_passes >= 3


def stalls(chip: Chip) -> None:
    chip.gain = 0.0
    chip.done(Request.REVERSE, 200, 2000, 0, 3)


def lags(chip: Chip) -> None:
    feed(chip, [100 * k for k in range(60)])
    chip.gain = 3.0
    chip.done(Request.FOLLOW, 20, 60)


def starves(chip: Chip) -> None:
    feed(chip, [10 * k for k in range(10)])
    chip.done(Request.FOLLOW, 20, 500)


def runs_backwards(chip: Chip) -> None:
    chip.gain = -65.0
    chip.done(Request.REVERSE, 150, 2000, 0, 3)


CAUSES: dict[Fault, Callable[[Chip], object]] = {
    Fault.HEARTBEAT: lambda chip: chip.run(101, beat=False),
    Fault.LOW: lambda chip: setattr(chip, "moving", lambda: -8000.0),
    Fault.HIGH: lambda chip: setattr(chip, "moving", lambda: 8000.0),
    Fault.SPEED: lambda chip: setattr(chip, "moving", lambda: 25500.0),
    Fault.STALL: stalls,
    Fault.FOLLOWING: lags,
    Fault.UNDERRUN: starves,
    Fault.ENCODER: lambda chip: chip.ms(what=GLITCH),
    Fault.ABORTED: lambda chip: chip.done(Request.ABORT),
    Fault.END: lambda chip: (setattr(chip, "inputs", 2), chip.done(Request.JOG, 300, 500)),
    Fault.EMERGENCY: lambda chip: setattr(chip, "inputs", 4),
    Fault.DIRECTION: runs_backwards,
}


@pytest.mark.parametrize("fault", CAUSES, ids=lambda fault: fault.name)
def test_each_limit_acts_alone(make: Callable[..., Chip], fault: Fault) -> None:
    chip = ready(make(), WIRED if fault in (Fault.END, Fault.EMERGENCY) else LIMITS)
    CAUSES[fault](chip)
    for _ in range(3000):
        if not chip.pins.enabled:
            break
        chip.run(20, beat=fault != Fault.HEARTBEAT)
    assert (chip.pins.enabled, chip.pins.extend, chip.pins.retract) == (False, 0, 0)
    chip.moving = lambda: 0.0
    status = chip.status
    assert (status.state, status.faults) == (State.FAULT, fault)
    assert chip.ask(Request.ARM).kind == Reply.NAK


def test_an_index_that_has_moved_is_a_fault(make: Callable[..., Chip]) -> None:
    """Six counts that the chip takes for others: the mark is passed where it was not."""
    chip = ready(make(200))
    chip.moving = lambda: 2000.0
    chip.run(150)  # the first pass says where the mark is
    for _ in range(3):
        chip.ms(what=SLIP)
    chip.moving = lambda: -2000.0
    for _ in range(200):
        chip.run(1)
        if not chip.pins.enabled:
            break
    chip.moving = lambda: 0.0
    status = chip.status
    assert (status.state, status.faults, status.homed) == (State.FAULT, Fault.INDEX, False)
    assert abs(status.index_shift) == 6


@pytest.mark.parametrize("state", ["armed", "moving"])
def test_a_program_that_hangs_is_reset_by_the_watchdog_with_everything_off(armed: Chip, state: str) -> None:
    if state == "moving":
        armed.done(Request.REVERSE, 200, 2000, 1000, 3)
        armed.run(300)
        assert armed.pins.duty > 20
    armed.ms(what=HANG)
    took = 0
    while armed.pins.resets == 0:
        armed.ms()
        took += 1
        assert took < 40
    armed.ms()
    assert (armed.pins.enabled, armed.pins.duty) == (False, 0)
    armed.moving = lambda: 0.0
    armed.ms()
    assert armed.ask(Request.HEARTBEAT).values == (Request.HEARTBEAT, Reason.NO_HELLO)
    armed.ask(Request.HELLO, 3)
    assert armed.status.faults == Fault.RESTARTED


def test_a_reset_in_motion_leaves_everything_off(armed: Chip) -> None:
    armed.done(Request.REVERSE, 200, 2000, 1000, 3)
    armed.run(300)
    armed.ms(what=RESET)
    armed.ms()
    assert (armed.pins.enabled, armed.pins.duty) == (False, 0)


@pytest.mark.parametrize("speed", [15000.0, 24000.0])  # counts/s: 75 and 120 mm/s
def test_no_edge_of_the_encoder_is_lost(make: Callable[..., Chip], speed: float) -> None:
    """To and fro, while set points are followed and the line is busy."""
    chip = ready(make(), (-37000, 37000, 40000, 200, 255, 1000, 0, 255, 0))
    feed(chip, [0] * 32)
    chip.done(Request.FOLLOW, 1000, 32)
    chip.moving = lambda: speed if chip.time // 30 % 2 else -speed
    for _ in range(40):
        chip.ask(Request.HEARTBEAT)
        chip.ask(Request.SETPOINTS, 40, *[0] * 16)  # a gap: refused, and as long as a frame can be
    chip.moving = lambda: 0.0
    chip.run(3)
    status = chip.status
    assert Fault.ENCODER not in status.faults
    assert status.position == int(chip.place // 1)
    assert chip.pins.work < 8000  # cycles of the 16,000 of a millisecond, encoder and line included


def test_its_memory(armed: Chip, built: tuple[Path, Path]) -> None:
    """What it uses of 2 KB: its variables, and the stack at its deepest, which stay apart."""
    for kind, values in ((Request.SETPOINTS, (0, *range(16))), (Request.HEARTBEAT, ()), (Request.FOLLOW, (10, 16))):
        armed.ask(kind, *values)
    armed.run(300)
    words = subprocess.run(["avr-size", str(built[0])], capture_output=True, text=True, check=True).stdout.split()
    text, data, bss = (int(words[words.index("filename") + 1 + k]) for k in range(3))
    stack = RAM_END - armed.pins.stack
    assert text + data < 30000
    assert data + bss + stack < RAM * 3 // 4
    print(
        f"flash {text + data} bytes, variables {data + bss} bytes, stack {stack} bytes, work {armed.pins.work} cycles"
    )


def bytes_a_ms(chip: Chip) -> int:
    """The most of a reply's bytes that come within a millisecond."""
    chip.reader = Reader()
    return max(len(chip.ms(encode(SerialFrame(Request.HEARTBEAT, 77)) if k == 0 else b"")) for k in range(15))


def test_it_talks_at_115200_baud(tmp_path: Path, make: Callable[..., Chip]) -> None:
    """Built with BAUD=115200: whole dialogues with a host of that speed, and its bytes come 2.1 times as slowly as else."""
    chip = Chip(build(tmp_path, "BAUD=115200"), baud=115200)
    try:
        chip.run(START_UP, beat=False)
        ready(chip)
        points = [round(500 * (1 - np.cos(2 * np.pi * k / 50))) for k in range(51)]
        feed(chip, points)
        chip.done(Request.FOLLOW, 20, len(points))
        chip.run(1200)
        assert (chip.status.state, chip.status.bad_frames, chip.pins.resets) == (State.ARMED, 0, 0)
        assert 1.8 < bytes_a_ms(ready(make())) / bytes_a_ms(chip) < 2.4  # simavr shows both at half of their speed
    finally:
        chip.close()
    assert "BAUD=115200" in PAGE


@pytest.mark.parametrize("what", [16, 32], ids=["A0", "A1"])
def test_it_reads_the_bridges_current_and_stops_above_the_largest(make: Callable[..., Chip], what: int) -> None:
    """2.5 V at either output are half of the scale."""
    chip = ready(make(), (*LIMITS[:8], 500))
    assert chip.status.current == 0
    chip.sense = what
    chip.run(10)
    status = chip.status
    assert (status.state, status.current) == (State.ARMED, pytest.approx(511, abs=1))
    chip.run(20)
    assert (chip.status.faults, chip.pins.enabled, chip.pins.duty) == (Fault.CURRENT, False, 0)


def test_it_says_what_it_was_built_with(tmp_path: Path, make: Callable[..., Chip]) -> None:
    assert ready(make()).ask(Request.BUILD).values[:3] == (0, 250000, source_digest())
    chip = Chip(build(tmp_path, "DIRECTION_PIN=1", "BAUD=115200"), baud=115200)
    try:
        chip.run(START_UP, beat=False)
        assert ready(chip).ask(Request.BUILD).values[:3] == (1, 115200, source_digest())
    finally:
        chip.close()


@pytest.mark.parametrize("way", [1, -1])
def test_it_drives_a_bridge_with_one_pwm_and_a_direction(tmp_path: Path, way: int) -> None:
    """Built with DIRECTION_PIN=1: D9 is the PWM, D10 a plain output that is HIGH while the table is to retract."""
    chip = Chip(build(tmp_path, "DIRECTION_PIN=1"))
    try:
        chip.run(START_UP, beat=False)
        ready(chip)
        chip.done(Request.JOG, 4000 * way, 500)
        chip.run(300)
        assert chip.pins.extend > 60
        assert chip.pins.retract == 0
        assert bool(chip.pins.port_b & 4) is (way < 0)
        assert chip.place * way > 500
        chip.done(Request.ABORT)
        chip.ms()
        assert (chip.pins.enabled, chip.pins.extend, chip.pins.port_b & 4) == (False, 0, 0)
    finally:
        chip.close()
    assert "DIRECTION_PIN=1: D9 the PWM, D10 HIGH retracts" in PROTOCOL


def random_request(rng: np.random.Generator, at: int) -> tuple[Request, tuple[int, ...]]:
    """One that is often carried out."""
    kind = Request(int(rng.choice([1, 2, 3, 3, 3, 4, 4, 5, 6, 7, 7, 8, 8, 8, 9, 9, 10, 11, 12, 13, 13])))
    values: dict[Request, tuple[int, ...]] = {
        Request.HELLO: (3 if rng.random() < 0.95 else 1,),
        Request.LIMITS: (
            -7000,
            int(rng.choice([7000, 40000, -8000])),
            24000,
            100,
            255,
            500,
            0,
            int(rng.choice([255, 9])),
            0,
        ),
        Request.HOME: (0, int(rng.integers(-50, 50))),
        Request.JOG: (int(rng.integers(-600, 600)), int(rng.integers(-50, 520)) % 65536),
        Request.SETPOINTS: (
            int(rng.choice([0, at, at + 1])),
            *(int(p) for p in at + rng.integers(-30, 30, rng.integers(1, 17))),
        ),
        Request.FOLLOW: (int(rng.integers(0, 60)), int(rng.integers(0, 40))),
        Request.REVERSE: (int(rng.integers(0, 120)), int(rng.integers(10, 400)), int(rng.integers(0, 200)), 2),
    }
    return kind, values.get(kind, ())


@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.by_hand) for seed in (2, 3))])
def test_it_answers_as_its_model_does(make: Callable[..., Chip], seed: int) -> None:
    """Random dialogues, answer by answer, with a table that stands: replies are the same, but for the clock."""
    rng = np.random.default_rng(seed)
    chip, twin, reader, clock = make(), Twin(), Reader(), 0
    chip.gain = 0.0

    def model_to(time: int) -> None:
        nonlocal clock
        while clock < time:
            twin.tick(0, False, 0, False, 0)
            clock += 1

    different, refusals, done = [], set(), set()
    for number in range(1200):
        kind, values = random_request(rng, 0)
        data = encode(SerialFrame(kind, number % 256, values))
        model_to(chip.time + 1)
        (expected,) = reader.feed(twin.receive(data))
        reply = chip.reply_to(data)
        (refusals if reply.kind == Reply.NAK else done).add(
            reply.values[:2] if reply.kind == Reply.NAK else reply.values[:1]
        )
        mine, its = (each.values[1:] if each.kind == Reply.STATUS else each.values for each in (reply, expected))
        if (reply.kind, mine) != (expected.kind, its):
            different.append((number, kind.name, values, reply, expected))
        for _ in range(int(rng.integers(1, 60))):
            chip.ms()
    assert len(refusals) > 12
    assert len(different) <= 12, different[
        :5
    ]  # of 1,200, where a motion ends in the millisecond in which the request comes


def test_no_bytes_move_it_or_silence_it(make: Callable[..., Chip]) -> None:
    """Thousands of frames with bytes that were changed, cut and doubled: it is never armed by them, and answers afterwards."""
    rng = np.random.default_rng(1)
    chip = make()
    chip.ask(Request.HELLO, 3)
    chip.done(Request.CLEAR)
    chip.done(Request.LIMITS, *LIMITS)
    chip.ask(Request.HEARTBEAT)
    for number in range(3000):
        kind, values = random_request(rng, 0)
        data = bytearray(encode(SerialFrame(kind, number % 256, values)))
        for _ in range(int(rng.integers(1, 4))):
            what, place = int(rng.integers(3)), int(rng.integers(len(data)))
            if what == 0:
                data[place] ^= 1 << int(rng.integers(8))
            elif what == 1:
                del data[place:]
                data += b"\0"
            else:
                data[place:place] = rng.bytes(int(rng.integers(1, 100)))
        if any(frame.kind in (Request.ARM, Request.ABORT) for frame in Reader().feed(b"\0" + bytes(data))):
            continue  # the change left it whole, or was undone by the next
        chip.ms(bytes(data))
        for _ in range(len(data) // 20 + 2):  # the line takes 25 bytes a millisecond
            chip.ms()
        assert (chip.pins.enabled, chip.pins.duty, chip.pins.running, chip.pins.resets) == (False, 0, 1, 0)
    chip.run(30, beat=False)
    chip.seen = b""
    chip.reader = Reader()
    chip.ms(b"\0")
    chip.ms()
    assert chip.status.state == State.IDLE
    assert chip.status.bad_frames > 1000
