"""Responses under control laws, against scipy, constant inputs, and buildings that hold the same in their matrices."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from tests.structures.begin_of_el_centro import short

from dampyr.errors import DampyrWarning, ExtrapolationWarning, InputError, RangeError
from dampyr.ground_motions import GroundMotion, el_centro, resampled
from dampyr.models import Damper
from dampyr.structures import Building, available_control_laws, control_law, respond, two_storey
from dampyr.structures.controller import design_controller
from dampyr.structures.law_form import ControlLaw, LawDesign
from dampyr.studies import raminelli_2020

HIGH = 3.212
LONG = ("bang_bang", "lyapunov", "skyhook")  # proofs; a new law is looked at by `make test`
# Two are constant, one looks at the ground as a wheel, and one hardly ever lets go of a damper between ground and floor.
NOT_OF_A_BUILDING = ("passive_off", "passive_on", "groundhook", "maximum_dissipation")
EVERY_LAW = pytest.mark.parametrize(  # a kernel is compiled for each
    "name",
    [pytest.param(name, marks=[pytest.mark.prove] * (name in LONG)) for name in available_control_laws()],
)


@pytest.fixture(scope="module")
def damper() -> Damper:
    return raminelli_2020.damper()


MEASURES = ("state",)


@dataclass(frozen=True)
class Follow(ControlLaw):
    """A law of one's own: full input while the first floor moves to the right."""

    low: float = 0.0
    high: float = HIGH
    bias: float = 0.0


def design(law, building, row):
    return LawDesign({"first": np.eye(2 * building.n)[building.n]})


def decide(first: float, low: float, high: float, bias: float) -> float:
    return high + bias if first > 0.0 else low


def reference(damper: Damper, motion: GroundMotion, chosen: Callable, period: float, lag: float) -> tuple:
    """Peaks (n,) and the state at the end of the plain equations, by scipy between the instants at which anything changes.

    ``chosen(q, v, ground velocity, force)`` is the law. The lag of the coil is one more state.
    """
    from scipy.integrate import solve_ivp

    building, laws = two_storey(), list(damper.all_laws.values())
    n, row, minv = building.n, building.connection(1), np.linalg.inv(building.M)
    end = motion.dt * (motion.n - 1)
    edges = np.unique(np.round([*np.arange(0, end + 1e-9, period), *np.arange(0, end + 1e-9, motion.dt)], 9))
    y, u, peak = np.zeros(2 * n + 3), 0.0, np.zeros(n)
    for a, b in pairwise(edges):
        if abs(a / period - round(a / period)) < 1e-6:
            kx, kw, _ = (law(y[-1]) for law in laws)
            u = chosen(y[:n], y[n : 2 * n], y[-2], kx * (row @ y[n : 2 * n]) + kw * y[2 * n])
            y[-1] = u if lag == 0 else y[-1]
        a0, a1 = np.interp([a, b], motion.time, motion.acceleration)

        def rhs(t, y, a=a, b=b, a0=a0, a1=a1, u=u):
            q, v, w = y[:n], y[n : 2 * n], y[2 * n]
            kx, kw, rho = (law(y[-1]) for law in laws)
            rate, ground = row @ v, a0 + (a1 - a0) * (t - a) / (b - a)
            pull = minv @ (-building.K @ q - building.C @ v - row * (kx * rate + kw * w))
            coil = (u - y[-1]) / lag if lag else 0.0
            return np.concatenate([v, pull - ground, [rho * (rate - abs(rate) * w), ground, coil]])

        done = solve_ivp(rhs, (a, b), y, "Radau", rtol=1e-8, atol=1e-11, max_step=(b - a) / 2, dense_output=True)
        assert done.success
        peak = np.maximum(peak, np.abs(done.sol(np.linspace(a, b, 80))[:n]).max(axis=1))
        y = done.y[:, -1]
    return peak, y


def on_off(q, v, ground, f):
    return HIGH if (v[0] + ground) * v[0] > 0 else 0.0


def skyhook(q, v, ground, f):
    y = v[0] + ground
    return HIGH * min(1.0, y / v[0]) if y * v[0] > 0 else 0.0


