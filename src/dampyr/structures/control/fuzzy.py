r"""Fuzzy control by a table of rules: the input by how much the floor moves and how much the damper does.

.. math:: u = u_{min} + (u_{max} - u_{min}) \sum_{ij} \mu_i(a)\, \mu_j(b)\, w_{ij}, \qquad
          a = \frac{\dot y}{v_1}, \quad b = \frac{\dot x}{v_1}

:math:`\dot y` [m/s] is the absolute velocity of the damper's upper end, :math:`\dot x` the rate of its stroke, both positive
where they lengthen the damper, :math:`v_1` the ``speed`` at which they count as large. Each is negative, about zero or
positive by the triangles :math:`\mu` between -1, 0 and 1 (beyond, by their ends). The table w is the same for the mirrored
motion, so it has five rules: ``same`` signs, ``opposite`` signs, ``floor`` moves and the damper does not, ``damper`` moves
and the floor does not, ``still``. The default is a smoothed `on_off`. It needs no model of the building; its rules are tuned
and not derived.

References: T. Takagi and M. Sugeno, Fuzzy identification of systems and its applications to modeling and control, IEEE
Transactions on Systems, Man, and Cybernetics 15 (1985) 116-132; K.-M. Choi, S.-W. Cho, H.-J. Jung and I.-W. Lee, Semi-active
fuzzy control for seismic response reduction using magnetorheological dampers, Earthquake Engineering and Structural Dynamics 33
(2004) 723-736.
"""

from dataclasses import dataclass
from typing import Annotated

from dampyr.models.part import checked
from dampyr.structures.law_form import ControlLaw
from dampyr.units import Quantity

MEASURES = ("velocity", "rate")


@checked
@dataclass(frozen=True)
class Fuzzy(ControlLaw):
    """The ``speed`` [m/s] that counts as large, and the share of the greatest input that each rule asks for."""

    speed: Annotated[float, Quantity("m/s", low=0, open_low=True)] = 0.1
    same: Annotated[float, Quantity("", low=0, high=1)] = 1.0
    opposite: Annotated[float, Quantity("", low=0, high=1)] = 0.0
    floor: Annotated[float, Quantity("", low=0, high=1)] = 0.5
    damper: Annotated[float, Quantity("", low=0, high=1)] = 0.0
    still: Annotated[float, Quantity("", low=0, high=1)] = 0.0


def large(x: float) -> float:
    return min(1.0, abs(x))


def decide(
    velocity: float,
    rate: float,
    low: float,
    high: float,
    speed: float,
    same: float,
    opposite: float,
    floor: float,
    damper: float,
    still: float,
) -> float:
    return low + (high - low) * (
        large(velocity / speed) * large(rate / speed) * (same if velocity * rate > 0.0 else opposite)
        + large(velocity / speed) * (1.0 - large(rate / speed)) * floor
        + (1.0 - large(velocity / speed)) * large(rate / speed) * damper
        + (1.0 - large(velocity / speed)) * (1.0 - large(rate / speed)) * still
    )
