"""Rides over several roads: those of single calls, and what is told of them."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.errors import InputError
from dampyr.structures import control_law, quarter_car, random_road, respond, ride_figures, rides, road
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
