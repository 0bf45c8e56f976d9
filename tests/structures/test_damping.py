import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.structures import shear_building
from dampyr.structures.damping import modal, rayleigh

MASSES, SPRINGS = [1.0, 2.0, 3.0, 2.0], [10.0, 20.0, 40.0, 15.0]


def pole_ratios(building):
    """Damping ratios from the eigenvalues of the first-order system, by rising frequency."""
    n = building.n
    a = np.block([
        [np.zeros((n, n)), np.eye(n)],
        [-np.linalg.solve(building.M, building.K), -np.linalg.solve(building.M, building.C)],
    ])  # fmt: skip
    poles = np.linalg.eigvals(a)
    poles = poles[poles.imag > 0]
    poles = poles[np.argsort(np.abs(poles))]
    return -poles.real / np.abs(poles)


@pytest.mark.parametrize(("modes", "ratios"), [((1, 2), (0.02, 0.05)), ((1, 3), (0.03, 0.03)), ((4, 2), (0.06, 0.03))])
def test_rayleigh_is_exact_at_the_chosen_modes(modes, ratios):
    building = shear_building(MASSES, SPRINGS, damping_ratio=ratios, modes=modes)
    damping_ratios = pole_ratios(building)
    assert [damping_ratios[m - 1] for m in modes] == pytest.approx(ratios, rel=1e-9)
    pencil = np.column_stack([building.M.ravel(), building.K.ravel()])
    fit, *_ = np.linalg.lstsq(pencil, building.C.ravel(), rcond=None)
    assert pencil @ fit == pytest.approx(building.C.ravel(), abs=1e-12)


def test_one_ratio_is_a_pair_of_the_same():
    one = shear_building(MASSES, SPRINGS, damping_ratio=0.04, modes=(1, 3))
    two = shear_building(MASSES, SPRINGS, damping_ratio=(0.04, 0.04), modes=(1, 3))
    assert pytest.approx(two.C) == one.C


def test_modal_ratios_are_recovered():
    ratios = [0.01, 0.07, 0.0, 0.03]
    building = shear_building(MASSES, SPRINGS, damping_ratio=ratios, method="modal")
    assert pole_ratios(building) == pytest.approx(ratios, abs=1e-9)
    assert building.damping_ratios == pytest.approx(ratios, abs=1e-9)


def test_matrices_of_any_building_take_damping():
    building = shear_building(MASSES, SPRINGS, damping_ratio=0.05)
    assert rayleigh(building.M, building.K, 0.05) == pytest.approx(building.C)
    every = shear_building(MASSES, SPRINGS, damping_ratio=0.05, method="modal")
    assert modal(building.M, building.K, 0.05) == pytest.approx(every.C)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"damping_ratio": (0.02, 0.05), "modes": (1, 5)}, r"modes = \(1, 5\) .* from 1 to 4"),
        ({"damping_ratio": 0.02, "modes": (2, 2)}, r"two different modes"),
        ({"damping_ratio": (0.02, 0.03, 0.04)}, r"3 damping ratios are given; give one, or one for each of the two"),
        ({"damping_ratio": (0.02, 0.03), "method": "modal"}, r"2 damping ratios .* one per mode \(4 here\)"),
        ({"damping_ratio": (0.02, -0.03)}, r"damping_ratio = -0.03"),
        ({"damping_ratio": (0.05, 0.001)}, r"modes 1 and 2 give mode [34] the ratio -.*, which feeds it"),
        ({"damping_ratio": (0.001, 0.2), "modes": (1, 2)}, None),
        ({"damping_ratio": (0.0, 0.05), "modes": (2, 4)}, r"give mode 1 the ratio -"),
    ],
)
def test_ratios_that_do_not_fit(options, message):
    if message is None:  # negative alpha alone feeds nothing: there is no mode below the first
        assert np.all(shear_building(MASSES, SPRINGS, **options).damping_ratios >= 0.0)
        return
    with pytest.raises(InputError, match=message):
        shear_building(MASSES, SPRINGS, **options)
