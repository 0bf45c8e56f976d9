r"""The sigmoid model: a force-velocity curve that saturates and then rises, run through with a lag.

.. math:: F = (f_t + c|v|)\tanh\frac{v - v_h w}{v_k}, \qquad
          \dot w = \begin{cases} \dot v/v_h & \text{while } -1 < w < 1 \\ 0 & \text{where } w \text{ is held at } \pm 1
          \end{cases}

In the letters of the source :math:`F = f_t (1 + k_v|v|)\,(1 - e^{-\alpha(v + v_h)})/(1 + e^{-\alpha(v + v_h)})` with
:math:`\alpha = 2/v_k` and :math:`k_v = c/f_t`. There vh takes the sign of the acceleration at once, so the force jumps where
the acceleration does; w takes it over a change of velocity of 2 vh, and from there on the two agree. What the source makes a
function of current is here a voltage law; its functions of the peak velocity of a sine have no meaning for other
motions and are left out.

The step is exact while the velocity is monotone between samples. Do not use it for a building: the shift was read off
cycles of sine and has no energy balance (see `hysteretic_biviscous`); there use `dahl`, `bouc_wen` or `modified_bouc_wen`.

Where the velocity turns within vh of zero, its sign and that of the force differ until w has followed, and c makes the force
fall while the velocity rises. Behind a `compliance` or `free_play` nothing holds the piston's velocity there: the equation has
several roots. So in series c acts where it resists the motion and nowhere else,
:math:`F = (f_t + c\max(0, v \operatorname{sgn}\tau))\,\tau` with :math:`\tau = \tanh((v - v_h w)/v_k)`, one for every motion.
It differs from the one above by at most :math:`c\,v_h^2/(4 v_k)`, and by nothing where the two signs agree.

Ma, Wang, Rakheja and Su (2002), Proceedings of the 41st IEEE Conference on Decision and Control; Wang, Ma, Rakheja and Su
(2003), Proceedings of the Institution of Mechanical Engineers D 217, 537.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import tanh
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.models.parts._slip import slip
from dampyr.units import Quantity

NOT_FOR_BUILDINGS = (
    "its shift was read off cycles of sine and has no energy balance, so it may push; "
    "use dahl, bouc_wen or modified_bouc_wen"
)
STATES = {"w": (-1.0, 1.0)}  # held there
EXAMPLE = {"ft": 300.0, "c": 1200.0, "vk": 0.02, "vh": 0.012}


@checked
@dataclass(frozen=True)
class Sigmoid:
    """The force ``ft`` of the knee, the rise ``c`` after it, the knee's velocity ``vk`` and the lag ``vh`` in velocity."""

    ft: Annotated[float, Quantity("N", low=0, linear=True)]
    c: Annotated[float, Quantity("N s/m", low=0, linear=True)]
    vk: Annotated[float, Quantity("m/s", low=0, open_low=True)]
    vh: Annotated[float, Quantity("m/s", low=0, open_low=True)]


def advance(w: float, v0: float, v1: float, vh: float) -> float:
    return slip(w, (v1 - v0) / vh)


def force(w: float, v: float, ft: float, c: float, vk: float, vh: float) -> float:
    return (ft + c * abs(v)) * tanh((v - vh * w) / vk)


def force_in_series(w: float, v: float, ft: float, c: float, vk: float, vh: float) -> float:
    bend = tanh((v - vh * w) / vk)
    if v * bend <= 0.0:
        return ft * bend
    return (ft + c * abs(v)) * bend


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for part in (0.4, 0.15):
        for lag in (0.2, 0.05):
            yield {"vk": part * scale.speed, "vh": lag * scale.speed}
