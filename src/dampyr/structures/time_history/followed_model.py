"""The damper's model in the controller of a law that asks for a force, as the kernel of `respond` runs it.

Plain Python for numba; `dampyr.structures.wanted_force` says what it computes, and has the arrays.
"""

from __future__ import annotations

from typing import Any

from dampyr.models.inverse import TOLERANCE, find_input
from dampyr.models.laws import look_up

BOUND_WITH = ("dampyr.models.inverse", "dampyr.models.laws")


def _unbound(*_: Any) -> Any:
    raise TypeError("a driver runs only after dampyr.models.codegen.kernels.bind has given it its dampers")


advance = _unbound


def follow(d: int, s: Any, control: Any, models: Any) -> None:
    """The model of a site goes on to the measured stroke and rate, under the command that was given."""
    past, x, v = models.past[d], s[models.at[d, 0]], s[models.at[d, 1]]
    if models.begun[d] == 0:
        models.begun[d] = 1
    else:
        command = control.command[d]
        past[2] = command + (past[2] - command) * models.left[d]
        if past[2] != past[2]:  # the motion grew without bound; the search's upper bound must be a number all the same
            past[2] = models.bounds[d, 0]
        look_up(control.knots[d], control.coefficients[d], past[2], models.params[d])
        advance(models.kind[d], models.states[d], past[0], x, past[1], v, models.period[d], models.params[d])
    past[0], past[1] = x, v


def input_of_force(d: int, s: Any, wanted: float, control: Any, models: Any) -> float:
    """The command whose force after a period is nearest to the wanted one, the rate staying as it is."""
    low, high, left, period = models.bounds[d, 0], models.bounds[d, 1], models.left[d], models.period[d]
    u, x, v, found = models.past[d, 2], s[models.at[d, 0]], s[models.at[d, 1]], models.found
    least, most = low + (u - low) * left, high + (u - high) * left
    find_input(
        wanted, u, least, most, TOLERANCE, models.nodes[d], models.states[d], x, x + period * v, v, v, period,
        control.knots[d], control.coefficients[d], models.work[d], models.params[d], models.kind[d], found,
    )  # fmt: skip
    return min(max((found[0] - u * left) / (1.0 - left), low), high)
