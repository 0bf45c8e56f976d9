"""One trial step of a damper from its committed state: the force, and its derivatives by displacement and velocity."""

from __future__ import annotations

from typing import Any


def _unbound(*_: Any) -> Any:
    raise TypeError("a driver runs only after dampyr.models.codegen.kernels.bind has given it a composition")


advance = force = _unbound
SHIFT = 1e-5  # of the step, for the difference quotients


def try_step(s, work, x0, v0, x1, v1, a1, dt, p, out):
    """Fill ``out`` with the force at the end of the step from (s, x0, v0) to (x1, v1), dF/dx and dF/dv there; ``work`` holds
    the state at the end. ``s`` stays. The tangent is that of the step (algorithmic), on the side that the step goes to."""
    out[0] = end_of_step(s, work, x0, v0, x1, v1, a1, dt, p)
    f = out[0]
    h = SHIFT * max(abs(x1 - x0), 1e-7)
    if x1 < x0:
        h = -h
    out[1] = (end_of_step(s, work, x0, v0, x1 + h, v1, a1, dt, p) - f) / h
    k = SHIFT * max(abs(v1), 1e-5)
    out[2] = (end_of_step(s, work, x0, v0, x1, v1 + k, a1, dt, p) - f) / k
    end_of_step(s, work, x0, v0, x1, v1, a1, dt, p)


def end_of_step(s, work, x0, v0, x1, v1, a1, dt, p):
    """The force at the end of a step, whose state ``work`` takes; where no time has passed, that of the state as it is."""
    for i in range(s.size):
        work[i] = s[i]
    if dt > 0.0:
        advance(0, work, x0, x1, v0, v1, dt, p)
    return force(0, work, x1, v1, a1, p)
