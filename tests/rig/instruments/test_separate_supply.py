"""A supply of its own without a clock: constant voltages, steps with their latency, and cuts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.rig.instruments.laboratory import agree, records_of, rig_file

from dampyr.errors import DampyrWarning
from dampyr.records import Record
from dampyr.rig import Drive, simulated
from dampyr.rig.simulation.simulator import Simulator


def test_a_supply_without_a_clock_holds_constant_voltages(laboratory: Path, usual: list[Record]) -> None:
    path = rig_file(laboratory, supply="./bench_supply")
    ours = records_of(simulated(path), laboratory / "out")
    agree(ours, usual, skip=0.3)
    assert "(no sample clock: its voltage comes up to 90 ms late)" in ours[0].provenance["board"]


def test_a_step_of_its_voltage_is_told_with_its_latency(laboratory: Path) -> None:
    drive = Drive(0.01, np.zeros(100), np.r_[np.zeros(50), np.full(50, 2.0)])
    with simulated(rig_file(laboratory, supply="./bench_supply")) as rig:
        simulator: Simulator = rig.board.acquisition.simulator  # type: ignore[attr-defined]
        with rig.armed() as table:
            table.home(here=True)
            with pytest.warns(DampyrWarning, match="steps of its voltage come up to 90 ms late"):
                blocks = list(table.play(drive))
            begin = simulator.time - table.loop.next / rig.settings.board.rate
    samples = [block for block, _ in blocks]
    time, voltage = (np.concatenate([getattr(block, name) for block in samples]) for name in ("time", "voltage"))
    commanded = time[np.flatnonzero(voltage > 1.9)[0]]
    truth = simulator.truth
    late = truth.time[np.flatnonzero(truth.voltage > 1.9)[0]] - begin - commanded
    assert 0.02 < late <= rig.command_delay == pytest.approx(0.09)
    with simulated() as rig:
        assert rig.command_delay == 0.0


def test_a_cut_is_not_followed_by_what_was_queued(laboratory: Path) -> None:
    with simulated(rig_file(laboratory, supply="./bench_supply")) as rig:
        board, simulator = rig.board, rig.board.acquisition.simulator  # type: ignore[attr-defined]
        board.start(1000.0, np.r_[np.full(100, 2.0), np.full(300, 3.0)])
        board.read(80)
        assert simulator.command == pytest.approx(2.0, abs=1e-3)
        board.write(0.0)
        for _ in range(5):
            board.read(50)
        assert simulator.command == pytest.approx(0.0, abs=1e-3)
        board.stop()
        board.start(1000.0, np.full(100, 1.0))
        board.read(80)
        assert simulator.command == pytest.approx(1.0, abs=1e-3)
