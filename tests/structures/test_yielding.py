"""Storeys that yield: against OpenSees' Steel01 and BoucWen, with P-delta by its exact geometry, and by hand."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tests.structures.begin_of_el_centro import short

from dampyr.errors import InputError
from dampyr.structures import respond, shear_building, yielding_shear_building
from dampyr.studies import raminelli_2020

MODEL = Path(__file__).with_name("yielding_in_opensees.py")
MASSES, STIFFNESSES, DASHPOTS = [2e4, 2e4, 1.5e4], [2e7, 1.6e7, 1.2e7], [8e4, 6e4, 5e4]
YIELD, HARDENING, HEIGHT = 0.004, 0.05, 3.0


def theirs(motion, step: float, exponent: float | None, heights: float | None, **wear: float) -> np.ndarray:
    """Peak and last drifts (2, 3) of OpenSees at a step; skips where it cannot be loaded."""
    request = {
        "masses": MASSES, "stiffnesses": STIFFNESSES, "dashpots": DASHPOTS, "yield_drifts": [YIELD] * 3,
        "hardening": HARDENING, "exponent": exponent, "heights": heights and [heights] * 3,
        "dt": motion.dt, "acceleration": motion.acceleration.tolist(), "step": step, **wear,
    }  # fmt: skip
    done = subprocess.run(
        [sys.executable, MODEL], input=json.dumps(request), capture_output=True, text=True, check=False
    )
    if "OpenSees cannot be loaded" in done.stderr:
        pytest.skip("OpenSees cannot be loaded: storeys that yield are not compared with it")
    found = json.loads(done.stdout.strip().splitlines()[-1])
    return np.array([found["peaks"], found["last"]])


@pytest.mark.parametrize(
    ("exponent", "heights"),
    [
        (None, HEIGHT),
        *(pytest.param(*case, marks=pytest.mark.prove) for case in ((None, None), (1.0, None), (3.0, HEIGHT))),
    ],
)
def test_drifts_are_those_of_opensees_at_shrinking_steps(exponent: float | None, heights: float | None) -> None:
    motion = short(6.0).scaled(3.0)
    building, storeys = yielding_shear_building(
        MASSES, STIFFNESSES, YIELD, HARDENING, exponent, dashpots=DASHPOTS, heights=heights
    )
    response = respond(building, motion, storeys, accuracy=1e-5)
    ours = np.array([response.peak_drift, response.drift[:, -1]])
    assert np.all(response.peak_drift[:2] > 2.0 * YIELD)
    coarse, fine = (theirs(motion, step, exponent, heights) for step in (1e-3, 5e-4))
    assert np.all(np.abs(fine - ours)[0] < 2e-3 * response.peak_drift)
    assert np.all(
        np.abs(fine - ours)[1] < 2e-3 * response.peak_drift.max()
    )  # what remains is a small difference of large ones
    assert np.abs(fine - ours).max() < 0.7 * np.abs(coarse - ours).max() + 2e-5 * YIELD


@pytest.mark.parametrize(
    "wear",
    [
        pytest.param({"strength_loss": 0.05, "stiffness_loss": 0.03}, marks=pytest.mark.prove),
        pytest.param({"strength_loss": 0.2}, marks=pytest.mark.prove),
        pytest.param({"stiffness_loss": 0.2}, marks=pytest.mark.prove),
    ],
    ids=lambda wear: " ".join(wear),
)
def test_storeys_that_wear_are_those_of_opensees(wear: dict[str, float]) -> None:
    motion = short(6.0).scaled(3.0)
    building, storeys = yielding_shear_building(MASSES, STIFFNESSES, YIELD, HARDENING, 2.0, dashpots=DASHPOTS, **wear)
    new, as_new = yielding_shear_building(MASSES, STIFFNESSES, YIELD, HARDENING, 2.0, dashpots=DASHPOTS)
    response, unworn = respond(building, motion, storeys, accuracy=1e-5), respond(new, motion, as_new, accuracy=1e-4)
    assert np.abs(response.peak_drift / unworn.peak_drift - 1.0).max() > 0.05  # the wear is seen
    coarse, fine = (theirs(motion, step, 2.0, None, **wear) for step in (1e-3, 5e-4))
    ours = np.array([response.peak_drift, response.drift[:, -1]])
    assert np.all(
        np.abs(2.0 * fine - coarse - ours) < 1e-3 * response.peak_drift
    )  # its wear is of first order in the step
    assert np.abs(fine - ours).max() < 0.6 * np.abs(coarse - ours).max()


def test_wear_by_hand() -> None:
    """Over half a cycle beyond yield the strength falls by nu^(-1/n) of the energy that was taken."""
    _, storeys = yielding_shear_building([1e4], [1e6], 0.01, 0.0, 2.0, strength_loss=0.5, damping_ratio=0.02)
    t = np.linspace(0.0, 1.0, 4001)
    x = 0.1 * t
    force = storeys[1].force(t, x)
    energy = float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(x)))
    assert force[-1] == pytest.approx(1e4 * (1.0 + 0.5 * energy / 100.0) ** -0.5, rel=0.01)


def test_below_its_yield_drift_a_sharp_storey_is_elastic() -> None:
    motion = short(6.0).scaled(0.1)
    building, storeys = yielding_shear_building(MASSES, STIFFNESSES, YIELD, damping_ratio=0.03)
    elastic = respond(shear_building(MASSES, STIFFNESSES, damping_ratio=0.03), motion)
    response = respond(building, motion, storeys, accuracy=1e-6)
    assert response.peak_drift.max() < YIELD
    np.testing.assert_allclose(response.peak_drift, elastic.peak_drift, rtol=1e-5)


def test_the_weight_above_a_storey_takes_stiffness_from_it() -> None:
    building, _ = yielding_shear_building(MASSES, STIFFNESSES, YIELD, HARDENING, heights=HEIGHT, damping_ratio=0.02)
    plain, _ = yielding_shear_building(MASSES, STIFFNESSES, YIELD, HARDENING, damping_ratio=0.02)
    drifts = np.linalg.inv(np.eye(3) - np.eye(3, k=-1))
    taken = np.diag(drifts.T @ (plain.K - building.K) @ drifts)
    np.testing.assert_allclose(taken, 9.80665 * np.array([5.5e4, 3.5e4, 1.5e4]) / HEIGHT, rtol=1e-9)
    np.testing.assert_array_equal(plain.C, building.C)


def test_a_damper_beside_a_storey_that_yields_leaves_less_drift() -> None:
    motion, damper = short(6.0).scaled(3.0), raminelli_2020.damper()
    small = {
        "masses": [145.8] * 2,
        "stiffnesses": [6e4] * 2,
        "yield_drifts": 0.01,
        "hardening": 0.05,
        "damping_ratio": 0.03,
    }
    building, storeys = yielding_shear_building(**small)
    bare = respond(building, motion, storeys, after=2.0)
    held = respond(building, motion, storeys | {1: [storeys[1], damper]}, voltage=1.98, after=2.0)
    assert held.peak_drift[0] < 0.5 * bare.peak_drift[0]
    assert held.inputs == (None, 1.98, None)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"yield_drifts": 0.0}, "yield_drifts = .* greater than 0"),
        ({"yield_drifts": [0.1, 0.2]}, "2 yield_drifts do not match 3 storeys"),
        ({"hardening": 1.0}, "hardening = 1.0 is not allowed"),
        ({"exponent": 0.5}, "exponent = 0.5 is not allowed"),
        ({"strength_loss": 0.1}, "strength_loss = 0.1 is of a storey with a round corner; give exponent="),
        ({"exponent": 2.0, "stiffness_loss": -0.1}, "stiffness_loss = -0.1 is not allowed"),
        (
            {"hardening": 0.001, "heights": 3.0},
            r"storey 1 turns over once it has yielded.*the hardening must be at least 0.00899",
        ),
    ],
)
def test_what_is_wrong_is_said(change: dict, message: str) -> None:
    given = {"masses": MASSES, "stiffnesses": STIFFNESSES, "yield_drifts": YIELD, "damping_ratio": 0.02} | change
    with pytest.raises(InputError, match=message):
        yielding_shear_building(**given)
