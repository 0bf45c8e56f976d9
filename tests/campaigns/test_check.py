"""The check before motion: each limit, what it says, and that the value it proposes is the largest that passes."""

import re
from dataclasses import replace
from math import pi

import numpy as np
import pytest

from dampyr import campaigns
from dampyr.campaigns.check import STROKE_MARGIN, largest, repairs, violations_of
from dampyr.campaigns.kinds import kind
from dampyr.models import Damper
from dampyr.models.laws import Constant
from dampyr.rig import RigSettings
from dampyr.studies import raminelli_2020
from dampyr.units import parse

RIG = RigSettings()
TANH = {"hyperbolic_tangent.ft": 0.0, "hyperbolic_tangent.v0": 0.01, "hyperbolic_tangent.s": 0.0}
DASHPOT = Damper("hyperbolic_tangent", TANH | {"hyperbolic_tangent.c": Constant(3000.0, 0.0, 3.0)})
SINE, REST, SWEEP = kind("sine"), kind("rest"), kind("sweep")


def rig(**parts):
    """The original rig with other values: ``rig(actuator={"lag": 1e-9})``."""
    return replace(RIG, **{part: replace(getattr(RIG, part), **values) for part, values in parts.items()})


def limits(step, settings=RIG, damper=None):
    return [each.limit for each in violations_of(step, settings, damper)]


def test_a_sine_that_the_rig_can_do_passes():
    assert violations_of(SINE(0.008, 1.0, 1.98), RIG) == ()


def test_the_speed_at_which_a_dashpot_stops_it_is_the_closed_form():
    """2 pi f A against free - droop*(c v + friction): v_max = (free - droop*friction)/(1 + droop*c), without lag."""
    settings = rig(actuator={"lag": 1e-9})
    max_speed = (0.078 - 2e-5 * 15.0) / (1 + 2e-5 * 3000.0)
    largest_amplitude = largest(SINE(0.030, 1.0), "amplitude", settings, DASHPOT)
    assert 2 * pi * largest_amplitude == pytest.approx(max_speed, rel=0.01)
    assert 2 * pi * largest_amplitude <= max_speed
    assert limits(SINE(1.001 * max_speed / (2 * pi), 1.0), settings, DASHPOT) == ["speed"]


def test_the_lag_of_the_motor_takes_its_share():
    """A first-order lag needs sqrt(1 + (2 pi f tau)^2) times the speed of a sine, without load; a short taper needs more."""
    settings = rig(actuator={"lag": 0.05, "droop": 0.0})
    share = np.hypot(1.0, 2 * pi * 2.0 * 0.05)
    largest_amplitude = largest(SINE(0.010, 2.0, taper=6, period=0.002), "amplitude", settings)
    assert 2 * pi * 2.0 * largest_amplitude == pytest.approx(0.078 / share, rel=0.01)
    assert largest(SINE(0.010, 2.0, taper=1, period=0.002), "amplitude", settings) < largest_amplitude
    [finding] = violations_of(SINE(0.98 * 0.078 / (4 * pi), 2.0), settings)
    assert "with what its lag takes" in finding.words


def test_a_refusal_says_what_is_needed_what_there_is_and_what_would_do():
    plan = campaigns.plan(
        campaigns.campaign_of({"step": [{"kind": "sine", "amplitude": "20 mm", "frequency": "2 Hz"}]})
    )
    [text] = plan.refusals
    assert text.startswith("step 1, sine 20 mm at 2 Hz, 0 V: needs 251.3 mm/s, the actuator gives ")
    gives, load = re.search(r"gives ([\d.]+) mm/s at (\d+) N", text).groups()
    assert float(gives) == pytest.approx(78 - 0.02 * float(load), abs=0.02)
    amplitude, frequency = re.search(
        r"lower the amplitude to ([\d.]+ mm) or the frequency to ([\d.]+ Hz)$", text
    ).groups()
    for step in (SINE(parse(amplitude, "m"), 2.0), SINE(0.020, parse(frequency, "Hz"))):
        assert violations_of(step, RIG) == ()


@pytest.mark.parametrize("damper", [None, raminelli_2020.damper()], ids=["envelope", "card"])
@pytest.mark.parametrize(
    ("step", "field"),
    [
        (SINE(0.020, 2.0), "amplitude"),
        (SINE(0.020, 2.0, 3.2), "frequency"),
        (SINE(0.010, 0.1, 6.0), "voltage"),
        (SINE(0.045, 0.05), "amplitude"),
        (SWEEP(0.02, 0.1, 5.0), "stop"),
        (kind("random")(0.03, high=3.0), "amplitude"),
        (kind("earthquake")(), "scale"),
        (kind("quasi_static")(0.02, speed=0.2), "speed"),
        (kind("voltage_steps")(0.02, 2.0, voltages=(0.0, 3.0)), "frequency"),
        (kind("random_voltage")(0.01, 0.2, high=9.0), "high"),
        (kind("reversals")(1.2), "half_period"),
        (REST(9000.0, period=0.05), "duration"),
    ],
    ids=lambda value: value if isinstance(value, str) else type(value).__name__,
)
def test_the_value_that_is_proposed_passes_and_one_per_cent_more_does_not(step, field, damper):
    assert violations_of(step, RIG, damper)
    value = largest(step, field, RIG, damper)
    assert violations_of(replace(step, **{field: value}), RIG, damper) == ()
    assert violations_of(replace(step, **{field: 1.01 * value}), RIG, damper)


