"""Control laws by name, checked against the building and the damper that they control."""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterable
from dataclasses import MISSING, Field, fields
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr import registry, units
from dampyr.errors import InputError
from dampyr.models.inverse import check_invertible
from dampyr.models.part import quantities
from dampyr.structures.controller import REGISTRY, asks_force, class_in, module_of
from dampyr.structures.law_form import ControlLaw
from dampyr.structures.sensors import MEASURES, Sensor

Array = NDArray[np.float64]
MIN_LAG = 2e-5  # s, as `dampyr.structures.sites.MIN_DELAY`: steps resolve the lag
MAX_PARTS = 400  # of a sample of the motion: steps of 50 us at 20 ms, far below the period of any controller


def available_control_laws() -> list[str]:
    """The names of the laws in the registry ``dampyr.structures.control``."""
    return registry.names(REGISTRY)


def control_law(name: str, **settings: Any) -> Any:
    """The law called ``name``, such as ``control_law("on_off", high=3.212)``, as an input for `respond` and `ensemble`.

    ``low`` (default 0) and ``high`` [V or A, as the damper takes it] are the least and the greatest input, ``period`` the
    time between decisions (default 0.005 s), ``lag`` the time constant of the coil (default 0 s: it follows at once; a
    damper with the part ``lag`` has its own). ``sensors``, a mapping from what the law measures to a
    :class:`~dampyr.structures.sensors.Sensor`, give noise, bias, quantum, range and delay, ``seed`` the noise; what is not
    in it is measured ideally. Other settings are the law's own; its file in ``dampyr.structures.control`` says what they
    mean, and when not to use it.

    Raises :class:`~dampyr.errors.InputError` for a name, a setting or a value that is not allowed.

    Examples
    --------
    >>> import dampyr as dp
    >>> dp.structures.control_law("on_off", high=3.212, lag=0.01)
    OnOff(low=0.0, high=3.212, period=0.005, lag=0.01, sensors=(), seed=1)
    """
    cls = class_in(registry.member(REGISTRY, name))
    allowed = {field.name: field for field in fields(cls)}
    settings = {"low": 0.0} | settings
    unknown = [key for key in settings if key not in allowed]
    if unknown:
        raise InputError(f"{unknown[0]!r} is not a setting of {name}; it has {', '.join(allowed)}")
    missing = [key for key, field in allowed.items() if field.default is MISSING and key not in settings]
    if missing:
        raise InputError(f"{name} needs {missing[0]}; write {missing[0]}=, a number")
    given = {key: settings.pop(key) for key in ("sensors", "seed") if key in settings}
    law = cls(**{key: _number(name, allowed[key], value) for key, value in settings.items()}, **given)
    _check_order(law)
    return law


def control_laws_of(name: str, **settings: Any) -> list[Any]:
    """The laws of every combination of the settings, of which some are lists: the gains to choose from in a search.

    >>> import dampyr as dp
    >>> laws = dp.structures.control_laws_of("clipped_optimal", high=3.0, effort=[0.01, 0.1], lag=[0.0, 0.01])
    >>> len(laws)
    4

    Raises :class:`~dampyr.errors.InputError` as `control_law` does, and for a list without a value.
    """
    several = {key: list(value) for key, value in settings.items() if isinstance(value, list | np.ndarray)}
    for key, values in several.items():
        if not values:
            raise InputError(f"{key} = [] of {name} has no value to choose from; give one or more")
    one = {key: value for key, value in settings.items() if key not in several}
    return [
        control_law(name, **one, **dict(zip(several, values, strict=True))) for values in product(*several.values())
    ]


def law_of(text: str, damper: Any) -> Any:
    """The control law written as ``on_off:lag=10ms,high=3``, over the damper's calibrated range unless it gives low and high.

    Several weights are parted by slashes, ``lyapunov:weights=1/2/3/4``; the number of a sensor has the name of what it
    measures before it, ``bang_bang:force.noise=3,force.delay=1,seed=4``.
    """
    name, _, rest = text.partition(":")
    low, high = damper.range
    settings: dict[str, Any] = {"low": low, "high": high}
    sensors: dict[str, dict[str, Any]] = {}
    for part in rest.split(",") if rest else []:
        key, equals, value = (word.strip() for word in part.partition("="))
        if not equals:
            raise InputError(
                f"control law {text!r}: {part!r} is not a setting; write it as in on_off:period=0.01,lag=0.005"
            )
        measure, point, fault = key.partition(".")
        if point:
            sensors.setdefault(measure, {})[_fault(text, key, fault)] = _in_unit_of(measure, fault, value)
        else:
            settings[key] = value.split("/") if key == "weights" else _value_of_text(key, value)
    if sensors:
        settings["sensors"] = {measure: Sensor(**faults) for measure, faults in sensors.items()}
    return control_law(name, **settings)


