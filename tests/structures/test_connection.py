import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.models import Damper
from dampyr.structures import Building, respond, shear_building, state_space
from dampyr.structures.time_history.linear_response import peak_displacement

MOTION = GroundMotion(np.asarray(el_centro().acceleration)[:201], 0.02, "start of El Centro")


@pytest.fixture(scope="module")
def building() -> Building:
    made = shear_building([150.0, 140.0, 120.0], [140e3, 110e3, 80e3], damping_ratio=0.03)
    return Building(made.M, made.C, made.K, "three floors", floors=("low", "middle", "top"))


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


@pytest.mark.prove
def test_a_linear_damper_over_two_storeys_is_part_of_the_building(building):
    """Its spring and dashpot, put into the matrices by hand, give the same motion."""
    k, c, row = 30e3, 2e3, np.array([-1.0, 0.0, 1.0])
    part = Damper("spring + dahl", {"spring.k0": k, "dahl.kx": c, "dahl.kw": 1e-9, "dahl.rho": 1000.0})
    both = Building(building.M, building.C + c * np.outer(row, row), building.K + k * np.outer(row, row))
    expected = respond(both, MOTION, step=0.001)
    response = respond(building, MOTION, {(1, 3): part}, voltage=0.0, step=0.001)
    assert response.displacement == pytest.approx(expected.displacement, abs=1e-8)
    assert response.stroke[0] == pytest.approx(response.displacement[2] - response.displacement[0], abs=0)
    assert response.force[0] == pytest.approx(k * response.stroke[0] + c * (row @ response.velocity), abs=1e-6)
    assert response.base_shear == pytest.approx(expected.base_shear, abs=1e-3)


def test_a_pair_of_neighbours_is_a_storey(building, cubics):
    pair = respond(building, MOTION, {("low", "middle"): cubics}, voltage={(1, 2): 1.98}, step=0.002)
    storey = respond(building, MOTION, {2: cubics}, voltage={2: 1.98}, step=0.002)
    assert np.array_equal(pair.displacement, storey.displacement)
    assert pair.storeys == storey.storeys == (2,)
    assert pair.sites == storey.sites == ("storey 2",)


def test_a_connection_turned_round_turns_its_stroke_and_force(building, cubics):
    up = respond(building, MOTION, {(0, 2): cubics}, voltage=1.98, step=0.002)
    down = respond(building, MOTION, {(2, 0): cubics}, voltage=1.98, step=0.002)
    assert up.displacement == pytest.approx(down.displacement, abs=1e-12)
    assert up.stroke == pytest.approx(-down.stroke, abs=1e-12)
    assert up.force == pytest.approx(-down.force, abs=1e-6)


@pytest.mark.prove
def test_a_response_says_where_its_dampers_stand(building, cubics):
    dampers = {1: cubics, (0, 2): cubics, ("low", "top"): cubics}
    response = respond(building, MOTION, dampers, voltage={1: 0.0, (0, "middle"): 1.98, (1, 3): 0.5}, step=0.005)
    assert response.sites == ("storey 1", "0-middle", "low-top")
    assert response.storeys == (1, 0, 0)
    assert response.inputs == (0.0, 1.98, 0.5)
    data = response.to_xarray()
    assert data.damper_site.values.tolist() == ["storey 1", "0-middle", "low-top"]
    assert data.damper_storey.values.tolist() == [1, 0, 0]


@pytest.mark.parametrize(
    ("dampers", "voltage", "message"),
    [
        ({(0, 2): 3.0}, 0.0, r"between floors 0 and 2 holds a float"),
        ({(0, 2): None}, {(0, 3): 0.0}, r"input is given for floors 0-3, which holds no damper; .* floors 0-2"),
        ({(0, 2): None}, {1: 0.0, (0, 1): 0.0}, r"two inputs are given for the place in storey 1"),
        ({(0, 2): None}, None, r"damper between floors 0 and 2 has no voltage"),
        ({(0, 9): None}, 0.0, r"floor 9 is not in"),
    ],
)
def test_wrong_placements_are_one_helpful_sentence(building, cubics, dampers, voltage, message):
    given = {place: cubics if damper is None else damper for place, damper in dampers.items()}
    if isinstance(voltage, dict) and (0, 3) in voltage:
        voltage |= {(0, 2): 0.0}
    with pytest.raises(InputError, match=message):
        respond(building, MOTION, given, voltage=voltage)


def test_the_calibrated_stroke_holds_over_two_storeys_too(building, cubics):
    small = Damper("dahl", dict(cubics.laws), ranges={"displacement": (0.0, 0.002)})
    with pytest.warns(UserWarning, match=r"damper between floors 0 and 2 reaches a displacement of"):
        response = respond(building, MOTION, {(0, 2): small}, voltage=0.0)
    assert len(response.doubts) == 1


def test_the_largest_stroke_lies_between_samples():
    t = np.arange(0.0, 1.0, 0.05) + 0.013
    largest_stroke = peak_displacement(np.sin(7.0 * t), 7.0 * np.cos(7.0 * t), 0.05)
    assert largest_stroke == pytest.approx(1.0, abs=2e-4)
    assert np.abs(np.sin(7.0 * t)).max() < 1.0 - 2e-4


def test_state_space_takes_places(building):
    model = state_space(building, [1, (0, 3)])
    assert model.connection.tolist() == [[-1.0, 0.0], [0.0, 0.0], [0.0, -1.0]]
