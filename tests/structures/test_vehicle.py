import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from dampyr.errors import InputError
from dampyr.models import Constant, Damper, Polynomial
from dampyr.structures import axle_roads, control_law, half_car, quarter_car, random_road, respond, road

SPRUNG, UNSPRUNG, SUSPENSION, TYRE, DAMPING, TYRE_DAMPING = 290.0, 45.0, 18e3, 190e3, 1700.0, 150.0
DT = 0.004


def transmissibility(omega: float) -> np.ndarray:
    """Absolute motion of wheel and body over a road of unit amplitude, from the equations of the two masses."""
    spring, tyre = SUSPENSION + 1j * omega * DAMPING, TYRE + 1j * omega * TYRE_DAMPING
    wheel = [-(omega**2) * UNSPRUNG + spring + tyre, -spring]
    body = [-spring, -(omega**2) * SPRUNG + spring]
    return np.linalg.solve(np.array([wheel, body]), np.array([tyre, 0.0]))


def waves(frequency: float) -> tuple[np.ndarray, np.ndarray]:
    """Time and height of a road that begins level: Y (1 - cos)."""
    t = DT * np.arange(round(8.0 / DT) + 1)
    return t, 0.01 * (1.0 - np.cos(2 * np.pi * frequency * t))


@pytest.mark.parametrize("frequency", [0.8, 1.4, 3.0, 11.0])
@pytest.mark.parametrize("as_damper", [False, True])
def test_steady_state_is_the_transmissibility(frequency, as_damper):
    omega, (t, y) = 2 * np.pi * frequency, waves(frequency)
    dashpot = Damper("dahl", {"dahl.kx": DAMPING, "dahl.kw": 1e-9, "dahl.rho": 1000.0})
    car = quarter_car(SPRUNG, UNSPRUNG, SUSPENSION, TYRE, 0.0 if as_damper else DAMPING, TYRE_DAMPING)
    dampers = {("unsprung", "sprung"): dashpot} if as_damper else None
    response = respond(car, road(y, 0.1, 0.1 / DT), dampers, voltage=0.0 if as_damper else None)
    late = slice(len(t) - 600, len(t) - 20)  # the end of the spline is bent by its end condition
    for k, h in enumerate(transmissibility(omega)):
        expected = 0.01 * (1.0 - (h * np.exp(1j * omega * t)).real)
        assert (response.displacement[k] + y)[late] == pytest.approx(expected[late], abs=3e-4 * 0.01 * abs(h))
        acceleration = 0.01 * omega**2 * (h * np.exp(1j * omega * t)).real
        size = 0.01 * omega**2 * abs(h)
        assert response.acceleration[k][late] == pytest.approx(acceleration[late], abs=2e-3 * size)


def test_the_force_on_the_road_is_the_base_shear():
    _, y = waves(2.0)
    car = quarter_car(SPRUNG, UNSPRUNG, SUSPENSION, TYRE, DAMPING, TYRE_DAMPING)
    response = respond(car, road(y, 0.2, 0.2 / DT))
    pushed = TYRE * response.displacement[0] + TYRE_DAMPING * response.velocity[0]
    assert response.base_shear == pytest.approx(pushed, abs=1e-6 * np.abs(pushed).max())


def test_a_road_integrates_back_to_its_heights():
    """Twice integrated, exactly for an acceleration that is linear between samples."""
    rng = np.random.default_rng(3)
    heights = np.cumsum(rng.normal(0.0, 0.004, 60))
    motion = road(heights, 0.25, 12.5)
    assert motion.dt == pytest.approx(0.02)
    a, v, y = np.asarray(motion.acceleration), 0.0, heights[0]
    for k in range(len(a) - 1):
        y += v * motion.dt + motion.dt**2 * (a[k] / 3.0 + a[k + 1] / 6.0)
        v += motion.dt * (a[k] + a[k + 1]) / 2.0
        assert y == pytest.approx(heights[k + 1], abs=1e-12)


