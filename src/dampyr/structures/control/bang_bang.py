r"""Decentralised bang-bang: full input while the damper takes energy from the building's absolute motion.

.. math:: u = u_{max} \text{ if } \dot s f > 0, \text{ else } u_{min}, \qquad
          \dot s = \lambda^T (\dot q + \iota\, \dot x_g)

f [N] is the force of the damper as it is measured, :math:`\dot s` [m/s] the rate at which it lengthens where the ground
counts as still: for a damper on the ground the absolute velocity of its floor, for any other the rate of its stroke.
What falls fastest is :math:`\tfrac12 q^T K q + \tfrac12 (\dot q + \iota \dot x_g)^T M (\dot q + \iota \dot x_g)`. It
needs no model of the building. A damper between two floors nearly always opposes its own stroke, so there the law hardly
differs from full input always.

References: N. H. McClamroch and H. P. Gavin, Closed loop structural control using electrorheological dampers, American
Control Conference (1995) 4173-4177; L. M. Jansen and S. J. Dyke, Semiactive control strategies for MR dampers: comparative
study, Journal of Engineering Mechanics 126 (2000) 795-803.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from dampyr.models.part import checked
from dampyr.structures.building import Building
from dampyr.units import Quantity


@checked
@dataclass(frozen=True)
class BangBang:
    """The inputs ``low`` and ``high`` [V or A], the ``period`` between decisions and the ``lag`` of the coil [s]."""

    low: Annotated[float, Quantity("V or A")]
    high: Annotated[float, Quantity("V or A")]
    period: Annotated[float, Quantity("s", low=0, open_low=True)] = 0.005
    lag: Annotated[float, Quantity("s", low=0)] = 0.0


def gains(law: BangBang, building: Building, row: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rate of the stroke where the ground counts as still."""
    return np.concatenate([np.zeros(building.n), row, [row @ building.carried]])


def decide(signal: float, force: float, low: float, high: float) -> float:
    return high if signal * force > 0.0 else low
