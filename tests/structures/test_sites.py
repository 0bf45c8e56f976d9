"""Dampers in storeys and between any two floors: what a place means, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.models import Damper
from dampyr.structures import Building, ensemble, respond, two_storey
from dampyr.structures.sites import describe_place, drawn_placements, drifts, make_sites

MOTION = GroundMotion(np.asarray(el_centro().acceleration)[:201], 0.02, "start of El Centro")


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


DAHL = {"dahl.kx": 1000.0, "dahl.kw": 200.0, "dahl.rho": 1000.0}


@pytest.mark.prove
def test_draws_are_of_the_dampers_before_their_parts_are_left_out() -> None:
    """As `Damper.draws` gives them, by the seed; of several dampers each has its own seed, of one in two places one."""
    card = Damper("dahl", DAHL, covariance=np.diag([1e2, 1.0, 1e2]))
    drawn = card.draws(20, 3)
    responses = respond(two_storey(), MOTION, {1: card}, voltage=[0.0], draws=20, seed=3)
    peaks = ensemble(two_storey(), MOTION, drawn, 0.0, accuracy="strict").dataset.force.values
    low, high = responses.intervals["0 V"]["peak_force_N"]
    np.testing.assert_array_equal([low, high], np.quantile(peaks[0, :, 0, 0, 0], (0.05, 0.95), axis=0))
    both = ensemble(two_storey(), MOTION, [None, {1: card, 2: card}], 0.0, draws=2, seed=3).dataset
    ours = ensemble(two_storey(), MOTION, [None, *({1: d, 2: d} for d in card.draws(2, 3))], 0.0).dataset
    np.testing.assert_array_equal(both.force, ours.force)


def test_a_site_has_no_static_force() -> None:
    """A building is at rest in its equilibrium with it; in a test of the damper alone it is measured."""
    laws = {"dahl.kx": 900.0, "dahl.kw": 150.0, "dahl.rho": 9000.0, "offset.f0": 130.0}
    [site] = make_sites(two_storey(), Damper("dahl + offset", laws), 0.0, None, False)
    assert dict(zip(site.composition.parameters, site.values, strict=True)) == laws | {"offset.f0": 0.0}


def test_dampers_that_are_drawn_are_the_same_in_all_their_places() -> None:
    card = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 150.0, "dahl.rho": 9000.0}, covariance=np.diag([9.0, 4.0, 1.0]))
    other = replace(card)
    for placed in drawn_placements({1: card, 2: [card, other]}, 3, 5):
        assert placed[1] is placed[2][0]
        assert placed[1].values(0.0) != pytest.approx(placed[2][1].values(0.0), rel=1e-9)
    first = [placed[1].values(0.0) for placed in drawn_placements({1: card}, 3, 5)]
    np.testing.assert_array_equal(first, [drawn.values(0.0) for drawn in card.draws(3, 5)])


def test_drifts_are_differences_of_neighbours(building: Building) -> None:
    np.testing.assert_array_equal(drifts(building), np.eye(3) - np.eye(3, k=-1))
    assert describe_place(2) == "in storey 2"
    assert describe_place((0, 2)) == "between floors 0 and 2"
