r"""The power law: a viscous damper whose force rises with a power of the velocity.

.. math:: F = C \operatorname{sgn}(v)\,|v/v_1|^{\alpha}, \qquad v_1 = 1\ \mathrm{m/s}

C is the force at 1 m/s, in numbers the C of :math:`F = C|v|^\alpha` with v in m/s; alpha is 0.15 to 0.5 of dampers whose
force is to be limited, 1 of a dashpot, up to 2 of an orifice. The energy of a cycle of amplitude A and peak force F is
:math:`\lambda F A` with :math:`\lambda = 2^{2+\alpha}\,\Gamma^2(1+\alpha/2)/\Gamma(2+\alpha)`.

With alpha below 1 the slope at v = 0 has no limit, and no step of a building would be short enough; here
:math:`|v|^{\alpha-1}` is :math:`(v^2 + v_s^2)^{(\alpha-1)/2}` with vs = 10 um/s: less than 0.4 % from the power at 0.1 mm/s,
and less than 4e-5 at 1 mm/s. It has no memory: behind a `compliance` it is the Maxwell element of viscous dampers in
buildings.

The viscous devices of NTC 2018 section 11.9.6; OpenSees' ViscousDamper is the same behind a spring.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import exp, log
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

SMALL = 1e-5  # m/s
EXAMPLE = {"C": 1200.0, "alpha": 0.4}


@checked
@dataclass(frozen=True)
class PowerLaw:
    """The force ``C`` at 1 m/s and the exponent ``alpha``."""

    C: Annotated[float, Quantity("N", low=0, linear=True)]
    alpha: Annotated[float, Quantity("", low=0, open_low=True, high=3)]


def force(v: float, C: float, alpha: float) -> float:
    return C * v * exp(0.5 * (alpha - 1.0) * log(v * v + SMALL * SMALL))


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for alpha in (0.3, 1.0, 1.7):
        yield {"alpha": alpha}