def opposing(q, v, ground, f):
    return HIGH if (v[0] + ground) * f > 0 else 0.0


@pytest.mark.prove  # the reference takes long
@pytest.mark.parametrize(
    ("name", "chosen", "period", "lag"),
    [
        ("on_off", on_off, 0.005, 0.0),
        ("on_off", on_off, 0.02, 0.01),
        ("skyhook", skyhook, 0.01, 0.0),
        ("bang_bang", opposing, 0.01, 0.005),
    ],
)
def test_equals_scipy(damper, name, chosen, period, lag):
    motion = short(2.6)
    peak, end = reference(damper, motion, chosen, period, lag)
    law = control_law(name, high=HIGH, period=period, lag=lag)
    response = respond(two_storey(), motion, {1: damper}, voltage=law)
    assert response.converged
    assert response.scheme == "exact path"
    assert response.peak_displacement == pytest.approx(peak, rel=1e-4)
    fine = respond(two_storey(), motion, {1: damper}, voltage=law, step=2.5e-4)
    assert fine.peak_displacement == pytest.approx(peak, rel=5e-6)
    assert fine.displacement[:, -1] == pytest.approx(end[:2], abs=1e-6 * peak.max())
    assert fine.input[0, -1] == pytest.approx(end[-1], abs=1e-6)


@pytest.mark.prove  # the reference takes long
def test_optimal_control_equals_scipy(damper):
    law = control_law("clipped_optimal", high=HIGH, period=0.01)
    weights = design_controller(law, two_storey(), two_storey().connection(1)[None], 0).rows[0]
    motion = short(2.6)

    def chosen(q, v, ground, f):
        return HIGH if (weights[:4] @ np.concatenate([q, v]) - f) * f > 0 else 0.0

    peak, _ = reference(damper, motion, chosen, 0.01, 0.0)
    assert respond(two_storey(), motion, {1: damper}, voltage=law).peak_displacement == pytest.approx(peak, rel=1e-4)


@EVERY_LAW
@pytest.mark.parametrize("lag", [0.0, 0.01])
def test_a_law_with_nothing_to_choose_is_a_constant_input(damper, name, lag):
    constant = respond(two_storey(), short(6.0), {1: damper}, voltage=1.98, step=0.0025)
    law = control_law(name, low=1.98, high=1.98, lag=lag)
    response = respond(two_storey(), short(6.0), {1: damper}, voltage=law, step=0.0025)
    assert response.displacement == pytest.approx(constant.displacement, abs=1e-14)
    assert response.force == pytest.approx(constant.force, abs=1e-9)
    assert np.all(response.input == 1.98)
    assert np.all(constant.input == 1.98)


@pytest.mark.parametrize("name", [name for name in available_control_laws() if not name.startswith("passive")])
def test_every_law_keeps_its_input_in_bounds_and_uses_both_ends(damper, name):
    law = control_law(name, low=0.4, high=3.0, lag=0.002)
    response = respond(two_storey(), short(12.0), {1: damper}, voltage=law)
    assert response.converged
    assert 0.4 <= response.input.min() < 0.5
    assert 2.9 < response.input.max() <= 3.0
    assert response.laws == (f"{name} 0.4 to 3 V, lag 0.002 s",)
    assert response.inputs == (None,)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.prove] * (name in (*LONG, "clipped_optimal")))
        for name in available_control_laws()
        if name not in NOT_OF_A_BUILDING
    ],
)
def test_every_law_does_better_than_the_damper_without_input(damper, name):
    passive_off, passive_on = (respond(two_storey(), short(12.0), {1: damper}, voltage=u) for u in (0.0, HIGH))
    lag = 0.002 if name == "predictive" else 0.0  # without one, a single decision of its 2,400 hangs on the step
    response = respond(two_storey(), short(12.0), {1: damper}, voltage=control_law(name, high=HIGH, lag=lag))
    assert passive_on.peak_displacement[0] < response.peak_displacement[0] < passive_off.peak_displacement[0]
    assert response.peak_drift[1] < min(passive_on.peak_drift[1], passive_off.peak_drift[1])
    assert 0.0 < response.mean_input[0] < HIGH


