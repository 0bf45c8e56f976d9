"""Rides of a car over several random roads of one class, at several inputs of its damper: figures beside one another."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from dampyr.errors import InputError
from dampyr.findings import Finding, worst_first
from dampyr.models import Damper
from dampyr.origin import Origin, combined
from dampyr.shown import Shown
from dampyr.structures.building import Building
from dampyr.structures.ride import RideFigures, ride_figures
from dampyr.structures.road_profile import random_road
from dampyr.structures.time_history.respond import case_name, respond
from dampyr.structures.vehicle import AXLES, HalfCar, axle_roads, road
from dampyr.units import in_si

PLACE = ("unsprung", "sprung")
LEAD = 10.0  # m, in which a road rises from level
STEP, SPACING = 0.0025, 0.05  # s and m, at most, between heights: controllers' periods are multiples of the former
Progress = Callable[[str, float], None]


@dataclass(frozen=True, eq=False, repr=False)
class Rides(Shown):
    """Figures of rides: ``figures``, the input in words -> a `RideFigures` for each road, in the order of the seeds.

    ``car``, ``road_class``, ``speed`` [m/s] and ``length`` [m] say of what; ``origin`` is that of the damper. ``position`` [m
    behind the front axle] is where the acceleration is felt in a half car, None in a quarter car.
    """

    car: str
    road_class: str
    speed: float
    length: float
    figures: Mapping[str, tuple[RideFigures, ...]]
    origin: Origin
    position: float | None = None

    def __getitem__(self, name: str) -> tuple[RideFigures, ...]:
        """The figures at the input of this name, one for each road."""
        if name not in self.figures:
            raise InputError(f"{name!r} is not an input; choose from {', '.join(map(repr, self.figures))}")
        return self.figures[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.figures)

    def mean(self, name: str, figure: str) -> tuple[float, float]:
        """The mean of a figure over the roads at an input, and its standard deviation, NaN for a single road."""
        values = np.array([getattr(one, figure) for one in self[name]])
        return float(values.mean()), float(values.std(ddof=1)) if len(values) > 1 else math.nan

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Those of all rides, each once with its input as the source."""
        of_inputs = {
            (name, finding.kind): replace(finding, source=finding.source or name)
            for name, several in self.figures.items()
            for one in several
            for finding in one.findings
        }
        return worst_first(of_inputs.values())


def rides(
    car: Building,
    damper: Damper | Sequence[Damper],
    voltage: Any = None,
    *,
    current: Any = None,
    road_class: str = "C",
    speed: float = 20.0,
    length: float = 400.0,
    seeds: int = 5,
    position: float | None = None,
    progress: Progress | None = None,
) -> Rides:
    """A quarter or a half car over several random roads, at each of several inputs of its dampers.

    Parameters
    ----------
    car
        What `quarter_car` or `half_car` gives. A damper stands between wheel and body, of a half car at both axles.
    damper
        The damper; of a half car also a pair of them, front and rear.
    voltage, current
        Its input, V or A: a number or a control law, or a list of these; none for a damper without one.
    road_class
        Of ISO 8608, "A" (very good) to "H" (very poor).
    speed, length
        m/s, and m of each road; quantities such as ``"72 km/h"`` are taken, too.
    seeds
        How many roads: those of `random_road` with the seeds 1 to this.
    position
        Of a half car: where on its body the acceleration is felt, m behind the front axle; by default the centre of mass.
    progress
        Called with what is being done, and the fraction of all that is done.

    Raises
    ------
    InputError
        An argument is wrong; the building is no car.

    Examples
    --------
    >>> import dampyr as dp
    >>> S = dp.structures
    >>> car = S.quarter_car(290.0, 45.0, suspension=18e3, tyre=190e3, damping=300.0)
    >>> law = S.control_law("on_off", high=1.0)
    >>> found = S.rides(car, dp.studies.raminelli_2020.damper(), [0.0, law], seeds=2, length=200.0)
    >>> {name: round(found.mean(name, "weighted_acceleration")[0], 2) for name in found}
    {'0 V': 1.19, 'on_off 0 to 1 V': 1.42}
    """
    speed, length = float(in_si(speed, "m/s", "speed")), float(in_si(length, "m", "length"))
    if not 0.0 < speed < math.inf:
        raise InputError(f"speed = {speed!r} m/s is not allowed; it must be greater than 0")
    if isinstance(seeds, bool) or not isinstance(seeds, int) or seeds < 1:
        raise InputError(f"seeds = {seeds!r} is not allowed; give a whole number, at least 1")
    spacing = speed * STEP / math.ceil(speed * STEP / SPACING * (1 - 1e-9))
    name, given = ("voltage", voltage) if current is None else ("current", current)
    if voltage is not None and current is not None:
        raise InputError("both voltage= and current= are given; a damper takes one of the two")
    inputs = list(given) if isinstance(given, list | tuple) else [given]
    dampers = _at_axles(car, damper)
    start = (LEAD + (car.wheelbase if isinstance(car, HalfCar) else 0.0)) / speed
    figures: dict[str, list[RideFigures]] = {}
    for seed in range(1, seeds + 1):
        profile = random_road(road_class, length, spacing, seed, LEAD)
        label = f"road of class {road_class}, seed {seed}"
        if isinstance(car, HalfCar):
            motion: Any = axle_roads(profile, spacing, speed, car.wheelbase, label)
        else:
            motion = road(profile, spacing, speed, label)
        for k, value in enumerate(inputs):
            if progress is not None:
                progress(f"road {seed} of {seeds}", ((seed - 1) * len(inputs) + k) / (seeds * len(inputs)))
            keyword = {name: value} if value is not None else {}
            response = respond(car, motion, dampers, **keyword)
            figures.setdefault(case_name(response), []).append(ride_figures(response, car, start, position))
    felt_at = (
        float(car.centre if position is None else in_si(position, "m", "position"))
        if isinstance(car, HalfCar)
        else None
    )
    return Rides(
        car.name,
        road_class,
        speed,
        length,
        {key: tuple(several) for key, several in figures.items()},
        combined(each.origin for each in dampers.values()),
        felt_at,
    )


def _at_axles(car: Building, damper: Damper | Sequence[Damper]) -> dict[tuple[str, str], Damper]:
    """The damper of a quarter car at its place, or those of a half car at theirs."""
    if not isinstance(car, HalfCar):
        if isinstance(damper, list | tuple):
            raise InputError(f"{len(damper)} dampers are given, and {car.name} has one axle; give one")
        return {PLACE: damper}  # type: ignore[dict-item]
    pair = tuple(damper) if isinstance(damper, list | tuple) else (damper, damper)
    if len(pair) != 2:
        raise InputError(f"{len(pair)} dampers are given; give one for both axles, or two, front and rear")
    return {(f"{axle} wheel", f"{axle} body"): each for axle, each in zip(AXLES, pair, strict=True)}
