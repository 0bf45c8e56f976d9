"""The door for energy: however its block ends, the coil is dead and the table at rest; each safety layer acts alone."""

from dataclasses import replace

import numpy as np
import pytest
from tests.endurance import Endurance
from tests.rig.drives import made, played, ramp, sine
from tests.rig.simulation.driver import PROMPT
from tests.rig.wires.process import over_wires_here

from dampyr import campaigns
from dampyr.errors import InputError, RigFault
from dampyr.rig import Drive, DutyReversals, Rig, RigSettings, simulated
from dampyr.rig.firmware.protocol import State
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import InProcess
from dampyr.rig.instruments.ni_daqmx.simulated import InProcessBoard
from dampyr.rig.interlock import APART, Samples
from dampyr.rig.session import ArmedRig
from dampyr.rig.simulation.simulator import Simulator, parse_faults

SOON = 0.100  # s of simulated time


def one_way(seconds: float) -> Drive:
    """Set points cannot leave the stroke: the firmware refuses them. A duty can."""
    rest = np.zeros(round(seconds / 0.01))
    return Drive(0.01, rest, rest, reversals=DutyReversals(0.5, seconds, 0.0, 1))


def check_safe(simulator: Simulator, since: float) -> None:
    """0 V at the coil and the table at rest within `SOON`; the current follows with the coil's time constant."""
    simulator.run_unattended(SOON)
    truth = simulator.truth
    after = truth.time > since + SOON
    assert np.all(truth.voltage[truth.time > since + 0.005] == 0.0)
    assert np.all(np.abs(truth.speed[after]) < 1e-6)
    assert simulator.at_rest_since <= since + SOON
    assert not simulator.twin.enabled


@pytest.mark.parametrize("ends", [None, KeyboardInterrupt, ValueError, SystemExit])
def test_however_the_block_ends_it_is_safe(ready: tuple[Rig, Simulator], ends: type[BaseException] | None) -> None:
    rig, simulator = ready
    since = 0.0

    def run() -> None:
        nonlocal since
        with rig.armed() as table:
            for k, (block, _) in enumerate(table.play(sine(0.012, 0.9, 6.0))):
                if k > 40 and abs(block.status.speed) > 8000:
                    since = simulator.time
                    if ends:
                        raise ends
                    return

    if ends:
        with pytest.raises(ends):
            run()
    else:
        run()
    assert since > 0.0
    check_safe(simulator, since)


def test_abort_brakes_and_whoever_waits_is_told(ready: tuple[Rig, Simulator]) -> None:
    rig, simulator = ready
    since = 0.0

    def press(k: int, table: ArmedRig, _: Samples) -> None:
        nonlocal since
        if k == 60:
            since = simulator.time
            table.abort("by the operator")

    with pytest.raises(RigFault, match="aborted: by the operator") as caught:
        played(rig, sine(0.012, 0.9, 6.0), press)
    assert caught.value.ring == "operator"
    check_safe(simulator, since)


def test_leaving_goes_on_where_a_step_fails(ready: tuple[Rig, Simulator], monkeypatch: pytest.MonkeyPatch) -> None:
    rig, simulator = ready
    monkeypatch.setattr(rig.uno, "stop", lambda: (_ for _ in ()).throw(RigFault("the cable is out")))
    since = 0.0

    def fail(k: int, *_: object) -> None:
        nonlocal since
        if k == 60:
            since = simulator.time
            raise ValueError("mine")

    with pytest.raises(ValueError, match="mine") as caught:
        played(rig, sine(0.012, 0.9, 6.0), fail)
    assert any("the cable is out" in note for note in caught.value.__notes__)
    check_safe(simulator, since)


# layer 1: the firmware, with the interlock off and no check; layer 2 is in test_interlock.py


def test_ring_one_alone_the_stroke() -> None:
    rig, simulator = made(interlocked=False)
    with pytest.raises(RigFault, match="the upper end of the stroke") as caught:
        played(rig, one_way(5.0))
    assert caught.value.ring == "firmware"
    assert simulator.truth.position.max() < 0.037  # the damper's stop: the limit is the path of braking before


