"""Write campaign-file.md from what the kinds of step say of themselves: ``python docs/reference/make_campaigns.py``."""

from __future__ import annotations

import inspect
import re
import sys
from dataclasses import MISSING, Field, fields
from pathlib import Path
from typing import Any, get_origin, get_type_hints

from dampyr.campaigns import Header, available_steps, kind
from dampyr.config import origin, split
from dampyr.units import Quantity, for_people

PAGE = Path(__file__).with_name("campaign-file.md")
HEAD = """# Campaign file

A campaign is a TOML file: a few lines on the whole, and one table `[[step]]` for each thing to do, whose `kind` is one of those
below. A quantity is a text with its unit, `"12.4 mm"`, or a number in SI. [How to write one](../how-to/campaigns.md).

## Above the steps

{header}

## In every step

| key | what |
|---|---|
| `kind` | one of the kinds below |
| `repeats` | how often each of its tests is run, default 1 |
| `zip` | `true`: lists are taken row by row; else several lists make a grid, whose first list changes slowest |
| `rows` | a CSV table beside the campaign whose header names fields, `peak_to_peak [mm],frequency [Hz]`: a test for each row |
| `peak_to_peak` | twice the `amplitude`, in its place, in every kind that has one |

A list in the place of a value gives one test for each entry. Where a field is a list itself (`voltages`, `speeds`), a list is
one test and a list of lists several.

Every test has a name that follows from the file alone, `03-sine-12.4mm-1.5Hz-0.8712V-r2`: its number as written, its kind, what
is particular, and the repeat. Each begins and ends at rest in the middle of the stroke. With `order = "random"` tests change
places by the seed between those that keep theirs: warm-ups and rests.
"""


def page() -> str:
    """The whole page."""
    return "\n".join([HEAD.format(header=table(Header)), *map(section, available_steps())])


def section(name: str) -> str:
    """What one kind is: its purpose, its path, and its fields."""
    cls = kind(name)
    text = inspect.getdoc(sys.modules[cls.__module__]) or ""
    return "\n".join([f"## `{name}`", "", markdown(text), "", table(cls), ""])


def table(cls: Any) -> str:
    """The fields of a dataclass."""
    hints = get_type_hints(cls, include_extras=True)
    rows = [
        f"| `{f.name}` | {unit(hints[f.name])} | {default(f, hints[f.name])} | {origin(hints[f.name])} |"
        for f in fields(cls)
    ]
    return "\n".join(["| field | unit | default | what |", "|---|---|---|---|", *rows])


def unit(hint: Any) -> str:
    """The SI unit, or what else a value is; of a list, of each entry."""
    plain, quantity = split(hint)
    words = {int: "whole number", str: "text", bool: "true or false", float: "1"}
    label = quantity.unit or "1" if quantity else words[plain]
    label = label if label != "1" else "–"
    return f"list, {label}" if get_origin(plain) is tuple else label


def default(field: Field[Any], hint: Any) -> str:
    """The default as a person types it."""
    if field.default is MISSING:
        return "required"
    _, quantity = split(hint)
    if field.default is None:
        return "none"
    if isinstance(field.default, bool):
        return str(field.default).lower()
    if quantity is None or not quantity.unit:
        return f"{field.default}".removesuffix(".0") or "none"
    return typed(field.default, quantity)


def typed(value: Any, quantity: Quantity) -> str:
    """A value in the unit that people read."""
    unit, factor = ("s", 1.0) if quantity.unit == "s" else for_people(quantity.unit)
    if isinstance(value, tuple):
        return ", ".join(f"{each * factor:g} {unit}" for each in value)
    return f"{value * factor:g} {unit}"


def markdown(text: str) -> str:
    """A docstring of these files as Markdown: displayed equations, mathematics in a line, code."""
    text = re.sub(r"^\.\. math:: (.*(?:\n[ ]+\S.*)*)", lambda m: "$$" + " ".join(m[1].split()) + "$$", text, flags=re.M)
    text = re.sub(r":math:`([^`]+)`", r"$\1$", text)
    return re.sub(r"``([^`]+)``", r"`\1`", text)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
