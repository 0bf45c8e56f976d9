"""Published studies run again, the published value beside ours, and the demonstration of the whole chain.

A study is one module or package of this folder. Where it has a function ``damper()``, that damper is offered with the published
sets, by the command line and by the console.
"""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from dampyr import registry

if TYPE_CHECKING:
    from dampyr.models import Damper

THESIS = "raminelli_2020"


def available_dampers() -> list[str]:
    """The names of all published dampers: of the studies that have one, then those of `dampyr.models.published`."""
    from dampyr.models import published

    own = [name for name, study in registry.members(__name__) if hasattr(study, "damper")]
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

    studies = registry.members(__name__)
    return published.card_or_published(
        name, others={own: study.damper for own, study in studies if hasattr(study, "damper")}
    )


def __getattr__(name: str) -> ModuleType:
    if not name.startswith("_") and name in registry.names(__name__):
        return registry.member(__name__, name)
    raise AttributeError(f"module {__name__!r} has no study {name!r}; there are {', '.join(registry.names(__name__))}")
