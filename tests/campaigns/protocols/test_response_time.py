"""Response time: what it runs, and the lag of the simulated coil; a good supply is accepted, a slow one refused."""

from dataclasses import replace

import pytest
from click.testing import CliRunner
from tests.campaigns.quick_rig import quick_rig

from dampyr import campaigns
from dampyr.cli import cli
from dampyr.errors import InputError
from dampyr.rig import RigSettings

TABLE = {
    "kind": "response_time",
    "amplitude": "12 mm",
    "speeds": ["20 mm/s", "30 mm/s"],
    "high_voltages": ["1 V", "1.98 V"],
}
SETTINGS = RigSettings()


def test_every_pair_runs_at_every_speed_with_a_learned_drive():
    tests = campaigns.campaign_of({"protocol": TABLE | {"low_voltages": ["0 V", "1 V"]}}).tests
    found = [(test.kind, test.step.speed, test.step.low, test.step.high, test.learn) for test in tests]
    assert found == [
        ("voltage_switch", speed, low, high, True) for low, high in ((0.0, 1.0), (1.0, 1.98)) for speed in (0.02, 0.03)
    ]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"speeds": []}, r"protocol\.speeds and high_voltages need at least one"),
        ({"low_voltages": [0.0, 0.1, 0.2]}, r"protocol\.low_voltages has 3 values and high_voltages 2"),
    ],
)
def test_what_makes_no_sense_is_refused(change, words):
    with pytest.raises(InputError, match=words):
        campaigns.campaign_of({"protocol": TABLE | change})


@pytest.mark.prove
def test_the_lag_of_the_coil_is_found_and_a_slow_coil_is_refused_with_the_reason(tmp_path):
    (tmp_path / "limits.csv").write_text("quantity,high [ms],step\nt63,20,\n")
    table = TABLE | {"speeds": ["30 mm/s"], "high_voltages": ["1.98 V"]}
    campaign = campaigns.campaign_of({"protocol": table, "check_amplitude": 0.0})
    for name, inductance in (("good", 0.044), ("slow", 0.176)):
        lag = inductance / SETTINGS.supply.resistance
        settings = replace(SETTINGS, supply=replace(SETTINGS.supply, inductance=inductance))
        campaigns.perform(campaign, quick_rig(settings=settings), tmp_path / name)
        result = campaigns.judge_protocol(tmp_path / name, tmp_path / "limits.csv")
        times = [figure.value for figure in result.figures if figure.quantity == "t63"]
        # The law of the damper's force bends with the voltage: the rise is later than the coil, the fall is not.
        assert times == pytest.approx([lag] * 4, rel=0.27)
        assert len({(figure.conditions["direction"], figure.conditions["step"]) for figure in result.figures}) == 4
        assert result.verdict == ("passed" if name == "good" else "failed")
        assert {judged.reason for judged in result.judged} == ({""} if name == "good" else {"above the upper limit"})
    refused = CliRunner().invoke(cli, ["protocol", str(tmp_path / "slow"), "--limits", str(tmp_path / "limits.csv")])
    assert refused.exit_code == 1
    assert "above the upper limit" in refused.output
    assert "commanded, not measured" in refused.output
