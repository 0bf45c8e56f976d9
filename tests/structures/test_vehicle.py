import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.structures import quarter_car, respond, road

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
