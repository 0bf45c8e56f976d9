"""The function phi_1 of exponential integrators: what is left of a stretch of a Maxwell arm at a constant rate."""

from math import exp

from dampyr.models.codegen.formula import intrinsic

SHORT = 1e-2  # below it the series are right to rounding, and differences of rounded numbers are not


def phi_1_derivative(value: float, turns: float) -> float:
    """The derivative of `phi_1`."""
    if turns < SHORT:
        return -0.5 + turns * (
            1.0 / 3.0 - turns * (1.0 / 8.0 - turns * (1.0 / 30.0 - turns * (1.0 / 144.0 - turns / 840.0)))
        )
    return (exp(-turns) - value) / turns


@intrinsic(phi_1_derivative)
def phi_1(turns: float) -> float:
    """(1 - exp(-turns))/turns: the share of a stretch that is left of it after the ``turns`` of time constants it took."""
    if turns < SHORT:
        return 1.0 - turns * (0.5 - turns * (1.0 / 6.0 - turns * (1.0 / 24.0 - turns * (1.0 / 120.0 - turns / 720.0))))
    return (1.0 - exp(-turns)) / turns
