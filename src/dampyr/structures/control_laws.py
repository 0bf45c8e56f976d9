"""Control laws by name, checked against the building and the damper that they control."""

from __future__ import annotations

import inspect
import math
import sys
from collections.abc import Iterable
from dataclasses import MISSING, Field, fields, is_dataclass
from fractions import Fraction
from functools import lru_cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr import registry, units
from dampyr.errors import InputError
from dampyr.models.codegen.formula import read
from dampyr.models.part import quantities

Array = NDArray[np.float64]
REGISTRY = "dampyr.structures.control"
SENSED = ("signal", "stroke", "rate", "force")
NEEDED = ("low", "high", "period", "lag")
MIN_LAG = 2e-5  # s, as `dampyr.structures.sites.MIN_DELAY`: steps resolve the lag
MAX_PARTS = 400  # of a sample of the motion: steps of 50 us at 20 ms, far below the period of any controller


def available_control_laws() -> list[str]:
    """The names of the laws in the registry ``dampyr.structures.control``."""
    return registry.names(REGISTRY)


def control_law(name: str, **settings: Any) -> Any:
    """The law called ``name``, such as ``control_law("on_off", high=3.212)``, as an input for `respond` and `ensemble`.

    ``low`` (default 0) and ``high`` [V or A, as the damper takes it] are the least and the greatest input, ``period`` the
    time between decisions (default 0.005 s), ``lag`` the time constant of the coil (default 0 s: it follows at once; a
    damper with the part ``lag`` has its own). Other settings are the law's own; its file in
    ``dampyr.structures.control`` says what they mean, and when not to use it.

    Raises :class:`~dampyr.errors.InputError` for a name, a setting or a value that is not allowed.

    Examples
    --------
    >>> import dampyr as dp
    >>> dp.structures.control_law("on_off", high=3.212, lag=0.01)
    OnOff(low=0.0, high=3.212, period=0.005, lag=0.01)
    """
    cls = _class(registry.member(REGISTRY, name))
    allowed = {field.name: field for field in fields(cls)}
    settings = {"low": 0.0} | settings
    unknown = [key for key in settings if key not in allowed]
    if unknown:
        raise InputError(f"{unknown[0]!r} is not a setting of {name}; it has {', '.join(allowed)}")
    missing = [key for key, field in allowed.items() if field.default is MISSING and key not in settings]
    if missing:
        raise InputError(f"{name} needs {missing[0]}; write {missing[0]}=, a number")
    law = cls(**{key: _number(name, allowed[key], value) for key, value in settings.items()})
    _check_order(law)
    return law


def law_of(text: str, damper: Any) -> Any:
    """The control law written as ``on_off:lag=10ms,high=3``, over the damper's calibrated range unless it gives low and high.

    Several weights are parted by slashes, ``lyapunov:weights=1/2/3/4``.
    """
    name, _, rest = text.partition(":")
    low, high = damper.range
    settings: dict[str, Any] = {"low": low, "high": high}
    for part in rest.split(",") if rest else []:
        key, equals, value = (word.strip() for word in part.partition("="))
        if not equals:
            raise InputError(
                f"control law {text!r}: {part!r} is not a setting; write it as in on_off:period=0.01,lag=0.005"
            )
        settings[key] = value.split("/") if key == "weights" else _value_of_text(key, value)
    return control_law(name, **settings)


def _value_of_text(key: str, value: str) -> Any:
    """A number in SI units, or for a time one with its unit, ``5ms``; what is neither is left to the law to refuse."""
    try:
        return float(value)
    except ValueError:
        return units.parse(value, "s") if key in ("period", "lag") else value


def _class(module: ModuleType) -> type:
    wanted = module.__name__.rpartition(".")[2].replace("_", "")
    return next(cls for name, cls in vars(module).items() if isinstance(cls, type) and name.lower() == wanted)


def _number(name: str, field: Field[Any], value: Any) -> Any:
    """A setting as a float, or a tuple of them where the default is one."""
    try:
        return tuple(float(v) for v in value) if isinstance(field.default, tuple) else float(value)
    except (TypeError, ValueError):
        several = "numbers" if isinstance(field.default, tuple) else "a number"
        raise InputError(f"{field.name} = {value!r} of {name} is not {several}") from None


def is_control_law(value: Any) -> bool:
    """Whether ``value`` is a law: a dataclass whose file has ``gains`` and ``decide``."""
    if isinstance(value, type) or not is_dataclass(value):
        return False
    return all(hasattr(_module(value), name) for name in ("gains", "decide"))


def _module(law: Any) -> ModuleType:
    return sys.modules[type(law).__module__]


def _name(law: Any) -> str:
    return _module(law).__name__.rpartition(".")[2]


def describe_law(law: Any, unit: str = "") -> str:
    """A law in short, for labels: its name, its inputs, and the settings that are not the default."""
    description = f"{_name(law)} {law.low:g} to {law.high:g} {unit}".rstrip()
    other = [field for field in fields(law) if field.name not in ("low", "high")]
    changed = [field for field in other if getattr(law, field.name) != field.default]
    settings = [f"{field.name} {_short(getattr(law, field.name))}{_unit(law, field.name)}" for field in changed]
    return ", ".join([description, *settings])


def _short(value: Any) -> str:
    return "(" + " ".join(f"{v:g}" for v in value) + ")" if isinstance(value, tuple) else f"{value:g}"


def _unit(law: Any, name: str) -> str:
    quantity = quantities(type(law)).get(name)
    return f" {quantity.unit}" if quantity and quantity.unit else ""


