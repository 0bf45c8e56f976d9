"""Every kind of step of a campaign as TOML with a value in each field that has no default, to be changed by the operator."""

from __future__ import annotations

from collections import Counter
from dataclasses import MISSING, Field, fields
from typing import Any, get_args, get_origin, get_type_hints

from pydantic import BaseModel

from dampyr import registry
from dampyr.campaigns.kinds import REGISTRY, kind
from dampyr.config import is_required, origin, split

SHOWN = {"m": (1e3, "mm"), "m/s": (1e3, "mm/s")}
TYPES = {str: "text", bool: "yes", int: "whole"}
EXAMPLES = {"m": (4.0, "mm"), "m/s": (10.0, "mm/s"), "Hz": (0.5, "Hz"), "V": (1.0, "V"), "s": (0.5, "s")}


class StepField(BaseModel):
    """A field of a step: its ``unit`` where a person types it ("" for none), its ``value`` to begin from, and what it means.

    ``type`` is number, whole, text or yes; ``several`` says that a list makes a test of each value, or is one test's own.
    """

    name: str
    unit: str
    type: str
    value: str
    words: str
    required: bool
    several: bool


class StepKind(BaseModel):
    """A kind of step: what it is, its table in a campaign, and its fields."""

    name: str
    title: str
    text: str
    fields: list[StepField]


def step_kinds() -> list[StepKind]:
    """All kinds."""
    return [
        StepKind(name=name, title=registry.title(module), text=step_text(name), fields=step_fields(name))
        for name, module in registry.members(REGISTRY)
    ]


def step_text(name: str) -> str:
    """A step of one kind; of several fields with one unit each has a larger value than the one before."""
    cls, units = kind(name), Counter[str]()
    hints = get_type_hints(cls, include_extras=True)
    lines = ["[[step]]", f'kind = "{name}"']
    for field in _required(cls):
        plain, quantity = split(hints[field.name])
        unit = quantity.unit if quantity else ""
        units[unit] += 1
        value = _example(plain, unit, units[unit])
        lines.append(f"{field.name} = {value}  # {origin(hints[field.name])}".rstrip(" #"))
    return "\n".join(lines) + "\n"


def step_fields(name: str) -> list[StepField]:
    """The fields of a step of one kind, those without a default first; lengths in mm."""
    cls, units = kind(name), Counter[str]()
    hints = get_type_hints(cls, include_extras=True)
    required = {field.name for field in _required(cls)}
    shown = []
    for field in sorted(fields(cls), key=lambda field: field.name not in required):
        if not field.init or field.name == "contents":
            continue
        plain, quantity = split(hints[field.name])
        unit = quantity.unit if quantity else ""
        units[unit] += 1
        factor, shown_unit = SHOWN.get(unit, (1.0, unit))
        several = get_origin(plain) is tuple
        inner = get_args(plain)[0] if several else plain
        value = _value(field, factor) if field.name not in required else _example_shown(inner, unit, units[unit])
        shown.append(
            StepField(
                name=field.name,
                unit=shown_unit,
                type=TYPES.get(inner, "number"),
                value=value,
                words=origin(hints[field.name]),
                required=field.name in required,
                several=several,
            )
        )
    return shown


def _value(field: Field[Any], factor: float) -> str:
    value = field.default_factory() if field.default_factory is not MISSING else field.default
    listed = value if isinstance(value, tuple) else (value,)
    return "; ".join(_typed(item, factor) for item in listed if item is not None)


def _typed(value: Any, factor: float) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value * factor:.10g}" if isinstance(value, int | float) else str(value)


def _example_shown(plain: Any, unit: str, count: int) -> str:
    if plain in (str, bool):
        return "" if plain is str else "yes"
    return f"{EXAMPLES.get(unit, (1.0, unit))[0] * count:g}"


def _required(cls: Any) -> list[Field[Any]]:
    return [field for field in fields(cls) if is_required(field)]


def _example(plain: Any, unit: str, count: int) -> str:
    if get_origin(plain) is tuple:
        return f"[{_example(float, unit, count)}]"
    if plain in (str, bool):
        return '""' if plain is str else "true"
    value, shown = EXAMPLES.get(unit, (1.0, unit))
    return f'"{value * count:g} {shown}"' if shown else f"{value * count:g}"
