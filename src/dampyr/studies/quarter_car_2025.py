"""A quarter car with a magnetorheological damper over a bump (2025), constant voltages and a two-state skyhook.

IEEE Transactions on Transportation Electrification, doi 10.1109/TTE.2025.3535765; the numbers are those of the README of
github.com/waqasmbaig/Semi-Active-MR-Damper-Control (commit 00050da). 320 kg on 40 kg, 22 and 190 kN/m, a haversine bump of
50 mm and 1 m at 45 km/h, 2.5 s; the passive car has 1500 N s/m in the place of the damper, which is `spencer_1997_baig`.

The static force k1 x0 of the damper, 21 N, which lets the body of the source's program sink from its place at the start, is
left out here, as `respond` counts from the static place: 1 % of the travel.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from dampyr.ground_motions import GroundMotion
from dampyr.models import published
from dampyr.structures import Building, Response, control_law, quarter_car, respond, road
from dampyr.studies._compared_value import ComparedValue, ComparisonTolerance, judge
from dampyr.studies._study_run import Progress, StudyRun, write

SPRUNG, UNSPRUNG, SUSPENSION, TYRE, DAMPING = 320.0, 40.0, 22e3, 190e3, 1500.0  # kg, kg, N/m, N/m, N s/m
HEIGHT, LENGTH, SPEED, DURATION, SPACING = 0.05, 1.0, 12.5, 2.5, 0.0125  # m, m, m/s, s, m
PASSIVE, SOFT, HARD, SKYHOOK = "1500 N s/m", "0 V", "2 V", "two-state skyhook, 0 and 2 V"
PUBLISHED = {
    PASSIVE: (1.66, 50.8, 14.0),
    SOFT: (1.41, 58.3, 17.0),
    HARD: (2.51, 29.4, 23.9),
    SKYHOOK: (2.17, 58.4, 8.5),
}
"""rms acceleration of the body, m/s2, largest travel and largest displacement of the body, mm."""
QUANTITIES = (("rms acceleration", "m/s²"), ("travel", "mm"), ("peak of the body", "mm"))
TOLERANCE = ComparisonTolerance(relative=0.03)
SETTLING = {SOFT: 16.75, SKYHOOK: 8.21}  # mm, by tests/studies/test_quarter_car_2025.py
STATIC = (
    "the force k1 x0 moves the source's body from its place at the start, and ours begins at its static place; with that force "
    "a plain Runge-Kutta on the source's equations gives {:g} mm"
)


def reproduce(data: Path | None = None, out: Path | None = None, progress: Progress | None = None) -> StudyRun:
    """Run the four cars over the bump; no data are needed. See `dampyr.studies._study_run`."""
    car = quarter_car(SPRUNG, UNSPRUNG, SUSPENSION, TYRE)
    damper = published.damper("spencer_1997_baig")
    law = control_law("on_off", low=0.0, high=2.0, period=0.001)
    compared: list[ComparedValue] = []
    for k, (name, values) in enumerate(PUBLISHED.items()):
        if progress is not None:
            progress(name, k / len(PUBLISHED))
        if name == PASSIVE:
            response = respond(quarter_car(SPRUNG, UNSPRUNG, SUSPENSION, TYRE, damping=DAMPING), motion())
        else:
            response = respond(car, motion(), {2: damper}, voltage={SOFT: 0.0, HARD: 2.0, SKYHOOK: law}[name])
        for (quantity, unit), theirs, ours in zip(QUANTITIES, values, figures(response), strict=True):
            why = STATIC.format(SETTLING[name]) if quantity == QUANTITIES[-1][0] and name in SETTLING else ""
            compared.append(judge(name, quantity, theirs, ours, unit, TOLERANCE, otherwise=why))
    study = StudyRun("quarter_car_2025", "MR quarter car (2025)", "doi 10.1109/TTE.2025.3535765", tuple(compared))
    return write(study, out)


def heights() -> np.ndarray:
    """The bump at the start of the road, m."""
    s = SPACING * np.arange(round(DURATION * SPEED / SPACING) + 1)
    return np.asarray(np.where(s < LENGTH, HEIGHT * np.sin(np.pi * s / LENGTH) ** 2, 0.0))


def motion() -> GroundMotion:
    """The road under the car."""
    return road(heights(), SPACING, SPEED, "bump")


def figures(response: Response) -> tuple[float, float, float]:
    """rms acceleration of the body, m/s2, largest travel and largest displacement of the body, mm."""
    body = response.displacement[1] + heights()
    return (
        float(np.sqrt(np.mean(response.acceleration[1] ** 2))),
        1e3 * float(response.peak_drift[1]),
        1e3 * float(np.abs(body).max()),
    )


def structure() -> Building:
    """The car without a damper."""
    return quarter_car(SPRUNG, UNSPRUNG, SUSPENSION, TYRE, name="quarter car (2025)")


STRUCTURES = {"quarter_car_2025": structure}
"""The car, by its name on the command line."""