def test_ring_one_alone_a_silent_host() -> None:
    rig, simulator = made(interlocked=False)
    since = 0.0

    def fall_silent(k: int, _: ArmedRig, block: Samples) -> None:
        nonlocal since
        if k > 40 and abs(block.status.speed) > 8000:
            since = simulator.time
            simulator.run_unattended(0.5)

    with pytest.raises(RigFault, match="the host was silent for too long"):
        played(rig, sine(0.012, 0.9, 6.0), fall_silent)
    truth = simulator.truth
    assert simulator.twin.state is State.FAULT  # until a host clears it
    assert np.all(truth.voltage[truth.time > since + 0.201] == 0.0)
    assert simulator.at_rest_since < since + 0.300


def test_ring_one_refuses_set_points_beyond_the_stroke() -> None:
    rig, _ = made(interlocked=False)
    with pytest.raises(RigFault, match="the Uno refused SETPOINTS: a value is out of range") as caught:
        played(rig, ramp(0.045, 4.0))
    assert caught.value.ring == "firmware"


@pytest.mark.parametrize("place", [0.0365, pytest.param(-0.05, marks=pytest.mark.prove), float("nan")])
def test_a_place_outside_of_the_travel_is_a_wrong_argument(ready: tuple[Rig, Simulator], place: float) -> None:
    rig, simulator = ready
    with rig.armed() as table:
        before = simulator.time
        with pytest.raises(
            InputError, match=r"displacement = .* mm is not allowed; the table goes from -36\.3 mm to 36\.3 mm"
        ):
            table.go(place)
        assert simulator.time == before
        for end in (0.0363, -0.0363):
            table.go(end)


def test_a_table_that_is_not_homed_goes_nowhere() -> None:
    rig, _ = made()
    with rig.armed() as table:
        with pytest.raises(InputError, match=r"not homed.*home the table first"):
            table.go(0.0)
        with pytest.raises(RigFault, match="refused JOG: its encoder is not homed; home the table first"):
            table.jog(0.003)


@pytest.mark.parametrize("speed", [0.121, -1.0, float("nan")])
def test_a_jog_that_is_too_fast_is_a_wrong_argument(ready: tuple[Rig, Simulator], speed: float) -> None:
    rig, _ = ready
    with rig.armed() as table, pytest.raises(InputError, match="a jog has at most 120 mm/s"):
        table.jog(speed)


# layer 3: the check, with no rig at all


def test_ring_three_alone() -> None:
    settings = {"step": [{"kind": "sine", "amplitude": "20 mm", "frequency": "2 Hz"}]}
    plan = campaigns.plan(campaigns.campaign_of(settings), RigSettings())
    assert "needs 251.3 mm/s, the actuator gives" in plan.refusals[0]
    rig, simulator = made()
    with pytest.raises(InputError, match=r"needs 251\.3 mm/s"):
        campaigns.perform(campaigns.campaign_of(settings), rig, "nowhere")
    assert simulator.time == 0.0


# what else a table does


def test_the_table_goes_home_by_its_index(ready: tuple[Rig, Simulator]) -> None:
    rig, simulator = ready
    with rig.armed() as table:
        assert table.homed
        table.go(0.010)
        assert simulator.truth.position[-1] == pytest.approx(0.010, abs=1e-4)
        assert table.position == pytest.approx(simulator.truth.position[-1], abs=6e-6)


def test_a_jog_lasts_as_long_as_it_is_asked_for(ready: tuple[Rig, Simulator]) -> None:
    rig, simulator = ready
    with rig.armed() as table:
        before = table.position
        table.jog(0.005, 0.3)
        assert table.position - before == pytest.approx(0.0015, abs=3e-4)
        assert not np.isnan(simulator.at_rest_since)
        with pytest.raises(InputError, match=r"seconds = 2 is not allowed; a jog lasts at most 0\.5 s"):
            table.jog(0.005, 2.0)


def test_a_coil_too_warm_for_its_supply_is_told() -> None:
    rig, _ = made()
    rig.warmth.temperature = 60.0
    with pytest.raises(RigFault, match=r"the coil at 60 degC needs 4\.6"):
        played(rig, Drive(0.01, np.zeros(300), np.full(300, 4.0)))


