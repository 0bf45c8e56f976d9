"""Travel has ends, homed or not, from wherever the table stands; and the encoder's index is looked at again and again."""

# ruff: noqa: PT012, PT017 - a fault may end a motion in any of its blocks

from __future__ import annotations

import numpy as np
import pytest
from tests.rig.table import begin_fault, host, settings, standing_at, strokes
from tests.rig.wires.process import over_wires_here

from dampyr.errors import RigFault
from dampyr.rig import Drive, DutyReversals
from dampyr.rig.session import ArmedRig
from dampyr.rig.simulation.simulator import Simulator

STOP = 0.037  # m: the damper's
CONTACT = 1.5e-4  # m that its stop gives under the 800 N of a slow motor
PLACES = [-0.0369, -0.005, 0.003, 0.0369]
MORE_PLACES = [-0.036, 0.019, 0.036]
ALL_OTHERS = [-0.030, -0.020, 0.0, 0.018, 0.020, 0.025]


def check_within(simulator: Simulator, switches: bool = False, speed: float = 0.005) -> None:
    """The table has never been farther than its ends, never fast, and never pushed hard."""
    truth = simulator.truth
    begin = np.abs(truth.position[0])
    assert np.abs(truth.position).max() <= max(begin, 0.03675 + 6e-5 if switches else STOP + CONTACT)
    assert np.abs(truth.speed).max() <= speed
    assert np.abs(truth.force).max() <= 1000.0


@pytest.mark.parametrize("switches", [False, pytest.param(True, marks=pytest.mark.prove)])
@pytest.mark.parametrize(
    "position",
    [
        *PLACES,
        *(pytest.param(place, marks=pytest.mark.prove) for place in MORE_PLACES),
        *(pytest.param(place, marks=pytest.mark.by_hand) for place in ALL_OTHERS),
    ],
)
def test_homing_from_anywhere_stays_within_the_stroke(position: float, switches: bool) -> None:
    rig, simulator = standing_at(position, rig=settings(switches))
    with rig.armed() as table:
        table.home()
        assert table.position == pytest.approx(simulator.truth.position[-1], abs=1.1e-5)
    check_within(simulator, switches)
    with rig.armed() as table:
        table.go(-0.010)
        assert simulator.truth.position[-1] == pytest.approx(-0.010, abs=1e-4)


@pytest.mark.parametrize(
    ("position", "way"),
    [
        (-0.036, -1),
        (0.030, 1),
        pytest.param(0.0, -1, marks=pytest.mark.prove),
        *(pytest.param(*case, marks=pytest.mark.by_hand) for case in ((-0.036, 1), (0.0, 1), (0.030, -1))),
    ],
)
@pytest.mark.parametrize("switches", [False, True])
def test_jogging_a_table_that_is_not_homed_ends_at_the_stroke(position: float, way: int, switches: bool) -> None:
    rig, simulator = standing_at(position, rig=settings(switches))

    def jog(table: ArmedRig) -> None:
        for _ in range(100):
            table.jog(way * 0.002, 0.5, wait=False)
            table.rest(0.44)

    with pytest.raises(RigFault) as raised, rig.armed() as table:
        jog(table)
    assert raised.value.ring == "firmware"
    assert ("end switch" if switches else "nothing moved") in str(raised.value)
    check_within(simulator, switches)
    with rig.armed() as table:  # and back it goes
        table.home()


@pytest.mark.parametrize("stalled", [0.05, 0.1, 0.15, 0.19, 0.3, 0.45])
@pytest.mark.parametrize("position", [-0.02, 0.03])
def test_a_motor_that_comes_free_stays_slow(position: float, stalled: float) -> None:
    rig, simulator = standing_at(position)
    with rig.armed() as table:
        table.jog(0.002, 0.5, wait=False)
        table.rest(0.12)
        begin_fault(simulator, f"stalled-motor@now for {stalled:g}s")
        try:
            for _ in range(4):
                table.jog(0.002, 0.5, wait=False)
                table.rest(0.4)
        except RigFault as problem:
            assert "nothing moved" in str(problem) or "too fast" in str(problem)
    assert np.abs(simulator.truth.speed).max() <= 0.006


