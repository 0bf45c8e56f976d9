"""The page of a plan: the tests, the limits of the rig, the paths, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dampyr.campaigns import Plan
from dampyr.campaigns.check import STROKE_MARGIN
from dampyr.campaigns.planned_tests import PlannedTest
from dampyr.phrases import sentence
from dampyr.rig import RigSettings
from dampyr.show.campaigns.planned_tests import plan_notes, plan_table
from dampyr.show.figures.envelope import envelope
from dampyr.show.figures.planned_drive import planned_drive
from dampyr.show.figures.style import case_colours
from dampyr.show.pages.blocks import Block, FigureBlock, Section, Text
from dampyr.show.pages.html_page import page
from dampyr.show.table import Verdict

FORCES = (0.0, 500.0, 1000.0, 1500.0)  # N: no load, and three loads in equal steps


def html(plan: Plan, *, call: str = "") -> str:
    """The page of a plan."""
    table = replace(plan_table(plan), caption="In the order in which they run.")
    notes = "\n\n".join(plan_notes(plan))
    sections = [Section("Planned tests", [table, *([Text(notes)] if notes else [])])]
    moving = [test for test in plan.tests if test.peak_speed > 0]
    if plan.refusals:
        refused: list[Block] = [Verdict("differs", sentence(refusal)) for refusal in plan.refusals]
        sections.insert(0, Section("Refused by the rig", refused))
    if moving:
        sections.append(Section("Limits of the rig", [_envelope(plan.rig, moving)]))
    groups = _groups(moving)
    colours = case_colours(groups.values())
    drives = [_drive(test, colours[groups[test.name]]) for test in _firsts(plan)]
    sections.append(Section("One test of each kind", drives))
    header = plan.campaign.header
    subtitle = f"{len(plan.tests)} tests on {plan.rig.name}, {plan.duration / 60:.1f} min"
    return page(
        header.name,
        sections,
        subtitle=subtitle,
        provenance={"note": header.note} if header.note else "",
        facts={"operator": header.operator} if header.operator else {},
        call=call,
    )


def _envelope(rig: RigSettings, tests: list[PlannedTest]) -> FigureBlock:
    places = [(test.peak_speed / (2 * np.pi * test.peak_position), test.peak_position) for test in tests]
    low, high = min(f for f, _ in places), max(f for f, _ in places)
    frequency = np.geomspace(0.6 * low, 1.6 * high, 200)
    limits = {f"{force:g} N": largest_amplitude(rig, frequency, force) for force in FORCES}
    groups: dict[str, list[tuple[float, float]]] = {}
    names = _groups(tests)
    for test, place in zip(tests, places, strict=True):
        if not test.refusal:
            groups.setdefault(names[test.name], []).append(place)
    refused = [place for test, place in zip(tests, places, strict=True) if test.refusal]
    figure = envelope(
        frequency,
        limits,
        {name: _columns(group) for name, group in groups.items()},
        _columns(refused),
        colours=case_colours(names.values()),
    )
    caption = (
        "Each test by its farthest position and the frequency at which a sine of that amplitude has its peak speed. The lines "
        "are the largest sines at a braking force, with the table's friction, the motor's lag and the stroke."
    )
    return FigureBlock(figure, caption, alt="Amplitude over frequency: the rig's limits and the tests.")


def largest_amplitude(rig: RigSettings, frequency: np.ndarray, force: float) -> np.ndarray:
    """The amplitude [m] of the largest sine at each frequency [Hz] against a constant braking force [N]."""
    omega = 2 * np.pi * frequency
    # the motor slows down under load, and reaches less the faster it is to reverse (a first-order lag)
    speed = rig.actuator.top_speed - rig.actuator.droop * (force + rig.table.friction)
    lagging = np.hypot(1.0, omega * rig.actuator.lag)
    max_amplitude = np.minimum(np.maximum(speed, 0.0) / lagging, rig.limits.speed) / omega
    return np.asarray(np.minimum(max_amplitude, rig.travel - STROKE_MARGIN))


def _groups(tests: list[PlannedTest]) -> dict[str, str]:
    """Test -> what it is drawn as: its voltage where all are of one kind, else its kind."""
    of_one_kind = len({test.kind for test in tests}) == 1
    return {test.name: f"{test.peak_voltage:g} V" if of_one_kind else test.kind.replace("_", " ") for test in tests}


def _columns(places: list[tuple[float, float]]) -> tuple[list[float], list[float]]:
    return [f for f, _ in places], [a for _, a in places]


def _firsts(plan: Plan) -> list[PlannedTest]:
    first_tests: dict[str, PlannedTest] = {}
    for test in plan.tests:
        if test.drive.reversals is None and test.peak_speed > 0:
            first_tests.setdefault(test.kind, test)
    return list(first_tests.values())


def _drive(test: PlannedTest, colour: str) -> FigureBlock:
    drive = test.drive
    return FigureBlock(
        planned_drive(drive.time, drive.displacement, drive.voltage, colour=colour),
        sentence(f"{test.name}: {test.words}"),
    )
