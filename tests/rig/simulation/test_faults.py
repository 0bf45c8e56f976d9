"""Faults of the simulated rig: as typed, and what each of them does."""

import numpy as np
import pytest
from tests.rig.simulation.driver import LIMITS, Host, follow, rig, sine

from dampyr.errors import InputError
from dampyr.rig.firmware.protocol import Fault, Request, SerialFrame, State, encode
from dampyr.rig.settings import RigSettings
from dampyr.rig.simulation import plant
from dampyr.rig.simulation.board_signals import OVERRUN, TIMEOUT, BoardError
from dampyr.rig.simulation.faults import KINDS, FaultSpec
from dampyr.rig.simulation.simulator import Simulator


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("stuck-encoder@12.5s for 3s", FaultSpec("stuck-encoder", 12.5, 3.0)),
        ("lost-bytes=0.25 @ 2 s", FaultSpec("lost-bytes", 2.0, amount=0.25)),
        ("broken-cell=-10V@100ms for 50ms", FaultSpec("broken-cell", 0.1, 0.05, -10.0)),
        (" hot-specimen @3 ", FaultSpec("hot-specimen", 3.0, amount=60.0)),
    ],
)
def test_faults_are_read_and_written_as_typed(text: str, fault: FaultSpec) -> None:
    assert FaultSpec.parse(text) == fault
    assert FaultSpec.parse(str(fault)) == fault


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("stuck-encoder", "cannot be read"), ("stuck-encodr@1s", "did you mean 'stuck-encoder'"),
        ("stuck-encoder@-1s", "0 s or later"), ("stuck-encoder@1s for 0s", "more than 0 s"),
        ("stuck-encoder@1mm", "does not measure"), ("stuck-encoder=3@1s", "takes no number"),
        ("lost-bytes=1.5@1s", "at most 1"), ("lost-bytes=-0.1@1s", "0 or more"), ("broken-cell=11@1s", "at most 10"),
        ("", "cannot be read"), ("@1s", "cannot be read"), ("lost-bytes@1s for", "1s for"),
    ],
)  # fmt: skip
def test_a_wrong_fault_is_one_sentence(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words) as problem:
        FaultSpec.parse(text)
    assert "\n" not in str(problem.value)


def moving(fault: str, seconds: float = 3.0) -> tuple[Simulator, Host, np.ndarray, np.ndarray]:
    """A table that follows a sine while something happens."""
    made, host = rig(None, fault)
    host.arm()
    made.write(0.8712)
    points = sine(0.008, 1.0, round(seconds), 0.01)
    host.sent = 0
    host.feed(points)
    host.done(Request.FOLLOW, 10, len(points))
    made.start(1000.0)
    volts, counts = [], []
    for _ in range(round(seconds / 0.04)):
        v, c = made.read(40)
        volts.append(v[0])
        counts.append(c)
        if made.twin.state == State.FOLLOWING:
            host.feed(points)
        else:
            host.wait()
    return made, host, np.concatenate(volts), np.concatenate(counts)


def test_a_stuck_encoder_of_the_uno_is_a_following_fault_or_a_stall() -> None:
    made, _, _, counts = moving("stuck-encoder-uno@1s for 9s")
    assert made.twin.state == State.FAULT
    assert made.twin.faults & (Fault.FOLLOWING | Fault.STALL)
    assert made.at_rest_since < 1.1
    assert 5 < np.ptp(counts[1000:]) < 400  # the board still saw it move, 2 mm at most


def test_a_stuck_encoder_of_the_board_shows_no_motion_and_is_behind_afterwards() -> None:
    made, _, _, counts = moving("stuck-encoder-board@1s for 0.53s")
    assert made.twin.state in (State.FOLLOWING, State.ARMED)
    assert np.ptp(counts[960:1489]) == 0
    true = np.floor(made.plant[plant.Y_X] / 5e-6)
    assert abs(counts[-1] - true) > 50


def test_a_stuck_encoder_hides_from_both() -> None:
    made, _, _, counts = moving("stuck-encoder@1s for 9s")
    assert made.twin.state == State.FAULT
    assert np.ptp(counts[1000:]) == 0


def test_a_glitching_encoder_is_seen() -> None:
    made, _, _, _ = moving("glitching-encoder@1s for 2ms")
    assert made.twin.faults == Fault.ENCODER


def test_a_broken_cell_floats_and_comes_back() -> None:
    _, _, volts, _ = moving("broken-cell=10@1s for 0.5s")
    lost = np.flatnonzero(volts > 9.9)
    assert lost.size == 500
    assert np.abs(volts[lost[-1] + 1 :]).max() < 1.0
    assert np.all(volts[lost] == 10.0 - 20.0 / 65536)


