"""All that is known of a record without its samples, for a table or for machines."""

from __future__ import annotations

from typing import Any

import numpy as np

from dampyr.records.label_checks import disagreements
from dampyr.records.measure import measure
from dampyr.records.overview import Overview, overview
from dampyr.records.quality import quality
from dampyr.records.record import Record


def describe(record: Record) -> dict[str, Any]:
    """Name, role, input, label, what was measured, how well it was sampled, and in ``notes`` what a person should look at, SI.

    ``measured`` is None where the motion does not repeat itself: then ``overview`` stands for it. ``input_range`` is the least
    and the largest input, None where it is not known.
    """
    seen = overview(record)
    measured = measure(record) if seen.repeats else None
    notes = disagreements(record)
    if measured is None:
        notes = [_irregular(seen), *notes]
    sampled = quality(record)
    return {
        "name": record.name,
        "role": record.role,
        "input": record.input,
        "input_value": record.input_value,
        "input_range": _range(record),
        "duration_s": record.duration,
        "label": record.label,
        "measured": measured,
        "overview": seen,
        "quality": sampled,
        "notes": [*(note.removeprefix(f"{record.name}: ") for note in notes), *sampled.notes],
        "history": record.history,
        "provenance": record.provenance,
    }


def _irregular(seen: Overview) -> str:
    if seen.dominant_hz is None:
        return "no whole cycle: nothing moves"
    return f"no repeating cycle: strongest at {seen.dominant_hz:.2g} Hz, {1e3 * seen.rms_speed:.3g} mm/s rms"


def _range(record: Record) -> list[float] | None:
    value = record.voltage if record.voltage is not None else record.current
    if value is None:
        return None
    return [value, value] if isinstance(value, float) else [float(np.min(value)), float(np.max(value))]
