"""True of every kind of step in the catalogue."""

from __future__ import annotations

import dataclasses
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dampyr.campaigns import available_steps
from dampyr.campaigns.check import STROKE_MARGIN, violations_of
from dampyr.campaigns.force_prediction import course
from dampyr.campaigns.kinds import kind
from dampyr.campaigns.step import words
from dampyr.config import origin, split
from dampyr.errors import InputError
from dampyr.rig import RigSettings
from dampyr.studies import raminelli_2020

RIG = RigSettings()
DAMPER = raminelli_2020.damper()
BY_NAME = {"start": 0.2, "stop": 1.5, "voltages": (0.0, 1.98), "duration": 5.0, "half_period": 0.2}
BY_UNIT = {"m": 0.006, "Hz": 0.8, "V": 1.98, "s": 2.0, "m/s": 0.004, "": 0.5}
SPANS = {"m": (1e-4, 0.05), "Hz": (0.05, 4.0), "V": (0.0, 4.0), "s": (0.3, 8.0), "m/s": (5e-4, 0.1), "": (0.02, 1.0)}


def typical(name: str, **others: Any) -> Any:
    """A step of this kind with a value for each field that has no default."""
    cls = kind(name)
    hints = get_type_hints(cls, include_extras=True)
    required = [f.name for f in dataclasses.fields(cls) if f.default is dataclasses.MISSING]
    arguments = {key: BY_NAME.get(key, BY_UNIT[split(hints[key])[1].unit]) for key in required}
    return cls(**arguments | others)


def numeric(drive: Any) -> tuple[float, float]:
    """The farthest position and the greatest speed between set points."""
    return float(np.abs(drive.displacement).max()), float(np.abs(np.diff(drive.displacement)).max() / drive.period)


@pytest.mark.parametrize("name", available_steps())
def test_it_begins_and_ends_at_rest_in_the_middle(name: str) -> None:
    drive = typical(name).drive(RIG)
    ends = [*drive.displacement[:20], *drive.displacement[-20:]]
    np.testing.assert_allclose(ends, 0.0, atol=1e-12)


@pytest.mark.parametrize("name", [n for n in available_steps() if typical(n).drive(RIG).reversals is None])
def test_its_peaks_are_those_of_its_path(name: str) -> None:
    step = typical(name, period=0.001)
    drive, peaks = step.drive(RIG), step.peaks(RIG)
    position, speed = numeric(drive)
    assert position == pytest.approx(peaks.position, rel=1e-3, abs=1e-12)
    assert speed == pytest.approx(peaks.speed, rel=1e-3, abs=1e-12)


@pytest.mark.parametrize("name", available_steps())
def test_its_speed_has_no_jumps(name: str) -> None:
    """Halving the period halves the change of speed from one set point to the next."""
    changes = []
    for period in (0.004, 0.002):
        x = typical(name, period=period).drive(RIG).displacement
        changes.append(float(np.abs(np.diff(x, 2)).max()) / period)
    assert changes[1] <= 0.62 * changes[0]


@pytest.mark.parametrize("name", available_steps())
def test_it_is_the_same_each_time(name: str) -> None:
    one, other = typical(name).drive(RIG), typical(name).drive(RIG)
    np.testing.assert_array_equal(one.displacement, other.displacement)
    np.testing.assert_array_equal(one.voltage, other.voltage)


@pytest.mark.parametrize(
    "name", [n for n in available_steps() if "seed" in {f.name for f in dataclasses.fields(kind(n))}]
)
def test_another_seed_gives_another_drive(name: str) -> None:
    one, other = typical(name, seed=1).drive(RIG), typical(name, seed=2).drive(RIG)
    same = np.array_equal(one.displacement, other.displacement) and np.array_equal(one.voltage, other.voltage)
    assert not same


@pytest.mark.parametrize("name", available_steps())
def test_it_says_what_it_is(name: str) -> None:
    cls, module = kind(name), __import__(kind(name).__module__, fromlist=["x"])
    assert cls.__doc__
    assert ".. math::" in module.__doc__, "the equation of its path"
    hints = get_type_hints(cls, include_extras=True)
    assert not [f.name for f in dataclasses.fields(cls) if not origin(hints[f.name])], "a field without words"
    assert set(cls.lowers) <= set(hints)
    assert words(name, typical(name)).startswith(name.replace("_", " "))


@pytest.mark.parametrize("name", available_steps())
@settings(max_examples=5, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_what_passes_the_check_stays_within_the_limits(name: str, data: st.DataObject) -> None:
    stays_within_the_limits_if_it_passes_the_check(name, data)


@pytest.mark.prove
@pytest.mark.parametrize("name", available_steps())
@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_what_passes_the_check_stays_within_the_limits_in_many_draws(name: str, data: st.DataObject) -> None:
    stays_within_the_limits_if_it_passes_the_check(name, data)


def stays_within_the_limits_if_it_passes_the_check(name: str, data: st.DataObject) -> None:
    """By the definition of each limit, computed here from the set points alone."""
    step = drawn(name, data)
    if step is None or violations_of(step, RIG, DAMPER):
        return
    drive = step.drive(RIG)
    position, speed = numeric(drive)
    assert position <= RIG.limits.stroke / 2 - STROKE_MARGIN + 1e-9
    assert speed <= RIG.limits.speed
    assert drive.voltage.max() <= min(RIG.limits.voltage, DAMPER.range[1]) + 1e-9
    assert drive.voltage.min() >= 0.0
    if drive.reversals is not None:
        way = step.duty * RIG.actuator.free_speed * (step.half_period / 2 + step.pause)
        assert way <= RIG.limits.stroke / 2
        return
    motion = course(drive, RIG, DAMPER)
    force = DAMPER.force(motion.t, motion.x, voltage=drive.voltage, velocity=motion.v)
    braking = np.where(force * motion.v > 0, np.abs(force), 0.0)
    left = RIG.actuator.free_speed - RIG.actuator.droop * (braking + RIG.table.friction)
    chord = np.abs(np.diff(drive.displacement)) / drive.period
    assert np.all(chord <= left[1:] + 1e-9)
    assert np.abs(force).max() <= RIG.limits.force


def drawn(name: str, data: st.DataObject) -> Any:
    """A step with every measured field drawn, or None where such a step cannot be made."""
    cls = kind(name)
    arguments: dict[str, Any] = {}
    for f in dataclasses.fields(cls):
        hint, quantity = split(get_type_hints(cls, include_extras=True)[f.name])
        if quantity is None or hint is int or quantity.unit == "degC" or f.name in ("period", "rest_before"):
            continue
        low, high = SPANS[quantity.unit]
        value = st.floats(max(low, quantity.low if np.isfinite(quantity.low) else low), min(high, quantity.high))
        several = get_origin(hint) is tuple and bool(get_args(hint))
        arguments[f.name] = tuple(data.draw(st.lists(value, min_size=1, max_size=3))) if several else data.draw(value)
    try:
        return cls(**arguments)
    except InputError:
        return None