def test_golden_car_has_the_frequencies_of_its_ratios():
    car = quarter_car(1.0, 0.15, 63.3, 653.0, 6.0)
    square = np.roots([0.15, -(653.0 + 1.15 * 63.3), 653.0 * 63.3])[::-1]
    assert car.floors == ("unsprung", "sprung")
    assert car.frequencies == pytest.approx(np.sqrt(square) / (2 * np.pi), rel=1e-9)
    assert car.frequencies == pytest.approx([1.208, 11.005], abs=1e-3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: quarter_car(0.0, 45.0, 18e3, 190e3), r"sprung = 0.0 .* greater than 0"),
        (lambda: quarter_car(290.0, 45.0, 18e3, 190e3, damping=-1.0), r"damping = -1.0 .* at least 0"),
        (lambda: road([0.0, 0.1], 0.1, 10.0), r"height has shape \(2,\)"),
        (lambda: road([0.0, 0.1, 0.0], 0.1, 0.0), r"speed = 0.0 .* greater than 0"),
    ],
)
def test_wrong_cars_and_roads_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_numbers_may_be_texts_with_units() -> None:
    car = quarter_car("0.4 t", 60.0, suspension="25 N/mm", tyre="260 kN/m", damping="1.5 kN s/m")
    numbers = quarter_car(400.0, 60.0, suspension=25e3, tyre=260e3, damping=1500.0)
    assert np.array_equal(car.M, numbers.M)
    assert np.array_equal(car.K, numbers.K)
    assert np.array_equal(car.C, numbers.C)
    bump = road(["0 mm", "10 mm", "0 mm"], "0.1 m", "36 km/h")
    assert np.array_equal(bump.acceleration, road([0.0, 0.01, 0.0], 0.1, 10.0).acceleration)
    with pytest.raises(InputError, match="tyre: the unit 'kg' does not measure what 'N/m' measures"):
        quarter_car(400.0, 60.0, suspension=25e3, tyre="5 kg")


BODY, INERTIA, FRONT, REAR = 580.0, 900.0, 1.2, 1.4
HALF = {
    "unsprung": (45.0, 40.0), "suspension": (18e3, 20e3), "tyre": (190e3, 200e3), "damping": (1500.0, 1300.0),
    "tyre_damping": (100.0, 150.0),
}  # fmt: skip


def by_heave_and_pitch(omega: float, speed: float) -> np.ndarray:
    """Heave, pitch and both wheels over a road exp(i omega t) under the front axle, by the textbooks' four equations."""
    (uf, ur), (kf, kr), (tf, tr), (cf, cr), (df, dr) = HALF.values()
    sf, sr, rf, rr = kf + 1j * omega * cf, kr + 1j * omega * cr, tf + 1j * omega * df, tr + 1j * omega * dr
    front, rear = np.array([1.0, FRONT, -1.0, 0.0]), np.array([1.0, -REAR, 0.0, -1.0])  # travels of (z, theta, uf, ur)
    dynamic = sf * np.outer(front, front) + sr * np.outer(rear, rear) + np.diag([0.0, 0.0, rf, rr])
    dynamic = dynamic - omega**2 * np.diag([BODY, INERTIA, uf, ur])
    return np.linalg.solve(dynamic, [0.0, 0.0, rf, rr * np.exp(-1j * omega * (FRONT + REAR) / speed)])


@pytest.mark.parametrize("frequency", [1.1, 1.7, 10.5])
@pytest.mark.parametrize("as_damper", [False, pytest.param(True, marks=pytest.mark.prove)])
def test_a_half_car_is_its_transfer_functions(frequency: float, as_damper: bool) -> None:
    omega, (t, y) = 2 * np.pi * frequency, waves(frequency)
    speed = (FRONT + REAR) / (65 * DT)
    values = HALF | ({"damping": 0.0} if as_damper else {})
    car = half_car(BODY, INERTIA, FRONT, REAR, **values)
    roads = axle_roads(y, speed * DT, speed, car.wheelbase)
    dampers = {
        (f"{axle} wheel", f"{axle} body"): Damper("dahl", {"dahl.kx": c, "dahl.kw": 1e-9, "dahl.rho": 1000.0})
        for axle, c in zip(("front", "rear"), HALF["damping"], strict=True)
    }
    response = respond(car, roads, dampers if as_damper else None, voltage=0.0 if as_damper else None)
    steady = 0.01 * omega**2 * by_heave_and_pitch(omega, speed)[:, None] * np.exp(1j * omega * t)
    late = slice(len(t) - 600, len(t) - 20)
    body = response.acceleration
    for ours, theirs in (
        (car.body_at(car.centre) @ body, steady[0]),
        (car.pitch @ body, steady[1]),
        (body[0], steady[2]),
        (body[2], steady[3]),
        (car.body_at(car.centre + REAR) @ body, steady[0] - REAR * steady[1]),
    ):
        assert ours[late] == pytest.approx(theirs.real[late], abs=3e-3 * np.abs(theirs).max())


