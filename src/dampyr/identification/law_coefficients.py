"""From the numbers of a fit to the coefficients of its damper's laws, and the dampers that they make."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.identification.problem import Problem
from dampyr.models import Damper

Array = NDArray[np.float64]


def law_matrix(problem: Problem) -> Array:
    """The matrix (C, G) from the fitted numbers to the coefficients of all laws; rows of fixed parameters are zero."""
    owners = [problem.columns[k] for k in problem.owners]
    T = np.zeros((sum(max(c.size, 1) for c in owners), problem.size))
    row = 0
    for column, k in zip(owners, problem.owners, strict=True):
        if column.size:
            T[row : row + column.size, problem.slices[k]] = column.to_coefficients()
        row += max(column.size, 1)
    return T


def law_coefficients(problem: Problem, theta: Array) -> Array:
    """The coefficients (C,) of all laws, in the order of the parameters, of the fitted numbers ``theta`` (G,)."""
    owners = [problem.columns[k] for k in problem.owners]
    fixed = [np.zeros(c.size) if c.size else np.array([c.fixed], dtype=float) for c in owners]
    return np.asarray(np.concatenate(fixed) + law_matrix(problem) @ theta)


def admissible_damper(damper: Damper, problem: Problem, theta: Array) -> Damper | None:
    """``damper`` with other fitted numbers; None where they leave its allowed values, such as between the knots of a law."""
    try:
        return damper.with_coefficients(law_coefficients(problem, theta))
    except InputError:
        return None
