"""Which damper stands where: the argument ``dampers=`` of a response, checked and turned into sites."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import ExtrapolationWarning, InputError
from dampyr.models.damper import INPUTS
from dampyr.structures.building import Building
from dampyr.structures.connection import describe_place, normal
from dampyr.structures.control_law import is_control_law, values_at

Array = NDArray[np.float64]
SHORTEST_DELAY = 2e-5
LEVELS = 9  # inputs of a law at which its damper's slopes are looked at


@dataclass(frozen=True, eq=False)
class Site:
    """One damper in a storey, or between any two floors (then ``storey`` is 0), at one input, or at the least of a ``law``."""

    storey: int
    damper: Any
    input_value: float | None
    values: Array
    delay: float
    floors: tuple[int, int] | None = None
    law: Any = None

    @property
    def place(self) -> int | tuple[int, int]:
        """The storey, or the two floors by count, 0 for the ground."""
        return self.storey if self.floors is None else self.floors

    @property
    def composition(self) -> Any:
        """What the kernel compiles."""
        return self.damper.composition

    def between(self, part: float) -> Array:
        """The parameters at ``part`` of the way from the least input of the law to the greatest."""
        u = self.law.low + part * (self.law.high - self.law.low)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ExtrapolationWarning)  # warned of when the site was made
            return np.asarray(self.damper.values(u, static=False, allow_extrapolation=True))


def place(
    building: Building,
    dampers: Mapping[Any, Any] | None,
    voltage: Any,
    current: Any,
    allow_extrapolation: bool,
) -> tuple[Site, ...]:
    """The sites of ``dampers``, a mapping from place to a damper or a list of them, at a constant input or under a law.

    A place is a storey, or two floors by label or count (see :mod:`dampyr.structures.connection`).
    ``voltage`` [V] or ``current`` [A] is one number or law for all or a mapping from place to these. The static
    force of a damper is left out: a building is at rest in its equilibrium with it.
    """
    if voltage is not None and current is not None:
        raise InputError("both voltage= and current= are given; a damper takes one of the two")
    if dampers is not None and not isinstance(dampers, Mapping):
        raise InputError(
            f"dampers is a {type(dampers).__name__}; write a mapping from storey to damper, such as {{1: damper}}"
        )
    voltage, current = _by_place(building, voltage), _by_place(building, current)
    sites = []
    for key, entry in (dampers or {}).items():
        there = normal(building, key)
        for damper in entry if isinstance(entry, list | tuple) else (entry,):
            sites.append(_site(there, damper, voltage, current, allow_extrapolation))
    _check_places(voltage if current is None else current, sites)
    return tuple(sites)


def laws_of(sites: tuple[Site, ...]) -> list[Any]:
    """The control laws of sites that have one."""
    return [site.law for site in sites if site.law is not None]


def _by_place(building: Building, value: Any) -> Any:
    """A mapping of inputs with its places written in one way; (1, 2) and storey 2 are the same."""
    if not isinstance(value, Mapping):
        return value
    inputs_by_place: dict[Any, Any] = {}
    for key, u in value.items():
        there = normal(building, key)
        if there in inputs_by_place:
            raise InputError(f"two inputs are given for the place {describe_place(there)}; give one")
        inputs_by_place[there] = u
    return inputs_by_place


def _site(there: Any, damper: Any, voltage: Any, current: Any, allow_extrapolation: bool) -> Site:
    for needed in ("values", "composition"):
        if not hasattr(damper, needed):
            raise InputError(
                f"the place {describe_place(there)} holds a {type(damper).__name__}; put a dampyr.models.Damper there"
            )
    u = _input(there, damper, voltage, current)
    law = u if is_control_law(u) else None
    if law is None:
        values = damper.values(u, static=False, allow_extrapolation=allow_extrapolation)
    else:
        values = values_at(law, damper, allow_extrapolation)[0]
    where = damper.composition.delay
    delay = 0.0 if where is None else float(values[where])
    if 0 < delay < SHORTEST_DELAY:
        raise InputError(
            f"the damper {describe_place(there)} has a delay of {delay:g} s, below the "
            f"{SHORTEST_DELAY:g} s that can be resolved; set it to 0"
        )
    storey, floors = (there, None) if isinstance(there, int) else (0, there)
    return Site(storey, damper, u if law is None else None, np.array(values, dtype=float), delay, floors, law)


def _input(there: Any, damper: Any, voltage: Any, current: Any) -> Any:
    """The constant input of a damper, or its law."""
    kind = getattr(damper, "input", "V")
    given = {"V": voltage, "A": current}
    value, other = given[kind], given["A" if kind == "V" else "V"]
    if isinstance(value, Mapping):
        value = value.get(there)
    if value is None and other is not None:
        wrong = INPUTS["A" if kind == "V" else "V"]
        raise InputError(
            f"{wrong}= is given, but the damper {describe_place(there)} takes a {INPUTS[kind]}; write {INPUTS[kind]}="
        )
    if value is None:
        raise InputError(
            f"the damper {describe_place(there)} has no {INPUTS[kind]}; write {INPUTS[kind]}=, a number in {kind} (0 is one)"
        )
    if is_control_law(value):
        return value
    if not isinstance(value, int | float | np.number) or not math.isfinite(value):
        raise InputError(
            f"{INPUTS[kind]} = {value!r} {describe_place(there)} is not a finite number; write a constant in {kind}, or a "
            'control law, such as control_law("on_off", high=...)'
        )
    return float(value)


def _check_places(value: Any, sites: list[Site]) -> None:
    taken = {site.place for site in sites}
    if isinstance(value, Mapping) and (stray := [there for there in value if there not in taken]):
        raise InputError(
            f"an input is given for {_name(stray[0])}, which holds no damper; "
            f"dampers stand in {', '.join(_name(there) for there in dict.fromkeys(s.place for s in sites))}"
        )


def _name(there: Any) -> str:
    return f"storey {there}" if isinstance(there, int) else f"floors {there[0]}-{there[1]}"
