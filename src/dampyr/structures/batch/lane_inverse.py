"""The input of a law that asks for a force, of one history of a block: the damper's model followed, and run backwards.

`dampyr.structures.wanted_force` says what is computed. A site has rows for the states of the model, its stroke, rate and input
at the latest sample, the laws of its parameters and the inputs at which the force is evaluated first; those of a history are
taken side by side for the functions that `respond` calls too. The search branches, so histories go one after the other here,
but only where the law decides.
"""

from __future__ import annotations

from math import exp
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dampyr.models.inverse import TOLERANCE, find_input, nodes
from dampyr.models.laws import look_up, polynomial_table
from dampyr.structures.control_laws import lag_of
from dampyr.structures.controller import asks_force

Array = NDArray[np.float64]
BOUND_WITH = ("dampyr.models.inverse", "dampyr.models.laws")


class SearchSizes(NamedTuple):
    """How many numbers the search of a site takes: states, parameters, pieces and powers of their laws, nodes."""

    states: int
    parameters: int
    pieces: int
    powers: int
    nodes: int

    @property
    def rows(self) -> int:
        """How many rows of a block they are."""
        return self.states + 3 + self.parameters * self.pieces * (1 + self.powers) + self.nodes

    @property
    def workspace(self) -> int:
        """How many numbers the search of one history writes to."""
        return self.rows + self.states + self.parameters + 4


def sizes_of(law: Any, damper: Any) -> SearchSizes | None:
    """The sizes of a law's search; None of one that decides on its input."""
    if not asks_force(law):
        return None
    parameters, pieces, powers = polynomial_table(damper, static=False)[1].shape
    first_inputs = nodes(damper, law.low, law.high)
    return SearchSizes(damper.composition.n_states, parameters, pieces, powers, len(first_inputs))


def search_numbers(law: Any, damper: Any) -> Array:
    """The numbers of a law's search at the start, as many as there are rows; none of a law that decides on its input."""
    if not asks_force(law):
        return np.zeros(0)
    knots, coefficients = polynomial_table(damper, static=False)
    path = np.asarray(damper.composition.path0, dtype=float)
    return np.concatenate(
        [path, [0.0, 0.0, law.low], knots.ravel(), coefficients.ravel(), nodes(damper, law.low, law.high)]
    )


def left_after_period(law: Any, damper: Any) -> float:
    """The share of the coil's gap to its command that is left after a period."""
    lag = lag_of(law, damper)
    return exp(-law.period / lag) if lag > 0.0 else 0.0


def _unbound(*_: Any) -> Any:
    raise TypeError("a driver runs only after dampyr.models.codegen.kernels.bind has given it its dampers")


advance = _unbound


def command_of(
    b: Any, history: int, wide: int, first: int, apart: int, at: int, states: int, parameters: int, pieces: int, powers: int,
    rows: int, steps: int, wanted: float, x: float, v: float, command: float, low: float, high: float, left: float,
    period: float,
) -> float:  # fmt: skip
    """The command whose force after a period is nearest to the wanted one, of a ``history``; its model goes on to x and v.

    Its numbers are in every ``apart``-th row from ``first`` on; ``at`` is where in the block ``b`` the workspace begins.
    """
    w = b[at : at + rows]
    for k in range(rows):
        w[k] = b[(first + k * apart) * wide + history]
    s, past, here = w[0:states], w[states : states + 3], states + 3
    table = parameters * pieces
    knots = w[here : here + table].reshape(parameters, pieces)
    coefficients = w[here + table : here + table + table * powers].reshape(parameters, pieces, powers)
    inputs, free = w[here + table + table * powers : rows], at + rows
    work, p = b[free : free + states], b[free + states : free + states + parameters]
    found = b[free + states + parameters : free + states + parameters + 4]
    if steps > 0:
        past[2] = command + (past[2] - command) * left
        if past[2] != past[2]:  # as in `dampyr.structures.time_history.followed_model.follow`
            past[2] = low
        look_up(knots, coefficients, past[2], p)
        advance(0, s, past[0], x, past[1], v, period, p)
    past[0], past[1] = x, v
    u = past[2]
    find_input(
        wanted, u, low + (u - low) * left, high + (u - high) * left, TOLERANCE, inputs, s, x, x + period * v, v, v, period,
        knots, coefficients, work, p, 0, found,
    )  # fmt: skip
    for k in range(states + 3):
        b[(first + k * apart) * wide + history] = w[k]
    return min(max((found[0] - u * left) / (1.0 - left), low), high)
