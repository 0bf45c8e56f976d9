"""Break-away: what it runs, and a simulated damper that sticks against one that does not."""

from dataclasses import replace

import pytest
from tests.campaigns.quick_rig import quick_rig

from dampyr import campaigns
from dampyr.errors import InputError
from dampyr.models import Damper, Polynomial
from dampyr.rig import RigSettings

TABLE = {
    "kind": "break_away",
    "amplitude": "3 mm",
    "dwells": ["1 s", "4 s"],
    "voltages": ["0 V", "1 V"],
    "speed": "4 mm/s",
}


def test_every_dwell_runs_at_every_voltage():
    tests = campaigns.campaign_of({"protocol": TABLE}).tests
    assert [(test.kind, test.step.pause, test.step.voltage, test.step.speed) for test in tests] == [
        ("friction", dwell, voltage, 0.004) for voltage in (0.0, 1.0) for dwell in (1.0, 4.0)
    ]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"dwells": []}, r"protocol\.dwells and voltages"),
        ({"dwells": ["0.1 s"]}, r"protocol\.dwells = 0\.1 s is too short"),
    ],
)
def test_what_makes_no_sense_is_refused(change, words):
    with pytest.raises(InputError, match=words):
        campaigns.campaign_of({"protocol": TABLE | change})


def sticking(excess):
    """A damper whose static friction is above its kinetic friction of 100 N by ``excess``; it slides freely above 1 mm/s."""
    numbers = {"fc": 100.0, "sigma1": 0.0, "sigma2": 500.0, "rho": 1e6, "e": excess, "vs": 1.5e-3}
    return Damper("lugre", {f"lugre.{name}": Polynomial((value, 0.0), 0.0, 4.4) for name, value in numbers.items()})


@pytest.mark.prove
def test_a_damper_that_sticks_is_refused_and_one_that_does_not_is_accepted(tmp_path):
    (tmp_path / "limits.csv").write_text("quantity,low,high\nratio,,1.1\nkinetic,90,110\n")
    table = TABLE | {"dwells": ["1 s"], "voltages": ["0 V"]}
    campaign = campaigns.campaign_of({"protocol": table, "check_amplitude": 0.0, "rest_between": 0.2})
    for excess, verdict in ((0.0, "passed"), (1.0, "failed")):
        folder = tmp_path / verdict
        sticking(excess).save(tmp_path / f"{verdict}.toml")
        specimen = replace(RigSettings().specimen, card=str(tmp_path / f"{verdict}.toml"))
        campaigns.perform(campaign, quick_rig(settings=replace(RigSettings(), specimen=specimen)), folder)
        result = campaigns.judge_protocol(folder, tmp_path / "limits.csv")
        assert {figure.conditions["direction"] for figure in result.figures} == {"extension", "compression"}
        assert len(result.figures) == 3 * 4  # two strokes there and back, each after a dwell
        assert result.verdict == verdict
        kinetic = [judged.verdict for judged in result.judged if judged.limit.quantity == "kinetic"]
        assert set(kinetic) == {"passed"}
