r"""Power-driven: the input with which the spring beside the damper gives back least power to what it carries.

.. math:: c = \begin{cases} c_{min} & k x \dot x + c_{min} \dot x^2 \ge 0 \\ c_{max} & k x \dot x + c_{max} \dot x^2 < 0 \\
          -k x/\dot x & \text{otherwise} \end{cases}, \qquad
          u = u_{min} + (u_{max} - u_{min}) \frac{c - c_{min}}{c_{max} - c_{min}}

x [m] is the stroke of the damper and :math:`\dot x` its rate; k [N/m] the stiffness of the building between the damper's ends.
:math:`c_{min}` and :math:`c_{max}` [N s/m] are those of the damper at its least and its greatest input, as the shares
``least`` and ``greatest`` of the critical damping :math:`2\sqrt{k m}` of the mass that it moves; the damping is taken as if it
grew linearly with the input. It needs a stroke sensor alone.

Reference: R. Morselli and R. Zanasi, Control of port Hamiltonian systems by dissipative devices and its application to improve
the semi-active suspension behaviour, Mechatronics 18 (2008) 364-369.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.models.part import checked
from dampyr.structures.building import Building
from dampyr.structures.control._optimal import stiffness_between
from dampyr.structures.law_form import ControlLaw, LawDesign
from dampyr.units import Quantity

MEASURES = ("stroke", "rate")


@checked
@dataclass(frozen=True)
class PowerDriven(ControlLaw):
    """``least`` and ``greatest``: the damper's damping at its two inputs as shares of the critical one."""

    least: Annotated[float, Quantity("", low=0)] = 0.05
    greatest: Annotated[float, Quantity("", low=0, open_low=True)] = 0.5

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.least < self.greatest:
            raise InputError(
                f"least = {self.least:g} of power_driven is not below greatest = {self.greatest:g}; exchange them"
            )


def design(law: PowerDriven, building: Building, row: NDArray[np.float64]) -> LawDesign:
    """The spring's force over the critical damping, a speed [m/s]: what the damper's share of it is compared with."""
    k = stiffness_between(building, row)
    critical = 2.0 * np.sqrt(k / float(row @ np.linalg.solve(building.M, row)))
    return LawDesign({"spring": np.array([k / critical, 0.0])})


def decide(spring: float, rate: float, low: float, high: float, least: float, greatest: float) -> float:
    return (
        low
        if (spring + least * rate) * rate >= 0.0
        else (
            high
            if (spring + greatest * rate) * rate < 0.0
            else low + (high - low) * (-spring / rate - least) / (greatest - least)
        )
    )
