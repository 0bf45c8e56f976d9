"""A building from its matrices: what it checks, and the places between its floors."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.structures import Building, shear_building, two_storey


def test_matrices_are_copies_and_read_only():
    mass = np.eye(2)
    building = Building(mass, 0 * np.eye(2), np.eye(2))
    mass[0, 0] = 7.0
    assert building.M[0, 0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        building.M[0, 0] = 3.0


def test_a_free_mode_has_no_damping_ratio_but_is_allowed():
    building = Building(np.eye(2), np.zeros((2, 2)), [[1.0, -1.0], [-1.0, 1.0]])
    assert building.frequencies[0] == pytest.approx(0.0, abs=1e-6)
    assert np.isnan(building.damping_ratios[0])


def test_connection_of_a_storey():
    building = shear_building([1.0] * 3, [1.0] * 3, damping_ratio=0.0)
    assert building.connection(1).tolist() == [1.0, 0.0, 0.0]
    assert building.connection(3).tolist() == [0.0, -1.0, 1.0]


EYE = np.eye(2)


@pytest.mark.parametrize(
    ("matrices", "message"),
    [
        ((np.ones((2, 3)), EYE, EYE), r"M has shape \(2, 3\); it must be square"),
        ((EYE, EYE, np.eye(3)), r"differ in size \(M 2x2, C 2x2, K 3x3\)"),
        ((EYE, EYE, [[1.0, 0.5], [0.2, 1.0]]), r"K is not symmetric: .* 0.3"),
        ((np.diag([1.0, 0.0]), EYE, EYE), r"M has the eigenvalue 0; .* greater than 0"),
        ((EYE, EYE, np.diag([1.0, -2.0])), r"K has the eigenvalue -2; .* at least 0"),
        ((EYE, np.diag([-1.0, 1.0]), EYE), r"C has the eigenvalue -1; .* at least 0"),
        ((EYE, EYE, np.diag([1.0, np.nan])), r"K holds values that are not finite"),
    ],
)
def test_bad_matrices_are_refused(matrices, message):
    with pytest.raises(InputError, match=message):
        Building(*matrices)


@pytest.mark.parametrize("storey", [0, 3, 1.5, True])
def test_a_storey_that_is_not_there_is_refused(storey):
    with pytest.raises(InputError, match=r"storey .* is not in .* to 2"):
        two_storey().connection(storey)


def test_floor_labels_must_fit():
    with pytest.raises(InputError, match=r"does not label 2 floors"):
        Building(EYE, EYE, EYE, floors=["a"])
    with pytest.raises(InputError, match=r"influence has shape"):
        Building(EYE, EYE, EYE, influence=[1.0])


def test_rows_of_places(building):
    assert building.connection(2).tolist() == [-1.0, 1.0, 0.0]
    assert building.connection((1, 2)).tolist() == [-1.0, 1.0, 0.0]
    assert building.connection((0, 2)).tolist() == [0.0, 1.0, 0.0]
    assert building.connection(("ground", "middle")).tolist() == [0.0, 1.0, 0.0]
    assert building.connection(("low", 3)).tolist() == [-1.0, 0.0, 1.0]
    assert building.connection((3, 1)).tolist() == [1.0, 0.0, -1.0]


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ((0, 4), r"floor 4 is not in three floors; write 0 .* up to 3, or a label: low, middle, top"),
        (("low", "attic"), r"floor 'attic' is not in"),
        ((2, 2), r"joins floor 2 to itself"),
        ((1, 2, 3), r"names 3 floors; .* between 2"),
        ((0, True), r"floor True is not in"),
    ],
)
def test_a_place_that_is_not_there(building, place, message):
    with pytest.raises(InputError, match=message):
        building.connection(place)


def test_a_floor_may_not_be_called_as_the_ground_is():
    with pytest.raises(InputError, match=r"a floor is called 'ground'"):
        Building(np.eye(2), np.eye(2), np.eye(2), floors=("ground", "first"))
