"""A control law at its place: measures, sensors and filter against numbers worked out here, and the kernel's own text."""

import math
import re
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.models import inverse as inverse_model
from dampyr.models.codegen.composition import text_of
from dampyr.structures import available_control_laws, control_law, shear_building, two_storey
from dampyr.structures.controller import ControllerRun, asks_force, design_controller, law_source, law_texts, module_of
from dampyr.structures.law_form import ControlLaw, LawDesign
from dampyr.structures.propagator import system
from dampyr.structures.sensor_noise import noise
from dampyr.structures.sensors import MEASURES as ALL_MEASURES
from dampyr.structures.sensors import DamperPlace, Sensor
from dampyr.structures.sites import make_sites
from dampyr.structures.time_history import followed_model, time_stepping
from dampyr.structures.time_history.kernel_run import _control
from dampyr.structures.wanted_force import inverse_of, wanted_forces

MEASURES = ("accelerations", "force")
STATES = {"count": 2.0}


@dataclass(frozen=True)
class Filtered(ControlLaw):
    """A law with a memory of two kinds."""

    gain: float = 0.5


def design(law, building, row):
    n = building.n_floors
    G = np.zeros((1, n + 1))
    G[0, 0] = law.gain
    return LawDesign({"sum": np.concatenate([[1.0], np.ones(n), [0.0]])}, np.array([[0.9]]), G)


def update(count: float, force: float) -> tuple[float]:
    return count + 1.0 if force > 0.0 else count


def decide(sum: float, count: float, low: float, high: float) -> float:
    return high if sum > count else low


def controller_of(law, building=None, place=1):
    building = building or two_storey()
    return design_controller(law, building, building.connection(place)[None], 0)


def test_a_filter_is_its_recurrence_written_out() -> None:
    run, rng = ControllerRun(controller_of(Filtered(0.0, 1.0))), np.random.default_rng(1)
    rows = DamperPlace(two_storey(), two_storey().connection(1)[None], 0).accelerations()
    x, count = 0.0, 2.0
    for _ in range(50):
        w = 1e-2 * rng.standard_normal(7)
        a, f = rows @ w, w[-1]
        count += f > 0.0
        assert run.decide(w) == (1.0 if x + a.sum() > count else 0.0)
        x = 0.9 * x + 0.5 * a[0]
        assert run.memory[0] == pytest.approx(x, rel=1e-9, abs=1e-12)


def test_a_sensor_is_late_biased_noisy_limited_and_counts_in_quanta() -> None:
    sensor = Sensor(noise=0.5, bias=0.2, quantum=0.25, range=2.0, delay=2)
    law = control_law("bang_bang", high=1.0, sensors={"force": sensor}, seed=9)
    run = ControllerRun(controller_of(law))
    truth = [3.0, -1.0, 0.7, 0.3, -4.0]
    for k, f in enumerate(truth):
        given, _ = run.measured(np.array([0, 0, 0, 0, 0, 0, f], dtype=float))
        late = truth[k - 2] if k >= 2 else 0.0
        drawn = late + 0.2 + 0.5 * noise(9, k * 65536)[1]
        assert given == pytest.approx(0.25 * np.floor(np.clip(drawn, -2.0, 2.0) / 0.25 + 0.5))
        run.sample += 1


def test_noise_is_white_normal_and_its_own_for_each_seed_site_channel_and_sample() -> None:
    from scipy.stats import kstest

    draws = np.array(
        [
            noise(seed, k * 65536 + site * 256 + pair)
            for seed in range(5) for site in range(2) for pair in range(2) for k in range(500)
        ]
    )  # fmt: skip
    values = draws.ravel()
    assert kstest(values, "norm").pvalue > 0.01
    assert abs(np.corrcoef(draws.T)[0, 1]) < 4 / np.sqrt(len(draws))
    assert abs(np.corrcoef(draws[:-1, 0], draws[1:, 0])[0, 1]) < 4 / np.sqrt(len(draws))
    by_stream = draws[:, 0].reshape(20, 500)
    others = np.corrcoef(by_stream)[np.triu_indices(20, 1)]
    assert np.abs(others).max() < 5 / np.sqrt(500)


@pytest.mark.parametrize("place", [1, 2, (0, 2)])
def test_measures_are_what_they_are_called(place) -> None:
    building = two_storey()
    row, rng = building.connection(place), np.random.default_rng(3)
    q, v, ground, ag, f = rng.standard_normal(2), rng.standard_normal(2), 0.3, -0.7, 11.0
    w = np.concatenate([q, v, [ground, ag, f]])
    here = DamperPlace(building, row[None], 0)
    a, e, b = system(building, row[None])
    relative = (a @ np.concatenate([q, v]) + e * ag + b[:, 0] * f)[2:]
    upper, lower = (2, 1) if place == 2 else (place if isinstance(place, int) else 2, 0)
    velocities = np.concatenate([[ground], v + ground])
    expected = {
        "stroke": row @ q,
        "rate": row @ v,
        "absolute_rate": row @ v + (0.0 if place == 2 else ground),
        "force": f,
        "velocity": velocities[upper],
        "lower_velocity": -velocities[lower],
        "acceleration": (relative + ag)[upper - 1],
        "accelerations": relative + ag,
        "state": np.concatenate([q, v]),
        "ground_velocity": ground,
        "ground_acceleration": ag,
    }
    assert set(expected) == set(ALL_MEASURES)
    for name, value in expected.items():
        assert ALL_MEASURES[name].rows(here) @ w == pytest.approx(np.atleast_1d(value), rel=1e-12, abs=1e-12), name