def test_the_input_is_held_between_decisions(damper):
    response = respond(two_storey(), el_centro(), {1: damper}, voltage=control_law("skyhook", high=HIGH, period=0.1))
    held = response.input[0, 1:].reshape(-1)[:1555].reshape(-1, 5)  # a jump at a sample shows at the next one
    assert np.all(held == held[:, :1])
    assert np.unique(held[:, 0]).size > 10


@pytest.mark.prove
@pytest.mark.parametrize("lag", [0.0, 0.004])
def test_the_mean_input_is_one_over_time(damper, lag):
    """Laws decide every 5 ms and the motion has a sample every 20: the mean is that of the same motion with 5 ms, and less."""
    motion = short(8.0)
    law = control_law("clipped_optimal", high=HIGH, lag=lag)
    response = respond(two_storey(), motion, {1: damper, 2: damper}, voltage={1: law, 2: 1.0}, step=0.00125)
    fine = resampled(motion, 0.005 if lag == 0.0 else 0.00125)
    expected = respond(two_storey(), fine, {1: damper, 2: damper}, voltage={1: law, 2: 1.0}, step=0.00125)
    assert response.displacement == pytest.approx(expected.displacement[:, :: round(motion.dt / fine.dt)], abs=1e-12)
    u = expected.input[0]
    mean = u[1:].mean() if lag == 0.0 else np.trapezoid(u, expected.time) / expected.time[-1]
    assert response.mean_input == pytest.approx([mean, 1.0], rel=1e-12 if lag == 0.0 else 5e-3)
    assert response.to_xarray().mean_input.attrs["units"] == "V"
    assert response.as_dict()["mean_input"] == response.mean_input.tolist()


def test_the_coil_follows_its_command_by_the_exponential(damper):
    """After a jump of the command at t = 0, which the law's bias makes, the coil's input is known."""
    law, tau = control_law("on_off", low=0.0, high=HIGH, period=10.0, lag=0.05), 0.05
    pushed = GroundMotion(np.full(26, 2.0), 0.02, "a push")  # the ground moves from the first instant on
    still = respond(two_storey(), pushed, {1: damper}, voltage=law)
    assert np.all(still.input == 0.0)  # at rest the law sees no velocity
    rising = respond(two_storey(), pushed, {1: damper}, voltage=control_law("on_off", high=HIGH, period=0.1, lag=tau))
    t = rising.time
    assert rising.input[0, 6:11] == pytest.approx(
        HIGH * (1 - np.exp(-(t[6:11] - 0.1) / tau)) * (rising.input[0, 10] > 0)
    )


@pytest.mark.prove  # its kernels take long to compile
def test_the_lag_of_the_damper_is_that_of_the_coil(damper):
    lagging = Damper("dahl + lag", dict(damper.all_laws) | {"lag.tau": 0.01})
    expected = respond(
        two_storey(), short(4.0), {1: damper}, voltage=control_law("on_off", high=HIGH, lag=0.01), step=0.001
    )
    response = respond(two_storey(), short(4.0), {1: lagging}, voltage=control_law("on_off", high=HIGH), step=0.001)
    assert response.displacement == pytest.approx(expected.displacement, abs=1e-15)
    with pytest.raises(InputError, match=r"a lag of 0.01 s and on_off one of 0.02 s; leave one"):
        respond(two_storey(), short(1.0), {1: lagging}, voltage=control_law("on_off", high=HIGH, lag=0.02))


@pytest.mark.parametrize("lag", [0.0, 0.01])
def test_energy_closes_and_its_residual_falls_with_the_step(damper, lag):
    law, worst = control_law("bang_bang", high=HIGH, lag=lag), []
    for step in (0.0025, 0.00125, 0.000625):
        energy = respond(two_storey(), el_centro(), {1: damper}, voltage=law, step=step).energy
        worst.append(np.abs(energy.residual).max() / energy.input.max())
    assert worst[0] < 2e-5
    assert worst[1] < worst[0] / 8
    assert worst[2] < worst[1] / 8


