"""A part of a damper: its parameters, states and formulas, read from its file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache, wraps
from types import ModuleType
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

import numpy as np

from dampyr.errors import InputError
from dampyr.models.codegen.formula import Formula, multiplied, read
from dampyr.registry import member
from dampyr.units import Quantity

REGISTRY = "dampyr.models.parts"
POINTS = 16  # at which a force is compared with the motion, on both sides of every kink
_Class = TypeVar("_Class", bound=type)


@dataclass(frozen=True)
class Scale:
    """The size of a record, for initial guesses: peak-to-peak stroke [m], peak speed [m/s], dt [s], large force [N]."""

    stroke: float
    speed: float
    dt: float
    force: float


def quantities(cls: type) -> dict[str, Quantity]:
    """The parameters of a part's dataclass: name -> meaning and allowed values."""
    parameters = {}
    for name, hint in get_type_hints(cls, include_extras=True).items():
        if get_origin(hint) is Annotated:
            parameters[name] = next(a for a in get_args(hint) if isinstance(a, Quantity))
    return parameters


def checked(cls: _Class) -> _Class:
    """Check each parameter against its allowed range when a part is made."""
    made: Callable[..., None] = cls.__init__  # type: ignore[misc]

    @wraps(made)
    def init(self: Any, *args: Any, **kwargs: Any) -> None:
        made(self, *args, **kwargs)
        for name, quantity in quantities(cls).items():
            quantity.check(f"{cls.__name__}.{name}", getattr(self, name))

    cls.__init__ = init  # type: ignore[misc]
    return cls


@dataclass(frozen=True)
class Part:
    """One part, as its file describes it to compositions, fits and exports.

    There is one object for each name (see `part`), so that each of its traits is read from the file once.
    """

    name: str
    cls: type
    module: ModuleType

    @cached_property
    def parameters(self) -> dict[str, Quantity]:
        """Parameter name -> quantity, in the order of the file."""
        by_name = quantities(self.cls)
        return {f.name: by_name[f.name] for f in fields(self.cls)}

    @cached_property
    def states(self) -> dict[str, tuple[float, float]]:
        """State name -> its bounds; every state is 0 at rest."""
        return getattr(self.module, "STATES", {})

    @cached_property
    def starts_at_rest(self) -> bool:
        """Whether the states are 0 at the start of every record: a fit does not find them."""
        return getattr(self.module, "STARTS_AT_REST", False)

    @cached_property
    def constant(self) -> tuple[str, ...]:
        """The parameters that do not follow the input, unless a fit is told a law for one by its name."""
        return getattr(self.module, "CONSTANT", ())

    @cached_property
    def scaling(self) -> tuple[str, ...]:
        """The parameters to which the force is proportional together; where each is linear, it is so to each."""
        return getattr(self.module, "SCALE_TOGETHER", tuple(key for key, q in self.parameters.items() if q.linear))

    @cached_property
    def within_stroke(self) -> tuple[str, ...]:
        """States in m that cannot be farther at the start of a record than the damper's ends have moved in all of them."""
        return getattr(self.module, "WITHIN_STROKE", ())

    @cached_property
    def advance(self) -> Formula | None:
        """The formula that moves the states, if there are any."""
        return read(self.module.advance, f"{self.name}_advance") if self.states else None

    @cached_property
    def force(self) -> Formula | None:
        """The formula of the force, if the part has one of its own."""
        return read(self.module.force, f"{self.name}_force") if hasattr(self.module, "force") else None

    @cached_property
    def force_in_series(self) -> Formula | None:
        """The formula of the force behind an element that stretches: that of `force` unless the file has one for this.

        It must not fall while the velocity rises, through the memory or directly: the stretch is found from it.
        """
        own = hasattr(self.module, "force_in_series")
        return read(self.module.force_in_series, f"{self.name}_force_in_series") if own else self.force

    @cached_property
    def rises_in_series(self) -> bool:
        """Whether the force behind an element that stretches may rise with a guess at it, by less than half of that."""
        return getattr(self.module, "RISES_IN_SERIES", False)

    @cached_property
    def rates(self) -> Formula | None:
        """The formula of the time derivatives of the states at x and v, if they follow a differential equation."""
        return read(self.module.rates, f"{self.name}_rates") if hasattr(self.module, "rates") else None

    @cached_property
    def switches(self) -> Formula | None:
        """The formula, one return, of what changes its sign where the rates have a kink, if they have any."""
        return read(self.module.switches, f"{self.name}_switches") if hasattr(self.module, "switches") else None

    @cached_property
    def stretch(self) -> Formula | None:
        """The formula of the stretch in series with the other parts, if the part has one."""
        return read(self.module.stretch, f"{self.name}_stretch") if hasattr(self.module, "stretch") else None

    @cached_property
    def factor(self) -> Formula | None:
        """The formula that multiplies the force of the other parts, one expression of v and its parameters, if there is one."""
        return read(self.module.factor, f"{self.name}_factor") if hasattr(self.module, "factor") else None

    @cached_property
    def shared(self) -> dict[str, str]:
        """Arguments of the force that are parameters of another part, by their flat names (`MultipliedPart`)."""
        return {}

    @cached_property
    def delay(self) -> str | None:
        """The name of the parameter that delays the whole damper, if this part is a delay."""
        return getattr(self.module, "DELAY", None)

    @cached_property
    def lag(self) -> str | None:
        """The name of the parameter by which the input lags behind its command, if this part is a lag."""
        return getattr(self.module, "LAG", None)

    @cached_property
    def speed(self) -> str | None:
        """The name of the parameter within whose speed the force changes, if the samples must follow that."""
        return getattr(self.module, "SPEED", None)

    @cached_property
    def search_starts(self) -> int:
        """From how many points a search of its parameters begins, where nobody says it: one alone may end beside the best."""
        return getattr(self.module, "SEARCH_STARTS", 1)

    @cached_property
    def add_on(self) -> bool:
        """Whether the part complements the model of a damper and is none by itself."""
        return getattr(self.module, "ADD_ON", False)

    @cached_property
    def holds(self) -> tuple[str, ...]:
        """The add-ons that the part includes already."""
        return getattr(self.module, "HOLDS", ())

    @cached_property
    def not_for_buildings(self) -> str:
        """Why the part must not stand in for a damper of a building, and what may; empty where it may."""
        return getattr(self.module, "NOT_FOR_BUILDINGS", "")

    @cached_property
    def not_tried(self) -> str:
        """Why a leaderboard does not try the part unless it is told to by name; empty where it does."""
        return getattr(self.module, "NOT_TRIED", "")

    @cached_property
    def unbounded(self) -> str:
        """Why the force may be infinite along a path of finite length, which is refused then; empty where it cannot."""
        return getattr(self.module, "UNBOUNDED", "")

    @cached_property
    def static(self) -> bool:
        """Whether the part is a static force that a building leaves out."""
        return getattr(self.module, "STATIC", False)

    @cached_property
    def path_only(self) -> bool:
        """Whether the states depend on the path alone, not on the speed along it."""
        return self.advance is None or not {"v0", "v1", "dt"} & set(self.advance.arguments)

    @cached_property
    def follows_velocity(self) -> bool:
        """Whether the states follow the velocity of the part, so that they need the one at the start of a step."""
        return self.advance is not None and "v0" in self.advance.arguments

    @cached_property
    def needs_acceleration(self) -> bool:
        """Whether the force needs the acceleration; in series such a part acts in parallel with the others."""
        return self.force is not None and "a" in self.force.arguments

    @cached_property
    def proportional_to(self) -> dict[str, str]:
        """Parameter -> the motion that its force is proportional to, ``"x"``, ``"v"``, ``"a"`` or ``"1"``, where it is one.

        Such as c of c v. Seen at points that are drawn once, so that no part must state it.
        """
        if self.force is None:
            return {}
        draws = np.random.default_rng(0)
        signed = set(self.force.arguments) - set(self.parameters)
        points = [
            {name: float(draws.uniform(-1.0 if name in signed else 0.5, 1.5)) for name in self.force.arguments}
            for _ in range(POINTS)
        ]
        motions = {"1": np.ones(POINTS)} | {
            name: np.array([at[name] for at in points]) for name in ("x", "v", "a") if name in self.force.arguments
        }
        proportional: dict[str, str] = {}
        for key, quantity in self.parameters.items():
            if not quantity.linear or key not in self.force.arguments:
                continue
            changes = [self._change(at, key) for at in points]
            same = [name for name, values in motions.items() if np.allclose(changes, values, rtol=1e-9, atol=1e-12)]
            if same:
                proportional[key] = same[0]
        return proportional

    def _change(self, at: dict[str, float], key: str) -> float:
        """Of the force at a point when a parameter grows by 1."""
        return float(self.module.force(**(at | {key: at[key] + 1.0})) - self.module.force(**at))

    def starts(self, scale: Scale) -> list[dict[str, float]]:
        """Values of the parameters that are not linear, as initial guesses of a fit."""
        propose: Callable[[Scale], Iterator[dict[str, float]]] | None = getattr(self.module, "starts", None)
        return list(propose(scale)) if propose else [{}]


