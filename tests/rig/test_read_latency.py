"""Samples that lay on the board for too long stop the rig, and nothing else does."""

import numpy as np
import pytest

from dampyr.rig import RigSettings
from dampyr.rig.firmware.protocol import Fault, State, Status
from dampyr.rig.interlock import Interlock, Samples
from dampyr.rig.read_latency import Lateness


def test_prompt_readings_of_clocks_that_differ_are_not_late() -> None:
    late = Lateness(1000.0)
    worst = max(late.of(40 * k, 12345.6 + 0.040 * k * (1 + 1e-4)) for k in range(90000))  # an hour, 100 ppm
    assert worst < 0.001


def test_a_host_that_was_stopped_is_late_by_as_long() -> None:
    late = Lateness(1000.0)
    for k in range(100):
        late.of(40 * k, 0.040 * k)
    assert late.of(40 * 100, 0.040 * 100 + 0.5) == pytest.approx(0.5, abs=1e-3)
    assert late.of(40 * 101, 0.040 * 101 + 0.47) == pytest.approx(0.47, abs=1e-3)  # it catches up
    assert late.of(40 * 120, 0.040 * 120) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(("waiting", "trips"), [(0.15, False), (0.17, True)])
def test_the_interlock_knows_four_blocks(waiting: float, trips: bool) -> None:
    status = Status(0, State.ARMED, Fault(0), 0, 0, 0, True, False, True, 64, 0, 0)
    still = np.zeros(40)
    samples = Samples(0, np.arange(40) / 1000, still, still, None, still[None], still.astype(int), still, status)
    trip = Interlock(RigSettings()).judge(samples, waiting)
    assert bool(trip) is trips
    if trip:
        assert str(trip).startswith(
            "age of the samples 0.17 s passed its limit of 0.16 s at 0.04 s; the host is too slow"
        )
