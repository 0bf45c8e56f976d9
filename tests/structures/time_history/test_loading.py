"""Floor loads in responses: against scipy's linear systems, modal superposition, an independent Runge-Kutta and OpenSees."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import StateSpace, lsim
from tests.structures.begin_of_el_centro import short

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.models import Constant, Damper, Polynomial
from dampyr.structures import (
    FloorLoads,
    control_law,
    ensemble,
    ensemble_cases,
    read_loads,
    respond,
    shear_building,
    two_storey,
)
from dampyr.structures.sensors import DamperPlace
from dampyr.structures.time_history.loading import common_step, excitation
from dampyr.structures.time_history.modal_coordinates import modal_condensation
from dampyr.structures.time_history.response import Response
from dampyr.studies import raminelli_2020

MODEL = Path(__file__).parent.with_name("loads_in_opensees.py")
MASSES, STIFFNESSES, DASHPOTS = [2e4, 2e4, 1.5e4], [2e7, 1.6e7, 1.2e7], [8e4, 6e4, 5e4]
DASHPOT = 3e4  # N s/m


def building():
    return shear_building(MASSES, STIFFNESSES, dashpots=DASHPOTS)


def gusts(dt: float = 0.02, seconds: float = 6.0) -> FloorLoads:
    rng = np.random.default_rng(5)
    t = dt * np.arange(round(seconds / dt) + 1)
    slow = np.cumsum(rng.normal(size=(2, len(t))), axis=1)
    return FloorLoads(t, {3: 2e3 * slow[0] + 8e3, 1: 1e3 * slow[1]})


def linear(b, loads: FloorLoads, time: np.ndarray, ground: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Displacements, velocities and absolute accelerations (3n, T) of scipy's system, exact for inputs that are linear."""
    n, P = b.n, np.eye(b.n)[:, [floor - 1 for floor in loads.floors_of(b)]]
    inverse = np.linalg.inv(b.M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ b.K, -inverse @ C]])
    B = np.block([[np.zeros((n, 1 + P.shape[1]))], [-np.ones((n, 1)), inverse @ P]])
    out = np.block([[np.eye(2 * n)], [A[n:]]])
    D = np.vstack([np.zeros((2 * n, B.shape[1])), np.hstack([np.zeros((n, 1)), inverse @ P])])
    u = np.column_stack([ground, loads.at(time)])
    return lsim(StateSpace(A, B, out, D), u, time)[1].T


def checked(response: Response, b, loads: FloorLoads, ground: np.ndarray, C: np.ndarray, rel: float) -> None:
    n, theirs = b.n, linear(b, loads, response.time, ground, C)
    for ours, rows in (
        (response.displacement, theirs[:n]),
        (response.velocity, theirs[n : 2 * n]),
        (response.acceleration, theirs[2 * n :]),
    ):
        assert ours == pytest.approx(rows, abs=rel * np.abs(rows).max())
    # what the ground carries is what the lowest storey hands down, the damper in it included
    v = theirs[n]
    shear = STIFFNESSES[0] * theirs[0] + (DASHPOTS[0] + C[0, 0] - b.C[0, 0]) * v
    assert response.base_shear == pytest.approx(shear, abs=rel * np.abs(shear).max())
    for peaks, histories in (
        (response.peak_base_shear, np.abs(response.base_shear).max()),
        (response.peak_acceleration, np.abs(response.acceleration).max(axis=1)),
        (response.peak_drift, np.abs(response.drift).max(axis=1)),
    ):  # taken between the samples, too
        assert np.all(peaks >= histories * (1 - 1e-9))
        assert peaks == pytest.approx(histories, rel=0.03)
    scale = np.abs(response.energy.input).max()
    assert np.abs(response.energy.residual).max() < 1e-4 * scale


@pytest.mark.parametrize("with_ground", [False, True])
def test_a_linear_building_is_scipys_system(with_ground: bool) -> None:
    b, loads, motion = building(), gusts(), short(6.0)
    response = respond(b, motion if with_ground else None, loads=loads)
    ground = np.interp(response.time, motion.time, motion.acceleration) * with_ground
    checked(response, b, loads, ground, np.array(b.C), 1e-9)
    assert response.peak_displacement == pytest.approx(np.abs(response.displacement).max(axis=1), rel=0.01)
    assert np.all(response.peak_displacement >= np.abs(response.displacement).max(axis=1))


def test_a_damper_that_is_a_dashpot_is_scipys_system() -> None:
    """In the kernel that dampers run in, with a motion of another step."""
    b, loads, motion = building(), gusts(0.025), short(6.0)
    dashpot = Damper("dahl", {"dahl.kx": DASHPOT, "dahl.kw": 1e-9, "dahl.rho": 1000.0})
    response = respond(b, motion, dashpot, voltage=0.0, loads=loads)
    assert response.time[1] == pytest.approx(0.005)
    C = np.array(b.C) + np.diag([DASHPOT, 0.0, 0.0])
    ground = np.interp(response.time, motion.time, motion.acceleration)
    checked(response, b, loads, ground, C, 1e-6)


