"""The velocity of a record, with a bandwidth that its history states (`dampyr.models.numerics.differentiation` has the
filter).
"""

from __future__ import annotations

from collections.abc import Sequence

from dampyr.errors import InputError
from dampyr.models.numerics.differentiation import carried, differentiate, response
from dampyr.records.record import Record

PER_TEST_FREQUENCY = 15.0  # Hz per Hz of the test: the harmonics of a distorted sine are kept
WITHOUT_CYCLES = 0.2  # of the sampling rate: the noise of the derivative grows with the frequency beyond it


def default_bandwidth(record: Record) -> float:
    """15 times the measured frequency, Hz, at most a fifth of the sampling rate; that without cycles."""
    from dampyr.records.cycle_analysis.cycles import cycle_bounds

    max_bandwidth = WITHOUT_CYCLES / record.dt
    spans = cycle_bounds(record)
    if not spans:
        return max_bandwidth
    rate = len(spans) / float(record.time[spans[-1][1]] - record.time[spans[0][0]])
    return min(PER_TEST_FREQUENCY * rate, max_bandwidth)


def check_bandwidth(records: Sequence[Record], bandwidth_hz: float) -> None:
    """InputError, naming a record, where one's samples do not carry this bandwidth of the velocity in Hz."""
    spans = [(record, *carried(record.dt, float(record.time[-1] - record.time[0]))) for record in records]
    lowest, highest = max(spans, key=lambda span: span[1]), min(spans, key=lambda span: span[2])
    if not bandwidth_hz <= highest[2]:
        record, limit, repair = highest[0], highest[2], f"lower it to {highest[2]:.4g} Hz or less"
        carry = f"samples {record.dt:.4g} s apart carry at most {limit:.4g} Hz"
    elif bandwidth_hz < lowest[1]:
        record, limit, repair = lowest[0], lowest[1], f"raise it to {lowest[1]:.4g} Hz or more"
        carry = f"{record.time[-1] - record.time[0]:.4g} s of samples carry at least {limit:.4g} Hz"
    else:
        return
    raise InputError(f"{record.name}: a bandwidth of {bandwidth_hz:g} Hz is not allowed, as its {carry}; {repair}")


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


__all__ = ["check_bandwidth", "default_bandwidth", "differentiate", "response", "with_velocity"]
