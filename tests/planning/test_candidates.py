"""Candidate tests are what the rig can do, and what it cannot is refused in one line."""

from dataclasses import replace

import numpy as np
import pytest
from tests.planning.laboratory import DAHL, VOLTAGES

from dampyr import campaigns
from dampyr.errors import InputError
from dampyr.models import Damper, Interpolation
from dampyr.planning.candidates import LEAST, RigEnvelope, envelope, voltages_of
from dampyr.rig import RigSettings

RIG = RigSettings()


@pytest.fixture(scope="module")
def small() -> RigEnvelope:
    return envelope(RIG, DAHL, (0.0, 3.212), seconds=6.0)


def test_every_candidate_is_inside_of_all_limits_and_a_campaign_can_hold_it(small: RigEnvelope) -> None:
    campaign = campaigns.campaign_of({"step": [each.table for each in small.candidates]})
    plan = campaigns.plan(campaign, RIG, DAHL)
    assert plan.refusals == ()
    assert {test.kind for test in campaign.tests} == {"sine", "voltage_steps", "sweep", "random"}
    for each, test in zip(small.candidates, campaign.tests, strict=True):
        assert test.step == each.step, each.words
        assert each.amplitude >= LEAST * RIG.encoder.count


def test_the_largest_sine_becomes_smaller_with_frequency_and_force(small: RigEnvelope) -> None:
    soft, hard = (small.limits[u] for u in (0.0, 3.212))
    assert np.all(np.diff(soft) < 0.0)
    assert np.all(hard < soft)


def test_voltages_come_from_the_card() -> None:
    knots = Damper("dahl", {name: Interpolation(VOLTAGES, (900.0,) * 4) for name in ("dahl.kx", "dahl.kw", "dahl.rho")})
    assert voltages_of(knots, RIG) == VOLTAGES
    assert voltages_of(DAHL, RIG) == pytest.approx(np.linspace(0.0, 3.212, 4))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"voltages": (0.0, 4.0)}, r"voltage = 4 V is outside of 0 to 3.212 V"),
        ({"voltages": ()}, "0 voltages are not allowed"),
        ({"kinds": ("friction",)}, "kinds names 'friction'; choose among sine, voltage_steps, sweep, random"),
        ({"kinds": ()}, "kinds is empty"),
        ({"seconds": 1.0}, "seconds = 1 is not allowed"),
        ({"damper": replace(DAHL, input="A", covariance=None)}, "this card is over the current in A"),
        (
            {"rig": replace(RIG, actuator=replace(RIG.actuator, free_speed=1e-4)), "kinds": ("sine",), "seconds": 4.0},
            "can do none of 0 candidate tests with this damper at 0 to 3.212 V",
        ),
    ],
)
def test_what_cannot_be_planned_is_said_in_one_line(change: dict, words: str) -> None:
    given = {"rig": RIG, "damper": DAHL} | change
    with pytest.raises(InputError, match=words):
        envelope(**given)
