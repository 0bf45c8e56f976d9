"""The force at the middle of the loop: gas force and the sensor's zero."""

from __future__ import annotations

from dampyr.records.cycle_analysis.cycles import mean_over_time, whole
from dampyr.records.record import Record


def mean_force(record: Record) -> float:
    """The mean force, N, over whole cycles, each instant weighted by its sampling interval."""
    part = whole(record, "the force offset")
    return mean_over_time(record.force, record, part.start, part.stop)


def remove_offset(record: Record, offset: float | None = None) -> Record:
    """The record with ``offset`` (N) taken from its force; by default the mean force over whole cycles."""
    if offset is None:
        value, source = mean_force(record), "the mean over whole cycles"
    else:
        value, source = float(offset), "as given"
    note = f"force offset of {value:.6g} N removed ({source})"
    provenance = dict(record.provenance) | {"force_offset_n": repr(value)}
    return record.replace(note=note, force=record.force - value, provenance=provenance)
