r"""The Maxwell-slip model: a dashpot beside four springs, each of which sticks until it slips.

.. math:: F = k_x v + k_w \sum_{i=1}^4 \frac{2i-1}{16} w_i, \qquad
          \dot w_i = \begin{cases} \dfrac{4\rho}{2i-1}\,v & \text{while } -1 < w_i < 1 \\ 0 & \text{where } w_i
          \text{ is held at } \pm 1 \end{cases}

The springs are equally stiff, and slip after (2i - 1)/(4 rho): midpoints of a uniform distribution of Jenkin's elements,
whose first loading is the parabola :math:`k_w(\rho x - \rho^2 x^2/4)` up to the path 2/rho, here in its tangents, which
leave it by kw/64 at most. kw and rho mean what they mean in `dahl`: the friction, and its stiffness kw rho before
anything slips. Unlike Dahl's, it remembers where it turned and closes its inner loops, which do not drift under a load
that pulses (Masing's rules). One such spring by itself is that of `bilinear`.

The step along a monotone piece is exact, however long.

Iwan (1966), Journal of Applied Mechanics 33, 893; Al-Bender, Lampaert and Swevers (2005), IEEE Transactions on Automatic
Control 50, 1883.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.models.parts._slip import slip
from dampyr.units import Quantity

STATES = {"w1": (-1.0, 1.0), "w2": (-1.0, 1.0), "w3": (-1.0, 1.0), "w4": (-1.0, 1.0)}  # where each slips
EXAMPLE = {"kx": 500.0, "kw": 350.0, "rho": 300.0}


@checked
@dataclass(frozen=True)
class MaxwellSlip:
    """Viscous friction ``kx``, friction ``kw`` when all slip, and ``rho``, its initial stiffness over kw."""

    kx: Annotated[float, Quantity("N s/m", low=0, linear=True)]
    kw: Annotated[float, Quantity("N", low=0, open_low=True, linear=True)]
    rho: Annotated[float, Quantity("1/m", low=0, open_low=True)]


def advance(
    w1: float, w2: float, w3: float, w4: float, x0: float, x1: float, rho: float
) -> tuple[float, float, float, float]:
    step = 4.0 * rho * (x1 - x0)
    return slip(w1, step), slip(w2, step / 3.0), slip(w3, step / 5.0), slip(w4, step / 7.0)


def force(w1: float, w2: float, w3: float, w4: float, v: float, kx: float, kw: float) -> float:
    return kx * v + kw * (w1 + 3.0 * w2 + 5.0 * w3 + 7.0 * w4) / 16.0


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for path in (0.3, 0.1, 0.03, 0.01):
        yield {"rho": 1.0 / (path * scale.stroke)}
