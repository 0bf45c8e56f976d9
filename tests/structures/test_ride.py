"""Figures of a ride: the weighting against the standard's table, rides against the transfer functions of the two masses."""

import numpy as np
import pytest
from scipy.signal import bilinear_zpk, sosfilt, tf2zpk, zpk2sos

from dampyr.errors import InputError
from dampyr.structures import (
    axle_roads,
    half_car,
    quarter_car,
    random_road,
    respond,
    ride_figures,
    road,
    single_mass,
    vertical_weighting,
    weighted_acceleration,
)

PRINTED = {  # W_k of ISO 2631-1, thousandths by third octaves, as papers print the standard's table
    0.5: 418, 0.8: 477, 1: 482, 1.25: 484, 1.6: 494, 2: 531, 2.5: 631, 3.15: 804, 4: 967, 5: 1039, 6.3: 1054, 8: 1036,
    10: 988, 12.5: 902, 16: 768, 20: 636, 25: 513, 31.5: 405, 40: 314, 50: 246, 63: 186, 80: 132,
}  # fmt: skip
SPRUNG, UNSPRUNG, SUSPENSION, TYRE, DAMPING = 320.0, 40.0, 22e3, 190e3, 1500.0


def test_the_weighting_is_the_table_of_the_standard():
    exact = 10.0 ** (np.round(10.0 * np.log10(list(PRINTED))) / 10.0)  # nominal frequencies are rounded
    assert 1e3 * vertical_weighting(exact) == pytest.approx(list(PRINTED.values()), rel=0.015)


def test_the_weighted_history_is_that_of_a_filter_in_time():
    """A cascade of digital filters by the bilinear transform, written apart."""
    dt, tau = 0.0005, 2 * np.pi
    stages = [
        ([1, 0, 0], [1, tau * 0.4 * np.sqrt(2), (tau * 0.4) ** 2]),
        ([(tau * 100) ** 2], [1, tau * 100 * np.sqrt(2), (tau * 100) ** 2]),
        (np.array([1, tau * 12.5]) * tau * 12.5, [1, tau * 12.5 / 0.63, (tau * 12.5) ** 2]),
        ([1, tau * 2.37 / 0.91, (tau * 2.37) ** 2], [1, tau * 3.35 / 0.91, (tau * 3.35) ** 2]),
    ]
    t = dt * np.arange(8000)
    felt = given = np.sin(tau * 1.3 * t) + 0.5 * np.sin(tau * 9.0 * t) * (t > 1.0)
    for b, a in stages:
        felt = sosfilt(zpk2sos(*bilinear_zpk(*tf2zpk(b, a), 1.0 / dt)), felt)
    assert weighted_acceleration(given, dt) == pytest.approx(felt, abs=0.01)


def test_a_ride_on_a_random_road_is_that_of_the_two_masses_by_frequency():
    """rms of acceleration, travel and tyre load from the road's spectrum and the masses' transfer functions."""
    spacing, speed, length = 0.05, 20.0, 400.0
    car = quarter_car(SPRUNG, UNSPRUNG, SUSPENSION, TYRE, DAMPING)
    # twice the same period of the road: the second is steady
    once = random_road("C", length, spacing, seed=5, lead=0.0)
    heights = np.r_[random_road("C", length, spacing, seed=5), once[1:]]
    response = respond(car, road(heights, spacing, speed))
    figures = ride_figures(response, car, start=(10.0 + length) / speed)
    n = np.arange(1, round(length * 2.83)) / length
    n = n[n >= 0.011]
    variance = 256e-6 * (n / 0.1) ** -2.0 / length
    s = 2j * np.pi * n * speed
    spring = SUSPENSION + DAMPING * s
    wheel = TYRE / (UNSPRUNG * s**2 + TYRE + spring - spring**2 / (SPRUNG * s**2 + spring))
    body = wheel * spring / (SPRUNG * s**2 + spring)

    def rms(transfer):
        return np.sqrt(np.sum(np.abs(transfer) ** 2 * variance))

    assert figures.acceleration == pytest.approx(rms(s**2 * body), rel=0.01)
    assert figures.weighted_acceleration == pytest.approx(rms(s**2 * body * vertical_weighting(n * speed)), rel=0.01)
    assert figures.travel == pytest.approx(rms(body - wheel), rel=0.01)
    assert figures.tyre_load == pytest.approx(rms(TYRE * (wheel - 1.0)), rel=0.01)
    assert figures.static_load == pytest.approx(360.0 * 9.80665)
    assert figures.off_road == 0.0
    assert figures.findings == ()
    assert figures.transient >= figures.weighted_acceleration
    assert figures.peak_travel > 2.0 * figures.travel


def test_a_wheel_that_leaves_the_road_is_told():
    car = quarter_car(SPRUNG, UNSPRUNG, SUSPENSION, TYRE, DAMPING)
    motion = road(random_road("G", 200.0, seed=1), 0.05, 25.0)
    figures = ride_figures(respond(car, motion), car, start=0.4)
    assert 0.0 < figures.off_road < 0.5
    assert figures.peak_tyre_load > figures.static_load
    assert any("pull at the road" in finding.words for finding in figures.findings)
    assert "pull at the road" in repr(figures)
    assert figures.as_dict()["findings"][0]["severity"] == "doubt"