@pytest.mark.parametrize("fault", ["stuck-encoder", "stuck-encoder-uno", "swapped-encoder"])
@pytest.mark.parametrize("how", ["home", "jog"])
@pytest.mark.parametrize("position", [-0.030, 0.0, 0.034])
def test_an_encoder_that_is_dead_or_swapped_ends_a_slow_motion_within_millimetres(
    position: float, how: str, fault: str
) -> None:
    rig, simulator = standing_at(position, f"{fault}@0s")

    def move(table: ArmedRig) -> None:
        if how == "home":
            table.home()
        for _ in range(5):
            table.jog(0.002, 0.5, wait=False)
            table.rest(0.4)

    with pytest.raises(RigFault) as raised, rig.armed() as table:
        move(table)
    assert any(words in str(raised.value) for words in ("nothing moved", "swapped", "speed"))  # which the board sees
    moved = np.abs(simulator.truth.position - position).max()
    assert moved < (5e-4 if fault == "swapped-encoder" else 2.5e-3)
    assert np.abs(simulator.truth.speed).max() < 0.017


@pytest.mark.parametrize("here", [True, False])
def test_a_swapped_encoder_of_a_table_that_was_homed_by_hand_ends_its_first_motion(here: bool) -> None:
    rig, simulator = standing_at(0.004, "swapped-encoder@0s")
    with pytest.raises(RigFault, match="swapped"), rig.armed() as table:
        table.home(here=here)
        table.go(0.010)
    assert np.abs(simulator.truth.position - 0.004).max() < 1e-3


@pytest.mark.parametrize("speed", [0.001, 0.01, 0.06])
def test_a_dead_encoder_in_a_test_ends_it_within_its_stop(speed: float) -> None:
    """Towards the end of the stroke, the worst place."""
    rig, simulator = standing_at(0.0, rig=settings(switches=True))
    with pytest.raises(RigFault), rig.armed() as table:
        table.home()
        table.go(0.030 if speed < 0.05 else 0.0)
        begin, end = table.position, 0.036
        n = round((end - begin) / speed / 0.01) + 1
        path = np.linspace(begin, end, n)
        for k, _ in enumerate(table.play(Drive(0.01, path, np.zeros(n)))):
            if k == 8:
                begin_fault(simulator, "stuck-encoder@now")
    assert np.abs(simulator.truth.position).max() < STOP
    assert not simulator.twin.enabled


def test_at_full_speed_the_limit_is_a_braking_path_before_the_stop() -> None:
    rig, simulator = standing_at(-0.010)
    rest = np.zeros(500)
    with pytest.raises(RigFault, match="the upper end of the stroke"), rig.armed() as table:
        table.home()
        table.go(-0.020)
        for _ in table.play(Drive(0.01, rest, rest, reversals=DutyReversals(1.0, 3.0, 0.0, 1))):
            pass
    assert np.abs(simulator.truth.speed).max() > 0.06
    assert simulator.truth.position.max() < STOP


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("out", [0.0002, 0.0004])
def test_a_table_outside_of_its_limits_comes_back(side: int, out: float) -> None:
    """Such as after braking from full speed at the end of the stroke."""
    rig, simulator = standing_at(0.0)
    with rig.armed() as table:
        table.home()
        table.go(side * 0.030)
    travel = rig.settings.travel
    simulator.plant[[0, 2]] += side * (travel - 0.030 + out)  # somebody turned the screw: both counters saw it
    simulator.run_unattended(0.1)
    with rig.armed() as table:
        assert table.loop.status.outside
        before = simulator.time
        table.go(side * 0.020)
        truth = simulator.truth
        assert simulator.truth.position[-1] == pytest.approx(side * 0.020, abs=1e-4)
    outside = np.abs(truth.position[truth.time > before]) > travel
    assert np.abs(truth.speed[truth.time > before][outside]).max() <= 0.005
    with rig.armed() as table:
        assert not table.loop.status.outside


def test_an_emergency_stop_ends_everything_and_is_said_by_name() -> None:
    rig, simulator = standing_at(0.002, rig=settings(stop=True))
    with pytest.raises(RigFault, match="the emergency stop was pressed"), rig.armed() as table:
        table.home()
        begin_fault(simulator, "emergency-stop@now for 3s")
        table.go(0.010)
    with pytest.raises(RigFault, match="the emergency stop is pressed, or its wire is broken; release it"), rig.armed():
        pass
    simulator.run_unattended(3.0)
    with rig.armed() as table:
        assert table.homed
        table.go(-0.005)


# the index


