"""From where a search begins: the parts' own proposals, tried at each input."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from dampyr.identification.pieces import Piece
from dampyr.identification.problem import Point, Problem
from dampyr.identification.solver import projected_cost
from dampyr.models.part import Scale

MOST_STARTS = 48
SCANNED_SAMPLES = 4000


def begin(problem: Problem) -> Point:
    """From where the search begins: the best of the parts' proposals, tried at each input apart."""
    neutral = _neutral(problem)
    groups: dict[float, list[int]] = {}
    for k, one in enumerate(problem.pieces):
        groups.setdefault(float(np.mean(one.u)), []).append(k)
    best = {u: _best_start(problem, neutral, members) for u, members in groups.items()}
    theta = neutral.theta.copy()
    inputs = np.array(sorted(best))
    for column, span in zip(problem.columns, problem.slices, strict=True):
        key = column.name
        if column.size and all(key in best[u] for u in inputs):
            values = np.array([best[u][key] for u in inputs])
            theta[span] = [values[int(np.argmin(np.abs(inputs - knot)))] for knot in column.knots]
            if column.kind == "constant":
                theta[span] = float(np.median(values))
    return replace(neutral, theta=theta)


def _neutral(problem: Problem) -> Point:
    theta = np.concatenate(
        [np.full(c.size, max(c.quantity.low, 0.0) + 1e-9 * c.quantity.open_low) for c in problem.columns]
    )
    local = np.zeros((len(problem.pieces), problem.locals))
    if "offset" in problem.common:
        local[:, 0] = [float(np.mean(p.force)) for p in problem.pieces]
    return Point(theta, local)


def _best_start(problem: Problem, neutral: Point, members: list[int]) -> dict[str, float]:
    """The proposal with the lowest cost on the records at one input, of which at most two are tried, shortened."""
    chosen = members[:: max(1, len(members) // 2)][:2]
    pieces = [_shortened(problem.pieces[k]) for k in chosen]
    inputs = [float(np.mean(p.u)) for p in pieces]
    singles = [replace(c, kind="constant", knots=(inputs[0],)) for c in problem.columns]
    small = Problem(problem.composition, singles, pieces, problem.nuisances)
    at = _neutral(small)
    best: tuple[float, dict[str, float]] = (np.inf, {})
    for proposal in _proposals(problem, pieces):
        theta = at.theta.copy()
        for column, span in zip(singles, small.slices, strict=True):
            if column.size and column.name in proposal:
                theta[span] = proposal[column.name]
        cost = projected_cost(small, replace(at, theta=theta))
        if cost < best[0]:
            best = (cost, proposal)
    return best[1]


def _shortened(one: Piece) -> Piece:
    n = min(one.t.size, SCANNED_SAMPLES)
    u = one.u[:n] if np.ndim(one.u) else one.u  # type: ignore[index]
    return replace(one, t=one.t[:n], x=one.x[:n], v=one.v[:n], force=one.force[:n], u=u, cycle=one.cycle[:n])


def _proposals(problem: Problem, pieces: list[Piece]) -> list[dict[str, float]]:
    stroke = float(np.median([np.ptp(p.x) for p in pieces]))
    speed = float(np.median([np.quantile(np.abs(p.v), 0.95) for p in pieces]))
    scale = Scale(stroke, max(speed, 1e-9), float(np.median([np.median(np.diff(p.t)) for p in pieces])))
    lists = [
        [{f"{p.name}.{key}": value for key, value in start.items()} for start in p.starts(scale)]
        for p in problem.composition.parts
    ]
    joined = [{k: v for part in combination for k, v in part.items()} for combination in itertools.product(*lists)]
    return joined[:MOST_STARTS]
