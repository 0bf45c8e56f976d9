"""The page of a plan."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dampyr import campaigns
from dampyr.campaigns.check import violations_of
from dampyr.campaigns.kinds import kind
from dampyr.rig import RigSettings
from dampyr.show.campaigns.planned_tests import plan_notes, plan_table
from dampyr.show.pages.plan_page import largest_amplitude
from dampyr.show.pages.result_page import write_page

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
STEPS = [
    {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz"},
    {"kind": "sine", "amplitude": "20 mm", "frequency": "2 Hz"},
    {"kind": "earthquake"},
    {"kind": "rest", "duration": "3 s"},
    {"kind": "reversals", "half_period": "0.2 s"},
]


@pytest.mark.usefixtures("figures_not_rendered")
def test_the_page_tells_every_test_every_refusal_and_every_note(tmp_path):
    campaign_plan = campaigns.plan(campaigns.campaign_of({"name": "a page", "operator": "me", "step": STEPS}))
    html = write_page(campaign_plan, tmp_path / "plan.html").read_text(encoding="utf-8")
    for test in campaign_plan.tests:
        assert test.name in html
    assert "needs 251.3 mm/s" in html
    assert "scaled to" in html
    assert "its force is unknown" in html
    assert html.count("<svg") == 3  # the envelope, a sine, an earthquake
    assert "Refused by the rig" in html


def test_a_plan_without_motion_has_a_page(tmp_path):
    campaign_plan = campaigns.plan(campaigns.campaign_of({"step": [STEPS[3]], "check_amplitude": 0}))
    assert "<svg" not in write_page(campaign_plan, tmp_path / "plan.html").read_text(encoding="utf-8")


def test_the_rows_are_in_the_units_that_people_read():
    [row] = plan_table(campaigns.plan(campaigns.campaign_of({"step": STEPS[:1]}))).rows
    assert row[3:5] == pytest.approx([16 * np.pi, 8.0])


def test_a_note_on_a_repeated_test_is_told_once_for_each_name():
    campaign_plan = campaigns.plan(campaigns.campaign_of({"step": [STEPS[2] | {"repeats": 2}]}))
    assert len(plan_notes(campaign_plan)) == 1 + 2


@pytest.mark.parametrize(("frequency", "lag"), [(0.1, 0.025), (1.0, 1e-9), (1.0, 0.025), (2.0, 0.01)])
def test_the_line_of_the_figure_is_where_the_check_refuses(frequency, lag):
    """At 0 N the line is the check's own limit, of a sine with a long taper."""
    rig = RigSettings()
    rig = replace(rig, actuator=replace(rig.actuator, lag=lag, droop=1e-12))
    max_amplitude = float(largest_amplitude(rig, np.array(frequency), 0.0))
    for share, passes in ((0.99, True), (1.01, False)):
        step = kind("sine")(share * max_amplitude, frequency, taper=8, period=0.005)
        assert (violations_of(step, rig) == ()) is passes
