"""Dampers in a building against scipy's stiff solver, the method of steps, and matrices that hold the same."""

import math

import numpy as np
import pytest
from tests.structures.begin_of_el_centro import short

from dampyr.ground_motions import el_centro
from dampyr.models import Damper
from dampyr.structures import Building, respond, two_storey


def dahl(values: tuple[float, float, float]):
    kx, kw, rho = values
    return (lambda w, v: rho * (v - abs(v) * w)), (lambda w, x, v: kx * v + kw * w)


@pytest.mark.parametrize(
    ("voltage", "seconds"),
    [(0.0, 1.0), *(pytest.param(u, 2.6, marks=pytest.mark.prove) for u in (0.0, 3.21))],
)
def test_equals_a_stiff_reference(cubics, stiff_reference, voltage, seconds):
    motion = short(seconds)
    values = cubics.values(voltage)
    expected = stiff_reference(two_storey(), motion, [(1, *dahl(values))], seconds)
    response = respond(two_storey(), motion, {1: cubics}, voltage=voltage)
    assert response.scheme == "exact path"
    assert response.peak_displacement == pytest.approx(expected, rel=1e-4)
    fine = respond(two_storey(), motion, {1: cubics}, voltage=voltage, step=0.0002)
    assert fine.peak_displacement == pytest.approx(expected, rel=2e-6)


@pytest.mark.prove
def test_two_dampers_in_two_storeys_equal_a_stiff_reference(cubics, stiff_reference):
    motion = short(3.0)
    values = cubics.values(0.0), cubics.values(1.98)
    expected = stiff_reference(two_storey(), motion, [(1, *dahl(values[0])), (2, *dahl(values[1]))], 3.0)
    response = respond(two_storey(), motion, {1: cubics, 2: cubics}, voltage={1: 0.0, 2: 1.98})
    assert response.storeys == (1, 2)
    assert response.peak_displacement == pytest.approx(expected, rel=1e-4)


@pytest.mark.prove
def test_two_dampers_side_by_side_are_one_twice_as_strong(cubics):
    kx, kw, rho = cubics.values(1.98)
    strong = Damper("dahl", {"dahl.kx": 2 * kx, "dahl.kw": 2 * kw, "dahl.rho": rho})
    pair = respond(two_storey(), short(6.0), {1: [cubics, cubics]}, voltage=1.98, step=0.001)
    one = respond(two_storey(), short(6.0), {1: strong}, voltage=0.0, step=0.001)
    assert pair.force.shape[0] == 2
    assert pair.displacement == pytest.approx(one.displacement, abs=1e-12)
    assert pair.base_shear == pytest.approx(one.base_shear, abs=1e-6)


@pytest.mark.prove
def test_rate_dependent_damper_equals_a_stiff_reference(tangent, stiff_reference):
    c, ft, v0, s = tangent.values(0.0)
    motion = short(2.6)
    law = (lambda w, v: 0.0), (lambda w, x, v: c * v + ft * math.tanh((v + s * x) / v0))
    expected = stiff_reference(two_storey(), motion, [(1, *law)], 2.6)
    response = respond(two_storey(), motion, {1: tangent}, voltage=0.0)
    assert response.peak_displacement == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("k", [0.0, pytest.param(20e3, marks=pytest.mark.prove)])
def test_a_spring_and_a_dashpot_are_part_of_the_building(k):
    """A damper that is linear must equal the building whose matrices hold it."""
    c, laws = 3e3, {"dahl.kx": 3e3, "dahl.kw": 1e-9, "dahl.rho": 1000.0}
    part = Damper("spring + dahl", laws | {"spring.k0": k}) if k else Damper("dahl", laws)
    bare, row = two_storey(), two_storey().connection(2)
    both = Building(bare.M, bare.C + c * np.outer(row, row), bare.K + k * np.outer(row, row))
    expected = respond(both, el_centro(), step=0.001)
    response = respond(bare, el_centro(), {2: part}, voltage=0.0, step=0.001)
    assert response.displacement == pytest.approx(expected.displacement, abs=1e-8)
    assert response.acceleration == pytest.approx(expected.acceleration, abs=1e-5)
    assert response.base_shear == pytest.approx(expected.base_shear, abs=1e-3)
    assert response.peak_drift == pytest.approx(expected.peak_drift, rel=1e-7)