def test_lost_bytes_are_asked_for_again() -> None:
    rig, _ = made("lost-bytes=0.002@3s for 4s")
    played(rig, sine(0.005, 1.0, 4.0))
    assert rig.uno.bad_frames > 0


def test_the_real_wires_give_what_the_plant_gives() -> None:
    """Lockstep over TCP and gRPC: the same samples as in this process."""

    def samples(table: ArmedRig) -> list[float]:
        return [float(v) for block, selected in table.play(sine(0.005, 1.0, 3.0)) for v in block.force[selected]]

    forces = []
    for connect in (simulated, over_wires_here):
        with connect(seed=3) as rig, rig.armed() as table:
            table.home()
            table.go(0.0)
            forces.append(samples(table))
    np.testing.assert_array_equal(*forces)


# one rig over many runs, wherever its table stands


def host(simulator: Simulator) -> Rig:
    """A host that connects anew to a rig that runs on."""
    return Rig(simulator.settings, Uno(InProcess(simulator.serial)), InProcessBoard(simulator), threaded=False)


def standing_at(position: float, *faults: str, settings: RigSettings | None = None) -> tuple[Rig, Simulator]:
    simulator = Simulator(settings or RigSettings(), faults=parse_faults(faults), position=position)
    return host(simulator), simulator


def check_aligned(table: ArmedRig, simulator: Simulator, middle: float = 0.0) -> None:
    """Where the board and the Uno say that the table is, it is."""
    block = next(table.loop.blocks())
    true = float(simulator.truth.position[-1]) - middle
    assert block.displacement[-1] == pytest.approx(true, abs=1.1e-5)
    assert table.position == pytest.approx(true, abs=1.1e-5)


def moved(rig: Rig, simulator: Simulator, to: float) -> None:
    with rig.armed() as table:
        check_aligned(table, simulator)
        table.go(to)
        check_aligned(table, simulator)


@pytest.mark.parametrize(
    "position",
    [-0.0011, 0.003, *(pytest.param(far, marks=pytest.mark.prove) for far in (-0.0175, -0.005, 0.018))],
)
def test_a_table_is_homed_from_where_it_stands_and_armed_again_where_it_was_left(position: float) -> None:
    rig, simulator = standing_at(position)
    with rig.armed() as table:
        table.home()
        assert table.homed
        check_aligned(table, simulator)
        table.go(0.005)
    for to in (-0.012, 0.030, 0.0):
        moved(rig, simulator, to)
    assert rig.warmth.temperature == pytest.approx(rig.settings.specimen.room, abs=0.1)


def test_a_search_without_an_index_leaves_a_rig_that_can_be_armed() -> None:
    settings = replace(RigSettings(), encoder=replace(RigSettings().encoder, index=0.050))  # beyond the damper's stop
    rig, simulator = standing_at(-0.020, settings=settings)
    with pytest.raises(RigFault, match="no index mark was found"), rig.armed() as table:
        table.home()
    with rig.armed() as table:
        table.home(here=True)
        block = next(table.loop.blocks())
    assert block.displacement[-1] == pytest.approx(0.0, abs=1.1e-5)
    assert abs(simulator.truth.position[-1]) > 0.036
    assert np.abs(simulator.truth.position).max() < 0.0372  # its stops were met at 800 N
    assert np.abs(simulator.truth.force).max() < 1000.0


def test_a_table_is_homed_again_while_it_is_homed() -> None:
    rig, simulator = standing_at(0.015)
    with rig.armed() as table:
        table.home(here=True)
        table.go(0.003)
        table.home(here=True)
        assert abs(next(table.loop.blocks()).displacement[-1]) < 1.1e-5
        table.home()
        check_aligned(table, simulator)


