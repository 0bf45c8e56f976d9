"""The simulated rig beside the original one: the same open-loop drive, its records side by side, in numbers and in a figure.

The original's drive is read off its records: the duty rose evenly to its top and fell again, 2.2 ms a step (4.2 ms at
0.8712 V), with 50 ms at the top. The tops 248 and 165 of 255 are the longest and the shortest drives of each voltage.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from dampyr.errors import InputError
from dampyr.records import Record, read_campaign
from dampyr.rig.drive import DutyReversals
from dampyr.rig.settings import RigSettings
from dampyr.rig.simulation.twin_validation import SETTLING, Characteristics, characteristics, open_loop

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SLOPES = {0.0: 2.2e-3, 0.8712: 4.2e-3, 1.98: 2.2e-3, 3.212: 2.2e-3}  # s for each step of the duty
TOPS = (248, 165)
PAUSE = 0.05  # s at the top
SHOWN = 3.0  # cycles in the figure


@dataclass(frozen=True, eq=False)
class Pair:
    """A measured record and the simulated one of the same drive, with what they show."""

    voltage: float
    top: int
    measured: Record
    simulated: Record
    theirs: Characteristics
    ours: Characteristics


def pairs(folder: str | Path, settings: RigSettings | None = None) -> list[Pair]:
    """The pairs of all voltages and both tops; ``folder`` holds the original campaign. InputError where it lacks a voltage."""
    records = [record for record in read_campaign(folder) if record.role == "fit" and record.voltage is not None]
    return [_pair(records, settings or RigSettings(), v, top) for v in SLOPES for top in TOPS]


def _pair(records: Sequence[Record], settings: RigSettings, voltage: float, top: int) -> Pair:
    drive = DutyReversals(duty=top / 255, half_period=top * SLOPES[voltage], pause=PAUSE)
    ours = open_loop(settings, drive, voltage)
    matches = [(r, characteristics(r)) for r in records if abs(float(np.mean(r.voltage)) - voltage) < 0.01]  # type: ignore[arg-type]
    if not matches:
        raise InputError(f"the folder has no record at {voltage:g} V; give the folder of the original campaign")
    period = 2 * (drive.half_period + drive.pause)
    record, theirs = min(matches, key=lambda match: abs(match[1].period - period))
    return Pair(voltage, top, record, ours, theirs, characteristics(ours))


def table(pairs: Sequence[Pair]) -> list[dict[str, float | str]]:
    """A row for each pair and number: measured and simulated, in the units of people."""
    factors = {
        "stroke": ("mm", 1e3), "peak_speed": ("mm/s", 1e3), "third": ("%", 100.0), "others": ("%", 100.0),
        "mean_force": ("N", 1.0), "force_span": ("N", 1.0), "period": ("s", 1.0), "drift": ("mm/s", 1e3),
    }  # fmt: skip
    return [
        {"voltage": pair.voltage, "top": pair.top, "what": name.replace("_", " "), "unit": unit,
         "measured": getattr(pair.theirs, name) * factor, "simulated": getattr(pair.ours, name) * factor}
        for pair in pairs
        for name, (unit, factor) in factors.items()
    ]  # fmt: skip


def figure(pairs: Sequence[Pair], top: int = TOPS[0]) -> Figure:
    """The pairs of one top of the duty, a row for each voltage."""
    from dampyr.show.figures.side_by_side import MotionStretch, side_by_side

    def cut(record: Record, period: float) -> MotionStretch:
        t, x = record.time, record.displacement
        moving = t[int(np.argmax(np.abs(x - x[0]) > 1e-4))] + SETTLING
        cycle = x[(t > moving) & (t < moving + period)]
        level = x - 0.5 * (cycle.min() + cycle.max())
        rising = np.flatnonzero((level[:-1] < 0) & (level[1:] >= 0) & (t[1:] > moving))
        start = t[rising[0]]
        window = (t >= start) & (t < start + SHOWN * period)
        return MotionStretch(t[window] - start, level[window], record.force[window])

    rows = [
        (f"{p.voltage:g} V, {p.measured.name}", cut(p.measured, p.theirs.period), cut(p.simulated, p.theirs.period))
        for p in pairs
        if p.top == top
    ]
    return side_by_side(rows)