def test_what_does_not_fit_is_said() -> None:
    for law, message in (
        (
            control_law("on_off", high=1.0, sensors={"force": Sensor(noise=1.0)}),
            "'force', which OnOff does not measure; it",
        ),
        (Filtered(0.0, 1.0, gain=float("nan")), "they must be finite"),
    ):
        with pytest.raises(InputError, match=message):
            controller_of(law)
    for name, value in (("noise", -1.0), ("range", 0.0), ("delay", 1.5), ("bias", float("inf")), ("quantum", "a")):
        with pytest.raises(InputError, match=f"{name} = .* of a sensor is not allowed"):
            Sensor(**{name: value})
    with pytest.raises(InputError, match=r"seed = -1 is not allowed; it must be a whole number from 0"):
        control_law("on_off", high=1.0, seed=-1)
    with pytest.raises(InputError, match="write a Sensor for each measure"):
        control_law("on_off", high=1.0, sensors={"rate": 0.1})


@pytest.mark.parametrize("name", available_control_laws())
def test_the_text_of_the_kernel_decides_as_the_controller_does(name: str, cubics: Damper, monkeypatch) -> None:
    """On one record of measurements, with sensors that err; the lanes are compared in test_ensemble_control.py."""
    measures = getattr(module_of(control_law(name, high=3.0)), "MEASURES", ())
    asks = asks_force(type(control_law(name, high=3.0)))
    erring = Sensor(1e-5, 1e-6, 1e-7, 1e6, 1) if asks else Sensor(0.1, 0.05, 0.01, 1e6, 1)
    law = control_law(name, high=3.0, sensors=dict.fromkeys(measures, erring), seed=4)
    building = two_storey()
    sites = make_sites(building, {1: cubics}, law, None, False)
    each = controller_of(law)
    control, models = _control(sites, law_source((law,))[1], [each], 0.005, 200), wanted_forces(sites, [0], [each])
    run, rng = ControllerRun(each, inverse=inverse_of(law, cubics)), np.random.default_rng(2)
    # forces as large as the building's springs give; where one is asked for, motions at which the damper gives it now and then
    sizes = [2e-5, 2e-5, 1e-3, 1e-3, 1, 1, 1e5] if asks else [1, 1, 1, 1, 1, 1, 1e5]
    record = rng.standard_normal((200, 7)) * sizes
    decided = [(run.decide(w), run.reason) for w in record]
    functions = {name: getattr(np, name) for name in ("exp", "sqrt", "tanh", "copysign")}
    exec(law_source((law,))[0], functions)
    for function in ("decide", "remember"):
        monkeypatch.setattr(time_stepping, function, functions[function])
    of_the_damper = {name: getattr(math, name) for name in ("exp", "expm1", "sqrt", "copysign")}
    exec(text_of((cubics.composition,)), of_the_damper)
    for function in ("advance", "force"):
        for module in (followed_model, inverse_model):
            monkeypatch.setattr(module, function, of_the_damper[function], raising=False)
    lin = SimpleNamespace(pull=np.zeros(2))
    for k, (w, (expected, _)) in enumerate(zip(record, decided, strict=True)):
        now = SimpleNamespace(z=w[:4], f=w[6:])
        with np.errstate(over="ignore"):
            time_stepping.measure(0, k, lin, control, None, now, w[4], w[5])
        time_stepping.filtered(0, control)
        control.command[0] = time_stepping.take_decision(0, k, control, models)
        assert control.command[0] == pytest.approx(expected, abs=1e-10)
    assert len({u for u, _ in decided}) >= (1 if name.startswith("passive") else 2)
    if asks:
        assert {"met", "wrong_sign", "above_largest"} <= {reason for _, reason in decided}
        assert models.tally.sum() == 200


def test_functions_of_one_name_in_two_files_stay_apart() -> None:
    """What a law calls has its prefix: `fuzzy` has a function ``large``, and another file may have one."""
    texts = law_texts(Filtered, "mine") + law_texts(type(control_law("fuzzy", high=1.0)), "theirs")
    assert [text.partition("(")[0] for text in texts] == [
        "def mine_decide", "def mine_update", "def theirs_large", "def theirs_decide",
    ]  # fmt: skip
    assert "theirs_large(velocity" in texts[-1]
    assert not re.search(r"(?<!_)\blarge\(", texts[-1])


def test_the_filter_of_the_state_is_the_one_that_riccatis_recursion_ends_at() -> None:
    """Its gain by two thousand steps of the plain Kalman recursion, written out here."""
    from scipy.linalg import expm

    building, law = shear_building([3e2, 2e2, 1e2], [2e5, 1e5, 1e5], damping_ratio=0.02), None
    law = control_law("clipped_optimal_lqg", high=1.0, noise=0.02, disturbance=0.5)
    each, row = controller_of(law, building), building.connection(1)
    a, e, b = system(building, row[None])
    big = np.zeros((8, 8))
    big[:6] = np.column_stack([a, b, e])
    step = expm(big * law.period)
    phi, push, C = step[:6, :6], step[:6, 7], a[3:]
    P = np.zeros((6, 6))
    for _ in range(4000):
        P = phi @ P @ phi.T + 0.25 * np.outer(push, push)
        L = P @ C.T @ np.linalg.inv(C @ P @ C.T + 4e-4 * np.eye(3))
        P = (np.eye(6) - L @ C) @ P
    assert pytest.approx(phi @ (np.eye(6) - L @ C), rel=1e-6, abs=1e-6 * np.abs(each.F).max()) == each.F
