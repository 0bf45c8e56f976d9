import json
import math
import warnings

import numpy as np
import pytest

from dampyr.errors import DampyrWarning, ExtrapolationWarning, InputError, RangeError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.models import Damper
from dampyr.structures import Building, respond, shear_building, single_mass, two_storey


def short(seconds: float, scale: float = 1.0) -> GroundMotion:
    """The first seconds of El Centro."""
    motion = el_centro()
    return GroundMotion(
        np.asarray(motion.acceleration)[: round(seconds / motion.dt) + 1] * scale,
        motion.dt,
        "start of El Centro",
    )


def dahl(values: tuple[float, float, float]):
    kx, kw, rho = values
    return (lambda w, v: rho * (v - abs(v) * w)), (lambda w, x, v: kx * v + kw * w)


def test_bare_building_needs_no_damper_and_says_linear():
    response = respond(two_storey(), el_centro())
    assert response.scheme == "linear"
    assert response.converged
    assert response.force.shape == (0, 1560)
    assert response.displacement.shape == (2, 1560)
    assert response.error_estimate < 2e-4


def test_a_damper_alone_stands_in_storey_1(cubics):
    alone = respond(two_storey(), short(1.0), cubics, voltage=1.0, step=0.005)
    mapped = respond(two_storey(), short(1.0), {1: cubics}, voltage=1.0, step=0.005)
    assert alone.sites == mapped.sites == ("storey 1",)
    assert np.array_equal(alone.displacement, mapped.displacement)
    assert np.array_equal(alone.force, mapped.force)


def test_what_is_neither_a_damper_nor_a_mapping_is_refused():
    with pytest.raises(InputError, match=r"dampers is a str; write a damper, which stands in storey 1, or a mapping"):
        respond(two_storey(), short(1.0), "dahl", voltage=1.0)


def test_a_response_as_a_dictionary_goes_through_json(cubics):
    response = respond(two_storey(), short(1.0), cubics, voltage=1.0, step=0.005)
    read = json.loads(json.dumps(response.as_dict()))
    assert read["peak_displacement_m"] == response.peak_displacement.tolist()
    assert read["peak_force_N"] == response.peak_force.tolist()
    assert read["mean_input"] == [1.0]
    assert read["sites"] == ["storey 1"]
    assert read["step_s"] == 0.005
    assert read["error_estimate"] is None
    assert read["converged"] is True


