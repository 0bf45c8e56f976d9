"""The records as a fit sees them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.records import Record, cycles, motion_start

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Piece:
    """One record from where its motion starts: arrays (n,), the input, and the cluster of each sample.

    ``weight`` is of each sample, or one for all, (1,); ``spread`` the standard deviation of the force in N. ``bend`` is the
    weight by the second derivative of a loss that is not squares (see `dampyr.identification.robust`).
    """

    name: str
    t: Array
    x: Array
    v: Array
    force: Array
    u: Array | float
    weight: Array
    spread: float
    cycle: NDArray[np.int64]
    unit: str
    bend: Array | None = None

    @property
    def ends(self) -> NDArray[np.int64]:
        """Where each cluster of samples ends."""
        return np.append(np.flatnonzero(np.diff(self.cycle)) + 1, self.t.size)


def piece(record: Record, bandwidth: float | None) -> Piece:
    """A record made ready: velocity as recorded or derived, weight 1 over the force's standard deviation."""
    from dampyr.records import with_velocity

    if record.input is None:
        raise InputError(f"{record.name}: its voltage is not known; read it with voltage= (or current=)")
    if record.velocity is None or bandwidth is not None:
        record = with_velocity(record, bandwidth)
    assert record.velocity is not None
    first = int(np.searchsorted(record.time, motion_start(record)))
    if record.n - first < 16:
        raise InputError(f"{record.name}: it holds no motion, so there is nothing to identify; check the displacement")
    kept = slice(first, None)
    force = record.force[kept]
    spread = float(np.std(force))
    if spread <= 1e-9 * max(1.0, float(np.max(np.abs(force)))):
        raise InputError(f"{record.name}: the force is constant at {force[0]:g} N; check the load cell's channel")
    u = record.voltage if record.input == "V" else record.current
    assert u is not None
    assert record.input is not None
    varies = np.ndim(u) > 0 and float(np.ptp(u)) > 1e-9
    given: Array | float = np.asarray(u)[kept] if varies else float(np.mean(u))
    return Piece(
        name=record.name,
        t=np.ascontiguousarray(record.time[kept]),
        x=np.ascontiguousarray(record.displacement[kept]),
        v=np.ascontiguousarray(record.velocity[kept]),
        force=np.ascontiguousarray(force),
        u=given,
        weight=np.array([1.0 / spread]),
        spread=spread,
        cycle=_cycle_numbers(record)[kept],
        unit=record.input,
    )


def _cycle_numbers(record: Record) -> NDArray[np.int64]:
    """Which cycle each sample belongs to; what comes before and after joins the nearest."""
    starts = np.array([i0 for i0, _ in cycles(record)], dtype=int)
    if starts.size == 0:
        return np.zeros(record.n, dtype=np.int64)
    return np.maximum(np.searchsorted(starts, np.arange(record.n), side="right") - 1, 0).astype(np.int64)