def test_a_drifting_cell_drifts_by_its_rate() -> None:
    _, _, drifted, _ = moving("drifting-cell=100@1s")
    _, _, plain, _ = moving("drifting-cell=0@1s")
    shift = (drifted - plain) * 613.0
    assert np.abs(shift[:900]).max() == 0.0
    slope = np.polyfit(np.arange(1500) / 1000.0, shift[1000:2500], 1)[0]
    assert slope == pytest.approx(100.0, rel=0.01)


def test_a_gain_of_the_cell_changes_what_is_shown_in_proportion() -> None:
    _, _, changed, _ = moving("cell-gain=0.9@1s")
    _, _, plain, _ = moving("cell-gain=1@1s")
    assert np.array_equal(changed[:850], plain[:850])
    assert changed[1000:] == pytest.approx(0.9 * plain[1000:], abs=4e-4)


def test_a_slow_cell_is_late_and_its_noise_small() -> None:
    _, _, slow, _ = moving("cell-slow=20Hz@1s")
    _, _, plain, _ = moving("cell-slow=1kHz@1s")
    late = [float(np.mean((slow[1500:2700] - plain[1500 - k : 2700 - k]) ** 2)) for k in range(16)]
    assert int(np.argmin(late)) == pytest.approx(8, abs=2)  # ms: 1/(2 pi 20 Hz)
    fast, usual = (np.std(np.diff(volts[1500:2700], 2)) for volts in (slow, plain))
    assert fast < 0.3 * usual


@pytest.mark.parametrize(("fault", "volts"), [("supply-gain=0.8@1s", 0.8 * 0.8712), ("supply-stuck@1s", 0.8712)])
def test_a_supply_gives_another_voltage_than_it_is_commanded(fault: str, volts: float) -> None:
    made, _, _, _ = moving(fault)
    assert made.truth.voltage[-1] == pytest.approx(volts, abs=1e-3)
    made.write(0.0)
    made.run_unattended(0.01)
    assert made.truth.voltage[-1] == pytest.approx(volts if "stuck" in fault else 0.0, abs=1e-3)
    made.run_unattended(0.3)  # the host is silent: the enable line cuts the coil, whatever the supply does
    assert made.truth.voltage[-1] == 0.0


def test_a_stalled_motor_is_a_fault() -> None:
    made, _, _, _ = moving("stalled-motor@0.9s")
    assert made.twin.faults & (Fault.STALL | Fault.FOLLOWING)
    assert made.at_rest_since == pytest.approx(0.901, abs=2e-3)


def test_a_hot_specimen_is_hot_at_once_and_the_channel_says_so() -> None:
    from dataclasses import replace

    base = RigSettings()
    made, host = rig(replace(base, wires=replace(base.wires, temperature="ai1")), "hot-specimen=45@0.5s")
    host.arm()
    made.start(1000.0)
    volts, _ = made.read(1000)
    assert volts.shape == (2, 1000)
    assert volts[1, 300] == pytest.approx(0.20, abs=2e-3)
    assert volts[1, -1] == pytest.approx(0.65, abs=2e-3)


@pytest.mark.parametrize(
    ("fault", "code"), [("board-timeout@0.2s for 1s", TIMEOUT), ("board-overrun@0.2s for 1s", OVERRUN)]
)
def test_the_board_gives_its_errors(fault: str, code: int) -> None:
    made, _ = rig(None, fault)
    made.start(1000.0)
    made.read(150)
    with pytest.raises(BoardError, match=str(code)) as problem:
        made.read(150)
    assert problem.value.code == code


def test_samples_that_nobody_reads_overrun_the_buffer() -> None:
    made, _ = rig()
    made.start(1000.0)
    made.run_unattended(9.0)
    assert made.read(1000)[1].size == 1000
    made.run_unattended(5.0)
    with pytest.raises(BoardError, match="-200279"):
        made.read(40)


def test_late_samples_are_late() -> None:
    made, _ = rig(None, "late-samples=0.7@0.1s for 0.1s")
    waited: list[float] = []
    made.delay_read = waited.append
    made.start(1000.0)
    for _ in range(8):
        made.read(40)
    assert waited == [0.7, 0.7]


def test_an_unplugged_serial_wire_says_nothing_and_the_watchdog_acts() -> None:
    made, host = rig(None, "unplugged-serial@1s")
    host.arm()
    host.done(Request.JOG, 400, 500)
    made.run_unattended(1.0 - made.time)
    assert made.serial(b"\1\2\3\0") == b""
    made.run_unattended(0.3)
    assert made.twin.faults == Fault.HEARTBEAT


def test_lost_bytes_lose_about_so_many_replies() -> None:
    made, host = rig(None, "lost-bytes=0.02@0.5s")
    host.arm()
    made.run_unattended(0.6)
    replies = []
    for k in range(400):
        replies.append(bool(host.reader.feed(made.serial(encode(SerialFrame(Request.STOP, k % 256, ()))))))
    assert 0.6 < np.mean(replies) < 0.95
    assert made.twin.reader.bad > 5


