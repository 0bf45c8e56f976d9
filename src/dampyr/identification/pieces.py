"""The records as a fit sees them, and what one record says about the parameters, compressed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.identification.design import Column
from dampyr.models import Composition
from dampyr.models.march import along_with_columns, delayed, delayed_by_tau
from dampyr.records import Record, cycles, motion_start

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Piece:
    """One record from where its motion starts: arrays (n,), the input, a weight, and the clusters of its samples."""

    name: str
    t: Array
    x: Array
    v: Array
    force: Array
    u: Array | float
    weight: float
    cycle: NDArray[np.int64]
    unit: str


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
        t=record.time[kept],
        x=record.displacement[kept],
        v=record.velocity[kept],
        force=force,
        u=given,
        weight=1.0 / spread,
        cycle=_cycle_numbers(record)[kept],
        unit=record.input,
    )


def _cycle_numbers(record: Record) -> NDArray[np.int64]:
    """Which cycle each sample belongs to; what comes before and after joins the nearest."""
    starts = np.array([i0 for i0, _ in cycles(record)], dtype=int)
    if starts.size == 0:
        return np.zeros(record.n, dtype=np.int64)
    return np.maximum(np.searchsorted(starts, np.arange(record.n), side="right") - 1, 0).astype(np.int64)


@dataclass(frozen=True)
class Start:
    """The nuisances of one record: the offset of its force in N and the states at its start."""

    offset: float
    states: Array


@dataclass(frozen=True)
class Linearised:
    """One record around a point: weighted residual (n,), derivatives by parameters (n, P) and by nuisances (n, L)."""

    residual: Array
    by_parameter: Array
    by_nuisance: Array


def parameters_at(columns: list[Column], theta: list[Array], u: Array | float) -> Array:
    """The parameter vector (P,), or (n, P) where the input varies."""
    return np.stack([c.value(th, u) for c, th in zip(columns, theta, strict=True)], axis=-1)


def linearise(
    composition: Composition,
    columns: list[Column],
    theta: list[Array],
    one: Piece,
    start: Start,
    offset: bool,
) -> Linearised:
    """The residual (measured less model) of one record, and its exact derivatives."""
    values = parameters_at(columns, theta, one.u)
    model, J = along_with_columns(composition, one.t, one.x, one.v, values, start.states)
    k = composition.delay
    if k is not None:
        model, J = _delay(one.t, model, J, values[..., k], k)
    P = len(composition.parameters)
    local = J[:, P:]
    if offset:
        local = np.column_stack((np.ones(one.t.size), local))
    residual = one.force - model - start.offset
    return Linearised(one.weight * residual, one.weight * J[:, :P], one.weight * local)


def _delay(t: Array, model: Array, J: Array, tau: Array, k: int) -> tuple[Array, Array]:
    """The force and its columns as they were tau earlier, with the derivative by tau in its place."""
    late = delayed(t, J, tau).copy()
    late[:, k] = delayed_by_tau(t, model, tau)
    return delayed(t, model, tau), late
