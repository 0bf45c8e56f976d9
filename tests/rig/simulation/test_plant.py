"""The plant against closed forms: speed and droop, ends and play, coil, load cell, heat, energy, and its own step."""

import numpy as np
import pytest
from tests.rig.simulation.driver import follow, rig, sine
from tests.rig.simulation.parts import settings

from dampyr.models import Damper
from dampyr.rig.firmware import control_core as c
from dampyr.rig.firmware.protocol import Request, State
from dampyr.rig.simulation import plant
from dampyr.rig.simulation.simulator import Simulator

NOTHING = Damper("spring", {"spring.k0": 0.0})


def driven(made: Simulator, seconds: float, duty: int) -> None:
    """Constant duty without firmware: what `control` would do, held by hand."""
    made.twin.registers[:] = 0
    made._kernel = held_at(made._kernel, duty)
    made.run_unattended(seconds)


def held_at(kernel, duty):
    """The kernel with the firmware out of the way: state REVERSING with a top that is reached at once."""

    def run(until, m, y, n, z, *rest):
        registers = rest[5]
        registers[[c.R_STATE, c.R_RATE, c.R_SIGN, c.R_STROKES, c.R_DUTY]] = (
            State.REVERSING,
            abs(duty),
            np.sign(duty),
            9,
            duty,
        )
        registers[[c.R_HALF, c.R_PAUSE, c.R_PHASE, c.R_HEARTBEAT, c.R_MAX_SPEED]] = 2, 10**9, 1, 10**9, 10**9
        registers[[c.R_LIMITED, c.R_MAX_DUTY, c.R_STALL, c.R_SLEW]] = 1, 255, 10**9, 255
        registers[[c.R_HOMED, c.R_LOW, c.R_HIGH, c.R_FREE]] = 1, -(10**9), 10**9, -(10**12)
        return kernel(until, m, y, n, z, *rest)

    return run


@pytest.mark.parametrize("duty", [255, -255, 128])
@pytest.mark.prove
def test_free_speed_is_reached_with_the_lag(duty: int) -> None:
    made, _ = rig(settings(table={"friction": 0.0}, actuator={"backlash": 0.0}), specimen=NOTHING)
    driven(made, 0.3, duty)
    truth, size = made.truth, (abs(duty) / 255 - 0.06) / 0.94
    expected = np.sign(duty) * 0.078 * size * (1 - np.exp(-truth.time / 0.025))
    np.testing.assert_allclose(truth.speed, expected, atol=2e-4 * 0.078)


@pytest.mark.prove
def test_a_load_slows_by_the_droop_and_one_along_does_not_hasten() -> None:
    made, _ = rig(settings(table={"friction": 15.0}, actuator={"backlash": 0.0}), specimen=friction(1000.0))
    driven(made, 0.3, 255)
    assert made.truth.speed[-1] == pytest.approx(0.078 - 2e-5 * 1015.0, rel=1e-3)
    pushed = Damper("offset", {"offset.f0": -1000.0})
    made, _ = rig(settings(table={"friction": 0.0}), specimen=pushed)
    driven(made, 0.3, 255)
    assert made.truth.speed[-1] == pytest.approx(0.078, rel=1e-4)


def friction(force: float) -> Damper:
    """Friction of that force, rounded below 0.1 mm/s."""
    laws = {"c": 0.0, "ft": force, "v0": 1e-4, "s": 0.0}
    return Damper("hyperbolic_tangent", {f"hyperbolic_tangent.{name}": value for name, value in laws.items()})


def test_a_load_beyond_the_motor_stalls_it_and_the_screw_holds() -> None:
    made, _ = rig(settings(table={"friction": 0.0}), specimen=Damper("spring", {"spring.k0": 4e5}))
    driven(made, 1.0, 255)
    assert made.truth.force[-1] == pytest.approx(0.078 / 2e-5, rel=3e-3)  # the firmware sees it stand
    made._kernel = held_at(rig(specimen=Damper("spring", {"spring.k0": 4e5}))[0]._kernel, 0)
    made.run_unattended(0.5)
    assert np.ptp(made.truth.position[-400:]) == 0.0


@pytest.mark.parametrize("duty", [255, -255])
def test_the_stroke_ends(duty: int) -> None:
    made, _ = rig(settings(specimen={"stroke": 1.0}), specimen=NOTHING)
    driven(made, 4.0, duty)
    assert abs(made.truth.position[-1]) == pytest.approx(0.2285, abs=1.1e-5)
    assert made.truth.speed[-1] == 0.0


