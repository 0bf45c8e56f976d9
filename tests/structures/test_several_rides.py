"""Rides over several roads: those of single calls, and what is told of them."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.errors import InputError
from dampyr.structures import (
    axle_roads,
    control_law,
    half_car,
    quarter_car,
    random_road,
    respond,
    ride_figures,
    rides,
    road,
)
from dampyr.studies import raminelli_2020

CAR = quarter_car(290.0, 45.0, suspension=18e3, tyre=190e3, damping=300.0)


def test_each_ride_is_that_of_a_single_call() -> None:
    damper, law = raminelli_2020.damper(), control_law("on_off", high=1.0)
    found = rides(CAR, damper, [0.0, law], road_class="B", speed=30.0, length=60.0, seeds=2)
    assert list(found) == ["0 V", "on_off 0 to 1 V"]
    motion = road(random_road("B", 60.0, 0.0375, seed=2), 0.0375, 30.0)
    alone = ride_figures(respond(CAR, motion, {("unsprung", "sprung"): damper}, voltage=law), CAR, start=10.0 / 30.0)
    assert found["on_off 0 to 1 V"][1].weighted_acceleration == pytest.approx(alone.weighted_acceleration, rel=1e-12)
    mean, scatter = found.mean("0 V", "travel")
    travels = [one.travel for one in found["0 V"]]
    assert (mean, scatter) == pytest.approx((np.mean(travels), np.ptp(travels) / np.sqrt(2)))
    assert np.isnan(rides(CAR, damper, 0.0, length=60.0, seeds=1).mean("0 V", "travel")[1])


def test_what_a_ride_finds_has_its_input() -> None:
    found = rides(CAR, raminelli_2020.damper(), [0.0], road_class="F", length=60.0, seeds=2)
    [leaves] = [finding for finding in found.findings if "a real one leaves it" in finding.words]
    assert leaves.source == "0 V"


def test_on_the_command_line() -> None:
    words = [
        "ride",
        "--voltage",
        "0",
        "--seeds",
        "1",
        "--length",
        "60",
        "--speed",
        "72 km/h",
        "--sprung",
        "300kg",
        "--json",
    ]
    done = CliRunner().invoke(cli, words)
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["speed"] == pytest.approx(20.0)
    assert told["rides"]["0 V"][0]["static_load"] == pytest.approx(345.0 * 9.80665)
    refused = CliRunner().invoke(cli, ["ride", "--voltage", "0", "--tyre", "soft"])
    assert refused.exit_code == 2
    assert "--tyre: 'soft' is not a quantity" in refused.stderr


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"speed": 0.0}, "speed = 0.0 m/s is not allowed"),
        ({"seeds": 0}, "seeds = 0 is not allowed"),
        ({"road_class": "J"}, "'J' is not a class of ISO 8608"),
        ({"current": 1.0}, "both voltage= and current="),
    ],
)
def test_what_is_wrong_is_said(change: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        rides(CAR, raminelli_2020.damper(), 0.0, **change)


def test_a_half_car_rides_with_dampers_at_both_axles() -> None:
    half, damper = half_car(580.0, 900.0, 1.2, 1.3, 45.0, (18e3, 20e3), 190e3, 300.0), raminelli_2020.damper()
    found = rides(half, damper, [0.0, 1.0], length=60.0, seeds=1, position=1.5)
    places = [("front wheel", "front body"), ("rear wheel", "rear body")]
    roads = axle_roads(random_road("C", 60.0, 0.05, seed=1), 0.05, 20.0, 2.5)
    alone = respond(half, roads, dict.fromkeys(places, damper), voltage=1.0)
    figures = ride_figures(alone, half, start=12.5 / 20.0, position=1.5)
    assert list(found) == ["0 V", "1 V"]
    assert found["1 V"][0].weighted_acceleration == pytest.approx(figures.weighted_acceleration, rel=1e-12)
    assert found["1 V"][0].axles["rear"] == figures.axles["rear"]
    assert found.position == 1.5
    pair = rides(half, [damper, damper], [1.0], length=60.0, seeds=1, position=1.5)
    assert pair["1 V"][0].axles == figures.axles
    assert rides(half, damper, [1.0], length=60.0, seeds=1).position == pytest.approx(1.2)


def test_wrong_numbers_of_dampers_are_refused() -> None:
    half, damper = half_car(580.0, 900.0, 1.2, 1.3, 45.0, 18e3, 190e3), raminelli_2020.damper()
    with pytest.raises(InputError, match="3 dampers are given; give one for both axles, or two"):
        rides(half, [damper] * 3, [0.0])
    with pytest.raises(InputError, match="2 dampers are given, and quarter car has one axle"):
        rides(CAR, [damper] * 2, [0.0])


def test_a_half_car_on_the_command_line() -> None:
    words = (
        "ride --voltage 0 --seeds 1 --length 60 --wheelbase 2.6 --centre 1.2 --seat 1.7 --suspension 18000,20000 --json"
    )
    done = CliRunner().invoke(cli, words.split())
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert (told["car"], told["position"]) == ("half car", 1.7)
    [ride] = told["rides"]["0 V"]
    body = 580.0 * np.array([1.4, 1.2]) / 2.6 + 45.0
    assert [ride["axles"][axle]["static_load"] for axle in ("front", "rear")] == pytest.approx(list(9.80665 * body))
    half = half_car(580.0, 580.0 * 1.2 * 1.4, 1.2, 1.4, 45.0, (18e3, 20e3), 190e3, 300.0)
    same = rides(half, raminelli_2020.damper(), [0.0], length=60.0, seeds=1, position=1.7)
    assert ride["weighted_acceleration"] == pytest.approx(same["0 V"][0].weighted_acceleration)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--seat 1.0", "--seat is of a half car; give --wheelbase, too"),
        ("--suspension 1,2", "--suspension 1,2: give one number, as a quarter car has one axle; --wheelbase makes two"),
        ("--wheelbase 2.6 --centre 3", "--centre 3 is not allowed; it must be between the axles, 0 to 2.6 m"),
        ("--wheelbase 2.6 --sprung 300,310", "--sprung is a quarter of the body, one number"),
        ("--wheelbase 2.6 --tyre 1,2,3", "--tyre 1,2,3: give one number, or front and rear as in 18000,22000"),
        ("--wheelbase soft", "--wheelbase: 'soft' is not a quantity"),
    ],
)
def test_wrong_half_cars_on_the_command_line(words: str, message: str) -> None:
    refused = CliRunner().invoke(cli, ["ride", "--voltage", "0", *words.split()])
    assert refused.exit_code == 2
    assert message in refused.stderr