def test_where_the_force_jumps_the_motion_obeys_its_equation(damper):
    building = two_storey()
    response = respond(building, el_centro(), {1: damper}, voltage=control_law("on_off", high=HIGH, period=0.02))
    row = building.connection(1)
    pull = -building.K @ response.displacement - building.C @ response.velocity - np.outer(row, response.force[0])
    assert response.acceleration == pytest.approx(np.linalg.solve(building.M, pull), abs=1e-9)
    kx, kw, _ = damper.values(response.input[0]).T
    w = (response.force[0] - kx * response.velocity[0]) / kw
    assert np.abs(w).max() <= 1 + 1e-9  # the force is that of the input beside it
    assert np.count_nonzero(np.diff(response.input[0])) > 100


@pytest.mark.prove  # its kernels take long to compile
def test_a_mass_in_the_damper_answers_its_jumps(damper):
    """An inertance belongs into the building's mass matrix just as well; a law of one's own sees no difference."""
    b, extra = two_storey(), 40.0
    row = b.connection(1)
    heavy = b.M + extra * np.outer(row, row)
    other = Building(heavy, b.C, b.K, influence=np.linalg.solve(heavy, b.M @ b.influence))
    with_mass = Damper("dahl + inertia", dict(damper.all_laws) | {"inertia.m": extra})
    expected = respond(other, short(6.0), {1: damper}, voltage=Follow(), step=0.0005)
    response = respond(b, short(6.0), {1: with_mass}, voltage=Follow(), step=0.0005)
    assert response.displacement == pytest.approx(expected.displacement, abs=1e-6 * expected.peak_displacement.max())
    assert np.array_equal(response.input, expected.input)
    assert 0.2 < np.mean(response.input > 0) < 0.8


@pytest.mark.prove  # its kernels take long to compile
def test_a_law_of_ones_own_may_not_leave_its_bounds(damper):
    with pytest.raises(
        InputError, match=r"the law in storey 1 asked for 3.312; it must stay between its low = 0 and high"
    ):
        respond(two_storey(), short(2.0), {1: damper}, voltage=Follow(bias=0.1))


@pytest.mark.prove  # its kernels take long to compile
def test_laws_numbers_and_clocks_side_by_side(damper):
    """Each site has its own: a law with nothing to choose, at another period, beside a number changes nothing."""
    slow = control_law("skyhook", low=1.0, high=1.0, period=0.04)
    fast = control_law("on_off", high=HIGH, period=0.005)
    given = {1: fast, 2: 1.0}, {1: fast, 2: slow}
    one, two = (respond(two_storey(), short(4.0), {1: damper, 2: damper}, voltage=v, step=0.001) for v in given)
    assert two.displacement == pytest.approx(one.displacement, abs=1e-15)
    assert one.laws == ("on_off 0 to 3.212 V", "")
    assert one.inputs == (None, 1.0)
    alone = respond(two_storey(), short(4.0), {1: damper, 2: damper}, voltage=fast, step=0.001)
    assert np.abs(alone.displacement - one.displacement).max() > 1e-5


def test_a_damper_over_the_current_takes_laws_too(damper):
    by_current = Damper("dahl", damper.all_laws, input="A")
    law = control_law("on_off", high=HIGH)
    response = respond(two_storey(), short(2.0), {1: by_current}, current=law, step=0.001)
    expected = respond(two_storey(), short(2.0), {1: damper}, voltage=law, step=0.001)
    assert response.displacement == pytest.approx(expected.displacement, abs=1e-15)
    assert response.to_xarray().input.attrs["units"] == "A"
    assert response.laws == ("on_off 0 to 3.212 A",)
    with pytest.raises(InputError, match="takes a current"):
        respond(two_storey(), short(1.0), {1: by_current}, voltage=law)


