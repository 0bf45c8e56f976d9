"""A shock dynamometer's run: order, and peak speeds by pi times stroke times frequency."""

from math import pi

import pytest
from tests.campaigns.quick_rig import quick_rig

from dampyr import campaigns
from dampyr.errors import InputError

TABLE = {"kind": "peak_velocity", "stroke": "100 mm", "speeds": ["131 mm/s", "524 mm/s"]}


def test_warm_up_and_gas_force_come_first_and_the_speeds_are_reached():
    tests = campaigns.campaign_of({"protocol": TABLE | {"voltages": ["0 V", "1 V"]}}).tests
    assert [test.kind for test in tests] == ["warm_up", "gas_force", "sine", "sine", "sine", "sine"]
    assert [2 * pi * t.step.frequency * t.step.amplitude for t in tests[2:]] == pytest.approx([0.131, 0.524] * 2)
    assert [test.step.voltage for test in tests[2:]] == [0.0, 0.0, 1.0, 1.0]
    assert tests[3].step.frequency * 60 == pytest.approx(100, rel=2e-3)  # 100 rpm at 100 mm is 0.524 m/s
    assert tests[0].step.frequency == tests[3].step.frequency


def test_the_rig_refuses_a_speed_that_it_cannot_reach():
    plan = campaigns.plan(campaigns.campaign_of({"protocol": TABLE}))
    assert any("limit" in str(refusal) or "gives" in str(refusal) for refusal in plan.refusals)


def test_without_speeds_it_is_refused():
    with pytest.raises(InputError, match=r"^protocol\.speeds and voltages need at least one value"):
        campaigns.campaign_of({"protocol": TABLE | {"speeds": []}})


@pytest.mark.prove
def test_the_table_of_forces_is_judged_without_the_gas_force_and_a_weak_specimen_is_refused(tmp_path):
    table = TABLE | {"stroke": "12 mm", "speeds": ["20 mm/s", "35 mm/s"], "voltages": ["1.98 V"], "warm_up_cycles": 2}
    table |= {"cycles": 3, "sign": "compression positive"}
    campaign = campaigns.campaign_of({"protocol": table, "check_amplitude": 0.0, "rest_between": 0.2})
    for name, faults in (("good", ()), ("weak", ("supply-gain=0.6@0s",))):
        records = campaigns.perform(campaign, quick_rig(*faults), tmp_path / name)
        result = campaigns.judge_protocol(tmp_path / name)
        values = {
            (f.quantity, f.conditions.get("speed"), f.conditions.get("direction")): f.value for f in result.figures
        }
        assert len(values) == 1 + 2 * 2 * 2
        gas = values["gas_force", None, None]
        assert gas == pytest.approx(
            -134.0, abs=0.5
        )  # what the simulated damper has without voltage, with the sign asked for
        for (quantity, speed, direction), value in values.items():
            if quantity == "force":
                assert value == pytest.approx(values["raw_force", speed, direction] - gas, abs=1.0)
                assert (value > 0.0) == (direction == "compression")
        if name == "good":
            forces = {key: value for key, value in values.items() if key[0] == "force"}
            rows = [
                f"force,{1e3 * speed:.6g},{direction},{value - 0.1 * abs(value):.1f},{value + 0.1 * abs(value):.1f}"
                for (_, speed, direction), value in forces.items()
            ]
            (tmp_path / "sheet.csv").write_text("\n".join(["quantity,speed [mm/s],direction,low,high", *rows]) + "\n")
        judged = campaigns.judge_protocol(tmp_path / name, tmp_path / "sheet.csv")
        assert judged.verdict == ("passed" if name == "good" else "failed")
        assert len(judged.judged) == 4
        assert len(records) == 4