@pytest.mark.parametrize("path", [0.001, -0.002])  # m, too short for the limit of the following error
def test_a_table_that_does_not_arrive_where_it_is_sent_is_a_fault(path: float) -> None:
    rig, simulator = made()
    with rig.armed() as table:
        table.home()
        table.go(0.0)
        simulator.faults = parse_faults([f"stalled-motor@{simulator.time:.3f}s"])
        with pytest.raises(RigFault, match=r"is the motor blocked|look at the motor") as raised:
            table.go(path)
    assert raised.value.ring in ("firmware", "check")
    assert simulator.at_rest_since == pytest.approx(simulator.time, abs=1.0)


@pytest.mark.parametrize("far", [0.0, 0.004, 0.010])
def test_a_rig_is_armed_again_after_an_abort_in_mid_stroke(far: float) -> None:
    rig, simulator = made()

    def press(_: int, table: ArmedRig, block: Samples) -> None:
        if block.displacement[-1] > far and block.status.speed > 2000:
            table.abort()

    with pytest.raises(RigFault, match="aborted"):
        played(rig, sine(0.012, 0.9, 6.0), press)
    moved(rig, simulator, -0.006)


@pytest.mark.parametrize(
    ("kind", "words"),
    [("stalled-motor", "is the motor blocked"), ("board-timeout", "the simulated board gives an error")],
)
def test_a_rig_is_armed_again_after_a_fault_in_mid_stroke(kind: str, words: str) -> None:
    rig, simulator = made()

    def break_down(_: int, __: ArmedRig, block: Samples) -> None:
        if block.displacement[-1] > 0.005 and not simulator.faults:
            simulator.faults = parse_faults([f"{kind}@{simulator.time + 0.001:.3f}s for 0.5s"])

    with pytest.raises(RigFault, match=words):
        played(rig, sine(0.012, 0.9, 8.0), break_down)
    simulator.run_unattended(1.0)
    assert simulator.truth.position[-1] > 0.004
    moved(rig, simulator, 0.002)


def test_a_rig_is_armed_again_after_a_stop_in_mid_stroke() -> None:
    rig, simulator = made()
    with rig.armed() as table:
        table.home()
        table.go(0.0)
        for block, _ in table.play(sine(0.012, 0.9, 6.0)):
            if block.displacement[-1] > 0.005:
                break
        table.stop()
        check_aligned(table, simulator)
    assert abs(simulator.truth.position[-1]) > 0.004
    moved(rig, simulator, -0.006)


def left_armed(simulator: Simulator, to: float) -> Rig:
    """A host that has homed the table and goes nowhere any more: it never leaves its `armed` block."""
    rig = host(simulator)
    rig.uno.hello()
    rig.uno.clear()
    rig.uno.configure(rig.settings)
    table = ArmedRig(rig)
    table.begin()
    table.home()
    table.go(to)
    return rig


def test_a_rig_that_is_armed_while_its_table_still_moves_is_aligned_at_rest() -> None:
    _, simulator = standing_at(0.0, settings=RigSettings(uno=PROMPT))  # or it stood before it is asked
    rig = left_armed(simulator, 0.005)
    rig.uno.jog(-1500, 500)
    simulator.run_unattended(0.1)
    rig.uno.abort()
    rig.uno.clear()
    assert rig.uno.heartbeat().speed != 0
    moved(host(simulator), simulator, -0.006)


def test_another_host_takes_over_a_table_that_is_homed() -> None:
    first, simulator = standing_at(-0.005)
    with first.armed() as table:
        table.home()
        table.go(0.017)
    moved(host(simulator), simulator, -0.020)
    moved(first, simulator, 0.009)


@pytest.mark.filterwarnings("ignore:the Uno was left in state ARMED")
def test_another_host_takes_over_a_rig_that_was_left_armed() -> None:
    _, simulator = standing_at(-0.005)
    left_armed(simulator, 0.017)
    moved(host(simulator), simulator, 0.010)


