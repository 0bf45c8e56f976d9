"""The element that sticks and slips: what `maxwell_slip`, `hysteretic_biviscous` and `sigmoid` remember."""

from dampyr.models.codegen.formula import intrinsic


def sticks(end: float, w: float, step: float) -> float:
    """The derivative of `slip` by either argument."""
    if abs(end) < 1.0:
        return 1.0
    return 0.0


@intrinsic(sticks, sticks)
def slip(w: float, step: float) -> float:
    """w + step, held between -1 and 1: exact along a monotone piece, however long."""
    return min(max(w + step, -1.0), 1.0)
