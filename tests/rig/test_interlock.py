"""The interlock acts alone: each limit with the firmware's wide open, and what it compares."""

# ruff: noqa: PT012, SIM117 - a fault may end a motion in any of its blocks

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.rig.drives import made, played, ramp, sine
from tests.rig.table import begin_fault, standing_at, strokes

from dampyr.errors import RigFault
from dampyr.rig import Drive, Rig, RigSettings
from dampyr.rig.firmware.protocol import Fault, Request, State, Status
from dampyr.rig.interlock import Interlock, Samples


def block(settings: RigSettings, x: np.ndarray, position: float, speed: float) -> Samples:
    count, n = settings.encoder.count, x.size
    status = Status(
        0, State.FOLLOWING, Fault(0), round(position / count), round(speed / count), 0, True, True, True, 0, 0, 0
    )
    zero, counts = np.zeros(n), np.round(x / count).astype(np.int64)
    return Samples(0, np.arange(n) * 1e-3, x, zero, None, np.zeros((1, n)), counts, zero, status)


@pytest.mark.parametrize(("waiting", "words"), [(0.06, None), (0.17, "age of the samples")])
def test_a_late_host_does_not_blame_the_encoder(waiting: float, words: str | None) -> None:
    """At 60 mm/s the table has moved on by the time at which the Uno is asked."""
    settings = RigSettings()
    x = 0.060 * np.arange(40) * 1e-3
    trip = Interlock(settings).judge(block(settings, x, x[-1] + 0.060 * (waiting + 0.02), 0.060), waiting)
    assert (trip and trip.what) == words


def test_positions_that_differ_are_still_seen() -> None:
    settings = RigSettings()
    trip = Interlock(settings).judge(block(settings, np.zeros(40), 0.0011, 0.0))
    assert trip is not None
    assert trip.what == "distance of the board's and the Uno's position"


def test_the_board_sees_the_index_by_itself() -> None:
    """The Uno is not asked: its fault is left out."""
    from dampyr.rig.firmware import control_core as c

    rig, simulator = standing_at(0.010)
    with pytest.raises(RigFault, match="shift of the encoder's index 30 counts passed its limit of 2 counts") as raised:
        with rig.armed() as table:
            table.home()
            table.go(0.0)
            for k, _ in enumerate(table.play(strokes())):
                simulator.twin.registers[c.R_INDEX_SET] = 0
                if k == 60:
                    begin_fault(simulator, "slipped-encoder=150um@now")
    assert raised.value.ring == "interlock"


def test_a_mark_has_two_edges_and_no_third() -> None:
    guard = Interlock(RigSettings(), index={0: 400})
    for place, shift in ((402, 0), (398, 0), (404, 2), (396, 2), (399, 1), (407, 7), (300, 100)):
        samples = replace(block(RigSettings(), np.zeros(40), 0.0, 0.0), index=np.array([place]))
        assert guard._index_shift(samples) == shift, place


@pytest.mark.parametrize("which", ["board", "uno"])
@pytest.mark.parametrize(
    "ms", [20, pytest.param(40, marks=pytest.mark.prove), pytest.param(100, marks=pytest.mark.prove)]
)
def test_board_and_uno_are_compared_at_each_rest(which: str, ms: int) -> None:
    """Less than the 1 mm by which they may differ in motion, more than 2 counts."""
    rig, simulator = standing_at(0.015)
    with pytest.raises(RigFault, match=r"at rest|distance of the board's") as raised, rig.armed() as table:
        table.home()
        table.go(0.0)
        for k, _ in enumerate(table.play(strokes(amplitude=0.001))):
            if k == 39:  # the table passes its middle at 6 mm/s
                begin_fault(simulator, f"stuck-encoder-{which}@now for {ms}ms")
    assert raised.value.ring == "interlock"


def opened_wide(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    def configure(_: RigSettings) -> None:
        rig.uno._ask(Request.LIMITS, -37000, 37000, 40000, 200, 255, 1000, 0, 255, 0)

    monkeypatch.setattr(rig.uno, "configure", configure)


def tripped(rig: Rig, drive: Drive, monkeypatch: pytest.MonkeyPatch) -> str:
    opened_wide(rig, monkeypatch)
    with pytest.raises(RigFault) as caught:
        played(rig, drive)
    assert caught.value.ring == "interlock", caught.value
    return str(caught.value)


def test_ring_two_alone_the_stroke(monkeypatch: pytest.MonkeyPatch) -> None:
    rig, simulator = made()
    assert "displacement 0.03" in tripped(rig, ramp(0.045, 4.0), monkeypatch)
    assert simulator.truth.position.max() < 0.0405  # a block of 40 ms, and the way to stop


def test_ring_two_alone_the_force(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = replace(RigSettings(), limits=replace(RigSettings().limits, force=400.0))
    rig, _ = made(settings=settings)
    assert "force" in tripped(rig, sine(0.008, 1.0, 5.0, 3.0), monkeypatch)


def test_ring_two_alone_the_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = replace(RigSettings(), limits=replace(RigSettings().limits, speed=0.030))
    rig, _ = made(settings=settings)
    assert "speed" in tripped(rig, sine(0.008, 1.0, 5.0, 0.0), monkeypatch)


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("broken-cell@8s", "load cell signal"),
        ("stuck-encoder-board@8s", "the board's and the Uno's position"),
        ("board-timeout@8s", "the simulated board gives an error"),
    ],
)
def test_ring_two_alone_faults(fault: str, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    rig, _ = made(fault)
    opened_wide(rig, monkeypatch)
    with pytest.raises(RigFault, match=words):
        played(rig, sine(0.010, 1.0, 8.0), times=3)


def test_ring_two_alone_a_measured_temperature(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = replace(RigSettings(), wires=replace(RigSettings().wires, temperature="ai1"))
    rig, _ = made("hot-specimen@8s", settings=settings)
    assert "temperature" in tripped(rig, sine(0.010, 1.0, 12.0), monkeypatch)


def test_ring_two_alone_an_estimated_temperature(monkeypatch: pytest.MonkeyPatch) -> None:
    rig, _ = made()
    rig.warmth.temperature = 71.5
    assert "estimated temperature" in tripped(rig, sine(0.010, 1.0, 12.0, 3.0), monkeypatch)