@pytest.mark.parametrize("which", ["board", "uno"])
@pytest.mark.parametrize("homed_again", [False, pytest.param(True, marks=pytest.mark.prove)])
def test_the_interlock_still_sees_that_the_positions_differ(which: str, homed_again: bool) -> None:
    """The table stands away from the middle when the encoder's line breaks, just before it moves on."""
    rig, simulator = standing_at(0.012)
    with rig.armed() as table:
        table.home()
        table.go(0.012)
    with rig.armed() as table:
        if homed_again:
            table.home()
            table.go(0.012)
        simulator.faults = parse_faults([f"stuck-encoder-{which}@{simulator.time + 0.001:.3f}s"])
        with pytest.raises(RigFault) as caught:
            table.go(0.002)
    assert caught.value.ring == "interlock"
    assert "distance of the board's and the Uno's position" in str(caught.value)
    passed = float(str(caught.value).split("position ")[1].split()[0])
    assert APART < passed < 2 * APART


def broken_off(rig: Rig, table: ArmedRig, what: str, to: float) -> None:
    """A stroke that ends in its middle."""
    simulator, at = rig.board.simulator, table.position
    path = np.linspace(at, np.clip(to, at - 0.02, at + 0.02), 101)
    for k, _ in enumerate(table.play(Drive(0.01, path, np.zeros(101)))):
        if k == 10:
            break
    if what == "stop":
        table.stop()
    elif what == "abort":
        table.abort()
    elif what == "fault":
        table.stop()
        simulator.faults = parse_faults([f"stalled-motor@{simulator.time:.3f}s for 1s"])
        with pytest.raises(RigFault, match="blocked"):
            table.go(table.position - 0.01 * np.sign(table.position))


def in_a_random_order(seed: int, steps: int) -> None:
    """Whatever was done before, the rig can be armed, and knows where its table is."""
    draw = np.random.default_rng(seed)
    rig, simulator = standing_at(float(draw.uniform(-0.017, 0.021)))
    middle = 0.0  # where the Uno's is, from where the damper's is
    with rig.armed() as table:
        table.home()
    for _ in range(steps):
        what = draw.choice(["go", "home", "stop", "abort", "fault", "leave", "host", "here"])
        to = float(draw.uniform(-0.03, 0.03))
        if what == "host":
            rig = host(simulator)
        with rig.armed() as table:
            check_aligned(table, simulator, middle)
            if what == "home" and -0.015 < table.position + middle < 0.015:
                table.home()
                middle = 0.0
            elif what == "here":
                table.go(float(np.clip(-middle + 0.1 * to, -0.036, 0.036)))
                table.home(here=True)
                middle = float(simulator.truth.position[-1])
            elif what == "go":
                table.go(to)
            else:
                broken_off(rig, table, what, to)
            if what not in ("abort", "fault", "leave", "host"):
                check_aligned(table, simulator, middle)
        simulator.run_unattended(1.0 if what == "fault" else 0.0)


@pytest.mark.filterwarnings("ignore:the Uno had stopped by itself")  # a host that comes after a fault
def test_arming_in_a_random_order() -> None:
    for seed in range(2):
        in_a_random_order(seed, 6)


@pytest.mark.prove
@pytest.mark.endure
@pytest.mark.filterwarnings("ignore:the Uno had stopped by itself")  # a host that comes after a fault
def test_arming_in_many_random_orders(endurance: Endurance) -> None:
    count = endurance.count(200, part=100)
    for seed in range(3, 3 + count):
        in_a_random_order(seed, 25)
    endurance.report(
        "a rig is armed, homed, moved, stopped, aborted, left and armed again in random order",
        None,
        f"{count} orders of 25 steps, seeds 3 to {2 + count}; it could always be armed again",
    )


@pytest.mark.prove
def test_a_rig_over_the_wires_is_armed_again_and_again() -> None:
    with over_wires_here() as rig:
        with rig.armed() as table:
            table.home()
            table.go(0.005)
        with rig.armed() as table:
            assert table.position == pytest.approx(0.005, abs=1e-4)
            for k, _ in enumerate(table.play(Drive(0.01, np.linspace(0.005, 0.015, 101), np.zeros(101)))):
                if k == 15:
                    table.abort()
                    break
        with rig.armed() as table:
            assert abs(table.position - 0.005) > 2 * APART
            block = next(table.loop.blocks())
            assert block.displacement[-1] == pytest.approx(table.position, abs=1.1e-5)
            table.go(-0.003)