def _fault(text: str, key: str, fault: str) -> str:
    allowed = [field.name for field in fields(Sensor)]
    if fault not in allowed:
        raise InputError(f"control law {text!r}: {key!r} is no number of a sensor; it has {', '.join(allowed)}")
    return fault


def _in_unit_of(measure: str, fault: str, value: str) -> Any:
    """The number of a sensor, in the SI unit of what it measures or with a unit, ``0.05m/s^2``; a delay is in samples."""
    try:
        return float(value)
    except ValueError:
        known = measure in MEASURES and fault != "delay"
        return units.parse(value, MEASURES[measure].unit) if known else value


def _value_of_text(key: str, value: str) -> Any:
    """A number in SI units, or for a time one with its unit, ``5ms``; what is neither is left to the law to refuse."""
    try:
        return float(value)
    except ValueError:
        return units.parse(value, "s") if key in ("period", "lag") else value


def _number(name: str, field: Field[Any], value: Any) -> Any:
    """A setting as a float, or a tuple of them where the default is one."""
    try:
        return tuple(float(v) for v in value) if isinstance(field.default, tuple) else float(value)
    except (TypeError, ValueError):
        several = "numbers" if isinstance(field.default, tuple) else "a number"
        raise InputError(f"{field.name} = {value!r} of {name} is not {several}") from None


def is_control_law(value: Any) -> bool:
    """Whether ``value`` is a law."""
    return isinstance(value, ControlLaw)


def _name(law: Any) -> str:
    return module_of(law).__name__.rpartition(".")[2]


def describe_law(law: Any, unit: str = "") -> str:
    """A law in short, for labels: its name, its inputs, and the settings that are not the default."""
    description = f"{_name(law)} {law.low:g} to {law.high:g} {unit}".rstrip()
    other = [field for field in fields(law) if field.name not in ("low", "high", "sensors")]
    changed = [field for field in other if getattr(law, field.name) != field.default]
    settings = [f"{field.name} {_short(getattr(law, field.name))}{_unit(law, field.name)}" for field in changed]
    return ", ".join([description, *settings, *(sensor.in_words(measure) for measure, sensor in law.sensors)])


def _short(value: Any) -> str:
    return "(" + " ".join(f"{v:g}" for v in value) + ")" if isinstance(value, tuple) else f"{value:g}"


def _unit(law: Any, name: str) -> str:
    quantity = quantities(type(law)).get(name)
    return f" {quantity.unit}" if quantity and quantity.unit else ""


def spelled(law: Any) -> str:
    """A law with all its settings, exactly, and the source of its file: for a digest."""
    values = [(field.name, getattr(law, field.name)) for field in fields(law) if field.name != "sensors"]
    exact = ", ".join(f"{k}={tuple(map(float, v)) if isinstance(v, tuple) else float(v)!r}" for k, v in values)
    return f"{_name(law)}({exact}) {law.sensors!r}\n{inspect.getsource(module_of(law))}"


def values_at(law: Any, damper: Any, allow_extrapolation: bool = False) -> Array:
    """The parameters of a damper (201, P) from the least input of ``law`` to the greatest, static forces left out.

    Raises InputError unless the law can control the damper: its inputs in the calibrated range (or extrapolation allowed), one
    lag, a constant delay, and for a law that asks for a force a damper whose force an input of the same step can choose.
    """
    _check_order(law)
    values: Array = damper.values(np.linspace(law.low, law.high, 201), False, allow_extrapolation)
    lag_of(law, damper)
    if asks_force(law):
        check_invertible(damper)
    k = damper.composition.delay
    if k is not None and np.ptp(values[:, k]) > 0:
        raise InputError(
            f"the delay of this damper changes with its input, which {_name(law)} cannot follow; "
            'give it a constant delay, or leave it out with .without("delay")'
        )
    return values


def _check_order(law: Any) -> None:
    if not law.low <= law.high:
        raise InputError(f"low = {law.low:g} of {_name(law)} is above high = {law.high:g}; exchange them")
    if not 0 < law.period < math.inf:
        raise InputError(f"period = {law.period:g} s of {_name(law)} is not allowed; it must be greater than 0")


def check_decided(law: Any, where: str, low: float, high: float) -> None:
    """Raise InputError where the least or the greatest decision of ``law`` is outside its own bounds."""
    slack = 1e-9 * max(abs(law.low), abs(law.high), 1.0)
    if not law.low - slack <= low <= high <= law.high + slack:
        raise InputError(
            f"the law {where} asked for {low if low < law.low else high:g}; it must stay between its low = {law.low:g} and "
            f"high = {law.high:g}"
        )


def lag_of(law: Any, damper: Any) -> float:
    """The time constant [s] by which the coil follows the law: the damper's own part ``lag``, or the law's setting."""
    if damper.input_lag > 0 and law.lag > 0:
        raise InputError(
            f"the damper has a lag of {damper.input_lag:g} s and {_name(law)} one of {law.lag:g} s; "
            "leave one of the two out, as they are the same coil"
        )
    lag = max(damper.input_lag, law.lag)
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
