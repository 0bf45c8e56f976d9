"""What loads on floors show."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from dampyr.phrases import listing, sentence
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures.floor_loads import LARGE, floor_loads
from dampyr.structures.floor_loads import FloorLoads

FEW = 4  # floors that a line lists


@describe.register
def describe_floor_loads(loads: FloorLoads) -> Description:
    """Times, the peak of each floor, source and history, and the forces over time."""
    n = len(loads.time)
    rows = [
        ("times", f"{n}, {loads.time[0]:.4g} to {loads.duration:.4g} s"),
        ("peaks", _peaks_in_words(loads)),
        ("source", loads.source),
        ("history", "; ".join(loads.history)),
    ]
    return Description(
        f"FloorLoads {loads.name!r}",
        [row for row in rows if row[1]],
        verdict=[*map(sentence, loads.history)],
        figure=lambda: floor_loads(loads.time, loads.forces),
        data=lambda: _numbers(loads),
        frame=lambda: DataFrameColumns(
            {"time_s": loads.time, **{f"{_plain(floor)}_N": row for floor, row in loads.forces.items()}}
        ),
    )


def loads_in_words(loads: FloorLoads) -> str:
    """What loads there are: their name, floors and peaks."""
    return f"{loads.name}: {_peaks_in_words(loads)}"


def _peaks_in_words(loads: FloorLoads) -> str:
    largest = max(loads.peaks.values())
    factor, unit = (1e-3, "kN") if largest >= LARGE else (1.0, "N")
    peaks = [f"{floor_in_words(floor)} peak {factor * value:.4g} {unit}" for floor, value in loads.peaks.items()]
    more = f", and {len(peaks) - FEW} more floors" if len(peaks) > FEW else ""
    return listing(peaks[:FEW], FEW) + more


def floor_in_words(floor: str) -> str:
    """``floor 1`` for a floor called 1; a name of its own stays."""
    return f"floor {floor}" if floor.isdigit() else floor


def _plain(floor: str) -> str:
    return re.sub(r"\W+", "_", floor_in_words(floor)).strip("_").lower()


def _numbers(loads: FloorLoads) -> dict[str, Any]:
    means = {floor: float(np.trapezoid(row, loads.time) / np.ptp(loads.time)) for floor, row in loads.forces.items()}
    return {
        "name": loads.name,
        "source": loads.source,
        "history": list(loads.history),
        "begin_s": float(loads.time[0]),
        "end_s": loads.duration,
        "peak_N": loads.peaks,
        "mean_N": means,
    }