@pytest.mark.parametrize(
    "place", [pytest.param(-0.020, marks=pytest.mark.by_hand), 0.004, pytest.param(0.030, marks=pytest.mark.prove)]
)
@pytest.mark.parametrize(
    "counts", [3, pytest.param(20, marks=pytest.mark.prove), pytest.param(-3, marks=pytest.mark.prove), -100]
)
def test_a_slip_of_the_encoder_ends_the_test_at_the_next_pass(place: float, counts: int) -> None:
    rig, simulator = standing_at(place)
    with rig.armed() as table:
        table.home()
    with pytest.raises(RigFault, match=r"index was not where homing put it|count leapt farther"), rig.armed() as table:
        table.go(0.0)
        for k, _ in enumerate(table.play(strokes())):
            if k == 35:
                begin_fault(simulator, f"slipped-encoder={counts * 5e-6:g}m@now")
    with rig.armed() as table:
        assert not table.homed
        table.home()
        assert table.position == pytest.approx(simulator.truth.position[-1], abs=1.1e-5)


def test_two_counts_are_none() -> None:
    rig, simulator = standing_at(0.010)
    with rig.armed() as table:
        table.home()
        table.go(0.0)
        begin_fault(simulator, "slipped-encoder=10um@now")
        for _ in table.play(strokes()):
            pass
        assert table.loop.status.index_shift == 2


def test_counts_that_are_lost_after_the_last_pass_are_seen_before_the_test_is_complete() -> None:
    rig, simulator = standing_at(-0.010)
    with rig.armed() as table:
        table.home()
        table.go(0.0)
        for k, _ in enumerate(table.play(strokes())):
            if k == 70:  # in the last quarter
                begin_fault(simulator, "slipped-encoder=0.2mm@now")
        with pytest.raises(RigFault, match="index"):
            table.verify_index()


@pytest.mark.parametrize(
    ("place", "slip", "new"),
    [
        (-0.005, 0.3, False),
        (0.008, -5.0, True),
        *(
            pytest.param(*case, marks=pytest.mark.prove)
            for case in (
                (-0.005, 1.7, False), (0.008, -0.3, False), (0.008, -5.0, False),
                (-0.005, 0.3, True), (-0.005, 1.7, True), (0.008, -0.3, True),
            )
        ),
    ],
)  # fmt: skip
def test_an_index_that_is_passed_nowhere_is_no_index_in_its_place(place: float, slip: float, new: bool) -> None:
    """More than the little way over which it is looked for; a new host does not know where it was passed."""
    rig, simulator = standing_at(-0.010)
    with rig.armed() as table:
        table.home()
        table.go(place)
    begin_fault(simulator, f"slipped-encoder={slip:g}mm@now")
    simulator.run_unattended(0.1)
    rig = host(simulator) if new else rig
    with rig.armed() as table:
        with pytest.raises(RigFault, match=r"index was not passed where homing put it.*home the table again"):
            table.verify_index()
        assert not table.homed
    with host(simulator).armed() as table:
        assert not table.homed
        table.home()
        table.verify_index()
        assert table.position == pytest.approx(simulator.truth.position[-1], abs=1.1e-5)


def test_a_table_that_was_homed_by_hand_has_no_index_to_verify_until_it_is_passed() -> None:
    rig, _ = standing_at(0.009)
    with rig.armed() as table:
        table.home(here=True)
        before = table.position
        table.verify_index()
        assert table.position == before
        table.go(-0.010)
        table.verify_index()
        assert table.position == pytest.approx(-0.007, abs=3e-4)


@pytest.mark.parametrize("place", [-0.030, 0.0, 0.00195, 0.002, 0.00205, 0.025])
def test_verifying_the_index_passes_it_from_wherever_the_table_stands(place: float) -> None:
    rig, _ = standing_at(0.001)
    with rig.armed() as table:
        table.home()
        table.go(place)
        before = table.loop.status.index_passes
        table.verify_index()
        assert table.loop.status.index_passes > before


@pytest.mark.prove
def test_a_rig_over_the_wires_latches_the_index() -> None:
    with over_wires_here(faults=["slipped-encoder=0.1mm@8s"]) as rig, rig.armed() as table:
        table.home()
        table.go(0.0)
        seen = []
        with pytest.raises(RigFault, match="index"):
            for _ in range(4):
                for block, _ in table.play(strokes()):
                    seen += block.index.tolist()
    assert seen[:3] == [400, 400, 400]
