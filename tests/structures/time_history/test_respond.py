"""A building with dampers under a motion: where they stand, what is left out, and what is refused."""

import math

import numpy as np
import pytest
from tests.structures.begin_of_el_centro import short

from dampyr.errors import DampyrWarning, ExtrapolationWarning, InputError, RangeError
from dampyr.ground_motions import GroundMotion
from dampyr.models import Damper
from dampyr.structures import respond, shear_building, single_mass, two_storey


def test_a_damper_alone_stands_in_storey_1(cubics):
    alone = respond(two_storey(), short(1.0), cubics, voltage=1.0, step=0.005)
    mapped = respond(two_storey(), short(1.0), {1: cubics}, voltage=1.0, step=0.005)
    assert alone.sites == mapped.sites == ("storey 1",)
    assert np.array_equal(alone.displacement, mapped.displacement)
    assert np.array_equal(alone.force, mapped.force)


def test_what_is_neither_a_damper_nor_a_mapping_is_refused():
    with pytest.raises(InputError, match=r"dampers is a str; write a damper, which stands in storey 1, or a mapping"):
        respond(two_storey(), short(1.0), "dahl", voltage=1.0)


@pytest.mark.prove  # its kernel takes long to compile
def test_the_static_force_is_left_out(cubics):
    kx, kw, rho = cubics.values(0.0)
    laws = {"dahl.kx": kx, "dahl.kw": kw, "dahl.rho": rho, "offset.f0": 130.0}
    with_offset = respond(two_storey(), short(3.0), {1: Damper("dahl + offset", laws)}, voltage=0.0, step=0.002)
    without = respond(two_storey(), short(3.0), {1: cubics}, voltage=0.0, step=0.002)
    assert with_offset.displacement == pytest.approx(without.displacement, abs=1e-14)


@pytest.mark.filterwarnings("ignore:the damper in storey 1 fed")
def test_a_delay_shorter_than_can_be_resolved_is_refused(late):
    laws = dict(late.laws) | {"delay.tau": 1e-5}
    with pytest.raises(InputError, match=r"delay of 1e-05 s.*set it to 0"):
        respond(two_storey(), short(1.0), {1: Damper("dahl + delay", laws)}, voltage=0.0)


def test_a_damper_that_feeds_the_building_is_reported():
    feeding = Damper("dahl + delay", {"dahl.kx": 900.0, "dahl.kw": 1e-9, "dahl.rho": 1000.0, "delay.tau": 0.25})
    with pytest.warns(DampyrWarning, match="storey 1 fed"):
        respond(two_storey(), short(4.0), {1: feeding}, voltage=0.0)


def test_shear_building_of_twenty_storeys(cubics):
    building = shear_building([1000.0] * 20, [2e6] * 20, damping_ratio=0.02)
    response = respond(building, short(2.0), {20: cubics}, voltage=0.0, step=0.002)
    fine = respond(building, short(2.0), {20: cubics}, voltage=0.0, step=0.0005)
    assert response.peak_drift == pytest.approx(fine.peak_drift, rel=1e-3)


def test_extrapolation_is_asked_for_by_name(cubics):
    with pytest.raises(RangeError, match=r"3.6"):
        respond(two_storey(), short(1.0), {1: cubics}, voltage=3.6)
    with pytest.warns(ExtrapolationWarning) as caught:
        respond(two_storey(), short(1.0), {1: cubics}, voltage=3.6, allow_extrapolation=True)
    assert len(caught) == 1


def test_motion_outside_the_calibrated_ranges_is_named(cubics):
    small = Damper("dahl", dict(cubics.laws), ranges={"displacement": (0.0, 0.001)})
    with pytest.warns(DampyrWarning, match=r"displacement of .* calibrated up to 0.001 m"):
        response = respond(two_storey(), short(3.0), {1: small}, voltage=0.0)
    assert len(response.doubts) == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (lambda d: {"dampers": {3: d}, "voltage": 0.0}, r"storey 3 is not in .* from 1 .* to 2"),
        (lambda d: {"dampers": {0: d}, "voltage": 0.0}, r"storey 0 is not in"),
        (
            lambda d: {"dampers": 3.0, "voltage": 0.0},
            r"dampers is a float; write a damper, .* or a mapping from storey",
        ),
        (lambda d: {"dampers": {1: 3.0}, "voltage": 0.0}, r"holds a float"),
        (lambda d: {"dampers": {1: d}}, r"has no voltage; write voltage="),
        (lambda d: {"dampers": {1: d}, "current": 0.5}, r"takes a voltage"),
        (lambda d: {"dampers": {1: d}, "voltage": 0.5, "current": 0.5}, r"one of the two"),
        (lambda d: {"dampers": {1: d}, "voltage": math.nan}, r"not a finite number"),
        (lambda d: {"dampers": {1: d}, "voltage": {1: 0.0, 2: 1.0}}, r"storey 2, which holds no damper"),
        (lambda d: {"dampers": {1: d}, "voltage": 0.0, "accuracy": "sloppy"}, r"choose from strict, fast"),
        (
            lambda d: {"dampers": {1: d}, "voltage": 0.0, "accuracy": 0.0},
            r"greater than 0 and at most 1; or choose from strict, fast",
        ),
        (
            lambda d: {"dampers": {1: d}, "voltage": 0.0, "step": 0.003},
            r"nearest that do are 0.00333333 s or 0.00285714 s",
        ),
        (lambda d: {"dampers": {1: d}, "voltage": 0.0, "step": -1.0}, r"greater than 0"),
    ],
)
def test_bad_arguments_are_one_helpful_sentence(cubics, arguments, message):
    with pytest.raises(ValueError, match=message):
        respond(two_storey(), short(1.0), **arguments(cubics))


def test_a_response_goes_on_after_the_record() -> None:
    """A pulse on an oscillator of 5 s, whose peak comes after it: that of the free vibration, by its closed form."""
    motion = GroundMotion(np.array([0.0, 1.0, 1.0, 0.0]), 0.1, "pulse")
    omega, zeta = 2 * np.pi / 5.0, 0.02
    tower = single_mass(100.0, stiffness=100.0 * omega**2, damping_ratio=zeta)
    ended, gone_on = respond(tower, motion), respond(tower, motion, after=10.0)
    assert gone_on.time[-1] == pytest.approx(10.3)
    np.testing.assert_allclose(gone_on.displacement[:, :4], ended.displacement, rtol=1e-12)
    damped = omega * np.sqrt(1 - zeta**2)
    x, v = ended.displacement[0, -1], ended.velocity[0, -1]
    t = np.linspace(0.0, 5.0, 50_001)
    free = np.exp(-zeta * omega * t) * (x * np.cos(damped * t) + (v + zeta * omega * x) / damped * np.sin(damped * t))
    assert gone_on.peak_displacement[0] == pytest.approx(np.abs(free).max(), rel=1e-6)
    assert gone_on.peak_displacement[0] > 5 * ended.peak_displacement[0]
    assert "ends with the record: what still swings then may reach its peak later" in repr(ended)
    assert "ends 10 s after the record" in repr(gone_on)
    assert (ended.as_dict()["after_s"], gone_on.to_xarray().attrs["after_s"]) == (0.0, 10.0)
    for wrong, words in ((-1.0, "at least 0"), (np.nan, "at least 0"), (True, 'must be a quantity such as "1 s"')):
        with pytest.raises(InputError, match=f"after = .*{words}"):
            respond(tower, motion, after=wrong)