def test_what_is_no_ride_is_refused():
    car = quarter_car(SPRUNG, UNSPRUNG, SUSPENSION, TYRE, DAMPING)
    response = respond(car, road(random_road("A", 30.0), 0.05, 20.0))
    with pytest.raises(InputError, match=r"start = 9 s leaves nothing of a ride of 2 s"):
        ride_figures(response, car, start=9.0)
    with pytest.raises(InputError, match="give one of a quarter car"):
        ride_figures(response, single_mass(1.0, 1.0))
    with pytest.raises(InputError, match=r"dt = 0.01 s is not allowed; W_k reaches to 100 Hz"):
        weighted_acceleration(np.zeros(9), 0.01)
    with pytest.raises(InputError, match="one row of finite numbers"):
        weighted_acceleration([0.0, np.nan], 0.001)


HALF = half_car(600.0, 950.0, 1.3, 1.4, 40.0, (20e3, 22e3), 190e3, (1500.0, 1300.0))


def test_a_ride_of_a_half_car_is_that_of_its_body_and_axles() -> None:
    """Each figure from the histories, written apart; the seat by the rigid body."""
    heights = random_road("C", 60.0, 0.05, seed=3)
    response = respond(HALF, axle_roads(heights, 0.05, 20.0, HALF.wheelbase))
    figures = ride_figures(response, HALF, start=0.7, position=1.7)
    part = response.time >= 0.7 - 1e-9
    front, rear = response.acceleration[1], response.acceleration[3]
    seat = front + (rear - front) * 1.7 / 2.7
    assert figures.acceleration == pytest.approx(np.sqrt(np.mean(seat[part] ** 2)))
    felt = weighted_acceleration(seat, 0.0025)[part]
    assert figures.weighted_acceleration == pytest.approx(np.sqrt(np.mean(felt**2)))
    assert figures.pitch_acceleration == pytest.approx(np.sqrt(np.mean(((front - rear)[part] / 2.7) ** 2)))
    weights = 9.80665 * np.array([600.0 * 1.4 / 2.7 + 40.0, 600.0 * 1.3 / 2.7 + 40.0])
    for axle, k, weight in (("front", 0, weights[0]), ("rear", 2, weights[1])):
        of_axle, load = figures.axles[axle], 190e3 * response.displacement[k][part]
        travel = (response.displacement[k + 1] - response.displacement[k])[part]
        assert of_axle.tyre_load == pytest.approx(np.sqrt(np.mean(load**2)))
        assert of_axle.peak_tyre_load == pytest.approx(np.abs(load).max())
        assert of_axle.travel == pytest.approx(np.sqrt(np.mean(travel**2)))
        assert of_axle.static_load == pytest.approx(weight)
    shares = {axle: of.tyre_load / of.static_load for axle, of in figures.axles.items()}
    worst = figures.axles[max(shares, key=lambda axle: shares[axle])]
    assert (figures.tyre_load, figures.static_load) == (worst.tyre_load, worst.static_load)
    assert figures.travel == max(of.travel for of in figures.axles.values())
    assert "rear axle" in repr(figures)
    assert "rad/s² rms" in repr(figures)
    assert figures.as_dict()["axles"]["front"]["travel"] == figures.axles["front"].travel
    at_centre = ride_figures(response, HALF, start=0.7)
    assert at_centre.acceleration == pytest.approx(ride_figures(response, HALF, 0.7, 1.3).acceleration)


def test_the_axle_that_leaves_the_road_is_named() -> None:
    heights = random_road("F", 40.0, 0.05, seed=3)
    response = respond(HALF, axle_roads(heights, 0.05, 20.0, HALF.wheelbase))
    words = [finding.words for finding in ride_figures(response, HALF, start=0.7).findings]
    assert any(word.startswith("the front tyre would have to pull") for word in words)
    assert any(word.startswith("the rear tyre would have to pull") for word in words)


def test_a_position_is_of_a_half_car() -> None:
    car = quarter_car(SPRUNG, UNSPRUNG, SUSPENSION, TYRE, DAMPING)
    response = respond(car, road(random_road("C", 20.0, 0.05, seed=3), 0.05, 20.0))
    with pytest.raises(InputError, match=r"position = 1\.0 is of a half car, and quarter car is a quarter of one"):
        ride_figures(response, car, position=1.0)
    with pytest.raises(InputError, match="give one of a quarter car, unsprung and sprung, or of a half car"):
        ride_figures(response, HALF)
    whole = respond(HALF, axle_roads(random_road("C", 20.0, 0.05, seed=3), 0.05, 20.0, HALF.wheelbase))
    with pytest.raises(InputError, match="position = nan is not allowed"):
        ride_figures(whole, HALF, position=np.nan)