def test_a_harmonic_force_is_the_sum_of_the_modes() -> None:
    """Steady state by modal superposition, modal damping."""
    b = shear_building(MASSES, STIFFNESSES, damping_ratio=0.05, method="modal")
    omega, size, t = 2 * np.pi * 2.2, 5e3, 0.002 * np.arange(10001)
    response = respond(b, None, loads=FloorLoads(t, {2: size * np.sin(omega * t)}))
    squares, modes = b.modes()
    by_mode = size * modes[1] / (squares - omega**2 + 2j * 0.05 * np.sqrt(squares) * omega)
    steady = (modes @ by_mode)[:, None] * np.exp(1j * omega * t)
    late = slice(-1000, None)
    assert response.displacement[:, late] == pytest.approx(steady.imag[:, late], abs=2e-4 * np.abs(steady).max())


def test_a_sudden_load_doubles_the_static_displacement() -> None:
    b = shear_building([1e3], [4e6], dashpots=[0.0])
    response = respond(b, None, loads=FloorLoads([0.0, 1.0], {1: [100.0, 100.0]}))
    assert response.peak_displacement[0] == pytest.approx(2 * 100.0 / 4e6, rel=1e-6)
    assert response.peak_acceleration[0] == pytest.approx(0.1, rel=1e-3)
    assert response.peak_base_shear == pytest.approx(200.0, rel=1e-3)
    assert response.acceleration[0, 0] == pytest.approx(0.1)


def test_loads_keep_their_last_value_in_the_rest() -> None:
    b = shear_building([1e3], [4e6], damping_ratio=0.2)
    response = respond(b, None, loads=FloorLoads([0.0, 0.3], {1: [0.0, 100.0]}), after=2.0)
    assert (response.time[-1], response.after) == (pytest.approx(2.3), 2.0)
    assert response.displacement[0, -1] == pytest.approx(100.0 / 4e6, rel=1e-6)


def test_a_blow_of_four_rows_is_its_momentum() -> None:
    """v = impulse/mass after a blow that is short beside the period."""
    b = shear_building([1e3], [4e3], dashpots=[0.0])
    response = respond(b, None, loads=FloorLoads([0.0, 0.001, 0.002, 2.0], {1: [0.0, 500.0, 0.0, 0.0]}))
    assert len(response.time) == 2001
    assert response.peak_displacement[0] == pytest.approx(0.5 / np.sqrt(4e3 * 1e3), rel=1e-5)


@pytest.mark.filterwarnings("ignore:.*was calibrated:dampyr.errors.DampyrWarning")
def test_a_law_sees_what_loads_and_ground_do() -> None:
    """Skyhook, which measures the absolute velocity: held to a Runge-Kutta that decides at the same instants."""
    b, motion = two_storey(), short(3.0)
    loads = FloorLoads([0.0, 0.4, 0.8, 3.0], {2: [0.0, 60.0, -60.0, 0.0]})
    laws = {"kx": Polynomial((50.0, 400.0), 0.0, 5.0), "kw": Constant(1e-9), "rho": Constant(1e3)}
    damper = Damper("dahl", {f"dahl.{name}": law for name, law in laws.items()})
    law = control_law("skyhook", low=0.0, high=2.0, period=0.01, lag=0.0)
    response = respond(b, motion, damper, voltage=law, loads=loads, accuracy=1e-4)
    h, state, ground, u = 0.0005, np.zeros(4), 0.0, 0.0
    inverse, peaks, inputs = np.linalg.inv(b.M), np.zeros(2), []

    def slope(t: float, s: np.ndarray) -> np.ndarray:
        push = [0.0, np.interp(t, loads.time, loads.forces["2"])] - b.C @ s[2:] - b.K @ s[:2]
        push[0] -= (50.0 + 400.0 * u) * s[2]
        return np.r_[s[2:], inverse @ push - np.interp(t, motion.time, motion.acceleration)]

    for k in range(round(3.0 / h)):
        t, absolute, rate = k * h, state[2] + ground, state[2]
        if k % 20 == 0:
            u = 2.0 * min(1.0, absolute / rate) if absolute * rate > 0.0 else 0.0
            inputs.append(u)
        one = slope(t, state)
        two = slope(t + h / 2, state + h / 2 * one)
        three = slope(t + h / 2, state + h / 2 * two)
        state = state + h / 6 * (one + 2 * two + 2 * three + slope(t + h, state + h * three))
        ground += h / 2 * float(np.sum(np.interp([t, t + h], motion.time, motion.acceleration)))
        peaks = np.maximum(peaks, np.abs(state[:2]))
    assert 0.2 < np.mean(inputs) < 1.8
    assert response.peak_displacement == pytest.approx(peaks, rel=1e-3)
    assert response.mean_input[0] == pytest.approx(np.mean(inputs), abs=0.01)


