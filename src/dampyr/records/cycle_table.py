"""Every whole cycle of a record by itself: what a damper dynamometer prints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dampyr.records.cycles import require_cycles
from dampyr.records.force_offset import mean_force
from dampyr.records.measure import cycle_energies
from dampyr.records.record import Record
from dampyr.records.velocity import default_bandwidth, differentiate


@dataclass(frozen=True)
class Cycle:
    """One whole cycle, SI.

    ``start_s`` and ``period_s``; ``stroke_m`` from its lowest to its highest point; ``least_force`` and ``largest_force``;
    ``energy`` dissipated, J. The peak-velocity pick-up: ``speed_out`` and ``speed_in`` are the largest velocities of extension
    (positive) and compression (negative), m/s, ``force_out`` and ``force_in`` the forces at those moments less the offset of
    the record, N.
    """

    start_s: float
    period_s: float
    stroke_m: float
    least_force: float
    largest_force: float
    energy: float
    speed_out: float
    force_out: float
    speed_in: float
    force_in: float


def cycle_table(record: Record, offset: float | None = None) -> list[Cycle]:
    """The whole cycles in their order; the velocity is derived as :func:`~dampyr.records.measure` derives it.

    ``offset`` in N is taken from the forces at peak velocity; None takes the record's mean force over its whole cycles. Raises
    InputError where there is no whole cycle.
    """
    spans = require_cycles(record, "a table of cycles")
    speed = differentiate(record.time, record.displacement, default_bandwidth(record))
    energies, zero = cycle_energies(record, spans), mean_force(record) if offset is None else offset
    table = []
    for (i0, i1), energy in zip(spans, energies, strict=True):
        x, f, v = record.displacement[i0 : i1 + 1], record.force[i0 : i1 + 1], speed[i0 : i1 + 1]
        out, back = int(np.argmax(v)), int(np.argmin(v))
        table.append(
            Cycle(
                start_s=float(record.time[i0]),
                period_s=float(record.time[i1] - record.time[i0]),
                stroke_m=float(np.ptp(x)),
                least_force=float(f.min()),
                largest_force=float(f.max()),
                energy=float(energy),
                speed_out=float(v[out]),
                force_out=float(f[out] - zero),
                speed_in=float(v[back]),
                force_in=float(f[back] - zero),
            )
        )
    return table
