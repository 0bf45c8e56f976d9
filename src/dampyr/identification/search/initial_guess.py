"""The initial guess of a search: the parts' own proposals, tried at each input."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from dampyr.identification.search.fit_data import Piece, thinned
from dampyr.identification.search.problem import Problem, SearchPoint, independent_blocks
from dampyr.identification.search.variable_projection import (
    COARSE_TOLERANCE,
    levenberg_marquardt,
    projected_cost,
    search,
)
from dampyr.identification.search.work import Work
from dampyr.models.codegen.composition import Composition
from dampyr.models.part import Scale

MAX_STARTS = 48  # proposals that are tried: each costs one evaluation of two shortened records
THINNED_SAMPLES = 1500  # of each record in the searches of several starts
SAME = 1e-3  # of the cost: within it two starts ended in the same optimum
START_SPREAD = 1.0  # standard deviation of the logarithm by which random starts differ from the best
SCANNED_SAMPLES = 3000  # of each record on which the proposals are tried


def begin(problem: Problem, work: Work | None = None) -> SearchPoint:
    """The point where the search begins: the best of the parts' proposals, tried at each input separately.

    Parts in series with something that stretches begin where they end without it. What it takes is counted as ``work``.
    """
    work = Work() if work is None else work
    if problem.composition.in_series:
        return _begin_from_rigid(problem, work)
    neutral = _make_neutral(problem)
    groups: dict[float, list[int]] = {}
    for k, piece in enumerate(problem.pieces):
        groups.setdefault(float(np.mean(piece.u)), []).append(k)
    best = {u: _choose_start(problem, members, work) for u, members in groups.items()}
    theta = neutral.theta.copy()
    inputs = np.array(sorted(best))
    for column, span in zip(problem.columns, problem.slices, strict=True):
        key = column.name
        if column.size and all(key in best[u] for u in inputs):
            values = np.array([best[u][key] for u in inputs])
            at_knots = [values[int(np.argmin(np.abs(inputs - knot)))] for knot in column.knots]
            theta[span] = at_knots * (2 if column.temperatures else 1)
            if column.kind == "constant":
                theta[span] = float(np.median(values))
    return replace(neutral, theta=theta)


def _begin_from_rigid(problem: Problem, work: Work) -> SearchPoint:
    """The fit without what stretches, and a stretch that is small against the stroke."""
    soft = [p.name for p in problem.composition.parts if p.stretch]
    chosen = [k for k, c in enumerate(problem.columns) if c.name.partition(".")[0] not in soft]
    inner = Composition(tuple(name for name in problem.composition.names if name not in soft))
    columns = [replace(problem.columns[k], quantity=inner.quantities[problem.columns[k].name]) for k in chosen]
    rigid = replace(problem, composition=inner, columns=columns)
    rigid_point = search(rigid, begin(rigid, work), tolerance=COARSE_TOLERANCE, work=work).point
    point = _apply_proposal(problem, _make_neutral(problem), _list_proposals(problem, problem.pieces)[0])
    theta, local = point.theta.copy(), point.local.copy()
    for k, span in zip(chosen, rigid.slices, strict=True):
        theta[problem.slices[k]] = rigid_point.theta[span]
    local[:, : rigid.locals] = rigid_point.local
    return SearchPoint(problem.inside(theta), local)


def _make_neutral(problem: Problem) -> SearchPoint:
    theta = np.maximum(problem.inner_limits[0], 0.0)
    local = np.zeros((len(problem.pieces), problem.locals))
    if "offset" in problem.common:
        local[:, 0] = [float(np.mean(p.force)) for p in problem.pieces]
    return SearchPoint(theta, local)


def search_several_starts(problem: Problem, starts: int, seed: int, work: Work) -> tuple[SearchPoint, int]:
    """The best of several starts, and how many ended in the same optimum (in the block where fewest did).

    Each independent block has its own starts: that of a single start, so that several are never worse, then the parts'
    proposals, the best first, and random points around the best by ``seed``; searched on thinned records, to 1e-4 of the cost.
    """
    point, agreed = begin(problem, work), starts
    theta, local = point.theta.copy(), point.local.copy()
    for k, block in enumerate(independent_blocks(problem)):
        rng = np.random.default_rng([seed, k])
        thin = replace(block.problem, pieces=[thinned(piece, THINNED_SAMPLES) for piece in block.problem.pieces])
        single = SearchPoint(point.theta[block.coefficients], point.local[block.records])
        points = [single, *_choose_starts(thin, starts - 1, rng, work)]
        ends = [levenberg_marquardt(thin, start, None, COARSE_TOLERANCE, work=work) for start in points]
        best = min(ends, key=lambda end: end.cost)
        agreed = min(agreed, sum(end.cost <= (1.0 + SAME) * best.cost + 1e-12 for end in ends))
        theta[block.coefficients], local[block.records] = best.point.theta, best.point.local
    return SearchPoint(theta, local), agreed


def _choose_starts(problem: Problem, starts: int, rng: np.random.Generator, work: Work) -> list[SearchPoint]:
    """The best proposals in their order, then random points around the first."""
    neutral = _make_neutral(problem)
    points = [_apply_proposal(problem, neutral, proposal) for proposal in _list_proposals(problem, problem.pieces)]
    points.sort(key=lambda point: projected_cost(problem, point, work))
    start_points = points[:starts]
    nonlinear = problem.is_logarithmic | ~problem.is_linear
    while len(start_points) < starts:
        factor = np.exp(START_SPREAD * rng.standard_normal(problem.size))
        start_points.append(
            replace(points[0], theta=problem.inside(np.where(nonlinear, points[0].theta * factor, points[0].theta)))
        )
    return start_points


def _apply_proposal(problem: Problem, neutral: SearchPoint, proposal: dict[str, float]) -> SearchPoint:
    theta = neutral.theta.copy()
    for column, span in zip(problem.columns, problem.slices, strict=True):
        if column.size and column.name in proposal:
            theta[span] = proposal[column.name]
    return replace(neutral, theta=problem.inside(theta))


def _choose_start(problem: Problem, members: list[int], work: Work) -> dict[str, float]:
    """The proposal with the lowest cost on the records at one input, of which at most two are tried, shortened."""
    chosen = members[:: max(1, len(members) // 2)][:2]  # the first and one of the middle: in campaigns, two motions
    pieces = [p.part(slice(max(SCANNED_SAMPLES, p.shortest))) for p in (problem.pieces[k] for k in chosen)]
    inputs = [float(np.mean(p.u)) for p in pieces]
    singles = [replace(c, kind="constant", knots=(inputs[0],), temperatures=None) for c in problem.columns]
    small = Problem(problem.composition, singles, pieces, problem.nuisances)
    at = _make_neutral(small)
    best: tuple[float, dict[str, float]] = (np.inf, {})
    for proposal in _list_proposals(problem, pieces):
        cost = projected_cost(small, _apply_proposal(small, at, proposal), work)
        if cost < best[0]:
            best = (cost, proposal)
    return best[1]


def _list_proposals(problem: Problem, pieces: list[Piece]) -> list[dict[str, float]]:
    stroke = float(np.median([np.ptp(p.x) for p in pieces]))
    speed = float(np.median([np.quantile(np.abs(p.v), 0.95) for p in pieces]))
    force = float(np.median([np.quantile(np.abs(p.force - np.mean(p.force)), 0.95) for p in pieces]))
    dt = float(np.median([np.median(np.diff(p.t)) for p in pieces]))
    scale = Scale(stroke, max(speed, 1e-9), dt, force)
    lists = [
        [{f"{p.name}.{key}": value for key, value in start.items()} for start in p.starts(scale)]
        for p in problem.composition.parts
    ]
    joined = [{k: v for part in combination for k, v in part.items()} for combination in itertools.product(*lists)]
    return joined[:MAX_STARTS]