def test_nothing_is_proposed_where_lowering_it_does_not_help():
    assert largest(SINE(0.020, 2.0, 1.0), "voltage", RIG) is None
    assert largest(SINE(0.020, 2.0, 0.0), "voltage", RIG) is None
    assert not [way for way in repairs(SINE(0.020, 2.0, 1.0), RIG) if "voltage" in way]


def test_the_stroke_counts_the_centre_and_some_room():
    max_position = RIG.travel - STROKE_MARGIN
    assert limits(SINE(max_position - 0.010, 0.1, centre=0.010)) == []
    assert limits(SINE(max_position - 0.0099, 0.1, centre=-0.010)) == ["stroke"]


def test_several_limits_are_told_together_each_with_its_repair():
    step = {"kind": "sine", "amplitude": "40 mm", "frequency": "0.1 Hz", "voltage": "5 V"}
    [text] = campaigns.plan(campaigns.campaign_of({"step": [step]})).refusals
    assert "needs 5 V at the coil, the limit is 4.4 V; lower the voltage to 4.4 V; it also goes 40 mm" in text
    assert text.endswith("lower the amplitude to 35.9 mm")


def test_the_voltage_stays_in_the_range_of_the_card():
    damper = raminelli_2020.damper()
    assert limits(SINE(0.005, 1.0, 3.212), RIG, damper) == []
    assert limits(SINE(0.005, 1.0, 3.3), RIG, damper) == ["voltage"]
    assert limits(SINE(0.005, 1.0, 3.3), RIG) == []
    assert largest(SINE(0.005, 1.0, 4.0), "voltage", RIG, damper) == 3.21


def test_a_damper_over_the_current_is_asked_through_the_coils_resistance():
    damper = Damper("hyperbolic_tangent", TANH | {"hyperbolic_tangent.c": Constant(900.0, 0.0, 0.5)}, input="A")
    assert limits(SINE(0.005, 1.0, 0.5 * 4.4), RIG, damper) == []
    assert limits(SINE(0.005, 1.0, 0.51 * 4.4), RIG, damper) == ["voltage"]


def test_a_warm_up_to_a_temperature_needs_a_thermocouple_and_a_limit_above_it():
    warm = kind("warm_up")(0.005, 1.0, temperature=40.0)
    wired = rig(wires={"temperature": "ai1"})
    assert limits(warm) == ["temperature"]
    assert limits(warm, wired) == []
    assert limits(replace(warm, temperature=71.0), wired) == ["temperature"]


def test_force_and_speed_have_limits_of_their_own():
    assert limits(SINE(0.008, 1.0, 1.98), rig(limits={"force": 300.0})) == ["force"]
    fast = rig(limits={"speed": 0.04})
    [finding] = violations_of(SINE(0.008, 1.0), fast)
    assert finding.words == "reaches 50.27 mm/s, the limit is 40 mm/s"
    assert limits(kind("reversals")(0.2, duty=1.0), fast) == ["speed"]
    assert (
        "may meet, by a conservative envelope,"
        in violations_of(SINE(0.008, 1.0), rig(limits={"force": 200.0}))[0].words
    )


def test_long_tests_are_refused():
    assert limits(SINE(0.005, 0.01, cycles=100)) == ["duration"]


def test_the_largest_duty_lowers_the_speed_that_the_actuator_gives():
    """(0.5 - 0.06)/(1 - 0.06) of the free speed at half duty, in the Uno's 127 of 255."""
    settings = rig(actuator={"lag": 1e-9, "droop": 0.0, "max_duty": 0.5})
    share = (127 / 255 - 0.06) / 0.94
    largest_amplitude = largest(SINE(0.030, 1.0), "amplitude", settings)
    assert 2 * pi * largest_amplitude == pytest.approx(0.078 * share, rel=0.01)
    assert RIG.actuator.top_speed == RIG.actuator.free_speed


def test_reversals_with_more_than_the_largest_duty_are_refused_before_the_uno_refuses_them():
    step = kind("reversals")(half_period=0.2, duty=1.0, count=2)
    assert limits(step) == []
    [finding] = violations_of(step, rig(actuator={"max_duty": 0.98}))
    assert finding.limit == "duty"
    assert "asks for a duty of 1, the largest is 0.98 (actuator.max_duty)" in finding.words
