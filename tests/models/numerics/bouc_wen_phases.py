"""The Bouc-Wen state by its phases alone."""

from dampyr.models.numerics.bouc_wen_exact import (
    back_at,
    phase,
    phase_back,
    state_at,
)


def by_phases(y: float, xi: float, n: float, c: float) -> float:
    """The step without a short series."""
    if y < 0.0:
        rest = phase_back(-y, n, c)
        return -back_at(rest - xi, n, c, min(rest - xi, 1.0)) if xi < rest else state_at(xi - rest, n)
    return state_at(phase(y, n) + xi, n)
