"""Every kind of step of a campaign as TOML with a value in each field that has no default, to be changed by the operator."""

from __future__ import annotations

from collections import Counter
from dataclasses import MISSING, Field, fields
from typing import Any, get_origin, get_type_hints

from pydantic import BaseModel

from dampyr import registry
from dampyr.campaigns.kinds import REGISTRY, kind
from dampyr.config import origin, split

EXAMPLES = {"m": (4.0, "mm"), "m/s": (10.0, "mm/s"), "Hz": (0.5, "Hz"), "V": (1.0, "V"), "s": (0.5, "s")}


class StepKind(BaseModel):
    """A kind of step: what it is, and its table in a campaign."""

    name: str
    title: str
    text: str


def step_kinds() -> list[StepKind]:
    """All kinds."""
    return [
        StepKind(name=name, title=registry.title(module), text=step_text(name))
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


def _required(cls: Any) -> list[Field[Any]]:
    return [field for field in fields(cls) if field.default is MISSING and field.default_factory is MISSING]


def _example(plain: Any, unit: str, count: int) -> str:
    if get_origin(plain) is tuple:
        return f"[{_example(float, unit, count)}]"
    if plain in (str, bool):
        return '""' if plain is str else "true"
    value, shown = EXAMPLES.get(unit, (1.0, unit))
    return f'"{value * count:g} {shown}"' if shown else f"{value * count:g}"
