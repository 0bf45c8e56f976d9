"""Differences between what a folder was begun with and what is asked of it now, in words: the campaign, the rig's settings."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, get_type_hints

from dampyr.campaigns.campaign import Campaign, Test
from dampyr.campaigns.step import shown
from dampyr.config import split
from dampyr.rig.settings import RigSettings
from dampyr.units import for_people

LEARN = "learn"
LISTED = 3  # differences that are named; of more, how many there are


def contents_of(campaign: Campaign) -> str:
    """All that a campaign runs as JSON, SI: name, kind and fields of each test, and what is in the files that it names."""
    return json.dumps([[test.name, test.kind, _fields(test)] for test in campaign.tests], default=str)


def _fields(test: Test) -> dict[str, Any]:
    files = {f"{name} (contents)": digest for name, digest in test.contents.items()}
    return dataclasses.asdict(test.step) | files | ({LEARN: True} if test.learn else {})


def campaign_differences(saved: str, names: Sequence[str], campaign: Campaign) -> str:
    """What a campaign runs differently from the one whose `contents_of` was ``saved``, in words.

    ``names`` are those of the saved one's tests, for a journal of before 2026-11-23, which has no contents.
    """
    before = {name: (kind, fields) for name, kind, fields in (json.loads(saved) if saved else ())}
    names = list(before) or list(names)
    now = {test.name: test for test in campaign.tests}
    differences = [f"{name} is not in it any more" for name in names if name not in now]
    differences += [f"{name} is new in it" for name in now if name not in names]
    if not differences and names != list(now):
        differences.append("its tests have another order")
    for name, (_, fields) in before.items():
        if name in now:
            differences += [f"{name}: {words}" for words in _step_differences(fields, now[name])]
    return _list_first(differences) or "the fields of its steps differ"


def step_differences(saved: str, test: Test) -> str:
    """How a test differs from the step that was ``saved`` as JSON, in words; empty where it does not."""
    return _list_first(list(_step_differences(json.loads(saved), test)))


def _step_differences(before: Mapping[str, Any], test: Test) -> Iterator[str]:
    now = json.loads(json.dumps(_fields(test), default=str))
    if before.get(LEARN, False) != now.get(LEARN, False):
        yield "its drive is learned now, and was not" if test.learn else "its drive was learned, and is not now"
    for name, value in now.items():
        if name in test.contents:  # a path: what counts is what is in the file
            continue
        if name in before and before[name] != value:
            if name.endswith(" (contents)"):
                yield f"the file of its {name.removesuffix(' (contents)')} holds something else"
            else:
                yield f"{name} was {_readable_field(test, name, before[name])}, is {_readable_field(test, name, value)}"


def _readable_field(test: Test, name: str, value: Any) -> str:
    """A field with its unit, as far as the value is one that the step may have."""
    value = tuple(value) if isinstance(value, list) else value
    try:
        return shown(dataclasses.replace(test.step, **{name: value}), name).removeprefix(f"{name} ") or str(value)
    except (ValueError, TypeError):
        return str(value)


def settings_differences(saved: str, rig: RigSettings) -> str:
    """How a rig differs from the settings that were ``saved`` as JSON, in words; empty where it does not."""
    before, now = json.loads(saved), json.loads(json.dumps(dataclasses.asdict(rig), default=str))
    differences = []
    for table, value in now.items():
        hints = get_type_hints(type(getattr(rig, table)), include_extras=True) if isinstance(value, dict) else {}
        pairs = value.items() if isinstance(value, dict) else [("", value)]
        for name, new in pairs:
            old = before.get(table, new)
            old = old.get(name, new) if name and isinstance(old, dict) else old
            if old != new:
                where, quantity = f"{table}.{name}".rstrip("."), split(hints.get(name))[1]
                unit = quantity.unit if quantity else ""
                differences.append(f"{where} was {_readable(old, unit)}, is {_readable(new, unit)}")
    return "; ".join(differences)


def _readable(value: Any, unit: str) -> str:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return repr(value)
    word, factor = for_people(unit) if unit else ("", 1.0)
    return f"{value * factor:.6g} {word}".strip()


def _list_first(differences: Sequence[str]) -> str:
    more = [f"and {len(differences) - LISTED} more"] if len(differences) > LISTED else []
    return "; ".join([*differences[:LISTED], *more])
