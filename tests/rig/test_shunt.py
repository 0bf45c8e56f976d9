"""Shunt across the load cell's bridge: its step is measured at rest, told where it changes, and checked by doctor."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from dampyr import records
from dampyr.campaigns import campaign_of, perform
from dampyr.campaigns.pass_marks import shunt_differs
from dampyr.errors import RigFault
from dampyr.rig import Rig, RigSettings, simulated
from dampyr.rig.diagnosis import _shunt
from dampyr.rig.instruments.ni_daqmx.driver import NiBoard
from dampyr.rig.instruments.separate_supply import SeparatelySupplied
from dampyr.rig.settings_file import write_settings
from dampyr.rig.shunt import ShuntStep, expected_step, slowest_rise, step_of, switch_shunt
from dampyr.rig.uncertainty_budget import Evidence

WIRED = replace(RigSettings(), wires=replace(RigSettings().wires, shunt="port0/line0"))
SINE = {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz", "cycles": 2, "voltage": "1.98 V"}


def test_a_resistor_of_390_kohm_is_a_force_of_562_N() -> None:
    assert expected_step(WIRED) == pytest.approx(562.5, abs=0.1)


@pytest.mark.parametrize("slow", [1e-4, 8e-3])
def test_a_step_has_its_size_and_its_rise(slow: float) -> None:
    t = np.arange(400) / 1000.0
    after = 100.0 + 562.0 * (1.0 - np.exp(-t / slow))
    step = step_of(np.full(300, 100.0), after, 1000.0)
    assert step.force == pytest.approx(562.0, abs=0.1)
    assert step.rise == pytest.approx(2.2 * slow, abs=1.5e-3)


def test_a_reading_without_a_step_rises_never() -> None:
    assert step_of(np.zeros(300), np.zeros(400), 1000.0) == ShuntStep(0.0, np.inf)


def marks_of_steps(*steps: float, rise: float = 1e-3) -> list[str]:
    shunts = tuple(ShuntStep(step, rise) for step in steps)
    return [mark.text for mark in shunt_differs(Evidence(shunts=shunts), WIRED)]


def test_a_step_that_changes_or_is_not_the_expected_one_is_marked() -> None:
    assert shunt_differs(Evidence(), WIRED) == []
    assert marks_of_steps(562.0, 561.0, 563.0) == []
    assert "-2.5% (+-0.7%) in the test" in marks_of_steps(562.0, 562.0, 548.0)[0]
    assert "since the run began" in marks_of_steps(562.0, 548.0, 548.0)[0]
    assert "562.5 N (+-21 N) are expected of 390000 ohm" in marks_of_steps(500.0, 500.0, 500.0)[0]


def test_a_step_that_is_gone_spoils_its_test() -> None:
    (mark,) = shunt_differs(Evidence(shunts=(*2 * (ShuntStep(562.0, 1e-3),), ShuntStep(0.3, np.inf))), WIRED)
    assert mark.spoils


def test_a_step_that_is_slow_is_marked_by_what_is_known_of_the_bandwidth() -> None:
    assert marks_of_steps(562.0, 562.0, 562.0, rise=slowest_rise(WIRED)) == []
    assert "has grown slow" in marks_of_steps(562.0, 562.0, 562.0, rise=0.018)[0]


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("", ""),
        ("cell-gain=0.97@14s", "% (+-0.7%) in the test: the gain"),
        pytest.param("cell-gain=0.9@1s", "are expected of 390000 ohm", marks=pytest.mark.prove),
        pytest.param("cell-slow=20Hz@1s", "takes 18 ms", marks=pytest.mark.prove),
    ],
)
def test_a_campaign_with_a_shunt_tells_what_friction_does_not(tmp_path: Path, fault: str, words: str) -> None:
    """A gain of 3 %, and what was wrong before the run began; a healthy run has no mark."""
    with simulated(WIRED, faults=[fault] if fault else []) as rig:
        perform(campaign_of({"step": [SINE]}), rig, tmp_path / "out")
    (record,) = records.read_campaign(tmp_path / "out")
    assert len(record.marks) == bool(fault)
    assert words in "".join(record.marks)


def test_the_relay_is_off_in_a_record_and_after_a_step_that_was_broken_off() -> None:
    with simulated(WIRED) as rig:
        rig.board.shunt(True)  # as a host that was killed has left it
        use(rig)


def use(rig: Rig) -> None:
    with rig.armed() as table:
        before = np.mean(np.concatenate([block.force for block in table._blocks_for(0.3)]))
        step = table.shunt_step()
        after = np.mean(np.concatenate([block.force for block in table._blocks_for(0.3)]))
        assert before == pytest.approx(rig.board.simulator.truth.force[-1], abs=4.0)
        assert step.force == pytest.approx(562.5, abs=4.0)
        assert after == pytest.approx(before, abs=4.0)
        table.check = stop
        with pytest.raises(RigFault, match="asked for"):
            table.shunt_step()
        assert rig.board.simulator._relay == 0.0


def stop() -> None:
    raise RigFault("it was asked for", "operator")


@pytest.mark.parametrize(
    ("cell", "wired", "repair"),
    [
        ({}, True, None),
        ({"shunt": 300e3}, True, "look at the resistor"),
        ({}, False, "its relay does nothing"),
    ],
)
def test_doctor_compares_the_step_with_the_expected_one(
    cell: dict[str, float], wired: bool, repair: str | None
) -> None:
    believed = replace(WIRED, load_cell=replace(WIRED.load_cell, **cell))
    with simulated(believed, parts=RigSettings()) as rig:
        if not wired:
            rig.board.simulator.settings = RigSettings()
        assert rig.calibration is not None
        check = _shunt(rig, rig.calibration, rig.calibration.force(rig.listen(0.5)[0][0]))
    assert (check.repair is None) == (repair is None)
    assert (repair or "") in (check.repair or "")


def test_a_driver_without_a_relay_is_told_so_and_a_separate_supply_passes_it_on() -> None:
    class Plain:
        pass

    class Relay:
        on: Any = None

        def shunt(self, on: bool) -> None:
            self.on = on

    with pytest.raises(RigFault, match=r"has no shunt\(\); write one"):
        switch_shunt(Plain(), True)
    relay = Relay()
    switch_shunt(SeparatelySupplied(relay, Plain(), 0.04), True)  # type: ignore[arg-type]
    assert relay.on is True


def test_the_ni_board_writes_the_relay_s_line_through_a_task_of_its_own() -> None:
    """By a stand-in of the driver's task: the simulated server has no digital lines."""
    pytest.importorskip("nidaqmx", reason="the extra rig is not installed: pip install dampyr[rig]")
    calls: list[Any] = []

    class Task:
        do_channels: Any

        def __init__(self) -> None:
            self.do_channels = self

        def add_do_chan(self, lines: str, line_grouping: Any) -> None:
            calls.append((lines, line_grouping.name))

        def write(self, value: bool, auto_start: bool) -> None:
            calls.append((value, auto_start))

        def close(self) -> None:
            calls.append("closed")

    board = NiBoard(WIRED)
    board._nidaqmx = SimpleNamespace(Task=lambda name, grpc_options: Task(), errors=board._nidaqmx.errors)
    board.shunt(True)
    board.shunt(False)
    channel = ("Dev1/port0/line0", "CHAN_PER_LINE")
    assert calls == [channel, (True, True), "closed", channel, (False, True)]


def test_the_settings_of_a_shunt_are_written_and_read(tmp_path: Path) -> None:
    from dampyr.rig.settings import load_settings

    assert load_settings(write_settings(WIRED, tmp_path / "rig.toml")).wires.shunt == "port0/line0"
    (tmp_path / "old.toml").write_text('[wires]\nserial = ""\n', "utf-8")
    assert load_settings(tmp_path / "old.toml").wires.shunt == ""
