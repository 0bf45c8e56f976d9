"""What a reader of a fit should know besides its numbers, each in one line."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from dampyr.identification.fit_data import Piece
from dampyr.identification.problem import Problem
from dampyr.identification.uncertainty import MIN_CYCLES, MIN_RECORDS, Uncertainty
from dampyr.identification.variable_projection import Outcome
from dampyr.models.damper import INPUTS

MIN_STEPS = 25  # of the displacement's resolution over the stroke
SLIDING = 1.0  # rho times the peak-to-peak stroke above which friction comes near its limit


def notes(
    problem: Problem, outcome: Outcome, uncertainty: Uncertainty, labels: list[str], within: Mapping[str, int]
) -> list[str]:
    """All notes: on the parameters, of which one or two records alone speak of those ``within``, on the motion, on single
    records."""
    return [
        *_of_parameters(problem, outcome, uncertainty, labels),
        *_of_few_records(problem, uncertainty, labels, within),
        *_of_motion(problem, outcome),
        *_of_records(problem),
    ]


def _of_parameters(problem: Problem, outcome: Outcome, uncertainty: Uncertainty, labels: list[str]) -> list[str]:
    notes = [
        f"{labels[k]} stands at its limit ({_limit(problem, k)}); its error is not known" for k in outcome.at_limit
    ]
    blind = [labels[k] for k in uncertainty.blind]
    if blind:
        notes.append(f"the records do not determine {', '.join(blind)} (infinite error)")
    if uncertainty.few:
        few = ", ".join(labels[k] for k in uncertainty.few)
        words = f"fewer than {MIN_CYCLES} cycles speak of them; record more"
        notes.append(f"the errors of {few} are not known (infinite): {words}")
    errors = np.sqrt(np.diag(uncertainty.covariance))
    vague = [k for k in np.flatnonzero(errors > np.abs(outcome.point.theta)) if np.isfinite(errors[k])]
    if vague:
        notes.append(
            f"the error of {', '.join(labels[k] for k in vague)} is larger than the value: the records hardly hold it"
        )
    return notes


def no_interval(count: int) -> str:
    """Why a number that only ``count`` records speak of has no interval."""
    return f"between-record variance is not estimated from {count} record{'s' * (count > 1)}"


def _of_few_records(
    problem: Problem, uncertainty: Uncertainty, labels: list[str], within: Mapping[str, int]
) -> list[str]:
    """Errors that rest on the cycles of one or two records."""
    notes = []
    inputs = {round(float(np.mean(p.u)), 6) for p in problem.pieces}
    where = f"at {'this' if len(inputs) == 1 else 'each'} {INPUTS[problem.pieces[0].unit]}"
    for count in sorted(set(within.values())):
        some = [label for label in labels if within.get(label) == count]
        errors = "the errors" if len(some) == len(labels) else f"the errors of {', '.join(some)}"
        notes.append(
            f"{no_interval(count)}: {errors} hold within these records only and give no 95 % interval; record "
            f"{MIN_RECORDS} or more {where}"
        )
    few = min((int(uncertainty.counts[labels.index(label)]) for label in within), default=10)
    if few < 10:
        notes.append(f"errors rest on {few} cycles only; they are rough")
    return notes


def _limit(problem: Problem, k: int) -> str:
    return [c.quantity.range_in_words() for c in problem.columns for _ in range(c.size)][k]


def _of_motion(problem: Problem, outcome: Outcome) -> list[str]:
    """Friction that never comes near its limit: only the slope of the loop is seen, the product of kw and rho."""
    stroke = max(float(np.ptp(one.x)) for one in problem.pieces)
    notes = []
    values = dict(zip((c.name for c in problem.columns), outcome.point.of(problem), strict=True))
    for part in problem.composition.parts:
        if not {"kw", "rho"} <= set(part.parameters) or values[f"{part.name}.rho"].size == 0:
            continue
        reach = float(np.max(values[f"{part.name}.rho"])) * stroke
        if reach < SLIDING:
            notes.append(
                f"{part.name}: the motion never leaves pre-sliding (rho times the stroke is {reach:.2g}, sliding needs 1 "
                f"or more): kw and rho are known only as a product; use larger amplitudes"
            )
    return notes


def _of_records(problem: Problem) -> list[str]:
    notes = [
        f"{one.name}: its loops create energy; is the force's sign inverted?"
        for one in problem.pieces
        if energy(one) < 0
    ]
    for one in problem.pieces:
        levels = np.unique(one.x).size
        if levels < MIN_STEPS:
            notes.append(
                f"{one.name}: the displacement takes only {levels} values over {1e3 * float(np.ptp(one.x)):.3g} mm; its "
                f"resolution hides the loop, so use an amplitude of {MIN_STEPS} steps or more"
            )
    return notes


def energy(one: Piece) -> float:
    """The work on the damper along a record, J; below 0 it gives energy."""
    return float(np.trapezoid(one.force - np.mean(one.force), one.x - np.mean(one.x)))


def trouble_of(problem: Problem, outcome: Outcome) -> str:
    """Why the numbers are no damper although the search has ended; empty where they are one."""
    positive = np.concatenate([np.full(c.size, c.quantity.linear and c.quantity.low == 0) for c in problem.columns])
    friction = set(map(int, np.flatnonzero(positive)))
    if friction and friction <= set(outcome.at_limit) and all(energy(one) < 0 for one in problem.pieces):
        return (
            "every friction stands at its limit 0, because the loops create energy: the force sign is inverted; turn it "
            "round where the records are read"
        )
    return ""
