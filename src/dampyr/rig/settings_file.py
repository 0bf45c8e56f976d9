"""Commented ``rig.toml``: every value with its unit and its origin."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path
from typing import Any, get_type_hints

from dampyr.atomic_write import write_whole
from dampyr.config import origin, split
from dampyr.rig.settings import RigSettings

HEAD = (
    "# A rig, as dampyr reads it. What is left out keeps its default; quantities may be typed with a unit, such as\n"
    '# free_speed = "78 mm/s". Remarks say the unit, and where the value comes from that dampyr comes with.\n\n'
)


def write_settings(settings: RigSettings, path: str | Path) -> Path:
    """Write a commented ``rig.toml``, whole or not at all; `load_settings` gives equal settings back."""
    path, lines = Path(path), []
    for name, cls in get_type_hints(RigSettings).items():
        value = getattr(settings, name)
        if isinstance(value, str):
            lines.append(f"{name} = {_toml(value)}\n")
        else:
            words = (cls.__doc__ or "").strip().split("\n")[0]
            lines.append(f"\n[{name}] # {words}\n" + "".join(_lines(value)))
    write_whole(path, HEAD + "".join(lines))
    return path


def _lines(table: Any) -> list[str]:
    """The lines of one table."""
    hints = get_type_hints(type(table), include_extras=True)
    return [f"{f.name} = {_toml(getattr(table, f.name))}{_remark(hints[f.name])}\n" for f in fields(table)]


def _remark(hint: Any) -> str:
    """Unit and origin of a value."""
    _, quantity = split(hint)
    said = [quantity.unit if quantity else "", origin(hint)]
    words = "; ".join(part for part in said if part)
    return f"  # {words}" if words else ""


def _toml(value: Any) -> str:
    """A value as TOML writes it; a float keeps every bit."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)
