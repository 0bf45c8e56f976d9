"""Commented ``rig.toml``: every value with its unit and its origin."""

from __future__ import annotations

import json
from dataclasses import fields, is_dataclass
from datetime import date
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
            summary = (cls.__doc__ or "").strip().split("\n")[0]
            lines.append(f"\n[{name}] # {summary}\n")
            for key, hint in get_type_hints(cls, include_extras=True).items():
                quantity = split(hint)[1]
                remark = "; ".join(filter(None, (quantity.unit if quantity else "", origin(hint))))
                item = getattr(value, key)
                if item is None:
                    lines.append(f"# {key} = {{ date = 2026-03-01, expires = 2027-03-01 }}  # {remark}\n")
                else:
                    lines.append(f"{key} = {_toml(item)}{f'  # {remark}' if remark else ''}\n")
    write_whole(path, HEAD + "".join(lines))
    return path


def _toml(value: Any) -> str:
    """A value as TOML writes it; a float keeps every bit."""
    if is_dataclass(value):
        held = ((field.name, getattr(value, field.name)) for field in fields(value))
        return f"{{ {', '.join(f'{name} = {_toml(item)}' for name, item in held if item is not None)} }}"
    if isinstance(value, date):
        return value.isoformat()
    if isinstance(value, bool):
        return "true" if value else "false"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)
