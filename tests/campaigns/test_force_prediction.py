"""Force that a test will meet: the conservative envelope over the published fit, and the motion that a load slows."""

import numpy as np
import pytest

from dampyr.campaigns.force_prediction import course, envelope, original_fit
from dampyr.campaigns.kinds import kind
from dampyr.models import Damper
from dampyr.models.laws import Constant
from dampyr.rig import RigSettings

RIG = RigSettings()
SINE, REST, SWEEP = kind("sine"), kind("rest"), kind("sweep")


def test_a_force_that_pushes_the_table_on_does_not_slow_it():
    """A gas spring helps one way: only the part against the motion counts."""
    push = Damper("offset", {"offset.f0": Constant(1000.0, 0.0, 3.0)})
    motion = course(SINE(0.005, 1.0).drive(RIG), RIG, push)
    assert np.all(motion.against[motion.v < 0] == 0.0)
    assert np.all(motion.against[motion.v > 0] == 1000.0)


def test_the_envelope_lies_above_its_fit_and_is_straight_between_voltages():
    F0, k, c, Fy = original_fit()[2, 1:]
    assert envelope(np.array(-0.01), np.array(0.05), np.array(1.98)) == pytest.approx(
        1.2 * (F0 + k * 0.01 + c * 0.05 + Fy)
    )
    u = np.linspace(0.0, 0.8712, 5)
    np.testing.assert_allclose(np.diff(envelope(0 * u, 0 * u, u), 2), 0.0, atol=1e-9)
    assert envelope(np.array(0.0), np.array(0.0), np.array(4.4)) > envelope(np.array(0.0), np.array(0.0), np.array(3.2))


def test_the_envelope_lies_above_every_sample_of_the_measured_records(campaign_folder):
    """And not far above: the greatest force of the records at each voltage is at least two thirds of it."""
    from dampyr.records import read_campaign

    shares: dict[float, list[float]] = {}
    for record in read_campaign(campaign_folder):
        x = record.displacement - 0.5 * (record.displacement.max() + record.displacement.min())
        v = np.gradient(record.displacement, record.time)
        upper = envelope(x, v, np.full(x.size, record.voltage))
        assert np.all(np.abs(record.force) < upper), record.name
        shares.setdefault(record.voltage, []).append(float(np.abs(record.force).max() / upper.max()))
    assert len(shares) == 4
    assert all(max(each) > 2 / 3 for each in shares.values())
