"""Fits of the published campaign: Dahl to each record, and a model of long valleys, against scipy over the same kernel."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.errors import DampyrWarning
from dampyr.identification import fit
from dampyr.identification.fits.least_squares import prepared
from dampyr.identification.search.fit_data import Piece, piece
from dampyr.identification.search.initial_guess import begin
from dampyr.identification.search.normal_equations import modelled_force
from dampyr.identification.search.problem import Problem, SearchPoint
from dampyr.models import compose
from dampyr.models.path_integration import along
from dampyr.records import Record, read_campaign

JOINT = "dampyr, one joint fit of all records with dahl + hyperbolic_tangent + spring + delay"
HARD = "modified_bouc_wen"
HARD_JOINT = f"dampyr, one joint fit of all records with {HARD}"
HARD_ONE = f"dampyr fit of one record with {HARD}"
HARD_PEER = f"scipy least_squares with {HARD}, from the same start"
COMPOSITION = "dahl + hyperbolic_tangent + spring + delay"
FIXED = {"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.s": 0.0}
PEER = "scipy least_squares, finite differences, no errors"
TITLE = "Dahl fit of each record of the published campaign (kx, kw, rho, the force's offset and the initial state)"


def run(data: Path | None) -> list[Line] | str:
    """`fit` with its choice of a start and its standard errors; least squares from one start, which gives no errors."""
    folder = data / "labcontrol-mr-damper" if data else None
    if folder is None or not folder.is_dir():
        return "the campaign's files are not on this machine; `dampyr datasets fetch labcontrol` gets them"
    records = read_campaign(folder)
    ours = np.array([identified(record) for record in records])
    peers = np.array([searched(piece(record, None)) for record in records])
    apart = np.max(np.abs(peers / ours - 1.0), axis=1)
    agree = f"{np.sum(apart < 1e-3)} of {len(records)} agree to 0.1 % in kx, kw and rho (median {np.median(apart):.0e})"
    contenders = {
        f"dampyr fit, {len(records)} records, with errors": lambda: [identified(record) for record in records],
        PEER: lambda: [searched(piece(record, None)) for record in records],
    }
    lines = race(contenders, {PEER: agree}, rounds=5)
    each = lines[0]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)  # sigma below 1/2, in every round
        difficult = hard(records)
    return [
        *lines,
        *race({JOINT: lambda: fit(records, COMPOSITION, bandwidth=8.0, fixed=FIXED)}, {}, rounds=3),
        Line("dampyr fit, per record", each.median / len(records), each.fastest / len(records), each.rounds),
        *difficult,
    ]


def hard(records: list[Record]) -> list[Line]:
    """The model with the most parameters that are hard to tell apart: one record, against the peer, and the campaign."""
    record = next(record for record in records if float(np.mean(np.asarray(record.voltage))) > 1.5)
    problem = prepared(HARD, [record])
    start = begin(problem)
    ours, (cost, evaluations) = fit(record, HARD), valley(problem, start)
    steps_and_end = (
        f"sum of squares {cost / ours.outcome.cost:.4g} times that of dampyr, which says {ours.reason.partition(':')[0]!r}; "
        f"{evaluations} evaluations"
    )
    contenders = {HARD_ONE: lambda: fit(record, HARD), HARD_PEER: lambda: valley(problem, start)}
    joint = [f"{HARD_JOINT}{more}" for more in ("", " + compliance", " + delay")]
    return [
        *race(contenders, {HARD_PEER: steps_and_end}, rounds=3),
        *race(
            {name: lambda name=name: fit(records, name.partition("with ")[2]) for name in joint},
            {},
            rounds=3,
            budget=30.0,
        ),
    ]


def valley(problem: Problem, start: SearchPoint) -> tuple[float, int]:
    """The cost that scipy comes to, and its evaluations: all unknowns in their scale at the start, finite differences."""
    nuisances = problem.locals
    theta = np.where(
        np.abs(start.theta) > 1e-6, start.theta, 100.0
    )  # kw and k1, which the start leaves to be solved for
    scale = np.concatenate((np.full(1, problem.pieces[0].spread), np.ones(nuisances - 1), np.abs(theta)))
    low, high = map(np.concatenate, zip(problem.local_limits, problem.inner_limits, strict=True))

    def residual(z: Any) -> Any:
        values = z * scale
        at = SearchPoint(values[nuisances:], values[None, :nuisances])
        one = problem.pieces[0]
        return one.weight * (one.force - modelled_force(problem, at, 0))

    from scipy.optimize import least_squares

    first = np.clip(np.concatenate((start.local[0], theta)), low, high)
    solution = least_squares(
        residual, first / scale, bounds=(low / scale, high / scale), xtol=1e-10, ftol=1e-8, gtol=1e-10, max_nfev=300
    )
    return float(solution.cost), int(solution.nfev + solution.njev * scale.size)


def identified(record: Record) -> list[float]:
    """kx, kw and rho by dampyr."""
    return list(fit(record, "dahl").parameters.values())


def searched(one: Piece) -> list[float]:
    """kx, kw and rho by least squares over offset, w(0) and these three, scaled, with derivatives by finite differences."""
    from scipy.optimize import least_squares

    composition = compose("dahl")
    middle, reach = float(np.mean(one.force)), 0.5 * float(np.ptp(one.force))
    scale = np.array([1000.0, reach, 10.0 / float(np.ptp(one.x)), reach, 1.0])

    def residual(z: Any) -> Any:
        kx, kw, rho, f0, w0 = z * scale
        model = along(composition, one.t, one.x, one.v, np.array([kx, kw, rho]), np.array([w0]))
        return (middle + f0 + model - one.force) / reach

    low, high = [0.0, 1e-9, 1e-9, -np.inf, -1.0], [np.inf, np.inf, np.inf, np.inf, 1.0]
    solution = least_squares(
        residual, [1.0, 0.8, 1.0, 0.0, 0.0], bounds=(low, high), xtol=1e-10, ftol=1e-10, gtol=1e-10
    )
    return [float(value) for value in (solution.x * scale)[:3]]