def test_a_half_car_on_a_random_road_is_an_independent_integration() -> None:
    car = half_car(BODY, INERTIA, FRONT, REAR, **HALF)
    heights = random_road("C", 20.0, 0.05, seed=2, lead=2.0)
    roads = axle_roads(heights, 0.05, 20.0, car.wheelbase)
    response = respond(car, roads)
    t, behind = response.time, np.r_[np.full(52, heights[0]), heights][: len(heights)]
    yf, yr = (CubicSpline(t, y, bc_type=((1, 0.0), (2, 0.0))) for y in (heights, behind))
    (uf, ur), (kf, kr), (tf, tr), (cf, cr), (df, dr) = HALF.values()

    def slope(now: float, s: np.ndarray) -> np.ndarray:
        z, theta, xf, xr, dz, dtheta, vf, vr = s
        front = kf * (z + FRONT * theta - xf) + cf * (dz + FRONT * dtheta - vf)
        rear = kr * (z - REAR * theta - xr) + cr * (dz - REAR * dtheta - vr)
        on_front, on_rear = tf * (xf - yf(now)) + df * (vf - yf(now, 1)), tr * (xr - yr(now)) + dr * (vr - yr(now, 1))
        return np.array(
            [dz, dtheta, vf, vr, -(front + rear) / BODY, (REAR * rear - FRONT * front) / INERTIA,
             (front - on_front) / uf, (rear - on_rear) / ur]
        )  # fmt: skip

    start = np.r_[heights[0], 0.0, heights[0], heights[0], np.zeros(4)]
    done = solve_ivp(slope, (0.0, t[-1]), start, t_eval=t, rtol=1e-8, atol=1e-12, max_step=roads.dt)
    z, theta, xf, xr, *rates = done.y
    theirs = np.array([xf - yf(t), z + FRONT * theta - yf(t), xr - yr(t), z - REAR * theta - yr(t)])
    assert response.displacement == pytest.approx(theirs, abs=1e-6 * np.abs(theirs).max())
    drift = np.array([xf - yf(t), z + FRONT * theta - xf, xr - yr(t), z - REAR * theta - xr])
    assert response.drift == pytest.approx(drift, abs=1e-6 * np.abs(drift).max())
    loads = np.array([tf * drift[0] + df * (rates[2] - yf(t, 1)), tr * drift[2] + dr * (rates[3] - yr(t, 1))])
    assert car.tyre_loads(response.displacement, response.velocity) == pytest.approx(
        loads, abs=1e-6 * np.abs(loads).max()
    )
    assert response.base_shear == pytest.approx(loads.sum(axis=0), abs=1e-6 * np.abs(loads).max())


def test_a_half_car_whose_axles_are_kept_apart_is_two_quarter_cars() -> None:
    """J = m l_f l_r: neither axle feels the other's road."""
    half = half_car(500.0, 500.0 * 1.1 * 1.5, 1.1, 1.5, (45.0, 40.0), (18e3, 20e3), 190e3, 300.0)
    assert half.M[1, 3] == pytest.approx(0.0, abs=1e-12)
    assert "body 500, wheels 45 and 40 kg" in repr(half)
    assert "2.6 m apart, 3270 and 2467 N on them; centre of mass 1.1 m behind" in repr(half)
    assert half.static_loads == pytest.approx(9.80665 * np.array([500 * 1.5 / 2.6 + 45.0, 500 * 1.1 / 2.6 + 40.0]))
    heights = random_road("C", 20.0, 0.05, seed=4, lead=2.0)
    roads = axle_roads(heights, 0.05, 20.0, half.wheelbase)
    damper = Damper("dahl", {"dahl.kx": 500.0, "dahl.kw": 200.0, "dahl.rho": 1000.0})
    dampers = {(f"{axle} wheel", f"{axle} body"): damper for axle in ("front", "rear")}
    both = respond(half, roads, dampers, voltage=0.0, accuracy=1e-6)
    assert both.sites == ("storey 2", "storey 4")
    for k, (axle, sprung, unsprung, spring) in enumerate(
        (("front", 500 * 1.5 / 2.6, 45.0, 18e3), ("rear", 500 * 1.1 / 2.6, 40.0, 20e3))
    ):
        car = quarter_car(sprung, unsprung, spring, 190e3, 300.0)
        alone = respond(car, roads.motions[axle], {2: damper}, voltage=0.0, accuracy=1e-6)
        rows = slice(2 * k, 2 * k + 2)
        for name in ("displacement", "acceleration", "drift"):
            theirs = getattr(alone, name)
            assert getattr(both, name)[rows] == pytest.approx(theirs, abs=1e-5 * np.abs(theirs).max()), name