@pytest.mark.parametrize(
    ("voltage", "seconds"),
    [(0.0, 1.4), *(pytest.param(u, 2.6, marks=pytest.mark.prove) for u in (0.0, 3.21))],
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


def test_small_amplitude_and_high_voltage_keep_the_accuracy(cubics):
    motion = el_centro().scaled(0.05)
    strict = respond(two_storey(), motion, {1: cubics}, voltage=2.25)
    fine = respond(two_storey(), motion, {1: cubics}, voltage=2.25, step=5e-5)
    assert strict.peak_displacement == pytest.approx(fine.peak_displacement, rel=2e-4)
    assert strict.peak_drift == pytest.approx(fine.peak_drift, rel=2e-4)


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


@pytest.mark.prove  # its kernel takes long to compile
def test_the_static_force_is_left_out(cubics):
    kx, kw, rho = cubics.values(0.0)
    laws = {"dahl.kx": kx, "dahl.kw": kw, "dahl.rho": rho, "offset.f0": 130.0}
    with_offset = respond(two_storey(), short(3.0), {1: Damper("dahl + offset", laws)}, voltage=0.0, step=0.002)
    without = respond(two_storey(), short(3.0), {1: cubics}, voltage=0.0, step=0.002)
    assert with_offset.displacement == pytest.approx(without.displacement, abs=1e-14)


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


@pytest.mark.filterwarnings("ignore:the damper in storey 1 fed")
def test_a_delay_shorter_than_can_be_resolved_is_refused(late):
    laws = dict(late.laws) | {"delay.tau": 1e-5}
    with pytest.raises(InputError, match=r"delay of 1e-05 s.*set it to 0"):
        respond(two_storey(), short(1.0), {1: Damper("dahl + delay", laws)}, voltage=0.0)


def test_a_damper_that_feeds_the_building_is_reported():
    feeding = Damper("dahl + delay", {"dahl.kx": 900.0, "dahl.kw": 1e-9, "dahl.rho": 1000.0, "delay.tau": 0.25})
    with pytest.warns(DampyrWarning, match="storey 1 fed"):
        respond(two_storey(), short(4.0), {1: feeding}, voltage=0.0)


def test_growth_without_bound_is_an_error():
    feeding = Damper("dahl + delay", {"dahl.kx": 9e6, "dahl.kw": 1e-9, "dahl.rho": 1000.0, "delay.tau": 0.02})
    with pytest.raises(InputError, match="grows without bound"):
        respond(two_storey(), short(20.0), {1: feeding}, voltage=0.0, step=0.01)


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


def test_peaks_are_taken_inside_the_step():
    coarse = respond(two_storey(), el_centro(), step=0.01)
    sampled = np.abs(coarse.displacement).max(axis=1)
    assert np.all(coarse.peak_displacement > sampled)
    assert coarse.peak_displacement == pytest.approx(
        respond(two_storey(), el_centro(), step=0.0005).peak_displacement, rel=1e-5
    )


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


def test_accuracy_is_recorded_and_fast_is_coarser(cubics):
    strict = respond(two_storey(), short(5.0), {1: cubics}, voltage=0.0)
    loose = respond(two_storey(), short(5.0), {1: cubics}, voltage=0.0, accuracy=0.05)
    tight = respond(two_storey(), short(5.0), {1: cubics}, voltage=0.0, accuracy=1e-8)
    assert strict.accuracy == 2e-4
    assert loose.step >= strict.step > tight.step
    assert tight.error_estimate < 1e-8
    assert respond(two_storey(), short(1.0), step=0.01).error_estimate is None


def test_shear_building_of_twenty_storeys(cubics):
    building = shear_building([1000.0] * 20, [2e6] * 20, damping_ratio=0.02)
    response = respond(building, short(2.0), {20: cubics}, voltage=0.0, step=0.002)
    fine = respond(building, short(2.0), {20: cubics}, voltage=0.0, step=0.0005)
    assert response.peak_drift == pytest.approx(fine.peak_drift, rel=1e-3)


def test_extrapolation_is_asked_for_by_name(cubics):
    with pytest.raises(RangeError, match=r"3.6"):
        respond(two_storey(), short(1.0), {1: cubics}, voltage=3.6)
    with pytest.warns(ExtrapolationWarning) as caught:
        respond(two_storey(), short(1.0), {1: cubics}, voltage=3.6, allow_extrapolation=True)
    assert len(caught) == 1


def test_motion_outside_the_calibrated_ranges_is_named(cubics):
    small = Damper("dahl", dict(cubics.laws), ranges={"displacement": (0.0, 0.001)})
    with pytest.warns(DampyrWarning, match=r"displacement of .* calibrated up to 0.001 m"):
        response = respond(two_storey(), short(3.0), {1: small}, voltage=0.0)
    assert len(response.doubts) == 1


def test_as_a_dataset(cubics):
    response = respond(two_storey(), short(1.0), {2: cubics}, voltage=0.0)
    data = response.to_xarray()
    assert data.displacement.dims == ("floor", "time")
    assert data.displacement.attrs["units"] == "m"
    assert data.time.attrs["units"] == "s"
    assert data.damper_storey.values.tolist() == [2]
    assert float(data.peak_drift.sel(storey=2)) == response.peak_drift[1]
    assert data.attrs["scheme"] == "exact path"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (lambda d: {"dampers": {3: d}, "voltage": 0.0}, r"storey 3 is not in .* from 1 .* to 2"),
        (lambda d: {"dampers": {0: d}, "voltage": 0.0}, r"storey 0 is not in"),
        (
            lambda d: {"dampers": 3.0, "voltage": 0.0},
            r"dampers is a float; write a damper, .* or a mapping from storey",
        ),
        (lambda d: {"dampers": {1: 3.0}, "voltage": 0.0}, r"holds a float"),
        (lambda d: {"dampers": {1: d}}, r"has no voltage; write voltage="),
        (lambda d: {"dampers": {1: d}, "current": 0.5}, r"takes a voltage"),
        (lambda d: {"dampers": {1: d}, "voltage": 0.5, "current": 0.5}, r"one of the two"),
        (lambda d: {"dampers": {1: d}, "voltage": math.nan}, r"not a finite number"),
        (lambda d: {"dampers": {1: d}, "voltage": {1: 0.0, 2: 1.0}}, r"storey 2, which holds no damper"),
        (lambda d: {"dampers": {1: d}, "voltage": 0.0, "accuracy": "sloppy"}, r"choose from strict, fast"),
        (
            lambda d: {"dampers": {1: d}, "voltage": 0.0, "accuracy": 0.0},
            r"greater than 0 and at most 1; or choose from strict, fast",
        ),
        (
            lambda d: {"dampers": {1: d}, "voltage": 0.0, "step": 0.003},
            r"nearest that do are 0.00333333 s or 0.00285714 s",
        ),
        (lambda d: {"dampers": {1: d}, "voltage": 0.0, "step": -1.0}, r"greater than 0"),
    ],
)
def test_bad_arguments_are_one_helpful_sentence(cubics, arguments, message):
    with pytest.raises(ValueError, match=message):
        respond(two_storey(), short(1.0), **arguments(cubics))


