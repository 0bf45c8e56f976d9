"""Sites of dampers in a building: the argument ``dampers=`` of a response, checked, with the input of each."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrWarning, ExtrapolationWarning, InputError
from dampyr.input_kinds import INPUTS, NO_INPUT
from dampyr.structures.building import Building
from dampyr.structures.building_options import InstallationOptions
from dampyr.structures.control_laws import is_control_law, values_at
from dampyr.units import in_si

Array = NDArray[np.float64]
MIN_DELAY = 2e-5  # s; a step may not be longer than a delay, so a shorter one would need a million steps in 20 s
LEVELS = 9  # inputs of a law at which its damper's slopes are evaluated: laws of parameters are smooth between them


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

    def levels(self) -> Array:
        """The parameters (`LEVELS`, P) from the least input of the law to the greatest; (1, P) where there is no law."""
        if self.law is None:
            return self.values[None]
        u = np.linspace(self.law.low, self.law.high, LEVELS)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ExtrapolationWarning)  # warned of when the site was made
            return np.asarray(self.damper.values(u, static=False, allow_extrapolation=True))


def one_in_each(damper: Any, storeys: Sequence[int]) -> dict[int, Any]:
    """A damper like it in each storey; InputError for a storey that is named twice."""
    if len(set(storeys)) < len(storeys):
        named = ", ".join(map(str, storeys))
        raise InputError(f"a storey is named twice ({named}); it has one damper here, so give each once")
    return dict.fromkeys(storeys, damper)


def warn_of_parts(sites: Iterable[Site], stacklevel: int = 3) -> None:
    """Warn of dampers with parts that are not for a building."""
    for note in dict.fromkeys(site.composition.not_for_buildings for site in sites):
        if note:
            warnings.warn(note, DampyrWarning, stacklevel=stacklevel)


def make_sites(
    building: Building,
    dampers: Any,
    voltage: Any,
    current: Any,
    allow_extrapolation: bool,
) -> tuple[Site, ...]:
    """The sites of ``dampers``: one damper, which stands in storey 1, or a mapping from place to a damper or a list of them.

    A place is a storey, or two floors by label or count (see :mod:`dampyr.structures.building`).
    ``voltage`` [V] or ``current`` [A] is one number or law for all or a mapping from place to these; it is of the dampers that
    have an input, and refused where none has. The static force of a damper is left out: a building is at rest in its
    equilibrium with it.
    """
    input_of(voltage, current)
    _check_has_input(dampers, voltage, current)
    voltage, current = _by_place(building, voltage), _by_place(building, current)
    sites = [
        _site(building.resolve_place(key), damper, voltage, current, allow_extrapolation)
        for key, damper in places_and_dampers(placement(dampers))
    ]
    _check_places(voltage if current is None else current, sites)
    return tuple(sites)


def input_of(voltage: Any, current: Any) -> tuple[str, Any]:
    """The name of the argument that has the input of the dampers, and that input; only one of the two may be given."""
    if voltage is not None and current is not None:
        raise InputError("both voltage= and current= are given; a damper takes one of the two")
    return ("voltage", voltage) if current is None else ("current", current)


def placement(dampers: Any) -> Mapping[Any, Any]:
    """``dampers`` as a mapping from place to damper: one alone stands in storey 1, None is the bare building."""
    if dampers is None:
        return {}
    if isinstance(dampers, Mapping):
        return dampers
    if not _is_damper(dampers):
        raise InputError(
            f"dampers is a {type(dampers).__name__}; write a damper, which stands in storey 1, or a mapping from storey "
            "to damper, such as {1: damper}"
        )
    return {1: dampers}


def installed(placed: Mapping[Any, Any], options: InstallationOptions) -> Mapping[Any, Any]:
    """The dampers of a placement without the parts that are left out, on the brace where there is one."""

    def change(damper: Any) -> Any:
        rest = damper.without(*options.without)
        return rest if options.brace is None else rest.on_brace(options.brace)

    return with_each(placed, change) if options.without or options.brace is not None else placed


def drawn_placements(placed: Mapping[Any, Any], count: int, seed: int) -> list[Mapping[Any, Any]]:
    """``count`` placements of dampers that are drawn by the seed; a damper that stands in several places is the same in all."""
    different = {id(damper): damper for _, damper in places_and_dampers(placed)}
    draws = [damper.draws(count, seed + k) for k, damper in enumerate(different.values())]
    drawn = [dict(zip(different, dampers, strict=True)) for dampers in zip(*draws, strict=True)]

    def with_draws(by_damper: Mapping[int, Any]) -> Mapping[Any, Any]:
        return with_each(placed, lambda damper: by_damper[id(damper)])

    return [with_draws(by_damper) for by_damper in drawn]


def with_each(placed: Mapping[Any, Any], change: Callable[[Any], Any]) -> Mapping[Any, Any]:
    """A placement with what ``change`` makes of each damper."""
    wrong = next((damper for _, damper in places_and_dampers(placed) if not _is_damper(damper)), None)
    if wrong is not None:
        raise InputError(f"a place holds a {type(wrong).__name__}; put a dampyr.models.Damper there")
    return {
        where: [change(damper) for damper in entry] if isinstance(entry, list | tuple) else change(entry)
        for where, entry in placed.items()
    }


def places_and_dampers(placed: Mapping[Any, Any]) -> list[tuple[Any, Any]]:
    """Each damper of a placement after the place where it stands, in the order of their sites."""
    several = ((where, entry if isinstance(entry, list | tuple) else (entry,)) for where, entry in placed.items())
    return [(where, damper) for where, dampers in several for damper in dampers]


def calibrated_displacements(placed: Mapping[Any, Any]) -> list[float]:
    """The displacement [m] that each damper of a placement was calibrated on, infinite where its card has none."""
    return [float(damper.ranges.get("displacement", (0.0, math.inf))[1]) for _, damper in places_and_dampers(placed)]


def _is_damper(value: Any) -> bool:
    return all(hasattr(value, needed) for needed in ("values", "composition"))


def laws_of(sites: tuple[Site, ...]) -> list[Any]:
    """The control laws of sites that have one."""
    return [site.law for site in sites if site.law is not None]


def describe_place(place: int | tuple[int, int]) -> str:
    """A place inside a sentence: "in storey 1", "between floors 0 and 2"."""
    return f"in storey {place}" if isinstance(place, int) else f"between floors {place[0]} and {place[1]}"


def connections(building: Building, sites: tuple[Site, ...]) -> Array:
    """What turns floor displacements into the strokes of the sites, a row each (N, n)."""
    return np.array([building.connection(site.place) for site in sites]).reshape(len(sites), building.n)


def drifts(building: Building) -> Array:
    """What turns displacements into the drifts of the storeys, a row each (n, n); rows of zeros for coordinates without one."""
    rows = np.zeros((building.n, building.n))
    rows[: building.n_floors] = [building.connection(storey) for storey in range(1, building.n_floors + 1)]
    return rows


def _by_place(building: Building, value: Any) -> Any:
    """A mapping of inputs with its places written in one way; (1, 2) and storey 2 are the same."""
    if not isinstance(value, Mapping):
        return value
    inputs_by_place: dict[Any, Any] = {}
    for key, u in value.items():
        place = building.resolve_place(key)
        if place in inputs_by_place:
            raise InputError(f"two inputs are given for the place {describe_place(place)}; give one")
        inputs_by_place[place] = u
    return inputs_by_place


def _site(place: Any, damper: Any, voltage: Any, current: Any, allow_extrapolation: bool) -> Site:
    if not _is_damper(damper):
        raise InputError(
            f"the place {describe_place(place)} holds a {type(damper).__name__}; put a dampyr.models.Damper there"
        )
    u = _input(place, damper, voltage, current)
    law = u if is_control_law(u) else None
    if law is None:
        values = damper.values(u, static=False, allow_extrapolation=allow_extrapolation)
    else:
        values = values_at(law, damper, allow_extrapolation)[0]
    where = damper.composition.delay
    delay = 0.0 if where is None else float(values[where])
    if 0 < delay < MIN_DELAY:
        raise InputError(
            f"the damper {describe_place(place)} has a delay of {delay:g} s, below the "
            f"{MIN_DELAY:g} s that can be resolved; set it to 0"
        )
    storey, floors = (place, None) if isinstance(place, int) else (0, place)
    return Site(storey, damper, u if law is None else None, np.array(values, dtype=float), delay, floors, law)


def _has_input(damper: Any) -> bool:
    return getattr(damper, "input", "V") != NO_INPUT


def any_has_input(placed: Mapping[Any, Any]) -> bool:
    """Whether a damper of a placement has an input, a voltage or a current."""
    return any(_has_input(damper) for _, damper in places_and_dampers(placed))


def _check_has_input(dampers: Any, voltage: Any, current: Any) -> None:
    """:class:`~dampyr.errors.InputError` where an input or a control law is given and no damper has one to be set."""
    word, value = input_of(voltage, current)
    placed = placement(dampers)
    if value is None or not placed or any_has_input(placed):
        return
    if is_control_law(value):
        raise InputError(f"a control law sets the input of a damper, and this one has none; leave {word}= out")
    raise InputError(f"{word}= is given, but the damper has no input; leave it out")


def _input(place: Any, damper: Any, voltage: Any, current: Any) -> Any:
    """The constant input of a damper, or its law."""
    kind = getattr(damper, "input", "V")
    if kind == NO_INPUT:
        return 0.0
    inputs = {"V": voltage, "A": current}
    value, other = inputs[kind], inputs["A" if kind == "V" else "V"]
    if isinstance(value, Mapping):
        value = value.get(place)
    if not getattr(damper, "needs_input", True) and value is None:
        return 0.0
    if value is None and other is not None:
        wrong = INPUTS["A" if kind == "V" else "V"]
        raise InputError(
            f"{wrong}= is given, but the damper {describe_place(place)} takes a {INPUTS[kind]}; write {INPUTS[kind]}="
        )
    if value is None:
        raise InputError(
            f"the damper {describe_place(place)} has no {INPUTS[kind]}; write {INPUTS[kind]}=, a number in {kind} (0 is one)"
        )
    if is_control_law(value):
        return value
    with (
        suppress(InputError) if isinstance(value, str) else nullcontext()
    ):  # a text that is not a quantity may be meant as a law
        value = in_si(value, kind, f"{INPUTS[kind]} {describe_place(place)}")
    if not isinstance(value, int | float | np.number) or not math.isfinite(value):
        raise InputError(
            f"{INPUTS[kind]} = {value!r} {describe_place(place)} is not a finite number; write a constant in {kind}, or a "
            'control law, such as control_law("on_off", high=...); several, to compare them, in a list'
        )
    return float(value)


def _check_places(value: Any, sites: list[Site]) -> None:
    occupied = {site.place for site in sites}
    with_input = {site.place for site in sites if _has_input(site.damper)}
    if isinstance(value, Mapping) and (passive := [place for place in value if place in occupied - with_input]):
        raise InputError(
            f"an input is given for {_place_name(passive[0])}, whose damper has none; leave that place out of the inputs"
        )
    if isinstance(value, Mapping) and (stray := [place for place in value if place not in occupied]):
        raise InputError(
            f"an input is given for {_place_name(stray[0])}, which holds no damper; "
            f"dampers stand in {', '.join(_place_name(place) for place in dict.fromkeys(s.place for s in sites))}"
        )


def _place_name(place: Any) -> str:
    return f"storey {place}" if isinstance(place, int) else f"floors {place[0]}-{place[1]}"
