"""The simulated rig: seeds, encoder, the times of samples, and homing."""

import numpy as np
import pytest
from tests.rig.simulation.driver import rig
from tests.rig.simulation.parts import settings

from dampyr.rig.firmware.protocol import Request, State
from dampyr.rig.simulation import plant

WIDE = (-30000, 30000, 40000, 150, 255, 1000, 0, 255, 0)


def test_the_same_seed_gives_the_same_bits_whatever_the_blocks() -> None:
    runs = []
    for block in (40, 7):
        made, host = rig()
        host.arm()
        made.start(1000.0)
        runs.append(np.concatenate([made.read(block)[0][0] for _ in range(280 // block)]))
    np.testing.assert_array_equal(runs[0], runs[1])
    assert np.std(np.diff(runs[0] * 613.0)) == pytest.approx(0.4 * np.sqrt(2), rel=0.15)
    steps = np.unique(np.round(np.diff(np.unique(runs[0])) / (20 / 65536), 6))
    assert np.all(steps == np.round(steps))


def test_the_encoder_floors_and_the_board_counts_from_its_start() -> None:
    made, host = rig(position=0.0031)
    host.arm(620)
    host.done(Request.JOG, -2000, 400)
    for _ in range(30):
        host.wait()
    made.start(500.0)
    _, counts = made.read(10)
    assert np.all(counts == 0)
    assert host.beat.position == 620 + np.floor(made.plant[plant.Y_X] / 5e-6) - np.floor(0.0031 / 5e-6)


@pytest.mark.parametrize("rate", [100.0, 1000.0, 3000.0, 40000.0])
def test_samples_come_at_their_times(rate: float) -> None:
    made, host = rig(settings(load_cell={"noise": 0.0}))
    host.arm()
    host.done(Request.JOG, 4000, 400)
    start = made.time
    made.start(rate)
    counts = np.concatenate([made.read(max(1, round(rate / 50)))[1] for _ in range(5)])
    t = start + np.arange(1, counts.size + 1) / rate
    truth = made.truth
    expected = np.interp(t, np.concatenate(([0.0], truth.time)), np.concatenate(([0.0], truth.position))) / 5e-6
    assert np.abs(counts + 0.5 - expected).max() < 1.2
    assert made.time == pytest.approx(start + counts.size / rate, abs=1.1e-4)


def test_home_looks_for_the_index() -> None:
    made, host = rig(position=-0.003)
    host.ask(Request.HELLO, 3)
    host.done(Request.CLEAR)
    host.done(Request.LIMITS, *WIDE)
    assert host.beat.limited
    host.done(Request.ARM)
    host.done(Request.HOME, 1, 400)  # the index lies 2 mm from the middle
    for _ in range(3000):
        if host.beat.state == State.ARMED:
            break
    status = host.beat
    assert status.homed
    assert status.position * 5e-6 == pytest.approx(made.plant[plant.Y_X], abs=6e-6)