def test_the_shorted_motor_stops_within_40_ms_from_full_speed() -> None:
    made, _ = rig(specimen=NOTHING)
    plain = made._kernel
    driven(made, 0.3, 255)
    made._kernel = plain
    made.twin.registers[:] = 0
    made.run_unattended(0.1)
    assert 0.02 < made.at_rest_since - 0.3 < 0.04


def test_backlash_is_a_play_operator() -> None:
    made, host = rig(settings(actuator={"backlash": 2e-4}), specimen=NOTHING)
    host.arm()
    screws, tables = [], []
    host.done(Request.REVERSE, 120, 400, 0, 4)
    for _ in range(40):
        assert host.beat.state != State.FAULT
        screws.append(made.plant[plant.Y_SCREW])
        tables.append(made.plant[plant.Y_X])
    screw, table = np.array(screws), np.array(tables)
    assert np.all(np.abs(screw - table) <= 1e-4 + 1e-12)
    out, back = np.diff(screw) > 1.2e-4, np.diff(screw) < -1.2e-4
    np.testing.assert_allclose((screw - table)[1:][out], 1e-4, atol=1e-9)
    np.testing.assert_allclose((screw - table)[1:][back], -1e-4, atol=1e-9)


@pytest.mark.parametrize("inductance", [0.044, 0.0])
def test_a_step_of_voltage_at_the_coil(inductance: float) -> None:
    made, host = rig(settings(supply={"inductance": inductance, "gain": 0.5}))
    host.arm()
    start = made.time
    made.write(2.0)
    host.wait()
    host.wait()
    truth = made.truth
    t = truth.time - start
    after = t > 0
    lag = inductance / 4.4
    expected = 1.0 / 4.4 * (1 - np.exp(-t[after] / lag)) if lag else np.full(after.sum(), 1.0 / 4.4)
    np.testing.assert_allclose(truth.current[after], expected, rtol=2e-4)
    assert np.all(truth.voltage[after] == pytest.approx(1.0, abs=2e-4))


def test_the_enable_line_cuts_the_coil_and_without_it_a_dead_host_leaves_it_live() -> None:
    for line in (True, False):
        made, host = rig(settings(supply={"enable_line": line}))
        host.arm()
        made.write(2.0)
        host.wait()
        made.run_unattended(1.0)
        assert made.twin.state == State.FAULT
        assert np.isnan(made.coil_dead_since) == (not line)


def test_the_force_passes_the_load_cells_filter_as_one_pole() -> None:
    made, _ = rig(settings(load_cell={"bandwidth": 20.0, "noise": 0.0, "wander": 0.0}), specimen=NOTHING)
    made.plant[plant.Y_CELL] = 500.0
    made.start(1000.0)
    volts, _ = made.read(100)
    t = np.arange(1, 101) / 1000.0
    np.testing.assert_allclose(volts[0] * 613.0, 500.0 * np.exp(-2 * np.pi * 20.0 * t), atol=0.1)


def test_work_is_heat_or_stored_or_cooled_away() -> None:
    made, host = rig(settings(specimen={"heat_capacity": 20.0, "cooling": 0.5}))
    host.arm()
    made.write(0.8712)
    follow(made, host, sine(0.01, 0.8, 8, 0.01))
    y, truth = made.plant, made.truth
    speed_force = np.concatenate(([0.0], truth.force[1:] * np.diff(truth.position)))
    assert y[plant.Y_TAKEN] == pytest.approx(speed_force.sum(), rel=2e-3)
    assert y[plant.Y_WORK] == pytest.approx(y[plant.Y_TAKEN] + y[plant.Y_RUBBED], rel=1e-9)
    assert y[plant.Y_RUBBED] == pytest.approx(15.0 * np.abs(np.diff(truth.position)).sum(), rel=1e-3)
    electric = np.trapezoid(truth.current**2 * 4.4 * (1 + 0.0039 * (truth.temperature - 20)), truth.time)
    assert y[plant.Y_HEATED] == pytest.approx(electric, rel=2e-3)
    static = 131.0 * (truth.position[-1] - truth.position[0])
    warmed = 20.0 * (y[plant.Y_TEMPERATURE] - 20.0)
    assert warmed == pytest.approx(y[plant.Y_TAKEN] - static + y[plant.Y_HEATED] - y[plant.Y_COOLED], rel=1e-3)
    assert warmed > 5.0


def test_it_cools_to_the_room_with_its_time_constant() -> None:
    made, _ = rig(settings(specimen={"heat_capacity": 10.0, "cooling": 2.0}), "hot-specimen=40@0s")
    made.run_unattended(5.0)
    assert made.truth.temperature[-1] == pytest.approx(20.0 + 40.0 * np.exp(-1.0), rel=1e-3)


