"""Endurance: blocks of one sine, the counter over them, and the end at a decay of the force, as its journal says."""

from dataclasses import replace

import numpy as np
import pytest
from tests.campaigns.quick_rig import quick_rig

from dampyr import campaigns
from dampyr.campaigns.protocols.endurance import Endurance
from dampyr.campaigns.run_control import EndedByProtocol
from dampyr.errors import InputError
from dampyr.records import Record
from dampyr.rig import RigSettings

TABLE = {
    "kind": "endurance", "amplitude": "5 mm", "frequency": "1 Hz", "voltage": "1 V", "cycles": 14, "block_cycles": 4,
    "stop_decay": "10 %",
}  # fmt: skip


def block(number, force, offset=30.0):
    t = np.arange(0.0, 6.0, 0.005)
    return Record(
        t, 0.005 * np.sin(2 * np.pi * t), offset + force * np.cos(2 * np.pi * t), voltage=1.0, name=f"{number:02d}-sine"
    )


def test_the_cycles_are_parted_into_blocks_and_counted_over_them():
    campaign = campaigns.campaign_of({"protocol": TABLE})
    assert [(test.kind, test.step.cycles) for test in campaign.tests] == [("sine", n) for n in (4, 4, 4, 2)]
    assert [campaign.protocol.counted(k)["cycles_before"] for k in range(5)] == ["0", "4", "8", "12", "14"]


def test_the_decay_is_of_half_the_range_against_the_reference_block():
    protocol = Endurance(0.005, 1.0, 12, block_cycles=4, reference_block=2, stop_decay=0.1)
    figures = protocol.figures([block(1, 600.0), block(2, 500.0), block(3, 440.0)])
    found = [figure.value for figure in figures if figure.quantity == "decay"]
    assert found == pytest.approx([-0.2, 0.0, 0.12], abs=1e-3)
    assert [figure.conditions["cycles"] for figure in figures[::2]] == [4, 8, 12]


def test_it_ends_above_the_decay_and_not_before_the_reference_block():
    protocol = Endurance(0.005, 1.0, 12, block_cycles=4, reference_block=2, stop_decay=0.1)
    forces = (600.0, 500.0, 440.0)
    readers = [lambda k=k: block(k + 1, forces[k]) for k in range(3)]
    assert [bool(protocol.ends(readers[:n])) for n in (1, 2, 3)] == [False, False, True]
    assert protocol.ends(readers).startswith("the force has decayed by 12 % in block 3, after 12 of 12 cycles")
    assert replace(protocol, stop_decay=None).ends(readers) == ""


def test_a_reference_block_beyond_the_last_is_refused():
    with pytest.raises(InputError, match="reference_block = 5 is not among the 4 blocks"):
        campaigns.campaign_of({"protocol": TABLE | {"reference_block": 5}})


@pytest.fixture(scope="module")
def campaign():
    return campaigns.campaign_of({"protocol": TABLE, "check_amplitude": 0.0, "rest_between": 0.2})


def states(folder):
    tests, events = campaigns.read_journal(folder)
    return [test.state for test in tests], events


@pytest.mark.prove
def test_a_healthy_specimen_runs_all_blocks_also_over_two_runs_and_passes(campaign, tmp_path):
    control, folder = campaigns.RunControl(), tmp_path / "healthy"

    def stop_in_the_second(progress):
        if progress.done == 1 and progress.phase == "testing" and progress.fraction > 0.5:
            control.stop()

    with pytest.raises(campaigns.Stopped, match="by its operator"):
        campaigns.perform(campaign, quick_rig(), folder, stop_in_the_second, control)
    assert states(folder)[0][0] == "complete"
    records = campaigns.perform(campaign, quick_rig(), folder)
    assert [record.provenance["cycles_before"] for record in records] == ["0", "4", "8", "12"]
    result = campaigns.judge_protocol(folder)
    assert (result.verdict, len(result.judged)) == ("passed", 4)
    assert max(abs(judged.figure.value) for judged in result.judged) < 0.03


@pytest.mark.prove
def test_a_specimen_that_loses_force_ends_the_campaign_with_the_reason_and_stays_ended(campaign, tmp_path):
    """The simulated force falls by 1 % a kelvin, and the specimen is suddenly warmer by 25 K, in the second block."""
    folder, settings = tmp_path / "fading", RigSettings()
    settings = replace(settings, specimen=replace(settings.specimen, softening=0.01))
    with pytest.raises(
        EndedByProtocol, match=r"the force has decayed by 2\d\.\d % in block \d, after \d+ of 14 cycles"
    ):
        campaigns.perform(campaign, quick_rig("hot-specimen=25@22s", settings=settings), folder)
    found, events = states(folder)
    assert "failed" not in found
    assert found[-1] != "complete"
    assert events[-1].what == "ended"
    assert "more than stop_decay = 10 %" in events[-1].detail
    result = campaigns.judge_protocol(folder)
    assert result.verdict == "failed"
    assert any(judged.reason == "above the upper limit" for judged in result.judged)
    with pytest.raises(EndedByProtocol, match="has decayed"):
        campaigns.perform(campaign, again_rig := quick_rig(settings=settings), folder)
    assert not again_rig.was_armed
    assert states(folder)[0] == found
