"""Force at mid-stroke, as shock dynamometers give it, and the gas force that is taken off it.

Of the last whole cycle, within 5 % of the stroke to either side of its middle: the largest force in extension and the least in
compression. The gas force is met at rest at places along the stroke: of each place that was reached from both sides the
mean of the two, so that friction cancels; half of their difference is the friction.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from dampyr.errors import InputError
from dampyr.records.cycle_analysis.break_away_force import rests
from dampyr.records.cycle_analysis.cycles import cut_cycles, no_cycle
from dampyr.records.record import Array, Record

WINDOW = 0.05  # of the stroke, to either side of its middle
LIKE_THE_MEDIAN = 0.02  # of the stroke: a last cycle that differs by more holds part of the run-out
SAME_PLACE = 0.02  # of the stroke of the places


@dataclass(frozen=True)
class MidStrokeForce:
    """Raw forces in N as recorded, at the ``place`` (m) of the stroke's middle; ``speed`` in m/s is the largest there."""

    cycle: int
    place: float
    speed: float
    extension: float
    compression: float


@dataclass(frozen=True)
class GasForceCurve:
    """Gas force in N at ``places`` (m), rising, and the friction at each."""

    places: Array
    forces: Array
    friction: Array

    def at(self, place: float) -> float:
        """The gas force at a place, between those that were met by linear interpolation, beyond them that of the nearest."""
        return float(np.interp(place, self.places, self.forces))


def mid_stroke_force(record: Record) -> MidStrokeForce:
    """Of the last whole cycle; InputError where there is none."""
    cycles = [cycle for cycle in cut_cycles(record).cycles if cycle.level]
    if not cycles:
        raise no_cycle(record, "the force at mid-stroke")
    usual = float(np.median([cycle.stroke_m for cycle in cycles]))
    cycle = [c for c in cycles if abs(c.stroke_m - usual) <= LIKE_THE_MEDIAN * usual][-1]
    inside = slice(cycle.first, cycle.last + 1)
    x, force = record.displacement[inside], record.force[inside]
    velocity = record.velocity[inside] if record.velocity is not None else np.gradient(x, record.time[inside])
    place = 0.5 * float(x.max() + x.min())
    near = np.abs(x - place) <= WINDOW * float(np.ptp(x))
    up, down = near & (velocity > 0.0), near & (velocity < 0.0)
    if not (up.any() and down.any()):
        raise InputError(f"{record.name}: no sample lies within {100 * WINDOW:g} % of mid-stroke; sample faster")
    speed = float(np.abs(velocity[near]).max())
    return MidStrokeForce(cycle.number, place, speed, float(force[up].max()), float(force[down].min()))


def gas_force_curve(record: Record) -> GasForceCurve:
    """From a record of rests at places that were reached from both sides, such as that of the step `gas_force`."""
    found = rests(record)
    x, force = record.displacement, record.force
    means = [(float(np.mean(x[(a + b) // 2 : b])), float(np.mean(force[(a + b) // 2 : b]))) for a, b in found]
    near = SAME_PLACE * float(np.ptp(x))
    met: dict[float, tuple[list[float], list[float]]] = {}
    for (before, _), (place, value) in pairwise(means):
        if abs(place - before) <= near:
            continue  # no move in between: the same rest
        known = next((other for other in met if abs(other - place) <= near), place)
        met.setdefault(known, ([], []))[0 if place > before else 1].append(value)
    both = sorted((place, float(np.mean(up)), float(np.mean(down))) for place, (up, down) in met.items() if up and down)
    if not both:
        raise InputError(f"{record.name}: no place was reached from both sides at rest; record the step gas_force")
    places, up, down = np.array(both).T
    return GasForceCurve(places, 0.5 * (up + down), 0.5 * (up - down))