def test_a_hot_specimen_gives_less_force_and_takes_less_current() -> None:
    forces, currents = [], []
    for heat in ("hot-specimen=0@0s", "hot-specimen=50@0s"):
        made, host = rig(settings(specimen={"softening": 0.004, "cooling": 0.0}), heat)
        host.arm()
        made.write(3.0)
        follow(made, host, sine(0.005, 1.0, 4, 0.01))
        forces.append(np.ptp(made.truth.force))
        currents.append(made.truth.current[-1])
    assert currents[1] / currents[0] == pytest.approx(1 / (1 + 0.0039 * 50), rel=1e-3)
    assert 0.6 < forces[1] / forces[0] < 1 - 0.004 * 50 + 1e-3


@pytest.mark.parametrize(
    ("parts", "laws"),
    [
        ("dahl + offset", {"dahl.kx": 2000.0, "dahl.kw": 600.0, "dahl.rho": 2e5, "offset.f0": 100.0}),
        ("bouc_wen", {"bouc_wen.c0": 1500.0, "bouc_wen.k0": 300.0, "bouc_wen.kw": 500.0, "bouc_wen.rho": 4e4,
                      "bouc_wen.sigma": 0.9, "bouc_wen.n": 1.7}),
        ("dahl + compliance", {"dahl.kx": 1000.0, "dahl.kw": 400.0, "dahl.rho": 3e3, "compliance.s": 1e-6}),
        ("dahl + inertia + delay", {"dahl.kx": 1000.0, "dahl.kw": 400.0, "dahl.rho": 3e4, "inertia.m": 2.0,
                                    "delay.tau": 0.004}),
    ],
)  # fmt: skip
@pytest.mark.prove
def test_it_converges_with_its_step_for_stiff_specimens(parts: str, laws: dict[str, float]) -> None:
    results = []
    for step in (2e-4, 1e-4, 1.25e-5):
        made, host = rig(settings(load_cell={"noise": 0.0}), specimen=Damper(parts, laws), step=step)
        host.arm()
        follow(made, host, sine(0.006, 1.0, 4, 0.01))
        results.append((made.truth.position, made.plant[plant.Y_WORK]))
    stroke = np.ptp(results[2][0])
    errors = [np.abs(x - results[2][0]).max() / stroke for x, _ in results]
    assert errors[1] < 4e-3
    assert errors[1] < 0.8 * errors[0] + 2e-4
    assert results[1][1] == pytest.approx(results[2][1], rel=0.01)


@pytest.mark.prove
def test_free_play_leaves_the_piston_behind() -> None:
    made, host = rig(settings(specimen={"free_play": 2e-3}))
    host.arm()
    made.write(1.98)
    follow(made, host, sine(0.006, 0.8, 5, 0.01))
    tight, other = rig()
    other.arm()
    tight.write(1.98)
    follow(tight, other, sine(0.006, 0.8, 5, 0.01))
    assert made.plant[plant.Y_TAKEN] < 0.95 * tight.plant[plant.Y_TAKEN]


def test_a_sine_of_10_mm_at_1_hz_is_followed_within_a_third_of_a_millimetre() -> None:
    made, host = rig()
    host.arm()
    made.write(0.8712)
    points = sine(0.010, 1.0, 12, 0.01)
    follow(made, host, points)
    truth, start = made.truth, host.began
    wanted = np.interp(truth.time - start, np.arange(points.size) * 0.01, points * 5e-6)
    steady = (truth.time - start > 2) & (truth.time - start < 10)
    assert np.abs(truth.position - wanted)[steady].max() < 0.35e-3
    assert made.twin.state == State.ARMED


@pytest.mark.parametrize("duty", [255, -255, 128])
def test_the_motors_current_is_that_of_its_load_and_of_its_start(duty: int) -> None:
    """At rest all of the speed that the duty asks for pushes, (v0 d/r) k; without load only Table A.2's 2.4 A are left."""
    made, _ = rig(settings(table={"friction": 0.0}, actuator={"backlash": 0.0}), specimen=NOTHING)
    size, per_newton = (abs(duty) / 255 - 0.06) / 0.94, (13.2 - 2.4) / 4500.0
    driven(made, 1e-3, duty)
    began = 2.4 + per_newton * 0.078 * size * np.exp(-9e-4 / 0.025) / 2e-5
    assert made.plant[plant.Y_BRIDGE] == pytest.approx(began, rel=2e-3)
    driven(made, 0.3, duty)
    assert made.plant[plant.Y_BRIDGE] == pytest.approx(2.4, abs=0.01)