@dataclass(frozen=True)
class MultipliedPart(Part):
    """A part whose force is multiplied by what the part ``by`` says (`Part.factor`)."""

    by: Part

    @cached_property
    def force(self) -> Formula | None:
        """The formula of the force, with the parameters of the factor after its own."""
        assert self.by.factor is not None
        plain = read(self.module.force, f"{self.name}_force")
        return multiplied(plain, self.by.factor, f"{self.name}_force_by_{self.by.name}", f"{self.by.name}_")

    @cached_property
    def shared(self) -> dict[str, str]:
        """The parameters of the factor."""
        return {f"{self.by.name}_{key}": f"{self.by.name}.{key}" for key in self.by.parameters}

    @cached_property
    def proportional_to(self) -> dict[str, str]:
        """As without the factor, which all parts have alike."""
        return part(self.name).proportional_to


@lru_cache(maxsize=64)
def part(name: str) -> Part:
    """The part called ``name``; :class:`~dampyr.errors.InputError` lists the names if there is none."""
    module = member(REGISTRY, name)
    wanted = name.replace("_", "")
    cls = next(c for n, c in vars(module).items() if isinstance(c, type) and n.lower() == wanted)
    result = Part(name, cls, module)
    motion = {"x0", "x1", "v0", "v1", "dt"} if result.states else {"x", "v", "a", "f"}
    taken = sorted(motion & {*result.parameters, *result.states})
    if taken:
        raise TypeError(
            f"{name}: {taken[0]!r} means the motion in its formulas, so no parameter or state can have this name"
        )
    return result


def part_name(model: object) -> str:
    """The name of the part whose object ``model`` is: ``"dahl"`` for ``Dahl(...)``; InputError for anything else."""
    cls = model if isinstance(model, type) else type(model)
    package, _, name = cls.__module__.rpartition(".")
    if package != REGISTRY or part(name).cls is not cls:
        raise InputError(f"{model!r} is not a part of a damper; give names such as 'dahl' or objects such as Dahl(...)")
    if isinstance(model, type):
        needed = ", ".join(f"{key}=..." for key in part(name).parameters)
        raise InputError(f"{cls.__name__} is a class without numbers; give {cls.__name__}({needed})")
    return name
