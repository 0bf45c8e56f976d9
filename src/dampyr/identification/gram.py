"""What the records say about the unknowns around a point: sums of products of derivatives and residuals.

The sums are taken while the kernel walks along a record, so the derivatives are never stored. They are the normal
equations of the record; what is lost against an orthogonal factorisation are directions whose derivatives agree to one part
in a million, which the records do not determine anyway (see `dampyr.identification.uncertainty`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dampyr.identification.fit_data import Piece
from dampyr.identification.problem import MISFIT, PRIOR, Point, Problem, is_viscous, values_at
from dampyr.models.input_lag import lagged
from dampyr.models.path_integration import (
    acceleration,
    along,
    along_with_columns,
    along_with_laws,
    delayed,
    delayed_by_tau,
    products_along,
)

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
NONE = np.empty(0)
LAG_STEP = 1e-6  # s, of the difference that gives the derivative by a lag


@dataclass(frozen=True)
class Plan:
    """Which columns the kernel sums for a record.

    ``source`` (C,) and ``factor`` (1 or n, C) as in `dampyr.models.path_integration.products_along`; ``parameter`` (C,)
    says which parameter a column belongs to, or -1; ``to_unknowns`` (C + 1, L + G + 1) how the unknowns' columns come of
    them.
    """

    source: Integers
    factor: Array
    parameter: Integers
    to_unknowns: Array


def plans(problem: Problem) -> list[Plan]:
    """One plan per record; kept with the problem."""
    cached: list[Plan] | None = problem.__dict__.get("_plans")
    if cached is None:
        cached = problem.__dict__["_plans"] = [_plan(problem, one) for one in problem.pieces]
    return cached


def _plan(problem: Problem, one: Piece) -> Plan:
    P, S, L, G = len(problem.columns), problem.composition.n_states, problem.locals, problem.size
    source, factors, parameter, targets = [], [], [], []
    for k, name in enumerate(problem.common):
        if name != "temperature":
            source.append(P + S + (name == "offset"))
            targets.append({k: 1.0})
    for j, place in enumerate(problem.composition.free_at_start if problem.states else ()):
        source.append(P + place)
        targets.append({len(problem.common) + j: 1.0})
    parameter += [-1] * len(source)
    factors += [np.ones(1)] * len(source)
    for k, factor, target in _entries(problem, one):
        source.append(k)
        parameter.append(k)
        factors.append(factor)
        targets.append({L + at: value for at, value in target.items()})
    matrix = np.zeros((len(source) + 1, L + G + 1))
    for row, target in enumerate(targets):
        for at, value in target.items():
            matrix[row, at] = value
    matrix[-1, -1] = 1.0
    varies = any(factor.size > 1 for factor in factors)
    width = np.column_stack(np.broadcast_arrays(*factors)) if varies else np.concatenate((*factors, NONE))[None]
    return Plan(np.array(source, dtype=np.int64), np.ascontiguousarray(width), np.array(parameter), matrix)


def _entries(problem: Problem, one: Piece) -> list[tuple[int, Array, dict[int, float]]]:
    """The columns of the parameters: which one, its factor along the record, and the coefficients it speaks of."""
    entries: list[tuple[int, Array, dict[int, float]]] = []
    viscous = is_viscous(problem) & ("temperature" in problem.common)
    for k, owner in enumerate(problem.owners):
        column, span = problem.columns[owner], problem.slices[owner]
        if column.size == 0:
            if viscous[k]:
                entries.append((k, np.ones(1), {}))
            continue
        basis = np.atleast_2d(column.basis(one.u))
        if problem.varying:
            entries += [(k, basis[:, j], {span.start + j: 1.0}) for j in range(column.size)]
        else:
            entries.append((k, np.ones(1), {span.start + j: float(b) for j, b in enumerate(basis[0]) if b != 0.0}))
    return entries


def products(problem: Problem, point: Point, by_cluster: bool = False) -> list[Array]:
    """The sums of products of each record over [nuisances, coefficients, residual], (groups, K, K) with K = L + G + 1.

    One group, or one per cluster of the record's samples. The residual is measured less model.
    """
    late = behind(problem, point)
    by_lag = [_by_lag(problem, point, r) for r in range(len(problem.pieces))]
    return [_of_record(late, point, r, plan, by_cluster, by_lag[r]) for r, plan in enumerate(plans(late))]


def _of_record(
    problem: Problem, point: Point, r: int, plan: Plan, by_cluster: bool, by_lag: Array | None = None
) -> Array:
    one = problem.pieces[r]
    values, gain = values_at(problem, point, r), point.nuisance(problem, r, "gain")
    factor, matrix = _by_point(problem, point, r, plan, values, gain)
    states, ends = point.states(problem, r), one.ends if by_cluster else np.array([one.t.size])
    force = one.force - point.nuisance(problem, r, "offset")
    together = problem.composition.delay is not None or problem.composition.n_states or by_lag is not None
    if values.ndim > 1 and together:
        sums = _stored(problem, one, values, states, force, plan.source, factor, gain, ends, by_lag)
    else:
        path = (one.t, one.x, one.v, _acceleration(problem, one))
        sums = products_along(
            problem.composition, path, values, states, force, one.weight, plan.source, factor, gain, ends
        )
    return np.asarray(matrix.T @ sums @ matrix)


def behind(problem: Problem, point: Point, more: float = 0.0) -> Problem:
    """The problem with inputs that lag behind their commands by the lag of the point and ``more``; itself without a lag."""
    k = problem.composition.lag
    if k is None or not problem.varying:
        return problem
    tau = float(problem.columns[k].value(point.of(problem)[k], 0.0)) + more
    return replace(problem, pieces=[replace(one, u=lagged(one.t, one.u, tau)) for one in problem.pieces])


def _by_lag(problem: Problem, point: Point, r: int) -> Array | None:
    """The derivative (n,) of the force of the parts by the lag, by a difference; None where nothing can lag."""
    if problem.composition.lag is None or not problem.varying:
        return None
    one, h = problem.pieces[r], LAG_STEP
    sides = []
    for more in (h, 0.0):
        values = values_at(behind(problem, point, more), point, r)
        sides.append(along(problem.composition, one.t, one.x, one.v, values, point.states(problem, r)))
    return np.asarray((sides[0] - sides[1]) / h)


def _acceleration(problem: Problem, one: Piece) -> Array:
    cached: Array | None = one.__dict__.get("_acceleration")
    if cached is None:
        cached = one.__dict__["_acceleration"] = acceleration(problem.composition, one.t, one.v)
    return cached


def _by_point(problem: Problem, point: Point, r: int, plan: Plan, values: Array, gain: float) -> tuple[Array, Array]:
    """The factors and the matrix of a plan with what changes from point to point: gain, temperature."""
    if not {"gain", "temperature"} & set(problem.common):
        return plan.factor, plan.to_unknowns
    factor, matrix = (
        plan.factor * np.where(plan.source == len(problem.columns) + problem.composition.n_states + 1, 1.0, gain),
        plan.to_unknowns,
    )
    if "temperature" in problem.common:
        viscous = is_viscous(problem)
        warmth = point.nuisance(problem, r, "temperature")
        mine = np.where(plan.parameter >= 0, viscous[plan.parameter], False)
        factor = factor * np.where(mine, warmth, 1.0)
        matrix = matrix.copy()
        matrix[:-1, problem.common.index("temperature")] = np.where(
            mine, _carried(problem, point, plan, values, warmth), 0.0
        )
    return np.ascontiguousarray(factor), matrix


def _carried(problem: Problem, point: Point, plan: Plan, values: Array, warmth: float) -> Array:
    """What multiplies each column so that their sum is the derivative by the logarithm of the viscosity's factor."""
    if not problem.varying:
        return np.where(plan.parameter >= 0, values[plan.parameter], 0.0) / warmth
    L = problem.locals
    theta = plan.to_unknowns[:-1, L:-1] @ point.theta
    held = np.array([problem.columns[k].fixed or 0.0 if k >= 0 else 0.0 for k in plan.parameter])
    return np.asarray(theta + held)