def test_sensors_see_the_accelerations_and_velocities_of_a_response() -> None:
    b, motion, loads = building(), short(2.0), gusts(0.02, 2.0)
    damper = Damper("dahl", {"dahl.kx": DASHPOT, "dahl.kw": 2e4, "dahl.rho": 800.0})
    response = respond(b, motion, {2: damper}, voltage=0.0, loads=loads)
    pushed = excitation(b, motion, loads, 0.0)
    place = DamperPlace(b, b.connection(2)[None], 0, pushed.loads(b))
    still = np.zeros_like(pushed.values.T)
    ground = pushed.motion
    w = np.vstack(
        [
            response.displacement,
            response.velocity,
            ground.velocity,
            ground.acceleration,
            response.force,
            still,
            pushed.values.T,
        ]
    )
    seen = place.accelerations() @ w
    assert seen == pytest.approx(response.acceleration, abs=1e-9 * np.abs(seen).max())
    assert (place.velocity(True) @ w)[0] == pytest.approx(response.velocity[1] + ground.velocity, abs=1e-12)


def theirs(b_loads: FloorLoads, motion: GroundMotion | None, step: float, steel: list[float]) -> np.ndarray:
    """Peak displacements and drifts (2, 3) of OpenSees at a step; skips where it cannot be loaded."""
    request = {
        "masses": MASSES, "stiffnesses": STIFFNESSES, "dashpots": DASHPOTS, "steel": steel, "step": step, "end": 6.0,
        "time": b_loads.time.tolist(), "forces": {floor: row.tolist() for floor, row in b_loads.forces.items()},
        "dt": 0.02, "acceleration": [] if motion is None else motion.acceleration.tolist(),
    }  # fmt: skip
    done = subprocess.run(
        [sys.executable, MODEL], input=json.dumps(request), capture_output=True, text=True, check=False
    )
    if "OpenSees cannot be loaded" in done.stderr:
        pytest.skip("OpenSees cannot be loaded: loads on floors are not compared with it")
    found = json.loads(done.stdout.strip().splitlines()[-1])
    return np.array([found["displacement"], found["drift"]])


@pytest.mark.parametrize("with_ground", [pytest.param(False, marks=pytest.mark.prove), True])
def test_peaks_are_those_of_opensees_at_shrinking_steps(with_ground: bool) -> None:
    """A brace that yields in the first storey, as Steel01 in parallel, gusts on two floors, and a ground motion."""
    loads, motion = gusts().scaled(2.0), short(6.0) if with_ground else None
    steel, k = [3e4, 1e7, 1e-12], 1e7
    brace = Damper("bilinear", {"bilinear.Q": 3e4, "bilinear.uy": 3e4 / k, "bilinear.k2": 0.0}, input="none")
    response = respond(building(), motion, brace, loads=loads, accuracy=1e-5)
    ours = np.array([response.peak_displacement, response.peak_drift])
    assert response.peak_drift[0] > 1.3 * 3e4 / k
    coarse, fine = (theirs(loads, motion, step, steel) for step in (2e-3, 5e-4))
    assert np.all(np.abs(fine - ours) < 5e-4 * ours)
    assert np.abs(fine - ours).max() < 0.5 * np.abs(coarse - ours).max() + 2e-5 * ours.max()


def test_a_reduced_structure_answers_as_the_whole_one() -> None:
    """Loads excite other shapes than the ground does: their static answers are among the coordinates."""
    tall = shear_building([2e4] * 30, np.linspace(60e6, 15e6, 30), damping_ratio=0.02)
    t = 0.01 * np.arange(501)
    loads = {"5": 4e4 * np.sin(9.0 * t), "30": 2e4 * np.cos(25.0 * t)}
    keep = [4, 9, 14, 19, 24, 29]
    small = modal_condensation(tall.M, tall.C, tall.K, keep)
    whole, ours = (respond(b, short(5.0), loads=FloorLoads(t, loads)) for b in (tall, small))
    assert ours.truncation is not None
    assert ours.truncation.judge.endswith("without the dampers")
    told = ours.truncation.errors
    for name in ("displacement", "acceleration"):
        true = getattr(whole, f"peak_{name}")[keep]
        missed = np.max(np.abs(getattr(ours, f"peak_{name}") / true - 1.0))
        assert missed < max(0.02, 2.0 * told[name]), name
    assert ours.peak_base_shear == pytest.approx(whole.peak_base_shear, rel=max(0.02, 2.0 * told["base_shear"]))


