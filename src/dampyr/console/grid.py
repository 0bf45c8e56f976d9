"""Campaigns as texts in the data folder, as grids of sines, and as plans for a page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.campaigns import Plan, campaign_of, plan
from dampyr.campaigns.force_prediction import specimen
from dampyr.campaigns.planned_tests import PlannedTest
from dampyr.campaigns.steps.earthquake import BUILT_IN
from dampyr.config import parse_toml
from dampyr.console.safe_paths import inside
from dampyr.errors import InputError
from dampyr.rig import RigSettings
from dampyr.show.pages.plan_page import FORCES, largest_amplitude
from dampyr.units import parse, round_trip

FOLDER = "campaigns"
MAX_TESTS = 400  # tests that a page plans at once
UNITS = {"amplitude": ("m", 1e3, "mm"), "frequency": ("Hz", 1.0, "Hz"), "voltage": ("V", 1.0, "V")}


@dataclass(frozen=True)
class Grid:
    """A campaign of sines: every amplitude [mm] with every frequency [Hz] and voltage [V]."""

    name: str = ""
    operator: str = ""
    note: str = ""
    amplitude: list[float] = field(default_factory=lambda: [2.0, 4.0])
    frequency: list[float] = field(default_factory=lambda: [0.5, 1.0])
    voltage: list[float] = field(default_factory=lambda: [0.0, 0.8712])
    cycles: int = 20
    repeats: int = 1
    random: bool = False
    seed: int = 0


def grid_text(grid: Grid) -> str:
    """The grid as a campaign's TOML."""
    for name in UNITS:
        if not getattr(grid, name):
            raise InputError(f"{name} is empty; give at least one value")
    head = {"name": grid.name, "operator": grid.operator, "note": grid.note}
    lines = [f"{key} = {_quoted(value)}" for key, value in head.items() if value]
    lines += ['order = "random"', f"seed = {grid.seed}"] if grid.random else []
    lines += ["", "[[step]]", 'kind = "sine"']
    for name, (_, _, unit) in UNITS.items():
        values = ", ".join(f'"{value:.10g} {unit}"' for value in getattr(grid, name))
        lines.append(f"{name} = [{values}]")
    lines += [f"cycles = {grid.cycles}", *([f"repeats = {grid.repeats}"] if grid.repeats != 1 else [])]
    return "\n".join(lines) + "\n"


def grid_of(text: str) -> Grid | None:
    """The grid that a campaign's TOML says and nothing else; None where it says more."""
    document = parse_toml(text)
    steps = document.pop("step", None)
    order = document.pop("order", "as written")
    allowed = {"name", "operator", "note", "seed"}
    if (
        not isinstance(steps, list)
        or len(steps) != 1
        or not set(document) <= allowed
        or order not in ("as written", "random")
    ):
        return None
    step = dict(steps[0])
    if step.pop("kind", "") != "sine" or not set(step) <= {*UNITS, "cycles", "repeats"}:
        return None
    try:
        values: dict[str, Any] = {
            name: _values(step.pop(name, 0.0 if name == "voltage" else None), name) for name in UNITS
        }
        return Grid(**document, **values, **step, random=order == "random")
    except InputError:
        return None


def _values(stated: Any, name: str) -> list[float]:
    unit, factor, _ = UNITS[name]
    listed = stated if isinstance(stated, list) else [stated]
    return [round_trip(parse(value, unit) * factor) for value in listed]


def _quoted(text: str) -> str:
    """A TOML string."""
    special = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r"}
    return '"' + "".join(special.get(c, c if c.isprintable() else f"\\U{ord(c):08x}") for c in text) + '"'


def planned_text(text: str, data: Path, rig: RigSettings, rig_folder: Path | None) -> Plan:
    """The plan of a campaign's TOML; files that it names are those beside the campaigns of ``data``."""
    try:
        document = parse_toml(text)
    except InputError as problem:
        raise InputError(f"this is not valid TOML: {problem}") from None
    _check_files(document, data / FOLDER)
    return plan(campaign_of(document, data / FOLDER, max_tests=MAX_TESTS), rig, specimen(rig, rig_folder))


def _check_files(document: Mapping[str, Any], folder: Path) -> None:
    """Files that steps name lie below ``folder``."""
    steps = document.get("step")
    for step in steps if isinstance(steps, list) else []:
        if not isinstance(step, Mapping):
            continue
        motions = step.get("motion", [])
        for name in [step.get("rows"), *(motions if isinstance(motions, list) else [motions])]:
            if isinstance(name, str) and name != BUILT_IN:
                inside(folder, name)


@dataclass(frozen=True)
class Envelope:
    """What a rig can do: for each braking force [N] the largest sine's amplitude [mm] at each frequency [Hz]."""

    frequency: list[float]
    limits: dict[str, list[float]]


def envelope_of(campaign_plan: Plan) -> Envelope:
    """The envelope of a plan's rig, from below the slowest of its tests to above the fastest."""
    moving = [sine_frequency(test) for test in campaign_plan.tests if test.peak_speed > 0]
    low, high = (min(moving, default=0.1), max(moving, default=5.0))
    frequency = np.geomspace(0.5 * min(low, 0.2), 2.0 * max(high, 5.0), 120)
    limits = {f"{force:g}": (1e3 * largest_amplitude(campaign_plan.rig, frequency, force)).tolist() for force in FORCES}
    return Envelope(frequency.tolist(), limits)


def sine_frequency(test: PlannedTest) -> float:
    """The frequency [Hz] of the sine with a test's peak speed and farthest position."""
    return float(test.peak_speed / (2 * np.pi * test.peak_position)) if test.peak_position else 0.0