def _stored(
    problem: Problem,
    one: Piece,
    values: Array,
    states: Array,
    force: Array,
    source: Integers,
    factor: Array,
    gain: float,
    ends: Integers,
    by_lag: Array | None = None,
) -> Array:
    """As the kernel does it, with the derivatives stored: for an input that varies while states remember it, or a delay."""
    model, J = along_with_columns(problem.composition, one.t, one.x, one.v, values, states)
    early = np.column_stack((J, model, np.ones(one.t.size)))[:, source] * factor
    mine = source < len(problem.columns)
    if problem.composition.n_states:
        wide = np.ascontiguousarray(np.broadcast_to(factor, (factor.shape[0], source.size))[:, mine])
        given = (one.t, one.x, one.v, values, states, source[mine], wide)
        early[:, mine] = along_with_laws(problem.composition, *given)[1]
    if by_lag is not None:
        early[:, source == problem.composition.lag] = by_lag[:, None]
    k, rows = problem.composition.delay, early
    if k is not None:
        slope = delayed_by_tau(one.t, model, values[..., k])[:, None]
        rows = np.where(source == k, slope * factor, delayed(one.t, early, values[..., k]))
        model = delayed(one.t, model, values[..., k])
    table = one.weight[:, None] * np.column_stack((rows, force - gain * model))
    return np.stack([part.T @ part for part in np.split(table, ends[:-1])])


def with_priors(problem: Problem, point: Point, sums: Array) -> Array:
    """The sums (M, K, K) with what is expected of gains and temperatures: as one more row each."""
    out = sums
    for name, spread in PRIOR.items():
        if name in problem.common:
            j, row = problem.common.index(name), np.zeros((len(problem.pieces), sums.shape[1]))
            row[:, j] = MISFIT / spread
            row[:, -1] = -MISFIT / spread * point.local[:, j]
            out = out + row[:, :, None] * row[:, None, :]
    return out


def modelled(problem: Problem, point: Point, record: int) -> Array:
    """The force (n,) that the fit gives for a record, its own offset, gain and states included, N."""
    problem = behind(problem, point)
    one, values = problem.pieces[record], values_at(problem, point, record)
    force = along(problem.composition, one.t, one.x, one.v, values, point.states(problem, record))
    k = problem.composition.delay
    late = force if k is None else delayed(one.t, force, np.asarray(values[..., k]))
    return point.nuisance(problem, record, "offset") + point.nuisance(problem, record, "gain") * late
