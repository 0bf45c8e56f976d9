r"""Clipped-optimal with an observer: the state that `clipped_optimal` needs, estimated from accelerations and the force.

.. math:: u = u_{max} H\{(f_c - f) f\}, \qquad f_c = -G \hat z, \qquad
          \hat z_k = \bar z_k + L (\ddot y_k - C \bar z_k - D f_k), \quad \bar z_{k+1} = \Phi \hat z_k + \Gamma f_k

G is the gain of `clipped_optimal`. :math:`\hat z` is the estimate of the steady Kalman filter at the law's samples from the
absolute accelerations :math:`\ddot y` of all floors and the damper's own force f, which is held between them; :math:`\Phi`,
:math:`\Gamma`, C and D are of the building with this damper alone. The filter takes the ground's acceleration as white from
sample to sample with the standard deviation ``disturbance``, and the accelerometers' noise as ``noise`` [m/s2]: more noise
makes it trust its model more. What a sensor is really like is said by ``sensors``. The forces of other dampers are not known
to it.

References: S. J. Dyke, B. F. Spencer, M. K. Sain and J. D. Carlson, Modeling and control of magnetorheological dampers for
seismic response reduction, Smart Materials and Structures 5 (1996) 565-575; R. E. Kalman, A new approach to linear filtering
and prediction problems, Journal of Basic Engineering 82 (1960) 35-45.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from dampyr.models.part import checked
from dampyr.structures.building import Building
from dampyr.structures.control._optimal import optimal_gains, state_filter
from dampyr.structures.law_form import ControlLaw, LawDesign
from dampyr.units import Quantity

MEASURES = ("accelerations", "force")


@checked
@dataclass(frozen=True)
class ClippedOptimalLqg(ControlLaw):
    """The ``effort`` and ``weights`` of clipped_optimal; the filter's ``noise`` and ``disturbance`` [m/s2]."""

    effort: Annotated[float, Quantity("", low=0, open_low=True)] = 0.01
    noise: Annotated[float, Quantity("m/s2", low=0, open_low=True)] = 0.05
    disturbance: Annotated[float, Quantity("m/s2", low=0, open_low=True)] = 1.0
    weights: tuple[float, ...] = ()


def design(law: ClippedOptimalLqg, building: Building, row: NDArray[np.float64]) -> LawDesign:
    """The wanted force of the estimate, and the filter."""
    gains = optimal_gains(building, row, law.effort, law.weights)
    estimate, F, G = state_filter(building, row, law.period, law.noise, law.disturbance)
    return LawDesign({"wanted": -gains @ estimate}, F, G)


def decide(wanted: float, force: float, low: float, high: float) -> float:
    return high if (wanted - force) * force > 0.0 else low
