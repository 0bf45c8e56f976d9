"""Floors that turn: against the closed form of one eccentric storey, scipy's system in centre and turn, and OpenSees."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.signal import StateSpace, lsim
from tests.structures.begin_of_el_centro import short

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, resampled
from dampyr.models import Damper
from dampyr.structures import (
    FloorLoads,
    control_law,
    ensemble,
    isolated,
    respond,
    shear_building,
    torsional_building,
)
from dampyr.structures.batch.modal import step
from dampyr.studies import raminelli_2020

MODEL = Path(__file__).with_name("torsion_in_opensees.py")
MASSES, INERTIAS = [2e4, 1.6e4], [4e5, 2.6e5]
FRAMES = {-5.0: [6e6, 5e6], 1.0: [4e6, 3e6], 6.0: [9e6, 7e6]}
CENTRES = [0.4, -0.3]
BETA = 0.002


def house(**changes: Any):
    return torsional_building(MASSES, INERTIAS, FRAMES, CENTRES, **({"damping_ratio": 0.03} | changes))


def by_centre_and_turn(across: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """M and K in (u_1, u_2, theta_1, theta_2) about the centres of mass, assembled frame by frame."""
    K = np.zeros((4, 4))
    for y, springs in FRAMES.items():
        first = np.array([1.0, 0.0, y - CENTRES[0], 0.0])
        second = np.array([-1.0, 1.0, -(y - CENTRES[0]), y - CENTRES[1]])
        K += springs[0] * np.outer(first, first) + springs[1] * np.outer(second, second)
    K[2, 2] += 2 * across
    K[3, 3] += across
    K[2, 3] -= across
    K[3, 2] -= across
    return np.diag([*MASSES, *INERTIAS]), K


def test_one_eccentric_storey_has_the_frequencies_of_its_closed_form() -> None:
    """Chopra 9.5: (w^2 - w_x^2)(w^2 - w_t^2) = (e/r)^2 w_x^4, with the turn about the centre of mass."""
    m, r, e, k, kt = 2e4, 4.0, 1.2, 8e6, 1.9e8
    b = torsional_building([m], [m * r**2], {e: k}, lines=(-6.0, 6.0), torsional_stiffness=kt)
    wx, wt = k / m, (kt + k * e**2) / (m * r**2)
    squares = 0.5 * (wx + wt) + np.array([-1.0, 1.0]) * np.sqrt(0.25 * (wx - wt) ** 2 + (e / r) ** 2 * wx**2)
    assert b.frequencies == pytest.approx(np.sqrt(squares) / (2 * np.pi), rel=1e-10)


def test_one_eccentric_storey_under_a_harmonic_ground_is_its_closed_form() -> None:
    m, r, e, k, kt, zeta = 2e4, 4.0, 1.2, 8e6, 1.9e8, 0.05
    b = torsional_building([m], [m * r**2], {e: k}, lines=(-6.0, 5.0), torsional_stiffness=kt, damping_ratio=zeta)
    omega, t = 2 * np.pi * 2.4, 0.005 * np.arange(6001)
    response = respond(b, GroundMotion(np.sin(omega * t), 0.005))
    M, K = np.diag([m, m * r**2]), np.array([[k, k * e], [k * e, kt + k * e**2]])
    squares, modes = np.linalg.eig(np.linalg.solve(M, K))
    steady = np.zeros((2, len(t)), dtype=complex)
    for w2, phi in zip(squares, modes.T, strict=True):
        share = -phi[0] * m / (phi @ M @ phi) / (w2 - omega**2 + 2j * zeta * np.sqrt(w2) * omega)
        steady += np.outer(phi, share * np.exp(1j * omega * t))
    late = slice(-1000, None)
    for ours, theirs in (
        ((b.at(0.0) @ response.displacement)[0], steady[0]),
        ((b.rotation @ response.displacement)[0], steady[1]),
        (response.displacement[0], steady[0] - 6.0 * steady[1]),
        (response.displacement[1], steady[0] + 5.0 * steady[1]),
    ):
        assert ours[late] == pytest.approx(theirs.imag[late], abs=2e-3 * np.abs(theirs).max())


def test_two_storeys_are_scipys_system_in_centre_and_turn() -> None:
    across = 5e7
    b = house(torsional_stiffness=across, method="rayleigh")
    M, K = by_centre_and_turn(across)
    # the same damping in these coordinates: u at the lines = T (u, theta)
    lines = np.array(b.lines)
    T = np.array(
        [[1, 0, lines[0] - CENTRES[0], 0], [1, 0, lines[1] - CENTRES[0], 0], [0, 1, 0, lines[0] - CENTRES[1]],
         [0, 1, 0, lines[1] - CENTRES[1]]]
    )  # fmt: skip
    np.testing.assert_allclose(T.T @ b.M @ T, M, atol=1e-6 * M.max())
    np.testing.assert_allclose(T.T @ b.K @ T, K, atol=1e-6 * K.max())
    C, motion = T.T @ b.C @ T, short(4.0)
    A = np.block([[np.zeros((4, 4)), np.eye(4)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    pushed = np.array([0.0] * 4 + [-1.0, -1.0, 0.0, 0.0])[:, None]
    system = StateSpace(A, pushed, np.eye(8), np.zeros((8, 1)))
    z = lsim(system, motion.acceleration, motion.time)[1].T
    response = respond(b, motion)
    x = T @ z[:4]
    assert response.displacement == pytest.approx(x, abs=1e-8 * np.abs(x).max())
    drift = np.array([x[0], x[1], x[2] - x[0], x[3] - x[1]])
    assert response.drift == pytest.approx(drift, abs=1e-8 * np.abs(drift).max())
    handed = -np.diag(M)[:2] @ (by_mass(b) @ response.acceleration)  # what both masses hand to the ground
    assert response.base_shear == pytest.approx(handed, abs=1e-8 * np.abs(handed).max())
    assert "2e+04, 1.6e+04 kg" in repr(b)
    assert response.floors == ("1 left", "1 right", "2 left", "2 right")


def by_mass(b: Any) -> np.ndarray:
    return np.asarray(b.at(CENTRES))


def test_a_building_without_eccentricity_does_not_turn() -> None:
    b = torsional_building([2e4, 2e4], [4e5, 4e5], {-5.0: [3e6, 2e6], 5.0: [3e6, 2e6]}, damping_ratio=0.03)
    plain = shear_building([2e4, 2e4], [6e6, 4e6], damping_ratio=0.03, method="modal")
    damper = Damper("dahl", {"dahl.kx": 2e4, "dahl.kw": 2e4, "dahl.rho": 800.0})
    pair = {("ground", "1 left"): damper, ("ground", "1 right"): damper}
    ours, same = (
        respond(b, short(4.0), pair, voltage=0.0),
        respond(plain, short(4.0), {1: [damper, damper]}, voltage=0.0),
    )
    assert ours.sites == ("storey 1", "storey 2")
    for k in range(2):
        assert ours.displacement[2 * k] == pytest.approx(same.displacement[k], abs=1e-6)
    assert np.abs(b.rotation @ ours.displacement).max() < 1e-9
    assert ours.base_shear == pytest.approx(same.base_shear, abs=1e-3 * same.peak_base_shear)


def theirs(step: float, steel: list[float], motion: Any) -> dict[str, np.ndarray]:
    """Peak drifts at the lines and turns of OpenSees at a step; skips where it cannot be loaded."""
    request = {
        "masses": MASSES[:1], "inertias": INERTIAS[:1], "centres": CENTRES[:1], "beta": BETA, "step": step,
        "frames": {y: k[0] for y, k in FRAMES.items()}, "lines": [-5.0, 6.0], "steel_at": 6.0, "steel": steel,
        "dt": motion.dt, "acceleration": motion.acceleration.tolist(),
    }  # fmt: skip
    done = subprocess.run(
        [sys.executable, MODEL], input=json.dumps(request), capture_output=True, text=True, check=False
    )
    if "OpenSees cannot be loaded" in done.stderr:
        pytest.skip("OpenSees cannot be loaded: floors that turn are not compared with it")
    assert done.stdout.strip(), done.stderr[-500:]
    return {name: np.ravel(values) for name, values in json.loads(done.stdout.strip().splitlines()[-1]).items()}


def test_a_brace_on_one_line_is_that_of_opensees() -> None:
    """One eccentric storey with a brace that yields at its right edge, as Steel01."""
    motion, force, stiff = short(6.0).scaled(2.0), 2e4, 8e6
    plain = torsional_building(MASSES[:1], INERTIAS[:1], {y: k[0] for y, k in FRAMES.items()}, CENTRES[0])
    b = type(plain)(plain.M, BETA * plain.K, plain.K, floors=plain.floors, lines=plain.lines, centres=plain.centres)
    brace = Damper("bilinear", {"bilinear.Q": force, "bilinear.uy": force / stiff, "bilinear.k2": 0.0}, input="none")
    response = respond(b, resampled(motion, 0.0025), {("ground", "1 right"): brace}, accuracy=1e-5)
    ours = {"drift": response.peak_drift, "turn": np.abs(b.rotation @ response.displacement).max(axis=1)}
    assert response.peak_drift[1] > 1.5 * force / stiff
    coarse, fine = (theirs(step, [force, stiff, 1e-12], motion) for step in (2e-3, 5e-4))
    assert np.all(np.abs(fine["drift"] - ours["drift"]) < 1e-3 * ours["drift"])
    assert fine["turn"] == pytest.approx(ours["turn"], rel=2e-3)  # ours at samples
    worst = [np.abs(of["drift"] - ours["drift"]).max() for of in (fine, coarse)]
    assert worst[0] < 0.5 * worst[1] + 2e-5 * ours["drift"].max()


@pytest.mark.parametrize("quantities", [("displacement", "drift"), ("drift",)])
@pytest.mark.parametrize("storeys", [1, pytest.param(4, marks=pytest.mark.prove)])
def test_an_ensemble_is_its_responses(quantities: tuple[str, ...], storeys: int) -> None:
    """In lanes, where drifts of a stack are differences of neighbours, and these are not; dense, and by modes."""
    frames = {-5.0: np.linspace(6e6, 4e6, storeys), 6.0: np.linspace(9e6, 7e6, storeys)}
    b = torsional_building([2e4] * storeys, [4e5] * storeys, frames, 0.3, damping_ratio=0.03)
    damper = Damper("dahl", {"dahl.kx": 2e4, "dahl.kw": 3e4, "dahl.rho": 800.0})
    motion, places = short(4.0), {("ground", "1 right"): damper}
    found = ensemble(b, motion, [places], [0.0], quantities=quantities, accuracy="strict").dataset
    response = respond(b, motion, places, voltage=0.0)
    assert found.drift.values.ravel() == pytest.approx(response.peak_drift, rel=1e-3)
    if "displacement" in quantities:
        assert found.displacement.values.ravel() == pytest.approx(response.peak_displacement, rel=1e-3)


def test_loads_and_laws_at_a_line() -> None:
    """A force on a line is one there: it turns the floor by its arm, statically."""
    b = house(damping_ratio=0.3)
    response = respond(b, None, loads=FloorLoads([0.0, 1.0], {"2 right": [0.0, 1e4]}), after=20.0)
    _, K = by_centre_and_turn()
    static = np.linalg.solve(K, [0.0, 1e4, 0.0, 1e4 * (6.0 - CENTRES[1])])
    assert (b.rotation @ response.displacement)[:, -1] == pytest.approx(static[2:], rel=1e-4)
    assert (b.at(CENTRES) @ response.displacement)[:, -1] == pytest.approx(static[:2], rel=1e-4)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: torsional_building([1e4], [1e5, 1e5], {0.0: 1e6}), "1 masses and 2 inertias"),
        (lambda: torsional_building([1e4], [1e5], {}), "frames must be a mapping from position"),
        (
            lambda: torsional_building([1e4], [1e5], {0.0: 1e6}),
            "give two different positions in m; a single frame does not",
        ),
        (lambda: torsional_building([1e4], [1e5], {0.0: 1e6}, lines=(-1.0, 1.0)), "can move or turn without a spring"),
        (
            lambda: torsional_building([1e4], [1e5], {0.0: -1.0, 1.0: 1e6}),
            r"frame at 0.0 m = \[-1.0\] .* at least 0 in N/m",
        ),
        (lambda: torsional_building([1e4], [1e5], {0.0: [1e6] * 2, 1.0: 1e6}), "give a finite number"),
        (lambda: torsional_building([1e4], [1e5], {0.0: 1e6, 1.0: 1e6}, names=("a", "a")), "two different names"),
        (lambda: torsional_building([1e4], [1e5], {0.0: 1e6, 1.0: 1e6}, method="none"), "damping method 'none'"),
        (lambda: house().condensed([1]), "floors that turn and cannot be condensed"),
        (
            lambda: isolated(
                house(), 1e3, Damper("bilinear", {f"bilinear.{k}": 1.0 for k in ("Q", "uy", "k2")}, input="none")
            ),
            "do not stand one on the other",
        ),
    ],
)
def test_what_is_wrong_is_said(call: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        call()


def test_a_law_at_a_line_runs() -> None:
    damper, law = raminelli_2020.damper(), control_law("on_off", high=1.98)
    response = respond(house(), short(1.0), {("ground", "1 right"): damper}, voltage=law, step=0.0025)
    assert 0.0 < response.mean_input[0] < 1.98


def test_lanes_know_that_its_floors_do_not_stand_one_on_the_other() -> None:
    """Their drifts are no differences of neighbours, as the proof of four storeys shows."""
    for b, stack in ((house(), False), (shear_building([1e4] * 3, [1e7] * 3, 0.02), True)):
        made = step(b, b.connection(1)[None], 0.005)
        assert made.is_stack is stack
        assert np.array_equal(made.drift[:, : b.n], np.array([b.connection(k + 1) for k in range(b.n)]))
