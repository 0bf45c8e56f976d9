"""Structures on several supports: against the equations of all degrees of freedom, and uniform motions."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.structures.begin_of_el_centro import short

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, padded
from dampyr.hybrid import HybridSetup
from dampyr.models import Damper
from dampyr.structures import (
    FloorLoads,
    SupportMotions,
    axle_roads,
    control_law,
    ensemble,
    half_car,
    isolated,
    respond,
    shear_building,
    state_space,
    with_supports,
)
from dampyr.structures.supports import SupportedBuilding

M = np.diag([2e4, 3e4, 2e4])
K = 1e6 * np.array(
    [
        [9.0, -4.0, 0.0, -5.0, 0.0],
        [-4.0, 7.0, -3.0, 0.0, 0.0],
        [0.0, -3.0, 10.0, 0.0, -7.0],
        [-5.0, 0.0, 0.0, 5.0, 0.0],
        [0.0, 0.0, -7.0, 0.0, 7.0],
    ]
)  # west pier - deck - deck - deck - east pier
BETA = 0.004  # of C = beta K, which slow motions of the supports do not stretch


def bridge() -> SupportedBuilding:
    return with_supports(M, BETA * K, K, ("west", "east"), name="bridge")


def pair(seconds: float = 4.0, lag: float = 0.3) -> SupportMotions:
    first = short(seconds)
    return SupportMotions(
        {"west": padded(first, lag), "east": padded(GroundMotion(0.7 * first.acceleration, first.dt), 0.0, before=lag)}
    )


def test_the_influence_is_how_the_floors_follow_slowly() -> None:
    b = bridge()
    assert b.support_influence.sum(axis=1) == pytest.approx(1.0)
    assert np.array_equal(b.influence, b.support_influence.sum(axis=1))
    assert b.K @ b.support_influence == pytest.approx(-K[:3, 3:], abs=1e-3)


def test_a_bridge_is_the_equations_in_absolute_displacements() -> None:
    """All degrees of freedom, whose supports move by the exact integrals of their accelerations; no influence in it."""
    b, motions = bridge(), pair()
    response = respond(b, motions)
    t = response.time
    of = [motions.motions[name] for name in ("west", "east")]

    def ground(now: float, order: int) -> np.ndarray:
        k = min(int(now / motions.dt), motions.n - 2)
        s = now - k * motions.dt
        values = []
        for m in of:
            a, b_ = m.acceleration[k], m.acceleration[k + 1]
            rise = (b_ - a) / motions.dt
            v, x = m.velocity[k], m.displacement[k]
            values.append((x + v * s + a * s**2 / 2 + rise * s**3 / 6, v + a * s + rise * s**2 / 2)[order])
        return np.array(values)

    inverse = np.linalg.inv(M)

    def slope(now: float, s: np.ndarray) -> np.ndarray:
        x, v = s[:3], s[3:]
        force = K[:3, :3] @ x + K[:3, 3:] @ ground(now, 0)
        force = force + BETA * (K[:3, :3] @ v + K[:3, 3:] @ ground(now, 1))
        return np.r_[v, -inverse @ force]

    done = solve_ivp(slope, (0.0, t[-1]), np.zeros(6), t_eval=t, rtol=1e-9, atol=1e-13, max_step=motions.dt)
    followed = b.support_influence @ np.array([m.displacement for m in of])
    assert response.displacement + followed == pytest.approx(done.y[:3], abs=1e-6 * np.abs(done.y[:3]).max())
    acceleration = np.array([slope(now, s)[3:] for now, s in zip(t, done.y.T, strict=True)]).T
    assert response.acceleration == pytest.approx(acceleration, abs=1e-6 * np.abs(acceleration).max())
    assert response.base_shear == pytest.approx(-np.diag(M) @ acceleration, abs=1e-6 * 7e4 * np.abs(acceleration).max())
    assert np.abs(response.energy.residual).max() < 1e-4 * np.abs(response.energy.input).max()


def test_supports_that_move_alike_are_one_ground() -> None:
    """With floor loads of another step, and a damper in the kernel."""
    k = np.array([3e7, 2e7])
    chain = np.array([[k.sum(), -k[1], -k[0]], [-k[1], k[1], 0.0], [-k[0], 0.0, k[0]]])
    b = with_supports(np.diag([2e4, 2e4]), np.diag([1e4, 1e4]), chain, ("ground floor",))
    plain = shear_building([2e4, 2e4], k, dashpots=[1e-9, 1e-9])
    plain = type(plain)(plain.M, np.diag([1e4, 1e4]), plain.K)
    motion, loads = short(3.0), FloorLoads([0.0, 0.015, 3.0], {2: [0.0, 5e3, 0.0]})
    damper = Damper("dahl", {"dahl.kx": 2e4, "dahl.kw": 3e4, "dahl.rho": 800.0})
    for dampers, u in (({}, None), ({1: damper}, 0.0)):
        ours = respond(b, SupportMotions({"ground floor": motion}), dampers, voltage=u, loads=loads)
        same = respond(plain, motion, dampers, voltage=u, loads=loads)
        for name in ("displacement", "velocity", "acceleration", "base_shear", "force"):
            theirs = getattr(same, name)
            scale = np.max(np.abs(theirs), initial=1e-300)
            assert getattr(ours, name) == pytest.approx(theirs, abs=1e-8 * scale), name
        assert ours.peak_acceleration == pytest.approx(same.peak_acceleration)
        assert ours.support_acceleration[0] == pytest.approx(same.ground_acceleration)
        assert ours.energy.input == pytest.approx(same.energy.input, abs=1e-8 * np.abs(same.energy.input).max())


def test_what_a_response_tells_of_its_supports() -> None:
    response = respond(bridge(), pair())
    assert response.supports == ("west", "east")
    assert not response.shaken
    assert "west peak 3." in repr(response)
    peaks = response.as_dict()["peak_support_acceleration_m_s2"]
    assert peaks["east"] == pytest.approx(0.7 * peaks["west"])
    assert response.to_xarray().support_acceleration.sel(support="west").max() > 2.0
    assert "west" in repr(pair())
    assert pair().as_dict()["samples"] == 216
    assert set(pair().to_dataframe().columns) == {"time_s", "west_m_per_s2", "east_m_per_s2"}


def test_dampers_stand_where_slow_motions_do_not_stretch_them() -> None:
    damper = Damper("dahl", {"dahl.kx": 100.0, "dahl.kw": 50.0, "dahl.rho": 800.0})
    for place in (1, 2, (1, 3)):
        with pytest.raises(InputError, match="of bridge is stretched by slow motions of the supports"):
            respond(bridge(), pair(), {place: damper}, voltage=0.0)
    car = half_car(580.0, 900.0, 1.2, 1.4, 45.0, 18e3, 190e3)
    for place in ((0, 1), ("front wheel", "front body"), ("ground", "rear body")):
        car.check_stroke(place)
    for place in ((1, 3), ("front body", "rear body")):
        with pytest.raises(InputError, match="stretched"):
            car.check_stroke(place)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: respond(bridge(), short(1.0)), "bridge stands on several supports; give SupportMotions"),
        (
            lambda: respond(shear_building([1e3], [1e6], 0.02), pair()),
            "stands on one ground, and motions of the supports west",
        ),
        (lambda: respond(bridge(), SupportMotions({"west": short(1.0)})), "stands on west, east: give one for each"),
        (lambda: ensemble(bridge(), short(1.0)), "ensemble takes structures on one ground alone"),
        (
            lambda: isolated(
                bridge(),
                1e3,
                Damper("bilinear", {"bilinear.Q": 1.0, "bilinear.uy": 1.0, "bilinear.k2": 0.0}, input="none"),
            ),
            "isolated",
        ),
        (lambda: state_space(bridge()), "state_space takes structures on one ground alone"),
        (lambda: HybridSetup(bridge()), "a hybrid test takes structures on one ground alone"),
        (lambda: bridge().condensed([1]), "cannot be condensed"),
        (lambda: SupportMotions({}), "mapping from support"),
        (lambda: SupportMotions({"west": 3.0}), "the motion of west is a float"),
        (lambda: SupportMotions({"west": short(1.0), "east": short(2.0)}), "move for 51 samples of 0.02 s and 101"),
        (lambda: with_supports(M, BETA * K, K[:, :4], ("west", "east")), "K has shape"),
        (lambda: with_supports(M[:2], BETA * K, K, ("west", "east")), "M has shape"),
        (lambda: with_supports(M, 0.0 * M, 0.0 * K, ("west", "east")), "not held by springs"),
        (
            lambda: with_supports(M, BETA * K + np.diag([1.0] * 5), K, ("west", "east")),
            "slow motions of the supports stretch",
        ),
        (lambda: with_supports(M, BETA * M, K, ("west", "west")), "give different names"),
    ],
)
def test_what_is_wrong_is_said(call: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        call()


def test_a_law_that_measures_one_ground_is_refused() -> None:
    car = half_car(580.0, 900.0, 1.2, 1.4, 45.0, 18e3, 190e3)
    roads = axle_roads(0.01 * np.hanning(101), 0.05, 10.0, car.wheelbase)
    damper = Damper("dahl", {"dahl.kx": 100.0, "dahl.kw": 50.0, "dahl.rho": 800.0})
    law = control_law("predictive", high=1.0)
    with pytest.raises(InputError, match="a law that measures the ground knows one"):
        respond(car, roads, {("front wheel", "front body"): damper}, voltage=law)