def test_a_given_step_may_not_be_longer_than_a_delay(late):
    with pytest.raises(InputError, match=r"longer than the delay of 0.0073 s"):
        respond(two_storey(), short(1.0), {1: late}, voltage=0.0, step=0.01)


def test_accuracy_that_is_not_reached_is_said(cubics, monkeypatch):
    import sys

    monkeypatch.setattr(sys.modules["dampyr.structures.time_history.step_size"], "MAX_STEP_COUNT", 2000)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        response = respond(two_storey(), short(2.0), {1: cubics}, voltage=1.98, accuracy=1e-9)
    assert not response.converged
    assert "2000 steps" in response.reason
    assert any("not to its accuracy" in str(w.message) for w in caught)


@pytest.mark.prove
@pytest.mark.filterwarnings("ignore::dampyr.errors.ExtrapolationWarning")
def test_strict_keeps_every_random_case_under_a_tenth_of_a_percent(cubics):
    rng = np.random.default_rng(20)
    for _ in range(40):
        scale, voltage = float(np.exp(rng.uniform(np.log(0.05), np.log(3.2)))), float(rng.uniform(0.0, 3.2))
        storey = int(rng.integers(1, 3))
        motion = el_centro().scaled(scale)
        strict = respond(two_storey(), motion, {storey: cubics}, voltage=voltage)
        fine = respond(two_storey(), motion, {storey: cubics}, voltage=voltage, step=1e-4)
        assert strict.peak_displacement == pytest.approx(fine.peak_displacement, rel=1e-3)
        assert strict.peak_drift == pytest.approx(fine.peak_drift, rel=1e-3)


def test_a_response_goes_on_after_the_record() -> None:
    """A pulse on an oscillator of 5 s, whose peak comes after it: that of the free vibration, by its closed form."""
    motion = GroundMotion(np.array([0.0, 1.0, 1.0, 0.0]), 0.1, "pulse")
    omega, zeta = 2 * np.pi / 5.0, 0.02
    tower = single_mass(100.0, stiffness=100.0 * omega**2, damping_ratio=zeta)
    ended, gone_on = respond(tower, motion), respond(tower, motion, after=10.0)
    assert gone_on.time[-1] == pytest.approx(10.3)
    np.testing.assert_allclose(gone_on.displacement[:, :4], ended.displacement, rtol=1e-12)
    damped = omega * np.sqrt(1 - zeta**2)
    x, v = ended.displacement[0, -1], ended.velocity[0, -1]
    t = np.linspace(0.0, 5.0, 50_001)
    free = np.exp(-zeta * omega * t) * (x * np.cos(damped * t) + (v + zeta * omega * x) / damped * np.sin(damped * t))
    assert gone_on.peak_displacement[0] == pytest.approx(np.abs(free).max(), rel=1e-6)
    assert gone_on.peak_displacement[0] > 5 * ended.peak_displacement[0]
    assert "ends with the record: what still swings then may reach its peak later" in repr(ended)
    assert "ends 10 s after the record" in repr(gone_on)
    assert (ended.as_dict()["after_s"], gone_on.to_xarray().attrs["after_s"]) == (0.0, 10.0)
    for wrong, words in ((-1.0, "at least 0"), (np.nan, "at least 0"), (True, 'must be a quantity such as "1 s"')):
        with pytest.raises(InputError, match=f"after = .*{words}"):
            respond(tower, motion, after=wrong)