def spelled(law: Any) -> str:
    """A law with all its settings, exactly, and the source of its file: for a digest."""
    values = [(field.name, getattr(law, field.name)) for field in fields(law)]
    exact = ", ".join(f"{k}={tuple(map(float, v)) if isinstance(v, tuple) else float(v)!r}" for k, v in values)
    return f"{_name(law)}({exact})\n{inspect.getsource(_module(law))}"


def values_at(law: Any, damper: Any, allow_extrapolation: bool = False) -> Array:
    """The parameters of a damper (201, P) from the least input of ``law`` to the greatest, static forces left out.

    Raises InputError unless the law can control the damper: its inputs in the calibrated range (or extrapolation allowed), one
    lag, a constant delay.
    """
    _check_order(law)
    values: Array = damper.values(np.linspace(law.low, law.high, 201), False, allow_extrapolation)
    lag_of(law, damper)
    k = damper.composition.delay
    if k is not None and np.ptp(values[:, k]) > 0:
        raise InputError(
            f"the delay of this damper changes with its input, which {_name(law)} cannot follow; "
            'give it a constant delay, or leave it out with .without("delay")'
        )
    return values


def _check_order(law: Any) -> None:
    if missing := [name for name in NEEDED if not hasattr(law, name)]:
        raise InputError(f"{_name(law)} has no setting {missing[0]!r}; every law has {', '.join(NEEDED)}")
    if not law.low <= law.high:
        raise InputError(f"low = {law.low:g} of {_name(law)} is above high = {law.high:g}; exchange them")
    if not 0 < law.period < math.inf:
        raise InputError(f"period = {law.period:g} s of {_name(law)} is not allowed; it must be greater than 0")


def lag_of(law: Any, damper: Any) -> float:
    """The time constant [s] by which the coil follows the law: the damper's own part ``lag``, or the law's setting."""
    k = damper.composition.lag
    of_damper = 0.0 if k is None else float(list(damper.all_laws.values())[k](law.low))
    if of_damper > 0 and law.lag > 0:
        raise InputError(
            f"the damper has a lag of {of_damper:g} s and {_name(law)} one of {law.lag:g} s; "
            "leave one of the two out, as they are the same coil"
        )
    lag = max(of_damper, law.lag)
    if 0 < lag < MIN_LAG:
        raise InputError(f"a lag of {lag:g} s is below the {MIN_LAG:g} s that can be resolved; set it to 0")
    return lag


def parts(laws: Iterable[Any], dt: float) -> int:
    """The least number of steps in a sample of a motion, ``dt`` s, that lets every law decide at the end of a step."""
    count = 1
    for law in laws:
        ratio = Fraction(law.period / dt).limit_denominator(MAX_PARTS)
        if ratio == 0 or abs(float(ratio) * dt / law.period - 1) > 1e-9:
            raise InputError(
                f"the period {law.period:g} s of {_name(law)} does not fit the motion's {dt:g} s; take a multiple of {dt:g} s "
                f"or of a whole part of it, such as {dt / math.ceil(dt / law.period):.6g} s"
            )
        count = math.lcm(count, ratio.denominator)
    if count > MAX_PARTS:
        raise InputError(
            f"the periods of the laws and the motion's {dt:g} s meet only in {count} parts of it, of which "
            f"{MAX_PARTS} are allowed; take periods that are multiples of one another"
        )
    return count


def gains(law: Any, building: Any, row: Array) -> Array:
    """The factors of the state and of the ground's velocity in the signal of a law, (2n + 1,)."""
    values = np.ascontiguousarray(_module(law).gains(law, building, row), dtype=float)
    if values.shape != (2 * building.n + 1,) or not np.all(np.isfinite(values)):
        raise InputError(f"the gains of {_name(law)} must be {2 * building.n + 1} finite numbers, not {values!r}")
    return values


def settings(law: Any) -> Array:
    """The numbers of a law in the order of its fields."""
    return np.array([getattr(law, name) for name in _numbers(type(law))], dtype=float)


def _numbers(cls: Any) -> list[str]:
    return [field.name for field in fields(cls) if not isinstance(field.default, tuple)]


def source(laws: tuple[Any, ...]) -> tuple[str, list[int]]:
    """The Python text of ``decide(kind, ...)``, which chooses among the laws, and the kind of each; None stands for no law.

    All registered laws are in it, so that what is compiled once serves every one of them.
    """
    classes = _law_classes()
    classes += tuple(c for c in dict.fromkeys(type(law) for law in laws if law) if c not in classes)
    return _text(classes), [classes.index(type(law)) if law else -1 for law in laws]


@lru_cache(maxsize=1)
def _law_classes() -> tuple[type, ...]:
    return tuple(_class(module) for _, module in registry.members(REGISTRY))


@lru_cache(maxsize=16)
def _text(classes: tuple[type, ...]) -> str:
    texts: dict[str, str] = {}
    lines = []
    for kind, cls in enumerate(classes):
        formula = read(sys.modules[cls.__module__].decide, f"law_{kind}")
        texts |= {name: read(f, name).source for name, f in formula.intrinsics().items()}
        texts[formula.name] = formula.source
        lines.append(f"if kind == {kind}: return {formula.name}({', '.join(_places(cls, formula.arguments))})")
    head = f"def decide(kind, {', '.join(SENSED)}, p):"
    return "\n\n".join([*texts.values(), "\n    ".join([head, *lines, "return 0.0"])])


def _places(cls: type, arguments: tuple[str, ...]) -> list[str]:
    numbers = _numbers(cls)
    unknown = [name for name in arguments if name not in (*SENSED, *numbers)]
    if unknown:
        raise InputError(
            f"decide of {cls.__name__} asks for {unknown[0]!r}; it may use {', '.join((*SENSED, *numbers))}"
        )
    return [name if name in SENSED else f"p[{numbers.index(name)}]" for name in arguments]
