"""Waiting at an armed rig: what looks on, what ends it, and that nothing is taken for news that is not."""

import time

import pytest
from tests.rig.wires.process import over_wires

from dampyr.campaigns import RunControl, Stopped, campaign_of, perform
from dampyr.errors import RigFault
from dampyr.rig import simulated
from dampyr.rig.interlock import Samples


class Enough(Exception):
    """Raised by a check."""


@pytest.mark.parametrize("motion", ["home", "go", "rest"])
def test_a_check_ends_what_is_waited_for(motion: str) -> None:
    blocks = 0

    def check() -> None:
        nonlocal blocks
        blocks += 1
        if blocks > 5:
            raise Enough

    with simulated() as rig, rig.armed() as table:
        table.home(here=True)
        table.check = check
        with pytest.raises(Enough):
            {"home": table.home, "go": lambda: table.go(0.02), "rest": lambda: table.rest(60.0)}[motion]()
        table.check = lambda: None
        table.stop()
        assert blocks == 6


@pytest.mark.prove
def test_the_rig_is_read_on_while_a_long_record_is_finished() -> None:
    with over_wires() as rig, rig.armed() as table:
        table.home(here=True)
        table.meanwhile(lambda: time.sleep(4.0))  # in lockstep the watchdog acts after three seconds of silence
        table.go(0.001)
        with pytest.raises(KeyError):
            table.meanwhile(lambda: {}["x"])


def test_a_campaign_that_was_aborted_before_it_armed_moves_nothing(tmp_path) -> None:
    campaign = campaign_of({"step": [{"kind": "sine", "amplitude": "2 mm", "frequency": "2 Hz", "cycles": 1}]})
    control = RunControl()
    control.abort("by a test")
    with simulated() as rig, pytest.raises(RigFault, match="aborted: by a test"):
        perform(campaign, rig, tmp_path, control=control)


def test_stop_is_heard_while_the_table_looks_for_its_index(tmp_path) -> None:
    campaign = campaign_of({"step": [{"kind": "sine", "amplitude": "2 mm", "frequency": "2 Hz", "cycles": 1}]})
    control, phases = RunControl(), []

    with simulated() as rig:
        rig.watchers.append(lambda samples: control.stop() if phases == ["homing"] and samples.time[-1] > 0.5 else None)
        with pytest.raises(Stopped):
            perform(campaign, rig, tmp_path, lambda progress: phases.append(progress.phase), control)
    assert phases == ["homing"]


def test_a_rig_in_this_process_waits_for_slow_work() -> None:
    """Its time passes only while it is read, so what follows does not depend on how long the work took."""
    seen: list[Samples] = []
    with simulated() as rig, rig.armed() as table:
        table.home(here=True)
        rig.watchers.append(seen.append)
        table.meanwhile(lambda: time.sleep(0.5))
        assert seen == []
        with pytest.raises(KeyError):
            table.meanwhile(lambda: {}["x"])
