"""What rides at several inputs show: a row for each input, means over the roads with their scatter."""

from __future__ import annotations

import math

from dampyr.findings import as_dicts
from dampyr.phrases import counted, with_reach
from dampyr.show.descriptions import Description, describe
from dampyr.show.structures.ride import figures_as_dict
from dampyr.show.table import Table
from dampyr.structures.several_rides import Rides

COLUMNS = (
    ("weighted acceleration", "weighted_acceleration", "m/s²", 1.0),
    ("greatest transient", "transient", "m/s²", 1.0),
    ("travel", "travel", "mm", 1e3),
    ("peak travel", "peak_travel", "mm", 1e3),
    ("tyre load", "tyre_load", "N", 1.0),
    ("off the road", "off_road", "%", 100.0),
)
"""Heading, figure, unit and factor."""
HALF = (
    "The acceleration is that of the body {:.3g} m behind the front axle; the travel is the larger one of both axles, and the "
    "tyre that whose load changes by the larger share of its weight."
)


@describe.register
def describe_rides(rides: Rides) -> Description:
    """The car and its roads, and the table of the figures."""
    roads = len(next(iter(rides.figures.values())))
    return Description(
        "Rides",
        [
            ("car", rides.car),
            ("roads", f"{roads} of class {rides.road_class}, {rides.length:g} m each, at {rides.speed:.4g} m/s"),
            ("inputs", str(len(rides.figures))),
        ],
        tables=[lambda: table_of(rides)],
        data=lambda: _numbers(rides),
    )


def table_of(rides: Rides) -> Table:
    """A row for each input."""
    roads = len(next(iter(rides.figures.values())))
    rows = [[name, *(_mean(rides, name, figure, factor) for _, figure, _, factor in COLUMNS)] for name in rides]
    return Table(
        ("input", *(heading for heading, *_ in COLUMNS)),
        rows,
        ("", *(unit for *_, unit, _ in COLUMNS)),
        align=("left", *("right" for _ in COLUMNS)),
        caption=f"{rides.car} on {counted(roads, 'road')} of class {rides.road_class} at {rides.speed:.4g} m/s.",
        notes=(
            "Means over the roads ± their standard deviation; root mean squares unless they are called peaks.",
            *([HALF.format(rides.position)] if rides.position is not None else []),
        ),
    )


def _mean(rides: Rides, name: str, figure: str, factor: float) -> str:
    mean, scatter = (factor * value for value in rides.mean(name, figure))
    return f"{mean:.3g}" if math.isnan(scatter) else with_reach(mean, scatter)


def _numbers(rides: Rides) -> dict[str, object]:
    figures = {name: [figures_as_dict(one) for one in several] for name, several in rides.figures.items()}
    about: dict[str, object] = {key: getattr(rides, key) for key in ("car", "road_class", "speed", "length")}
    if rides.position is not None:
        about["position"] = rides.position
    of_all = {"damper_origin": rides.origin.as_dict(), "findings": as_dicts(rides.findings)}
    return about | {"rides": figures} | of_all
