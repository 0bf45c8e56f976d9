"""Published studies run again, the published value beside ours, and the demonstration of the whole chain.

A study is one module or package of this folder. Where it has a function ``damper()``, that damper is offered with the published
sets, by the command line and by the console; where it has ``STRUCTURES``, functions by name, so are these structures.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from dampyr import registry
from dampyr.errors import MissingData, did_you_mean

if TYPE_CHECKING:
    from dampyr.models import Damper
    from dampyr.structures import Building

THESIS = "raminelli_2020"
OFFERS_NOTHING = "demo"  # no damper and no structure: it is not loaded for them, nor the whole chain with it


def available_studies() -> list[str]:
    """The names of the studies that `dampyr reproduce` runs: the modules here that have ``reproduce``."""
    return [name for name, study in registry.members(__name__) if hasattr(study, "reproduce")]


def available_dampers() -> list[str]:
    """The names of all published dampers: of the studies that have one, then those of `dampyr.models.published`."""
    from dampyr.models import published

    own = [name for name, study in _offering() if hasattr(study, "damper")]
    return [*own, *published.available_sets()]


def published_damper(name: str) -> Damper:
    """The published damper of this name; :class:`~dampyr.errors.InputError` with the known names if there is none."""
    from dampyr.models import published

    if name in registry.names(__name__) and hasattr(study := registry.member(__name__, name), "damper"):
        damper: Damper = study.damper()
        return damper
    return published.damper(name)


def load_damper(name: str | Path) -> Damper:
    """The damper of a card's file, or the published one of this name, as every command and the console take them.

    :class:`~dampyr.errors.MissingData` lists the names and the files where there is neither.
    """
    from dampyr.models import published

    others = {own: study.damper for own, study in _offering() if hasattr(study, "damper")}
    return published.card_or_published(name, others=others)


def available_structures() -> list[str]:
    """The names of all published structures."""
    return sorted(_structures())


def load_structure(name: str | Path) -> Building:
    """The structure of a file (`dampyr.structures.load`), or the published one of this name, as the command line takes them.

    A file of this name comes first. :class:`~dampyr.errors.MissingData` lists the names where there is neither, or says which
    data of a published structure are not there; :class:`~dampyr.errors.FileError` for a file that is wrong.
    """
    from dampyr import structures

    if Path(name).is_file():
        return structures.load(name)
    published = _structures()
    if str(name) in published:
        return published[str(name)]()
    hint = did_you_mean(str(name), published)
    raise MissingData(
        f"{name}: there is no such file, and no published structure of this name; {hint}published are "
        f"{', '.join(sorted(published))}; dampyr help your-own-structure says how a file is written"
    )


def _structures() -> dict[str, Callable[[], Building]]:
    return {name: make for _, study in _offering() for name, make in getattr(study, "STRUCTURES", {}).items()}


def _offering() -> list[tuple[str, ModuleType]]:
    """The studies that may offer a damper or structures."""
    offering = (name for name in registry.names(__name__) if name != OFFERS_NOTHING)
    return [(name, registry.member(__name__, name)) for name in offering]


def __getattr__(name: str) -> ModuleType:
    if not name.startswith("_") and name in registry.names(__name__):
        return registry.member(__name__, name)
    raise AttributeError(f"module {__name__!r} has no study {name!r}; there are {', '.join(registry.names(__name__))}")