def test_skyhook_at_both_axles_is_that_of_each() -> None:
    """The absolute velocities that laws measure are those of the axle's own road."""
    half = half_car(500.0, 500.0 * 1.3 * 1.3, 1.3, 1.3, 45.0, 18e3, 190e3, 300.0)
    roads = axle_roads(random_road("C", 20.0, 0.05, seed=4, lead=2.0), 0.05, 20.0, half.wheelbase)
    laws = {"dahl.kx": Polynomial((300.0, 700.0), 0.0, 3.0), "dahl.kw": Constant(10.0), "dahl.rho": Constant(1e3)}
    damper, law = Damper("dahl", laws), control_law("skyhook", high=2.0)
    places = [(f"{axle} wheel", f"{axle} body") for axle in ("front", "rear")]
    both = respond(half, roads, dict.fromkeys(places, damper), voltage=law, step=0.0005)
    car = quarter_car(250.0, 45.0, 18e3, 190e3, 300.0)
    for k, axle in enumerate(("front", "rear")):
        alone = respond(car, roads.motions[axle], {2: damper}, voltage=law, step=0.0005)
        moving = slice(60, None)  # before, the rear axle stands still but for rounding, which decides its input
        assert 0.1 < np.mean(alone.input[0, moving]) < 1.9
        assert both.input[k, moving] == pytest.approx(alone.input[0, moving], abs=1e-6)
        assert both.drift[2 * k + 1] == pytest.approx(alone.drift[1], abs=1e-9)


def test_the_rear_axle_comes_a_wheelbase_later() -> None:
    heights = np.r_[np.zeros(20), 0.05 * np.hanning(41), np.zeros(60)]
    roads = axle_roads(heights, 0.1, 10.0, 2.6)
    front, rear = (roads.motions[axle].displacement for axle in ("front", "rear"))
    assert rear[26:] == pytest.approx(front[:-26], abs=1e-9)
    between = axle_roads(heights, 0.1, 10.0, 2.65).motions["rear"].displacement
    fine = CubicSpline(0.1 * np.arange(len(heights)), heights)
    assert between[30:] == pytest.approx(fine(0.1 * np.arange(30, len(heights)) - 2.65), abs=1e-5)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: half_car(0.0, 900.0, 1.2, 1.4, 45.0, 18e3, 190e3), r"body = 0.0 .* greater than 0"),
        (lambda: half_car(580.0, 900.0, 1.2, -1.0, 45.0, 18e3, 190e3), r"rear = -1.0 .* greater than 0"),
        (
            lambda: half_car(580.0, 900.0, 1.2, 1.4, 45.0, (18e3, 0.0), 190e3),
            r"suspension = .* front and rear, finite and greater",
        ),
        (
            lambda: half_car(580.0, 900.0, 1.2, 1.4, (1.0, 2.0, 3.0), 18e3, 190e3),
            "unsprung = .* a number, or front and rear",
        ),
        (lambda: half_car(580.0, 900.0, 1.2, 1.4, 45.0, 18e3, 190e3, -1.0), "damping = -1.0 .* at least 0"),
        (lambda: axle_roads(np.zeros(9), 0.1, 10.0, 0.0), "wheelbase = 0.0 is not allowed"),
    ],
)
def test_wrong_half_cars_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
