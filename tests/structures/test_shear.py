"""Shear buildings and single masses: springs, closed forms, damping."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.structures import respond, shear_building, single_mass


def test_a_single_mass_under_a_constant_push_follows_the_closed_form():
    zeta, f, a = 0.05, 1.6, 0.7
    omega, t = 2 * np.pi * f, 0.02 * np.arange(300)
    response = respond(single_mass(800.0, frequency=f, damping_ratio=zeta), GroundMotion(np.full(300, a), 0.02))
    ringing = omega * np.sqrt(1 - zeta**2)
    decay = np.exp(-zeta * omega * t)
    shape = np.cos(ringing * t) + zeta * omega / ringing * np.sin(ringing * t)
    expected = -a / omega**2 * (1.0 - decay * shape)
    assert response.displacement[0] == pytest.approx(expected, abs=1e-12)
    top = a / omega**2 * (1.0 + np.exp(-zeta * np.pi / np.sqrt(1 - zeta**2)))
    assert response.peak_displacement[0] == pytest.approx(top, rel=1e-6)


def test_frequency_or_stiffness_say_the_same():
    by_stiffness = single_mass(5.0, stiffness=2000.0, damping_ratio=0.02)
    by_frequency = single_mass(5.0, frequency=20.0 / (2 * np.pi), damping_ratio=0.02)
    assert by_stiffness.K[0, 0] == pytest.approx(by_frequency.K[0, 0])
    assert by_stiffness.C[0, 0] == pytest.approx(2 * 0.02 * 20.0 * 5.0)


def test_mass_does_not_matter_to_a_single_mass():
    light, heavy = (respond(single_mass(m, frequency=2.0, damping_ratio=0.02), el_centro()) for m in (1.0, 900.0))
    assert light.displacement == pytest.approx(heavy.displacement, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, r"either frequency= in Hz or stiffness= in N/m"),
        ({"frequency": 1.0, "stiffness": 1.0}, r"give one of the two"),
        ({"frequency": -1.0}, r"frequency = \[-1.0\] must be"),
        ({"stiffness": 1.0, "damping_ratio": (0.02, 0.03)}, r"2 damping ratios are given"),
    ],
)
def test_wrong_single_masses_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        single_mass(1.0, **arguments)


@pytest.mark.prove
def test_twenty_storeys_with_several_dampers(cubics, tangent):
    building = shear_building([2e4] * 20, np.linspace(40e6, 15e6, 20), damping_ratio=(0.02, 0.03), modes=(1, 4))
    motion = GroundMotion(np.asarray(el_centro().acceleration)[:151], 0.02, "start of El Centro")
    dampers = {1: tangent, (0, 3): cubics, ("18", "20"): cubics}
    voltage = {1: 0.0, (0, 3): 1.98, (18, 20): 1.98}
    response = respond(building, motion, dampers, voltage=voltage)
    fine = respond(building, motion, dampers, voltage=voltage, step=0.00025)
    assert response.converged
    assert response.sites == ("storey 1", "0-3", "18-20")
    assert response.peak_drift == pytest.approx(fine.peak_drift, rel=1e-3)
    assert np.abs(fine.energy.residual).max() < 1e-6 * fine.energy.input.max()


def test_a_pair_of_ratios_needs_two_modes():
    with pytest.raises(InputError, match=r"2 damping ratios are given; give one"):
        shear_building([1.0], [1.0], damping_ratio=(0.02, 0.03))


def test_numbers_may_be_texts_with_units() -> None:
    texts = shear_building(["0.4 t", "300 kg"], ["500 kN/m", 4e5], dashpots=["1 kN s/m", 900.0])
    numbers = shear_building([400.0, 300.0], [5e5, 4e5], dashpots=[1000.0, 900.0])
    assert np.array_equal(texts.M, numbers.M)
    assert np.array_equal(texts.K, numbers.K)
    assert np.array_equal(texts.C, numbers.C)
    with pytest.raises(InputError, match=r"^masses: the unit 'm' does not measure what 'kg' measures"):
        shear_building(["0.4 m"], ["500 kN/m"], damping_ratio=0.02)
    tower = single_mass("20 t", frequency="1.5 Hz", damping_ratio=0.05)
    assert np.array_equal(tower.K, single_mass(2e4, frequency=1.5, damping_ratio=0.05).K)


def test_shear_building_stacks_springs():
    building = shear_building([1.0, 2.0, 3.0], [10.0, 20.0, 40.0], dashpots=[1.0, 0.0, 0.0])
    assert building.K.tolist() == [[30.0, -20.0, 0.0], [-20.0, 60.0, -40.0], [0.0, -40.0, 40.0]]
    assert building.C.tolist() == [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]


def test_uniform_shear_building_has_the_closed_form_frequencies():
    n, k, m = 6, 4e5, 700.0
    expected = np.sqrt(k / m) / np.pi * np.sin((2 * np.arange(1, n + 1) - 1) * np.pi / (2 * (2 * n + 1)))
    assert shear_building([m] * n, [k] * n, damping_ratio=0.0).frequencies == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("method", ["rayleigh", "modal"])
def test_damping_ratio_is_met(method):
    building = shear_building([1.0, 2.0, 3.0], [10.0, 20.0, 40.0], damping_ratio=0.05, method=method)
    ratios = building.damping_ratios
    assert ratios[:2] == pytest.approx([0.05, 0.05], rel=1e-9)
    assert (ratios[2] == pytest.approx(0.05, rel=1e-9)) == (method == "modal")


def test_one_storey_with_a_ratio():
    building = shear_building([2.0], [50.0], damping_ratio=0.05)
    assert building.C[0, 0] == pytest.approx(2 * 0.05 * 5.0 * 2.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"masses": [1.0], "stiffnesses": [1.0, 2.0], "damping_ratio": 0.0}, r"1 masses and 2 stiffnesses"),
        (
            {"masses": [1.0, -1.0], "stiffnesses": [1.0, 2.0], "damping_ratio": 0.0},
            r"masses = .* greater than 0",
        ),
        ({"masses": [1.0], "stiffnesses": [1.0]}, r"either damping_ratio= or dashpots="),
        ({"masses": [1.0], "stiffnesses": [1.0], "damping_ratio": 3.0}, r"damping_ratio = 3 .* below 1"),
        (
            {"masses": [1.0], "stiffnesses": [1.0], "damping_ratio": 0.03, "method": "caughey"},
            r"'rayleigh' or 'modal'",
        ),
        ({"masses": [1.0], "stiffnesses": [1.0], "dashpots": [-1.0]}, r"dashpots = .* at least 0"),
    ],
)
def test_bad_shear_buildings_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        shear_building(**arguments)