def test_a_restarted_uno_says_so_and_the_coil_dies() -> None:
    made, host = rig(None, "restarted-uno@0.5s")
    host.arm()
    made.write(2.0)
    made.start(1000.0)
    for _ in range(11):
        made.read(40)
        host.wait()
    made.read(80)
    assert made.twin.faults == Fault.RESTARTED
    assert not made.twin.enabled
    host.ask(Request.HELLO, 3)
    assert not host.beat.homed
    made.read(100)
    assert 0.5 < made.coil_dead_since < 0.56


def test_every_kind_does_something() -> None:
    """A kind of the table that no code looks at would be a fault that never comes."""
    from pathlib import Path

    source = Path(__import__("dampyr.rig.simulation.simulator", fromlist=["x"]).__file__).read_text("utf-8")
    assert [kind for kind in KINDS if f'"{kind}"' not in source] == []


def test_a_killed_host_leaves_a_dead_coil_and_a_table_at_rest_within_300_ms() -> None:
    made, host = rig()
    host.arm()
    made.write(3.212)
    points = sine(0.010, 1.0, 20, 0.01)
    host.feed(points)
    host.done(Request.FOLLOW, 10, len(points))
    made.start(1000.0)
    for _ in range(60):
        made.read(40)
        host.feed(points)
    killed = made.time
    made.run_unattended(1.0)
    assert made.twin.faults == Fault.HEARTBEAT
    assert made.at_rest_since - killed < 0.3
    assert made.coil_dead_since - killed < 0.3
    assert made.command == pytest.approx(3.212, abs=2e-4)  # the board holds its last value


def test_an_orderly_stop_rests_within_100_ms() -> None:
    made, host = rig()
    host.arm()
    points = sine(0.010, 1.2, 20, 0.01)
    made.write(0.0)
    follow(made, host, points[:250])
    host.sent = 0
    here = host.beat.position
    host.feed(here + points)
    host.done(Request.FOLLOW, 10, len(points))
    made.start(1000.0)
    for _ in range(40):
        made.read(40)
        host.feed(here + points)
        if made.time > 1 and abs(made.plant[plant.Y_V]) > 0.06:
            break
    stopped = made.time
    host.done(Request.STOP)
    made.read(200)
    assert made.at_rest_since - stopped < 0.1
    assert made.twin.state == State.FAULT if made.twin.faults else made.twin.state == State.ARMED


def test_a_swapped_encoder_counts_the_other_way() -> None:
    made, _, _, counts = moving("swapped-encoder@0s")
    assert made.twin.faults & Fault.DIRECTION
    assert np.abs(made.truth.position).max() < 5e-4
    assert np.ptp(counts) < 100


def test_a_slipped_encoder_is_off_by_so_much() -> None:
    made, _, _, counts = moving("slipped-encoder=0.3mm@0.2s", 1.0)
    true = np.floor(made.plant[plant.Y_X] / 5e-6)
    assert counts[-1] - true == pytest.approx(60, abs=1)


def test_an_inverted_cell_has_the_other_sign() -> None:
    _, _, inverted, _ = moving("inverted-cell@1s", 2.0)
    _, _, plain, _ = moving("drifting-cell=0@1s", 2.0)
    np.testing.assert_allclose(inverted[1000:], -plain[1000:], atol=4 * 2 * 0.4 / 613.0 + 3e-4)
    np.testing.assert_array_equal(inverted[:950], plain[:950])


def test_an_emergency_stop_cuts_motor_and_coil_by_itself() -> None:
    from dataclasses import replace

    base = RigSettings()
    made, host = rig(replace(base, wires=replace(base.wires, emergency_stop=True)), "emergency-stop@0.5s for 1s")
    host.arm(limits=(*LIMITS[:6], 0, *LIMITS[7:]))  # firmware that does not look
    made.write(2.0)
    host.done(Request.JOG, 2000, 500)
    while made.time < 0.6:
        host.wait()
    truth = made.truth
    assert np.all(truth.voltage[truth.time > 0.5005] == 0.0)
    assert np.abs(truth.speed[truth.time > 0.4]).max() > 0.005
    assert np.abs(truth.speed[truth.time > 0.55]).max() == 0.0


def test_the_damper_has_stops() -> None:
    made, host = rig(position=0.0365)
    host.arm(7300, (-9000, 9000, *LIMITS[2:]))
    for _ in range(8):
        if made.twin.state != State.FAULT:
            host.done(Request.JOG, 1000, 500)
        made.run_unattended(0.1)
        host.wait()
    assert 0.037 < made.truth.position.max() < 0.0375  # 4 kN
