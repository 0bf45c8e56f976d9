"""Section on the uncertainty of what was measured."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dampyr.records import Record
from dampyr.records.record import CHANNELS
from dampyr.show.pages.blocks import Section, Text
from dampyr.show.table import Cell, Table

SHOWN = {"time": ("ms", 1e3), "displacement": ("µm", 1e6), "velocity": ("mm/s", 1e3)}
"""The units of a page for channels that are not given in SI."""


def uncertainty_section(records: Sequence[Record]) -> Section | None:
    """The standard uncertainty of each channel over the records that state it; None where none does."""
    stated = [record for record in records if record.uncertainty]
    if not stated:
        return None
    rows: list[list[Cell]] = []
    for channel, unit in CHANNELS.items():
        uncertainties = [record.uncertainty[channel] for record in stated if channel in record.uncertainty]
        if not uncertainties:
            continue
        shown, factor = SHOWN.get(channel, ("°C" if unit == "degC" else unit, 1.0))
        sizes = np.array([uncertainty.standard for uncertainty in uncertainties]) * factor
        names = [uncertainty.largest for uncertainty in uncertainties]
        parts = {
            name: float(np.median([uncertainty.parts.get(name, 0.0) for uncertainty in uncertainties]))
            for name in uncertainties[0].parts
        }
        rest = ", ".join(
            f"{name} {factor * size:.2g}"
            for name, size in sorted(parts.items(), key=lambda item: -item[1])
            if size > 0.0
        )
        frequent = max(sorted(set(names)), key=names.count)
        rows.append([channel, shown, float(np.median(sizes)), float(sizes.min()), float(sizes.max()), frequent, rest])
    sources = sorted({text for record in stated if (text := record.provenance.get("voltage", ""))})
    words = [
        "One standard uncertainty (one sigma) of each channel: encoder, load cell, amplifier, supply, "
        "coil and converter, and what each test has shown of lost counts and of the shift of the force's zero. Two of them "
        "hold about 95 % of the errors. The parts are added in squares (JCGM 100:2008)."
    ]
    words += [f"The voltage in the records is {text}." for text in sources]
    if len(stated) < len(records):
        words.append(f"{len(records) - len(stated)} of {len(records)} records state none.")
    columns = ("channel", "unit", "median", "least", "greatest", "largest part", "parts, medians")
    table = Table(columns, rows, align=("left", "left", "", "", "", "left", "left"), digits=3)
    return Section("Uncertainty of the measurement", [Text(" ".join(words)), table])