def test_steps_that_differ_have_the_longest_common_one() -> None:
    assert common_step([0.02, 0.005], "x") == pytest.approx(0.005)
    assert common_step([0.02, 1 / 128], "x") == pytest.approx(1 / 3200)
    assert common_step([0.03, 0.02], "x") == pytest.approx(0.01)
    assert common_step([0.0333333, 0.1], "x") == pytest.approx(1 / 30)
    with pytest.raises(InputError, match=r"wind: the times have no common step of at least 0\.1 ms; resample"):
        common_step([0.02, 0.0071234], "wind")


def test_both_times_have_all_their_corners() -> None:
    """The response to both is the sum of those to each, whatever their steps."""
    b, motion = building(), short(2.0)
    still = GroundMotion(np.zeros(motion.n), motion.dt)
    loads = FloorLoads([0.015, 0.03, 0.9], {2: [0.0, 5e3, 0.0]})
    both = respond(b, motion, loads=loads)
    assert both.time[1] == pytest.approx(0.005)
    shaken, pushed = respond(b, motion), respond(b, still, loads=loads)
    apart = shaken.displacement + pushed.displacement[:, ::4]
    assert both.displacement[:, ::4] == pytest.approx(apart, abs=1e-9 * np.abs(apart).max())
    finer = respond(b, None, loads=loads)
    at = np.isclose(finer.time[:, None], pushed.time).any(axis=1)
    same = np.isclose(pushed.time[:, None], finer.time).any(axis=1)
    assert finer.displacement[:, at] == pytest.approx(pushed.displacement[:, same], abs=1e-9 * np.abs(apart).max())


def test_what_a_response_tells_of_its_loads() -> None:
    loads = FloorLoads([0.0, 0.5, 1.0], {1: [0.0, 30.0, 0.0], "floor 2": [0.0, -60.0, 0.0]}, name="gust")
    response = respond(two_storey(), None, loads=loads)
    assert response.title.endswith(", gust")
    assert "floor 1 peak 30 N, floor 2 peak 60 N" in repr(response)
    told = response.as_dict()["loads"]
    assert told["peak_N"] == {"1": 30.0, "floor 2": 60.0}
    assert told["mean_N"]["floor 2"] == pytest.approx(-30.0)
    dataset = response.to_xarray()
    assert dataset.floor_load.sel(loaded_floor="1").max() == 30.0
    assert dataset.floor_load.attrs["units"] == "N"
    several = respond(two_storey(), None, raminelli_2020.damper(), [0.0], loads=loads)
    assert several.title.endswith("gust")
    assert "gust" in repr(several)
    assert not response.shaken


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"motion": None}, r"motion is missing \(None\); give a GroundMotion"),
        ({"motion": None, "loads": 3.0}, "loads is of the type float; give FloorLoads, such as"),
        ({"motion": None, "loads": FloorLoads([0.0, 1.0], {"7": [0.0, 1.0]})}, "no floor '7'"),
        ({"motion": None, "loads": FloorLoads([0.0, 1.0], {1: [0.0, 1.0]}), "after": -1.0}, "after"),
    ],
)
def test_wrong_loads_of_a_response_are_refused(arguments: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        respond(two_storey(), **arguments)


def test_loads_are_given_by_name_and_to_responses_alone() -> None:
    loads = FloorLoads([0.0, 1.0], {1: [0.0, 1.0]})
    with pytest.raises(InputError, match="the motion is FloorLoads; give them by name"):
        respond(two_storey(), loads)
    with pytest.raises(
        InputError, match=r"ensemble runs motions of the ground alone, without loads on floors; take respond"
    ):
        ensemble(two_storey(), short(1.0), loads=loads)
    with pytest.raises(InputError, match=r"ensemble runs motions of the ground alone"):
        ensemble_cases(two_storey(), short(1.0), loads=loads)


def test_drawn_dampers_know_no_loads() -> None:
    loads = FloorLoads([0.0, 1.0], {1: [0.0, 1.0]})
    with pytest.raises(
        InputError, match="draws = 20 are run as an ensemble, which knows the motion of one ground and no loads"
    ):
        respond(two_storey(), None, raminelli_2020.damper(), [0.0], loads=loads, draws=20)


def test_a_table_is_what_was_written(tmp_path: Path) -> None:
    path = tmp_path / "wind.csv"
    path.write_text("time [s],floor 2 [kN]\n0,0\n0.5,0.06\n1,0\n")
    ours = respond(two_storey(), None, loads=read_loads(path))
    same = respond(two_storey(), None, loads=FloorLoads([0.0, 0.5, 1.0], {2: [0.0, 60.0, 0.0]}))
    assert np.array_equal(ours.displacement, same.displacement)
