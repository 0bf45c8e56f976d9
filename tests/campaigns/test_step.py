"""What every kind of step has: fields in the unit that people read, ranges, and set points enough for a cycle."""

import pytest

from dampyr.campaigns.step import check_ranges, enough_points, quantity_of, shown, words
from dampyr.campaigns.steps.random import Random
from dampyr.campaigns.steps.sine import Sine
from dampyr.campaigns.steps.voltage_steps import VoltageSteps
from dampyr.campaigns.steps.warm_up import WarmUp
from dampyr.errors import InputError


def test_a_field_is_shown_in_the_unit_that_people_read() -> None:
    step = Sine(0.0124, 2.0, rest_before=1.5)
    assert [shown(step, name) for name in ("amplitude", "frequency", "cycles", "rest_before")] == [
        "12.4 mm", "2 Hz", "cycles 20", "1.5 s",
    ]  # fmt: skip
    assert shown(step, "amplitude", "") == "12.4mm"
    steps = VoltageSteps(0.01, 1.0, (0.0, 1.5))
    assert (shown(steps, "voltages"), shown(steps, "voltages", "")) == ("0, 1.5 V", "0+1.5V")
    assert shown(WarmUp(0.005, 1.0), "temperature") == ""


def test_a_step_in_words_begins_with_its_kind() -> None:
    assert words("sine", Sine(0.02, 2.0, 0.8712)) == "sine 20 mm at 2 Hz, 0.8712 V"
    assert words("warm_up", WarmUp(0.005, 1.0, temperature=35.0)).startswith("warm up 5 mm at 1 Hz, 0 V, 35")


def test_eight_set_points_are_the_fewest_of_a_cycle() -> None:
    enough_points(0.0125, 10.0)
    with pytest.raises(InputError, match=r"fewer than 8 set points per cycle at 10 Hz; give at most 12\.5 ms"):
        enough_points(0.0126, 10.0)


def test_a_value_outside_of_its_range_is_refused_by_name() -> None:
    assert quantity_of(Random(0.01), "low").unit == "Hz"
    step = VoltageSteps(0.01, 1.0, (0.0, 1.5))
    object.__setattr__(step, "voltages", (0.0, -1.5))
    with pytest.raises(InputError, match=r"voltages = -1.5 V"):
        check_ranges(step)
