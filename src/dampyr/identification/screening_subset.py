"""The small set of short records on which many models are tried before a few are tried on all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dampyr.records import Record, cycles, default_bandwidth, measure, motion_start, with_velocity

PER_INPUT = 4
MAX_SAMPLES = 600
SHORTEST = 5.0  # s
MIN_CYCLES = 4
SAMPLES_PER_BANDWIDTH = 4.0


def screening_set(records: Sequence[Record], bandwidth: float | None = None) -> list[Record]:
    """At most four records of each input, from the smallest to the largest peak speed, shortened and thinned.

    Each has a velocity: as recorded, or derived with ``bandwidth`` Hz (its own by default where it has none) before samples are
    left out, as the rest of a slow record would not carry the bandwidth of a fast one.
    """
    groups: dict[float, list[Record]] = {}
    for record in records:
        groups.setdefault(float(record.input_value or 0.0), []).append(record)
    chosen: list[Record] = []
    for _, some in sorted(groups.items()):
        ranked = sorted(some, key=_speed)
        places = np.unique(np.round(np.linspace(0, len(ranked) - 1, PER_INPUT)).astype(int))
        chosen += [shortened(_moving(ranked[k], bandwidth)) for k in places]
    return chosen


def _moving(record: Record, bandwidth: float | None) -> Record:
    return record if record.velocity is not None and bandwidth is None else with_velocity(record, bandwidth)


def _speed(record: Record) -> float:
    return float(np.sqrt(np.mean(np.gradient(record.displacement, record.time) ** 2)))


def shortened(record: Record) -> Record:
    """The first five seconds or four cycles of the motion, whichever is longer, with no more samples than the motion needs.

    Samples are left out evenly, never averaged; the sampling rate stays four times the bandwidth of the motion.
    """
    start = motion_start(record)
    wanted = SHORTEST
    if cycles(record):
        wanted = max(SHORTEST, MIN_CYCLES / measure(record).frequency_hz)
    short = record.until(min(start + wanted, float(record.time[-1]))) if start + wanted > record.time[0] else record
    rate = SAMPLES_PER_BANDWIDTH * default_bandwidth(record)
    stride = max(1, min(short.n // MAX_SAMPLES, int(1.0 / (rate * record.dt))))
    return short.thinned(stride)
