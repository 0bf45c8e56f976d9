"""Response time of a step of the input: closed forms, and when there is none."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import Record
from dampyr.records.cycle_analysis.step_response import response_times

RATE, SPEED, STROKE, TAU = 1000.0, 0.03, 0.024, 0.02


def switched(tau=TAU, change=300.0, noise=0.0, at=0.3, bend=0.0, on=True):
    """An extension and a compression at a constant speed, the input switched in each; the force follows with ``tau``."""
    t = np.arange(0.0, 2 * STROKE / SPEED, 1 / RATE)
    turn = STROKE / SPEED
    x = np.where(t < turn, SPEED * t, 2 * STROKE - SPEED * t) + bend * np.sin(2 * np.pi * t / 0.2)
    u, force = np.zeros(t.size), np.zeros(t.size)
    for begin, low, high in ((at * turn, 0.0, 1.0), ((1 + at) * turn, 1.0, 0.0)):
        after = t >= begin - 1e-9
        u[after] = high
        force[after] = low + (high - low) * (1 - np.exp(-(t[after] - begin) / tau))
    force = (200.0 + change * force) * np.where(t < turn, 1.0, -1.0)
    force += noise * np.random.default_rng(1).normal(size=t.size)
    return Record(t, x, force, voltage=2.0 * u if on else 2.0)


@pytest.mark.parametrize("tau", [0.005, 0.02, 0.04])
def test_a_first_order_force_has_t63_tau_and_t90_2_3026_tau_within_a_sample(tau):
    rise, fall = response_times(switched(tau))
    assert (rise.step, rise.extension, fall.step, fall.extension) == ("rise", True, "fall", False)
    for found in (rise, fall):
        assert found.reason == ""
        assert found.speed == pytest.approx(SPEED, rel=1e-6)
        assert found.t63 == pytest.approx(tau, abs=1 / RATE)
        assert found.t90 == pytest.approx(2.3026 * tau, abs=1 / RATE)
        assert found.dead_time == pytest.approx(-tau * np.log(0.99), abs=1 / RATE)
        assert found.settled == pytest.approx(-tau * np.log(0.02), abs=2 / RATE)
    assert (rise.force_before, rise.force_after) == pytest.approx((200.0, 500.0), abs=0.1)
    assert (fall.force_before, fall.force_after) == pytest.approx((-500.0, -200.0), abs=0.1)


def test_the_time_counts_from_10_percent_of_a_ramp_of_the_input():
    record = switched()
    ramp = np.clip((record.time - 0.24) / 0.02, 0.0, 1.0) * np.clip((1.04 - record.time) / 0.02, 0.0, 1.0)
    rise, fall = response_times(record.replace(note="ramped", voltage=2.0 * ramp))
    assert rise.onset == pytest.approx(0.242, abs=1e-6)
    assert fall.onset == pytest.approx(1.022, abs=1e-6)


def test_a_step_below_the_noise_or_below_2_percent_has_no_time_and_says_why():
    (small, _), (lost, _) = response_times(switched(change=3.0)), response_times(switched(change=20.0, noise=6.0))
    assert small.t63 is small.t90 is small.settled is small.dead_time is None
    assert small.reason == "the force changes by 3 N, less than 4.06 N (5 sigma or 2 %)"
    assert lost.t63 is None
    assert "5 sigma" in lost.reason


def test_a_speed_that_varies_by_10_percent_has_no_time():
    steady, _ = response_times(switched(bend=4e-5))
    bent, _ = response_times(switched(bend=3e-4))
    assert steady.t63 is not None
    assert bent.t63 is None
    assert bent.reason.startswith("the speed varies by")


def test_noise_hides_the_dead_time_only():
    found, _ = response_times(switched(noise=2.0))
    assert found.dead_time is None
    assert found.reason.startswith("no dead time")
    assert found.t63 == pytest.approx(TAU, abs=2 / RATE)


def test_a_step_at_the_end_of_a_stroke_has_no_time():
    found = response_times(switched(at=0.98))[0]
    assert found.t63 is None
    assert "make the stroke longer" in found.reason


def test_without_a_step_it_is_refused():
    with pytest.raises(InputError, match="its input has no step"):
        response_times(switched(on=False))
