"""Which damper stands where: the argument ``dampers=`` of a response, checked and turned into sites."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.models.damper import INPUTS
from dampyr.structures.building import Building

Array = NDArray[np.float64]
SHORTEST_DELAY = 2e-5


@dataclass(frozen=True, eq=False)
class Site:
    """One damper in one storey, at one input."""

    storey: int
    damper: Any
    input_value: float | None
    values: Array
    delay: float

    @property
    def composition(self) -> Any:
        """What the kernel compiles."""
        return self.damper.composition


def place(
    building: Building,
    dampers: Mapping[int, Any] | None,
    voltage: Any,
    current: Any,
    allow_extrapolation: bool,
) -> tuple[Site, ...]:
    """The sites of ``dampers``, a mapping from storey to a damper or a list of them, at a constant input.

    ``voltage`` [V] or ``current`` [A] is one number for all or a mapping from storey to number. The static
    force of a damper is left out: a building is at rest in its equilibrium with it.
    """
    if voltage is not None and current is not None:
        raise InputError("both voltage= and current= are given; a damper takes one of the two")
    if dampers is not None and not isinstance(dampers, Mapping):
        raise InputError(
            f"dampers is a {type(dampers).__name__}; write a mapping from storey to damper, such as {{1: damper}}"
        )
    sites = []
    for storey, entry in (dampers or {}).items():
        building.connection(storey)
        for damper in entry if isinstance(entry, list | tuple) else (entry,):
            sites.append(_site(int(storey), damper, voltage, current, allow_extrapolation))
    _check_storeys(voltage if current is None else current, dampers or {})
    return tuple(sites)


def _site(storey: int, damper: Any, voltage: Any, current: Any, allow_extrapolation: bool) -> Site:
    for needed in ("values", "composition"):
        if not hasattr(damper, needed):
            raise InputError(f"storey {storey} holds a {type(damper).__name__}; put a dampyr.models.Damper there")
    u = _input(storey, damper, voltage, current)
    values = damper.values(u, static=False, allow_extrapolation=allow_extrapolation)
    where = damper.composition.delay
    delay = 0.0 if where is None else float(values[where])
    if 0 < delay < SHORTEST_DELAY:
        raise InputError(
            f"the damper in storey {storey} has a delay of {delay:g} s, below the "
            f"{SHORTEST_DELAY:g} s that can be resolved; set it to 0"
        )
    return Site(storey, damper, u, np.array(values, dtype=float), delay)


def _input(storey: int, damper: Any, voltage: Any, current: Any) -> float:
    kind = getattr(damper, "input", "V")
    given = {"V": voltage, "A": current}
    value, other = given[kind], given["A" if kind == "V" else "V"]
    if isinstance(value, Mapping):
        value = value.get(storey)
    if value is None and other is not None:
        wrong = INPUTS["A" if kind == "V" else "V"]
        raise InputError(
            f"{wrong}= is given, but the damper in storey {storey} takes a {INPUTS[kind]}; write {INPUTS[kind]}="
        )
    if value is None:
        raise InputError(
            f"the damper in storey {storey} has no {INPUTS[kind]}; write {INPUTS[kind]}=, a number in {kind} (0 is one)"
        )
    if not isinstance(value, int | float | np.number) or not math.isfinite(value):
        raise InputError(
            f"{INPUTS[kind]} = {value!r} in storey {storey} is not a finite number; write a constant in {kind}"
        )
    return float(value)


def _check_storeys(value: Any, dampers: Mapping[int, Any]) -> None:
    if isinstance(value, Mapping) and (stray := sorted(set(value) - set(dampers))):
        raise InputError(
            f"an input is given for storey {stray[0]}, which holds no damper; dampers stand in {sorted(dampers)}"
        )
