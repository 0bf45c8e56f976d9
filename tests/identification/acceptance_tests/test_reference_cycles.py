"""What a reference says of a cycle: tests of another specimen over speed, and a card within its ranges."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from tests.identification.judged_runs import CARD, A, dry, judge, measured, run

from dampyr.errors import ExtrapolationWarning


def test_tests_of_a_reference_are_interpolated_over_speed_in_each_direction():
    def uneven(x, v):
        return np.where(v > 0, 2000.0, 1200.0) * v + 40.0 * np.sign(v)

    references = [measured(uneven, f"at {hz} Hz", hz=hz) for hz in (0.5, 1.0, 2.0)]
    for amplitude, hz in ((A, 0.7), (1.07 * A, 1.4)):
        tested = measured(uneven, "tested", amplitude, hz)
        acceptance = judge(tested, references, tolerance=0.03, offset=0.0)
        assert (acceptance.verdict, len(acceptance.judged)) == ("passed", len(acceptance.points))
        assert abs(acceptance.worst.deviation) < 5e-3
        weak = judge(replace(tested, force=0.96 * tested.force), references, tolerance=0.03, offset=0.0)
        assert len(weak.outside) == len(weak.points)


def test_faster_slower_and_another_stroke_are_not_judged_and_say_why():
    references = [measured(dry(500.0, 50.0), hz=hz) for hz in (0.5, 1.0)]
    fast = judge(measured(dry(500.0, 50.0), "fast", hz=1.1), references)
    assert (fast.passed, fast.judged, fast.worst) == (None, (), None)
    assert fast.reason == "faster than the reference (up to 62.83 mm/s)"
    assert fast.reasons == {fast.reason: len(fast.points)}
    slow = judge(measured(dry(500.0, 50.0), "slow", hz=0.4), references)
    assert slow.reason == "slower than the reference (from 31.42 mm/s)"
    barely = judge(measured(dry(500.0, 50.0), "barely", hz=1.015), references)
    assert barely.passed is True
    wide = judge(measured(dry(500.0, 50.0), "wide", 2 * A, 0.4), references)
    assert wide.reason == "energy: the reference has another stroke at this speed (20 mm)"
    assert wide.passed is None
    assert len(wide.judged) == 2 * len(wide.points) // 3
    assert judge(measured(dry(500.0, 50.0), "wide", 2 * A, 0.4), references, quantities=["extension"]).passed is True


@pytest.mark.parametrize("nearly", [0.997, 1.0001, 1.003, 1.015])
def test_a_stroke_of_the_reference_is_judged_although_another_one_is_next_to_it(nearly):
    """Strokes at one frequency have neighbouring speeds, and a motion is never quite as fast as planned."""
    references = [measured(dry(500.0, 50.0), f"{amplitude}", amplitude) for amplitude in (0.5 * A, A, 1.5 * A)]
    tested = measured(dry(500.0, 50.0), "tested", nearly * A)
    judgement = judge(tested, references)
    assert (judgement.verdict, len(judgement.judged)) == ("passed", len(judgement.points))
    for point in judgement.points:
        if point.quantity == "energy":
            assert point.deviation == pytest.approx(energy_of(nearly * A) / (nearly * energy_of(A)) - 1.0, abs=1e-3)


def energy_of(amplitude):
    """J of a cycle at 1 Hz with F = 500 v + 50 sgn v."""
    return 500.0 * np.pi * 2.0 * np.pi * amplitude**2 + 4.0 * 50.0 * amplitude


def test_another_input_is_not_judged():
    reference = measured(dry(500.0, 50.0), voltage=1.0)
    other = judge(measured(dry(500.0, 50.0), voltage=2.0), reference)
    assert other.reason == "no reference at this input: 2 V here, 1 V there"
    assert judge(measured(dry(500.0, 50.0), voltage=1.01, seconds=7.0), reference).passed is True
    assert judge(measured(dry(500.0, 50.0), voltage=None, current=1.0), reference).passed is None
    assert judge(measured(dry(500.0, 50.0), voltage=None), reference).reason.startswith(
        "no reference at this input: no input known"
    )
    ramp = replace(reference, force=1.01 * reference.force, voltage=np.linspace(0.0, 2.0, reference.n))
    assert "a varying input in V" in judge(ramp, reference).reason
    passive = measured(dry(500.0, 50.0), voltage=None)
    assert judge(replace(passive, force=1.01 * passive.force), passive).passed is True


def test_a_record_is_never_its_own_reference():
    one, other = measured(dry(500.0, 50.0), "one"), measured(dry(400.0, 40.0), "other")
    assert judge(one, replace(one, name="copy")).reason == "the reference is this record itself"
    assert judge(one, [one, other]).verdict == "failed"


def test_what_a_card_does_not_know_is_not_judged():
    beyond = judge(replace(run(), voltage=1.0), CARD)
    assert beyond.reason == "voltage 1 V is outside the calibrated range 0 to 0 V"
    with pytest.warns(ExtrapolationWarning):
        assert judge(replace(run(), voltage=1.0), CARD, allow_extrapolation=True).passed is True
    of_current = judge(measured(dry(1.0, 1.0), voltage=None, current=1.0), CARD)
    assert of_current.reason == "the reference is over the voltage; 1 A here"
    assert "no input known here" in judge(measured(dry(1.0, 1.0), voltage=None), CARD).reason
    slow = replace(CARD, ranges={"velocity": (0.0, 0.05)})
    narrow = replace(CARD, ranges={"displacement": (0.0, 0.005)})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert judge(run(), slow).reason == "faster than the reference was calibrated (up to 50 mm/s)"
        assert "wider stroke" in judge(run(), narrow).reason
        assert judge(run(), narrow).passed is None
    assert judge(run(hz=0.5), slow).passed is True
