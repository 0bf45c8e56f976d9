"""Thresholds: what is judged of a test is said once, and another value changes what is said."""

from dataclasses import replace
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
import pytest
from tests.campaigns.quick_rig import quick_rig

from dampyr import records
from dampyr.campaigns import campaign_of, perform
from dampyr.campaigns.campaign_thresholds import USUAL, CampaignThresholds
from dampyr.campaigns.marks import MeasuredTest, drifting_zero, sudden_force
from dampyr.campaigns.pass_marks import zero_moved
from dampyr.config import origin
from dampyr.errors import InputError, RigFault
from dampyr.rig import RigSettings
from dampyr.rig.uncertainty_budget import Evidence

SINE = {
    "kind": "sine", "amplitude": "5 mm", "frequency": "1 Hz", "voltage": "1 V", "cycles": 6, "rest_before": "1 s",
}  # fmt: skip


def cycles(drift: float) -> MeasuredTest:
    """Sines between two rests, whose force drifts by so many N/s."""
    t = np.arange(12_000) / 1000.0
    moving = (t > 1.0) & (t < 11.0)
    x = np.where(moving, 0.005 * np.sin(2 * np.pi * (t - 1.0)), 0.0)
    force = 80.0 * np.tanh(np.gradient(x, t) / 0.003) + drift * t
    return MeasuredTest(t, x, force, force / RigSettings().load_cell.scale, 0.0, RigSettings())


def test_a_drift_is_marked_by_the_threshold_that_holds() -> None:
    measured = cycles(3.0)
    assert len(list(drifting_zero(measured))) == 1
    assert not list(drifting_zero(replace(measured, thresholds=CampaignThresholds(cycle_drift=100.0))))
    assert not list(drifting_zero(cycles(0.5)))
    assert len(list(drifting_zero(replace(cycles(0.5), thresholds=CampaignThresholds(cycle_drift="1 N"))))) == 1


def test_a_shift_between_slow_passes_is_marked_by_the_threshold_that_holds() -> None:
    shown = Evidence(zero_shift=(0.0, 8.0))
    assert len(zero_moved(shown)) == 1
    assert not zero_moved(shown, 0.0, CampaignThresholds(pass_shift=10.0))


def test_a_leap_is_marked_by_the_threshold_that_holds() -> None:
    measured = cycles(0.0)
    force = measured.force + np.where(measured.time > 11.5, 20.0, 0.0)
    assert not list(sudden_force(replace(measured, force=force)))
    lower = CampaignThresholds(sudden_force=10.0, sudden_rate=0.0)
    assert len(list(sudden_force(replace(measured, force=force, thresholds=lower)))) == 1


def test_a_campaign_is_judged_by_the_thresholds_that_it_is_given(drifted: Path, tmp_path: Path) -> None:
    """The same drift of the cell, with the thresholds as usual and with wide ones."""
    campaign = campaign_of({"name": "drift", "check_amplitude": 0, "step": [SINE]})
    wide = CampaignThresholds(cycle_drift=1e3, rest_drift=1e3, pass_shift=1e3)
    with quick_rig("drifting-cell=5@2s") as rig:
        [unmarked] = perform(campaign, rig, tmp_path, thresholds=wide)
    marked = records.read_campaign(drifted)[1]
    assert marked.name == unmarked.name.replace("01", "02")
    assert bool(marked.marks)
    assert marked.provenance.get("thresholds", "") == ""
    assert not unmarked.marks
    assert unmarked.provenance["thresholds"] == "rest_drift = 1000 N, cycle_drift = 1000 N, pass_shift = 1000 N"


def test_no_test_begins_after_a_stroke_that_the_threshold_does_not_allow(tmp_path: Path) -> None:
    campaign = campaign_of({"name": "stroke", "step": [SINE]})
    with quick_rig() as rig, pytest.raises(RigFault, match="the slow stroke before the first test was"):
        perform(campaign, rig, tmp_path, thresholds=CampaignThresholds(stroke_error=1e-6))


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"sudden_force": 0.0}, "sudden_force = 0 N is not allowed"),
        ({"spoiling_share": 1.5}, "spoiling_share = 1.5"),
        ({"cycles": 1}, "cycles = 1"),
        ({"pass_shift": "3 mm"}, "pass_shift: the unit 'mm' does not measure what 'N' measures"),
    ],
)
def test_a_value_outside_of_its_range_is_refused(values: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        CampaignThresholds(**values)


def test_every_threshold_says_what_is_judged() -> None:
    assert CampaignThresholds() == USUAL
    assert all(origin(hint) for hint in get_type_hints(CampaignThresholds, include_extras=True).values())
