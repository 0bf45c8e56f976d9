"""Plans of campaigns as a page shows them; computed in a process with limits (:mod:`dampyr.console.workers`)."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.campaigns import Plan
from dampyr.console.curves import line
from dampyr.console.grid import envelope_of, planned_text, sine_frequency
from dampyr.console.rigs import rig_file, rig_settings
from dampyr.phrases import listing
from dampyr.records import Record, describe
from dampyr.to_json import plain

POINTS = 2000  # of a path: twice the columns of a wide chart
REACH = re.compile(r"(displacement|velocity|frequency) reaches ([\d.e+-]+) (.*)")
"""A note whose value differs from test to test; the largest stands for all."""
METRES = re.compile(r"([\d.]+(?:e[+-]?\d+)?) m(/s)?(?![\w/])")
MAX_NAMED = 3  # tests that a note names one by one


def plan_answer(data: Path, text: str, rig: str) -> dict[str, Any]:
    """What a campaign's TOML would ask of a rig of the data folder, and all that the rig cannot do; nothing moves.

    Lengths in mm, speeds in mm/s, as the names say.
    """
    planned = _plan(data, text, rig)
    envelope = envelope_of(planned)
    return {
        "name": planned.campaign.header.name,
        "rig": planned.rig.name,
        "duration_s": planned.duration,
        "tests": [
            {
                "name": test.name, "words": test.words, "duration_s": test.duration, "speed_mm_s": 1e3 * test.peak_speed,
                "position_mm": 1e3 * test.peak_position, "force_N": test.peak_force, "voltage_V": test.peak_voltage,
                "frequency_Hz": sine_frequency(test), "refusal": test.refusal,
            }
            for test in planned.tests
        ],
        "notes": grouped_notes(planned),
        "refusals": list(planned.refusals),
        "envelope": vars(envelope),
    }  # fmt: skip


def path_answer(data: Path, text: str, rig: str, test: str = "") -> dict[str, Any]:
    """Displacement [mm] and voltage [V] over time [s] of a campaign's tests one after the other with the rests between them, or
    of the test of this name; decimated so that its peaks stay. ``tests`` are the times at which each begins.
    """
    planned = _plan(data, text, rig)
    chosen = [planned_test for planned_test in planned.tests if not test or planned_test.name == test]
    rest = planned.campaign.header.rest_between
    budget = max(40, 2 * POINTS // max(len(chosen), 1))
    displacement: list[list[float | None]] = [[], []]
    voltage: list[list[float | None]] = [[], []]
    begins, start = [], 0.0
    for planned_test in chosen:
        begins.append({"name": planned_test.name, "time": start})
        drive = planned_test.drive
        for path, values in ((displacement, 1e3 * drive.displacement), (voltage, drive.voltage)):
            drawn = line(drive.time, np.broadcast_to(values, np.shape(drive.time)), budget)
            path[0] += [start + value for value in drawn.x] + [None]  # a gap: what happens between tests is not drawn
            path[1] += [*drawn.y, None]
        start += planned_test.duration + rest
    return dict(
        plain({"displacement": displacement, "voltage": voltage, "tests": begins, "duration_s": max(start - rest, 0.0)})
    )


def grouped_notes(planned: Plan) -> list[str]:
    """What the expected force rests on, and each note on tests once, with the tests that it is about."""
    about: dict[str, list[str]] = {}
    largest: dict[str, tuple[float, str]] = {}
    for test in planned.tests:
        for note in dict.fromkeys(test.notes):
            reach = REACH.fullmatch(note)
            key = note if reach is None else f"{reach[1]} {reach[3]}"
            value = 0.0 if reach is None else float(reach[2])
            largest[key] = max(largest.get(key, (value, note)), (value, note))
            about.setdefault(key, []).append(test.name)
    notes = [f"{_named(names, len(planned.tests))}: {_in_mm(largest[key][1])}" for key, names in about.items()]
    return [*planned.notes, *notes]


def _in_mm(note: str) -> str:
    return METRES.sub(lambda value: f"{1e3 * float(value[1]):.4g} mm{value[2] or ''}", note)


def _named(names: list[str], count: int) -> str:
    names = list(dict.fromkeys(names))
    return "every test" if len(names) == count and count > 1 else listing(names, MAX_NAMED)


def _plan(data: Path, text: str, rig: str) -> Plan:
    settings, path = rig_settings(data, rig), rig_file(data, rig)
    return planned_text(text, data, settings, None if path is None else path.parent)


def warm_up() -> None:
    """Plan a test and describe a record, so that what this compiles is there for every process that is forked."""
    t = np.arange(400) / 200.0
    describe(Record(t, 1e-3 * np.sin(9.0 * t), 10.0 * np.cos(9.0 * t)))
    text = '[[step]]\nkind = "sine"\namplitude = "1 mm"\nfrequency = "2 Hz"\ncycles = 2\nvoltage = ["0 V", "1 V"]\n'
    plan_answer(Path(), text, "")