@pytest.mark.prove  # its kernels take long to compile
@pytest.mark.parametrize(
    "parts",
    [
        "dahl + delay",
        *(
            pytest.param(name, marks=pytest.mark.by_hand)
            for name in ("dahl + compliance", "hyperbolic_tangent + spring")
        ),
    ],
)
def test_other_dampers_settle_with_the_step(damper, parts):
    values = {"delay.tau": 0.0073, "compliance.s": 5e-6, "spring.k0": 900.0}
    tanh = {"hyperbolic_tangent.c": 1500.0, "hyperbolic_tangent.v0": 0.0032, "hyperbolic_tangent.s": 0.13}
    tanh["hyperbolic_tangent.ft"] = damper.all_laws["dahl.kw"]
    laws = (dict(damper.all_laws) if "dahl" in parts else tanh) | {
        k: v for k, v in values.items() if k.split(".")[0] in parts
    }
    given = (two_storey(), short(4.0), {1: Damper(parts, laws)})
    law = control_law("on_off", high=HIGH, period=0.02)
    response, fine = respond(*given, voltage=law, accuracy=1e-3), respond(*given, voltage=law, step=5e-5)
    assert response.converged
    assert response.peak_displacement == pytest.approx(fine.peak_displacement, rel=2e-3)
    assert fine.input.max() == HIGH


def test_as_a_dataset(damper):
    data = respond(two_storey(), short(1.0), {1: damper}, voltage=control_law("on_off", high=HIGH)).to_xarray()
    assert data.input.dims == ("damper", "time")
    assert data.input.attrs["units"] == "V"
    assert data.damper_law.values.tolist() == ["on_off 0 to 3.212 V"]
    bare = respond(two_storey(), short(1.0)).to_xarray()
    assert bare.input.shape == (0, 51)


def test_extrapolation_is_asked_for_by_name(damper):
    law = control_law("on_off", high=3.5)
    with pytest.raises(RangeError, match=r"3.5 V is outside the calibrated range 0 to 3.212 V"):
        respond(two_storey(), short(1.0), {1: damper}, voltage=law)
    with pytest.warns(ExtrapolationWarning) as caught:
        respond(two_storey(), short(1.0), {1: damper}, voltage=law, allow_extrapolation=True)
    assert len(caught) == 1
    with pytest.warns(ExtrapolationWarning), pytest.raises(InputError, match=r"dahl\.rho"):  # a root at 3.674 V
        respond(
            two_storey(), short(1.0), {1: damper}, voltage=control_law("on_off", high=4.0), allow_extrapolation=True
        )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"voltage": control_law("on_off", low=-1.0, high=1.0)}, "-1 V is outside the calibrated range"),
        ({"voltage": control_law("on_off", high=1.0, period=0.0061234)}, "does not fit the motion's 0.02 s"),
        (
            {"voltage": control_law("on_off", high=1.0), "step": 0.01},
            r"does not divide the periods of the laws; take 0.005 s",
        ),
        ({"voltage": control_law("on_off", high=1.0, lag=1e-6)}, r"a lag of 1e-06 s is below the 2e-05 s"),
        ({"voltage": "on_off"}, "'on_off' in storey 1 is not a finite number; write a constant in V, or a control law"),
        ({"current": control_law("on_off", high=1.0)}, "takes a voltage"),
    ],
)
def test_bad_arguments_are_one_helpful_sentence(damper, arguments, message):
    with pytest.raises(ValueError, match=message):
        respond(two_storey(), short(1.0), {1: damper}, **arguments)


def test_a_delay_that_changes_with_the_input_is_refused(damper):
    laws = dict(damper.all_laws) | {"delay.tau": damper.all_laws["dahl.kw"].with_coefficients((0.01, 0.001, 0.0, 0.0))}
    with pytest.raises(InputError, match="delay of this damper changes with its input"):
        respond(two_storey(), short(1.0), {1: Damper("dahl + delay", laws)}, voltage=control_law("on_off", high=1.0))


def test_accuracy_that_is_not_reached_is_said(damper, monkeypatch):
    import sys

    monkeypatch.setattr(sys.modules["dampyr.structures.time_history.step_size"], "MAX_STEP_COUNT", 2000)
    with pytest.warns(DampyrWarning, match="not to its accuracy"):
        response = respond(
            two_storey(), short(2.0), {1: damper}, voltage=control_law("on_off", high=HIGH), accuracy=1e-12
        )
    assert not response.converged
