"""The load cell at the bench: zeroed, and the guided steps of a calibration."""

import pytest
from tests.console.bench_runs import Phase, Until

from dampyr.console.bench_session import Bench
from dampyr.errors import InputError

pytestmark = pytest.mark.endure


def test_the_load_cell_is_zeroed(armed: Bench, until: Until, phase: Phase) -> None:
    armed.zero("a")
    phase(armed, "armed", 5.0)
    rig = armed.rig
    assert rig is not None
    assert rig.calibration is not None
    assert abs(rig.calibration.zero) > 0.01  # the simulated damper pushes
    assert rig.calibration.how.endswith(", zeroed at rest")
    until(lambda: (live := armed.state().live) is not None and abs(live.force) < 5.0, 2.0)


def test_the_guided_steps_of_a_calibration(bench: Bench, until: Until, phase: Phase) -> None:
    bench.connect("a")
    phase(bench, "idle")
    with pytest.raises(InputError, match="no calibration is under way"):
        bench.calibrate_step("a", "unloaded")
    bench.calibrate("a")
    bench.calibrate_step("a", "loaded", "20 kg")
    until(lambda: bench.state().fault)
    assert "read it first, without load" in bench.state().note
    bench.calibrate_step("a", "unloaded")
    until(lambda: (guided := bench.state().guided) is not None and guided.zeroed)
    phase(bench, "idle")
    bench.calibrate_step("a", "loaded", "20 kg")
    until(lambda: "mV only" in bench.state().note)  # nothing hangs on the cell
    phase(bench, "idle")
    bench.calibrate_end("a", keep=True)
    state = bench.state()
    assert state.guided is None
    assert state.rig is not None
    assert state.rig.calibrated == "zero read, scale as before"
    assert abs(state.rig.zero) > 0.01
