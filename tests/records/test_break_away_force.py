"""Break-away: the peak before sliding against the kinetic force, in closed form."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import Record
from dampyr.records.cycle_analysis.break_away_force import break_away_forces

SPEED, AMPLITUDE = 0.002, 0.005


def strokes(peak=150.0, kinetic=100.0, dwells=(2.0, 5.0), gas=0.0, noise=0.0):
    """A stroke after each dwell, there and back; the force falls from ``peak`` to ``kinetic`` within 0.2 mm."""
    t, x, force = [np.zeros(1)], [np.zeros(1)], [np.zeros(1)]
    place, way = 0.0, 1.0
    for dwell in dwells:
        s = np.arange(0.0, 2 * AMPLITUDE / SPEED, 0.002)
        rest = np.arange(0.0, dwell, 0.002)
        moved = SPEED * s
        t += [t[-1][-1] + 0.002 + rest, t[-1][-1] + 0.002 + dwell + s]
        x += [np.full(rest.size, place), place + way * moved]
        force += [np.full(rest.size, gas), gas + way * (kinetic + (peak - kinetic) * np.exp(-moved / 2e-4))]
        place, way = place + way * 2 * AMPLITUDE, -way
    f = np.concatenate(force)
    return Record(
        np.concatenate(t), np.concatenate(x), f + noise * np.random.default_rng(3).normal(size=f.size), voltage=0.0
    )


def test_peak_kinetic_force_and_dwell_of_every_stroke_are_those_that_were_made():
    found = break_away_forces(strokes())
    assert [one.extension for one in found] == [True, False]
    for one, dwell in zip(found, (2.0, 5.0), strict=True):
        assert one.force == pytest.approx(150.0, rel=5e-3)
        assert one.kinetic == pytest.approx(100.0, rel=5e-3)
        assert one.ratio == pytest.approx(1.5, rel=5e-3)
        assert one.dwell == pytest.approx(dwell, abs=0.1)
        assert one.speed == pytest.approx(SPEED, rel=1e-3)
        assert one.reason == ""


def test_a_gas_force_adds_to_one_direction_and_is_taken_from_the_other():
    extension, compression = break_away_forces(strokes(gas=20.0))
    assert (extension.kinetic, compression.kinetic) == pytest.approx((120.0, 80.0), rel=5e-3)
    assert (extension.force, compression.force) == pytest.approx((170.0, 130.0), rel=5e-3)


def test_without_a_peak_it_says_so():
    for record in (strokes(peak=100.0), strokes(peak=101.0, noise=1.0)):
        assert {one.reason for one in break_away_forces(record)} == {"no peak above the kinetic force and its noise"}


def test_without_a_rest_it_is_refused():
    t = np.arange(0.0, 5.0, 0.005)
    moving = Record(t, 0.005 * np.sin(2 * np.pi * t), np.cos(2 * np.pi * t), voltage=0.0)
    with pytest.raises(InputError, match="no stroke follows a rest"):
        break_away_forces(moving)