def delayed_reference(building, motion, damper, until, h):
    """Method of steps, written apart from the package: small explicit steps, the force of the past
    read off its samples."""
    kx, kw, rho, tau = damper.values(0.0)
    row, minv, lag = building.connection(1), np.linalg.inv(building.M), round(tau / h)
    n, steps = building.n, round(until / h)
    past, y, w = np.zeros(steps + 1), np.zeros(2 * n), 0.0
    top = np.zeros(n)
    ag = np.interp(np.arange(2 * steps + 1) * h / 2, motion.time, motion.acceleration)

    def rhs(y, a, f):
        q, v = y[:n], y[n:]
        return np.concatenate([v, minv @ (-building.K @ q - building.C @ v - row * f) - a])

    def before(k):
        return past[k] if k > 0 else 0.0

    for k in range(steps):
        f0, f1 = before(k - lag), before(k + 1 - lag)
        fh = 0.5 * (f0 + f1)
        k1 = rhs(y, ag[2 * k], f0)
        k2 = rhs(y + 0.5 * h * k1, ag[2 * k + 1], fh)
        k3 = rhs(y + 0.5 * h * k2, ag[2 * k + 1], fh)
        k4 = rhs(y + h * k3, ag[2 * k + 2], f1)
        new = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        dx = row @ (new[:n] - y[:n])
        s = math.copysign(1.0, dx)
        w = s + (w - s) * math.exp(-rho * abs(dx))
        y = new
        past[k + 1] = kx * (row @ y[n:]) + kw * w
        top = np.maximum(top, np.abs(y[:n]))
    return top


@pytest.mark.prove
def test_delayed_damper_equals_the_method_of_steps(late):
    motion = short(3.0)
    expected = delayed_reference(two_storey(), motion, late, 3.0, 0.0001)
    response = respond(two_storey(), motion, {1: late}, voltage=0.0)
    assert response.scheme == "general"
    assert response.peak_displacement == pytest.approx(expected, rel=2e-4)
    coarse = respond(two_storey(), motion, {1: late}, voltage=0.0, step=0.0025)
    assert coarse.peak_displacement == pytest.approx(expected, rel=1e-3)
    undelayed = Damper("dahl", {k: law for k, law in late.laws.items() if k != "delay.tau"})
    other = respond(two_storey(), motion, {1: undelayed}, voltage=0.0)
    assert abs(other.peak_displacement[0] / expected[0] - 1) > 0.01  # the delay does matter here


@pytest.mark.prove
def test_delay_may_differ_between_dampers(late, cubics):
    response = respond(two_storey(), short(2.0), {1: late, 2: cubics}, voltage=0.0)
    fine = respond(two_storey(), short(2.0), {1: late, 2: cubics}, voltage=0.0, step=0.0001)
    assert response.peak_displacement == pytest.approx(fine.peak_displacement, rel=2e-4)


def test_energy_closes_and_its_residual_falls_with_the_step(cubics):
    worst = []
    for step in (0.004, 0.002, 0.001):
        energy = respond(two_storey(), el_centro(), {1: cubics}, voltage=1.98, step=step).energy
        worst.append(np.abs(energy.residual).max() / energy.input.max())
    assert worst[0] < 1e-6
    assert worst[1] < worst[0] / 12
    assert worst[2] < worst[1] / 12
    assert worst[2] < 1e-8
    assert energy.damper[-1] > 0.5 * energy.input.max()
    assert np.all(np.diff(energy.viscous) >= 0)


@pytest.mark.prove
def test_fourth_order_in_the_step():
    """On a smooth damper without memory, halving the step divides the error by about sixteen."""
    soft = Damper(
        "hyperbolic_tangent",
        {
            "hyperbolic_tangent.c": 500.0,
            "hyperbolic_tangent.ft": 300.0,
            "hyperbolic_tangent.v0": 0.5,
            "hyperbolic_tangent.s": 0.0,
        },
    )
    motion = short(3.0)
    ends = {
        h: respond(two_storey(), motion, {1: soft}, voltage=0.0, step=h).displacement[:, -1]
        for h in (0.02, 0.01, 0.005, 0.0005)
    }
    errors = [np.abs(ends[h] - ends[0.0005]).max() for h in (0.02, 0.01, 0.005)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 3.5)


def test_histories_obey_the_equation_of_motion(cubics):
    building = two_storey()
    response = respond(building, short(5.0), {1: cubics}, voltage=1.98)
    row = building.connection(1)
    pull = -building.K @ response.displacement - building.C @ response.velocity - np.outer(row, response.force[0])
    assert response.acceleration == pytest.approx(np.linalg.solve(building.M, pull), abs=1e-9)
    assert response.base_shear == pytest.approx(-(building.M @ response.acceleration).sum(axis=0), rel=1e-12, abs=1e-9)
    assert response.stroke[0] == pytest.approx(response.drift[0], abs=0)
    assert response.drift[1] == pytest.approx(response.displacement[1] - response.displacement[0], abs=0)
    assert np.all(response.peak_acceleration >= np.abs(response.acceleration).max(axis=1))
    assert response.peak_force[0] >= np.abs(response.force).max()


def test_path_alone_decides_the_hysteretic_force(cubics):
    """The force histories are what the damper gives along the stroke of the response."""
    response = respond(two_storey(), short(5.0), {1: cubics}, voltage=0.0, step=0.001)
    kx, kw, _ = cubics.values(0.0)
    w = (response.force[0] - kx * response.velocity[0]) / kw
    assert np.abs(w).max() <= 1 + 1e-9
    assert np.abs(w).max() > 0.999
