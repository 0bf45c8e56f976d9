"""Force at mid-stroke and the gas force, in closed form."""

import numpy as np
import pytest

from dampyr.campaigns.kinds import kind
from dampyr.errors import InputError
from dampyr.records import Record
from dampyr.records.cycle_analysis.mid_stroke_force import gas_force_curve, mid_stroke_force
from dampyr.rig import RigSettings

AMPLITUDE, FREQUENCY, C, GAS, RATE = 0.01, 1.0, 5000.0, 112.0, 400.0  # RATE: N/m of the gas spring


def viscous(spike=0.0):
    """Five cycles of a viscous damper with a gas spring; a ``spike`` of force where it turns."""
    t = np.arange(0.0, 5.0, 0.001)
    x, v = AMPLITUDE * np.sin(2 * np.pi * t), 2 * np.pi * AMPLITUDE * np.cos(2 * np.pi * t)
    return Record(t, x, C * v + GAS + RATE * x + spike * (np.abs(x) > 0.5 * AMPLITUDE) * np.sign(v), voltage=0.0)


def staircase(friction=20.0, noise=0.0):
    """The step `gas_force` as a rig would follow it: at each place the gas spring, and friction by the way it was reached."""
    drive = kind("gas_force")(AMPLITUDE).drive(RigSettings())
    x, t = drive.displacement, drive.time
    way = np.sign(np.gradient(x))
    for k in range(1, x.size):  # at rest friction keeps the sign of the last motion
        way[k] = way[k] or way[k - 1]
    force = GAS + RATE * x + friction * way
    return Record(t, x, force + noise * np.random.default_rng(5).normal(size=t.size), voltage=0.0)


def test_the_largest_force_in_extension_and_the_least_in_compression_near_mid_stroke():
    found = mid_stroke_force(viscous())
    # Within 5 % of the stroke, x = +-1 mm: c v falls by 0.5 % there, and the gas spring adds 0.4 N at most.
    largest = 2 * np.pi * AMPLITUDE * C
    assert found.speed == pytest.approx(2 * np.pi * AMPLITUDE, rel=1e-3)
    assert (found.extension, found.compression) == pytest.approx((largest + GAS, GAS - largest), abs=0.5)
    assert found.place == pytest.approx(0.0, abs=1e-5)


def test_what_the_force_does_beyond_5_percent_of_the_stroke_does_not_enter():
    assert mid_stroke_force(viscous(spike=400.0)) == mid_stroke_force(viscous())


def test_it_is_that_of_the_last_whole_cycle():
    record = viscous()
    grown = record.replace(note="grown", force=record.force * (1.0 + 0.1 * np.floor(record.time)))
    assert mid_stroke_force(grown).extension == pytest.approx(1.4 * mid_stroke_force(record).extension, rel=0.03)


@pytest.mark.parametrize("noise", [0.0, 3.0])
def test_a_gas_force_of_112_newton_is_found_to_half_a_newton_through_friction(noise):
    curve = gas_force_curve(staircase(noise=noise))
    assert curve.at(0.0) == pytest.approx(GAS, abs=0.5)
    assert curve.at(0.005) == pytest.approx(GAS + RATE * 0.005, abs=0.5)
    assert curve.friction == pytest.approx(np.full(len(curve.places), 20.0), abs=0.5)
    assert len(curve.places) == 5  # the outermost two are reached from one side only


def test_without_places_or_cycles_it_is_refused():
    with pytest.raises(InputError, match="no place was reached from both sides"):
        gas_force_curve(viscous())
    t = np.arange(0.0, 3.0, 0.01)
    with pytest.raises(InputError, match="cycle"):
        mid_stroke_force(Record(t, 0.01 * t, 5.0 * t, voltage=0.0))
