"""The velocity of a record, with a bandwidth that its history states (`dampyr.models.derivative` has the filter)."""

from __future__ import annotations

from dampyr.models.derivative import differentiate, response
from dampyr.records.record import Record

PER_TEST_FREQUENCY = 15.0
WITHOUT_CYCLES = 0.2


def default_bandwidth(record: Record) -> float:
    """15 times the measured frequency, Hz, at most a fifth of the sampling rate; that without cycles."""
    from dampyr.records.cycles import cycles

    most = WITHOUT_CYCLES / record.dt
    found = cycles(record)
    if not found:
        return most
    rate = len(found) / float(record.time[found[-1][1]] - record.time[found[0][0]])
    return min(PER_TEST_FREQUENCY * rate, most)


def with_velocity(record: Record, bandwidth_hz: float | None = None) -> Record:
    """The record with the velocity derived from its displacement, 3 dB down at ``bandwidth_hz``.

    Without one: :func:`default_bandwidth`. The velocity that was recorded is replaced; the bandwidth is kept
    in the history and in the provenance (``velocity_bandwidth_hz``).
    """
    chosen = default_bandwidth(record) if bandwidth_hz is None else float(bandwidth_hz)
    velocity = differentiate(record.time, record.displacement, chosen)
    provenance = dict(record.provenance) | {
        "velocity": "derived from the displacement",
        "velocity_bandwidth_hz": f"{chosen:.6g}",
    }
    note = f"velocity derived from the displacement: local cubic, no phase, -3 dB at {chosen:.4g} Hz"
    return record.replace(note=note, velocity=velocity, provenance=provenance)


__all__ = ["default_bandwidth", "differentiate", "response", "with_velocity"]
