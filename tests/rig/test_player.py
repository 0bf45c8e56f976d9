"""A drive that is played: set points, voltages and samples on one clock."""

import numpy as np
import pytest
from tests.rig.drives import sine

from dampyr.errors import InputError
from dampyr.rig import Drive, Rig
from dampyr.rig.simulation.simulator import Simulator


def test_a_drive_is_followed_and_recorded_on_one_clock(ready: tuple[Rig, Simulator]) -> None:
    rig, simulator = ready
    drive = sine(0.010, 1.0, 4.0)
    with rig.armed() as table:
        begun, next_sample = simulator.time, table.loop.next
        started = simulator._task.start
        got = [
            (block.time[selected], block.displacement[selected], block.voltage[selected], block.target[selected])
            for block, selected in table.play(drive)
        ]
        t, x, u, asked = (np.concatenate(rows) for rows in zip(*got, strict=True))
        assert len(t) == 4001
        np.testing.assert_allclose(np.diff(t), 1e-3, atol=1e-12)
        followed = np.interp(t - t[0], np.arange(drive.n) * 0.01, drive.displacement)
        assert np.abs(x - followed).max() < 6e-4
        assert np.abs(asked - followed).max() < 2e-5  # a smooth path through the set points
        assert np.all(u == 2.0)
        truth = simulator.truth
        began = np.flatnonzero((truth.voltage > 0.0) & (truth.time > begun))[0]
        began_after = truth.time[began] - started - next_sample / rig.settings.board.rate
        assert began_after == pytest.approx(0.200, abs=0.0021)  # five blocks ahead, on the clock
        true = np.interp(started + 1e-3 + t, truth.time, truth.position)
        assert np.abs(x - true).max() < 2e-4


def test_the_coil_follows_steps_of_voltage_to_the_sample(ready: tuple[Rig, Simulator]) -> None:
    rig, simulator = ready
    steps = np.repeat([0.5, 1.5, 1.0, 2.0], 25)
    with rig.armed() as table:
        blocks = [
            (block.time[selected], block.voltage[selected])
            for block, selected in table.play(Drive(0.01, np.zeros(100), steps))
        ]
        t, u = (np.concatenate(rows) for rows in zip(*blocks, strict=True))
    truth = simulator.truth
    for volts in (0.5, 1.5, 1.0, 2.0):
        commanded = t[u == volts]
        really = truth.time[np.isclose(truth.voltage, volts, rtol=0.02)]
        assert really.max() - really.min() == pytest.approx(commanded.max() - commanded.min(), abs=0.045)
    assert np.flatnonzero(np.diff(u)).tolist() == [249, 499, 749]


def test_nothing_is_asked_for_outside_of_a_drive_nor_of_a_table_that_stands(ready: tuple[Rig, Simulator]) -> None:
    rig, _ = ready
    with rig.armed() as table:
        assert next(table.loop.blocks()).target is None
        targets = [block.target for block, _ in table.play(sine(0.004, 2.0, 1.0))]
        assert np.isnan(targets[0]).all()  # the command of the first blocks was fixed before
        assert sum(int(np.isfinite(target).sum()) for target in targets) == 1001
        standing = Drive(0.01, np.full(10, table.position), np.ones(10), standing=True)
        assert all(block.target is None for block, _ in table.play(standing))


def test_a_drive_that_begins_elsewhere_is_refused(ready: tuple[Rig, Simulator]) -> None:
    rig, _ = ready
    with rig.armed() as table, pytest.raises(InputError, match=r"begins at 5\.00 mm and the table stands at 0\.0"):
        next(table.play(Drive(0.01, np.full(10, 0.005), np.zeros(10))))
