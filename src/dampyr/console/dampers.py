"""Dampers that can be chosen on a page: the cards of the data folder, and the published ones."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from dampyr import studies
from dampyr.console import safe_paths
from dampyr.errors import DampyrError, InputError
from dampyr.input_kinds import unit_of
from dampyr.models import Damper
from dampyr.origin import Origin

CARDS = "cards"
MAX_CARD = 2**20  # bytes: a card with the covariance of 60 parameters has a tenth


class DamperLink(BaseModel):
    """A damper that can be chosen: its input's unit, empty where it has none, the range it was calibrated on, and its origin,
    which the title says, too, where it is not measured."""

    name: str
    title: str
    unit: str
    low: float
    high: float
    origin: Origin


def damper_of(data: Path, name: str) -> Damper:
    """The damper of a card of the data folder (``cards/NAME.toml``), or the published one of this name."""
    if name.startswith(f"{CARDS}/"):
        path = safe_paths.existing(data, name)
        if (size := path.stat().st_size) > MAX_CARD:
            raise InputError(f"{name} has {size / 1024:.0f} KiB, a card has at most {MAX_CARD // 1024}; choose another")
        return Damper.load(path)
    if name not in studies.available_dampers():  # never a file of this name wherever the console was started
        names = ", ".join([*_cards(data), *studies.available_dampers()])
        raise InputError(f"{name!r} is neither a card nor a published damper; choose from {names}")
    return studies.published_damper(name)


def _cards(data: Path) -> list[str]:
    return [f"{CARDS}/{name}" for name in safe_paths.files(data / CARDS, (".toml",))]


def title_of(name: str) -> str:
    """What a damper is called: a card without its folder, a published set by its name."""
    return name.removeprefix(f"{CARDS}/")


def dampers(data: Path) -> list[DamperLink]:
    """The cards first; what cannot be read is left out."""
    links = []
    cards = _cards(data)
    for name in [*cards, *studies.available_dampers()]:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                damper = damper_of(data, name)
            low, high = damper.range
        except DampyrError:
            continue
        title = name.removeprefix(f"{CARDS}/").removesuffix(".toml") if name in cards else f"published: {name}"
        title += f" ({damper.origin.kind})" if damper.origin.notice else ""
        links.append(
            DamperLink(name=name, title=title, unit=unit_of(damper.input), low=low, high=high, origin=damper.origin)
        )
    return links


def list_dampers(data: Path) -> list[dict[str, Any]]:
    """`dampers` as plain values."""
    return [link.model_dump() for link in dampers(data)]
