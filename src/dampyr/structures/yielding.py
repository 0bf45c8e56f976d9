r"""Shear buildings whose storeys yield: what remains of each storey in a linear building, and the rest as hysteretic elements.

A storey of the initial stiffness k that yields at the drift :math:`u_y` and has :math:`\alpha k` after it gives

.. math:: V = \alpha k\, d + (1 - \alpha)\, k u_y\, w(d) - \frac{P}{h}\, d

with w of the part `bilinear`, whose corner is sharp (OpenSees' Steel01), or of `bouc_wen` with the exponent n, whose corner is
round (OpenSees' BoucWen with :math:`\beta = \gamma`); both follow their path exactly in `respond`. With a ``strength_loss``
:math:`s` or a ``stiffness_loss`` :math:`c` a round storey wears with the energy E of its hysteresis (`bouc_wen_baber_noori`
without pinching),

.. math:: \dot w = \frac{1}{\eta u_y} \big(\dot d - \tfrac12 \nu (|\dot d| |w|^{n-1} w + \dot d |w|^n)\big), \quad
          \nu = 1 + s \frac{E}{(1 - \alpha) k u_y^2}, \quad \eta = 1 + c \frac{E}{(1 - \alpha) k u_y^2}

so that its strength is :math:`\nu^{-1/n}` and its stiffness :math:`1/\eta` of what they were. The last term of V is the
turning of the weight P above about the storey's height h (P-delta), linear in the drift, which the building's stiffness takes
up. Drifts that remain are the last ones of a response with a rest (``after=``).

References: A. K. Chopra, Dynamics of Structures (2017), chapters 7 and 22; Y.-K. Wen, Method for random vibration of hysteretic
systems, Journal of the Engineering Mechanics Division 102 (1976) 249-263; T. T. Baber and Y.-K. Wen, Random vibration of
hysteretic, degrading systems, Journal of the Engineering Mechanics Division 107 (1981) 1069-1087, for the wear.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.models import Constant, Damper
from dampyr.structures.building import Building
from dampyr.structures.shear import positive, shear_building, storey_matrix
from dampyr.units import STANDARD_GRAVITY

Array = NDArray[np.float64]


def yielding_shear_building(
    masses: ArrayLike,
    stiffnesses: ArrayLike,
    yield_drifts: ArrayLike,
    hardening: float = 0.0,
    exponent: float | None = None,
    strength_loss: float = 0.0,
    stiffness_loss: float = 0.0,
    damping_ratio: float | Sequence[float] | None = None,
    dashpots: ArrayLike | None = None,
    heights: ArrayLike | None = None,
    method: str = "rayleigh",
    name: str = "yielding shear building",
) -> tuple[Building, dict[int, Damper]]:
    r"""A shear building whose storeys yield, for `respond` and `ensemble`: the building, and the elements of its storeys.

    The elements stand where dampers stand: ``respond(building, motion, elements)``, and beside a damper in storey 1
    ``elements | {1: [elements[1], damper]}``. They have no input.

    Parameters
    ----------
    masses, stiffnesses
        ``(n,)`` in kg and N/m, or quantities: of each floor, and the initial one of the storey below it.
    yield_drifts
        ``(n,)`` in m, greater than 0, or one for all.
    hardening
        :math:`\alpha`, the stiffness after yield over the initial one, from 0 to below 1.
    exponent
        n of a round corner, 1 or more: 1 is a very round one, 10 nearly sharp. A sharp one unless it is given.
    strength_loss, stiffness_loss
        How much :math:`\nu` and :math:`\eta` grow while the hysteresis takes the energy of (1 - hardening) k u_y^2, 0 or more;
        they need a round corner.
    damping_ratio, dashpots, method
        As in `shear_building`; of the initial stiffness, without P-delta, and constant.
    heights
        ``(n,)`` in m, or one for all: with them the weight above each storey acts (P-delta).
    name
        What the building is called.

    Raises
    ------
    InputError
        A number is not allowed, or the weight would make a storey that has yielded turn over: its hardening must be at least
        P/(k h), as the building is linear in it.

    Examples
    --------
    >>> import dampyr as dp
    >>> S, motion = dp.structures, dp.ground_motions.el_centro().scaled(2.0)
    >>> building, storeys = S.yielding_shear_building([2e4, 2e4], [3e7, 2e7], 0.005, 0.03, damping_ratio=0.02)
    >>> response = S.respond(building, motion, storeys, after=5.0)
    >>> (1e3 * response.peak_drift).round(1), (1e3 * response.drift[:, -1]).round(1)
    (array([38. , 11.1]), array([-4.2, -2.4]))
    """
    elastic = shear_building(masses, stiffnesses, damping_ratio, dashpots, method, name)
    mass, spring = positive("masses", masses, "kg"), positive("stiffnesses", stiffnesses, "N/m")
    drift = per_storey("yield_drifts", yield_drifts, len(mass))
    if isinstance(hardening, bool) or not 0.0 <= hardening < 1.0:
        raise InputError(f"hardening = {hardening!r} is not allowed; it must be from 0 to below 1")
    if exponent is not None and not 1.0 <= exponent <= 50.0:
        raise InputError(f"exponent = {exponent!r} is not allowed; it must be from 1 to 50, or None for a sharp corner")
    wear = {"strength_loss": strength_loss, "stiffness_loss": stiffness_loss}
    for key, value in wear.items():
        if isinstance(value, bool) or not 0.0 <= value < np.inf:
            raise InputError(f"{key} = {value!r} is not allowed; it must be a finite number of at least 0")
        if value > 0.0 and exponent is None:
            raise InputError(
                f"{key} = {value:g} is of a storey with a round corner; give exponent=, such as 2, or leave it out"
            )
    turning = np.zeros(len(mass))
    if heights is not None:
        turning = STANDARD_GRAVITY * np.cumsum(mass[::-1])[::-1] / per_storey("heights", heights, len(mass))
    if np.any(short := hardening * spring < turning):
        k = int(np.argmax(short))
        raise InputError(
            f"storey {k + 1} turns over once it has yielded: its stiffness is then {hardening * spring[k]:.4g} N/m and the "
            f"weight above takes {turning[k]:.4g}; the hardening must be at least {turning[k] / spring[k]:.3g}"
        )
    building = Building(elastic.M, elastic.C, storey_matrix(hardening * spring - turning), name)
    force = (1.0 - hardening) * spring * drift
    elements = {
        k + 1: _element(float(force[k]), float(drift[k]), exponent, strength_loss, stiffness_loss)
        for k in range(len(mass))
    }
    return building, elements


def _element(force: float, drift: float, exponent: float | None, strength_loss: float, stiffness_loss: float) -> Damper:
    if exponent is None:
        return Damper("bilinear", {"bilinear.Q": force, "bilinear.uy": drift, "bilinear.k2": 0.0}, input="none")
    shape = {"k0": 0.0, "kw": force, "rho": 1.0 / drift, "sigma": 0.5, "n": float(exponent)}
    if strength_loss or stiffness_loss:
        plain = {"zetas": 0.0, "q": 0.0, "p": 0.0, "Shi": 1.0, "deltaShi": 0.0, "lamda": 1.0}  # no pinching
        wear = {"deltanu": strength_loss / drift, "deltaeta": stiffness_loss / drift}
        name = "bouc_wen_baber_noori"
        laws = {f"{name}.{key}": Constant(value) for key, value in (shape | plain | wear).items()}
        return Damper(name, laws, input="none")
    values = {"c0": 0.0} | shape
    return Damper("bouc_wen", {f"bouc_wen.{key}": Constant(value) for key, value in values.items()}, input="none")


def per_storey(name: str, values: ArrayLike, count: int) -> Array:
    """Lengths (count,) in m, greater than 0, of what was given for each storey or one for all."""
    array = positive(name, values, "m")
    if len(array) not in (1, count):
        raise InputError(f"{len(array)} {name} do not match {count} storeys; give one for each, or one for all")
    return np.broadcast_to(array, count).copy()
