"""Marks by the slow passes before and after a test."""

from dataclasses import replace

from dampyr.campaigns.pass_marks import gain_moved, passes_differ, zero_moved
from dampyr.rig import RigSettings
from dampyr.rig.uncertainty_budget import Evidence

RIG = RigSettings()


def test_a_zero_that_differs_before_and_after_a_test_is_marked() -> None:
    assert not zero_moved(Evidence())
    assert not zero_moved(Evidence(zero_shift=(1.0, 5.0)))
    (mark,) = zero_moved(Evidence(zero_shift=(1.0, -40.0)))
    assert "moved by -41 N in the test" in mark.text
    (mark,) = zero_moved(Evidence(zero_shift=(15.0, 16.0)))
    assert "moved by +16 N since the run began" in mark.text
    assert not zero_moved(Evidence(zero_shift=(0.0, 16.0), rise=12.0, warming=12.0))  # a gas charge that warmed


def test_a_height_that_differs_on_the_slow_passes_is_a_gain() -> None:
    assert not gain_moved(Evidence(), RIG)
    assert not gain_moved(Evidence(heights=(64.0, 64.5, 65.2)), RIG)
    assert not gain_moved(Evidence(heights=(0.0, 0.0, 64.0)), RIG)  # a cell that was dead: other marks say so
    (mark,) = gain_moved(Evidence(heights=(64.0, 64.0, 60.0)), RIG)
    assert "60 N high after the test" in mark.text
    assert "-6.2% (+-1.3%) in the test" in mark.text
    (mark,) = gain_moved(Evidence(heights=(64.0, 60.0, 60.3)), RIG)
    assert "since the run began" in mark.text
    assert not gain_moved(Evidence(heights=(64.0, 64.0, 60.0), rise=8.0, warming=8.0), RIG)  # a fluid that warmed


def test_a_zero_that_moved_is_told_beside_a_gain_only_where_that_does_not_explain_it() -> None:
    by_gain = Evidence(zero_shift=(0.0, -13.6), first_mean=136.0, heights=(64.0, 64.0, 57.6))
    assert ["gain" in mark.text for mark in passes_differ(by_gain, RIG)] == [True]
    both = replace(by_gain, zero_shift=(0.0, 30.0))
    assert ["gain" in mark.text for mark in passes_differ(both, RIG)] == [True, False]


def test_a_force_on_the_first_pass_that_the_card_does_not_promise_is_marked() -> None:
    shown = Evidence(zero_shift=(0.0, 0.0), first_mean=330.0, expected_mean=136.0)
    (mark,) = passes_differ(shown, RIG)
    assert "by the damper's card it is 136 N, 90.8 N more or less" in mark.text
    assert not passes_differ(replace(shown, first_mean=200.0), RIG)
    assert not passes_differ(replace(shown, expected_mean=None), RIG)
    assert len(passes_differ(replace(shown, zero_shift=(0.0, 50.0)), RIG)) == 1  # a zero that moves says enough
