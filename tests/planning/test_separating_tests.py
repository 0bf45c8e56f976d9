"""Where strokes go with frequencies in the records, a plan begins with three sines that tell a level from a stroke."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.identification.synthetic import sine
from tests.planning.laboratory import DAHL

from dampyr.identification import Fit, fit
from dampyr.models import Damper
from dampyr.planning import propose
from dampyr.planning.separating_tests import Separation, separate_level_from_stroke
from dampyr.records import Record, read_campaign
from dampyr.rig import RigSettings

RIG, INPUTS = RigSettings(), (0.0, 1.98)
FREQUENCIES = (0.5, 0.7, 1.0, 1.4, 2.0)


def records(amplitude: Callable[[float], float], count: int = 5, damper: Damper = DAHL) -> list[Record]:
    """Sines of so many frequencies at each input, of an amplitude [m] for each frequency."""
    return [
        sine(damper, u, f"{u:g}V-{f:g}Hz", amplitude(f), f, seconds=6.0, noise=2.0, seed=k)
        for u in INPUTS
        for k, f in enumerate(FREQUENCIES[:count])
    ]


def same_speed(frequency: float) -> float:
    return 0.05 / (2.0 * np.pi * frequency)


def separate(listed: Sequence[Record], rig: RigSettings = RIG) -> Separation | None:
    fitted = fit(listed, "dahl")
    assert isinstance(fitted, Fit)
    assert fitted.damper is not None
    return separate_level_from_stroke(fitted, rig, fitted.damper, INPUTS, 4.0)


def test_the_three_differ_in_nothing_in_the_stroke_and_in_the_frequency() -> None:
    found = separate(records(same_speed))
    assert found is not None
    assert "the larger the stroke the slower, rank correlation -1.00" in found.words
    repeated, stroke, frequency = (test.step for test in found.tests)
    assert (repeated.amplitude, repeated.frequency) == (pytest.approx(same_speed(1.0), rel=0.01), pytest.approx(1.0))
    assert stroke.frequency == repeated.frequency
    assert not 1 / 1.5 < stroke.amplitude / repeated.amplitude < 1.5
    assert frequency.amplitude == repeated.amplitude
    assert not 1 / 1.5 < frequency.frequency / repeated.frequency < 1.5
    assert {step.voltage for step in (repeated, stroke, frequency)} == {1.98}  # where the force is largest
    assert "1.98V-1Hz" in found.reasons[0]


def test_they_tell_a_weaker_session_from_a_force_that_grows_with_the_stroke() -> None:
    """Both lower the force of a small fast motion by about as much; on the three tests they differ."""
    found = separate(records(same_speed))
    assert found is not None

    def peak_force(test_damper: Damper, step: object) -> float:
        """The largest force of a sine, N."""
        t = np.arange(0.0, 4.0, 0.002)
        x = step.amplitude * np.sin(2.0 * np.pi * step.frequency * t)
        return float(np.max(np.abs(test_damper.force(t, x, voltage=1.98)[1000:])))

    repeated, stroke, _ = (test.step for test in found.tests)
    weaker = Damper("dahl", {"dahl.kx": 0.9 * 2576.0, "dahl.kw": 0.9 * 380.6, "dahl.rho": 13500.0})
    stiff = Damper("dahl + spring", {"dahl.kx": 2576.0, "dahl.kw": 380.6, "dahl.rho": 13500.0, "spring.k0": 30000.0})
    assert peak_force(weaker, repeated) == pytest.approx(0.9 * peak_force(DAHL, repeated), rel=1e-3)
    assert peak_force(weaker, stroke) / peak_force(weaker, repeated) == pytest.approx(
        peak_force(DAHL, stroke) / peak_force(DAHL, repeated), rel=1e-3
    )
    assert (
        abs(
            peak_force(stiff, stroke)
            / peak_force(stiff, repeated)
            / (peak_force(DAHL, stroke) / peak_force(DAHL, repeated))
            - 1.0
        )
        > 0.04
    )


@pytest.mark.parametrize(
    ("amplitude", "count"),
    [
        (lambda f: 0.008, 5),  # one stroke at all frequencies
        (lambda f: 0.006 + 0.004 * (f in (0.7, 1.4)), 5),  # no order
        (same_speed, 3),  # too few to tell an order
    ],
    ids=["one stroke", "no order", "three"],
)
def test_records_that_tell_need_no_such_tests(amplitude: Callable[[float], float], count: int) -> None:
    assert separate(records(amplitude, count)) is None


def test_a_damper_without_an_input_has_its_three_too() -> None:
    listed = [
        record.replace(note="no input", voltage=None, no_input=True, name=f"{record.name} passive")
        for record in records(same_speed)
        if record.voltage == 0.0
    ]
    planned = propose(listed, RIG, model="dahl", tests=4, seconds=4.0, kinds=("sine",))
    assert [bool(test.reason) for test in planned.tests] == [True, True, True, False]
    assert not any(" V" in test.candidate.words for test in planned.tests)


def test_another_stroke_at_a_frequency_of_the_records_is_enough() -> None:
    more = [*records(same_speed), sine(DAHL, 1.98, "other", 0.5 * same_speed(1.0), 1.0, seconds=6.0, noise=2.0)]
    assert separate(more) is None


def test_a_plan_begins_with_them_and_says_why() -> None:
    listed = records(same_speed)
    planned = propose(listed, RIG, model="dahl", tests=4, seconds=4.0, kinds=("sine",))
    assert [bool(test.reason) for test in planned.tests] == [True, True, True, False]
    assert planned.tests[1].why == "its stroke alone differs from the first test's"
    assert any("the first three of these tests" in note for note in planned.notes)
    assert planned.as_dict()["tests"][0]["reason"].startswith("as 1.98V-1Hz")
    few = propose(listed, RIG, model="dahl", tests=3, seconds=4.0, kinds=("sine",))
    assert not any(test.reason for test in few.tests)
    assert any("are proposed where 4 tests or more" in note for note in few.notes)
    short = propose(listed, RIG, model="dahl", tests=4, seconds=4.0, kinds=("sine",), duration=10.0)
    assert not any(test.reason for test in short.tests)


def test_a_rig_that_can_do_no_such_three_says_so() -> None:
    slow = replace(RIG, limits=replace(RIG.limits, stroke=0.004, braking=0.0))
    found = separate(records(same_speed), slow)
    assert found is not None
    assert found.tests == ()


def test_the_published_campaign_does_not_tell(campaign_folder: Path) -> None:
    listed = [r for r in read_campaign(campaign_folder, role="fit") if r.voltage in (0.0, 1.98)]
    found = separate(listed)
    assert found is not None
    assert "rank correlation -0.9" in found.words or "rank correlation -1.00" in found.words
    assert len(found.tests) == 3
