"""Registry of the kinds of step."""

from __future__ import annotations

from typing import Any

from dampyr import registry

REGISTRY = "dampyr.campaigns.steps"


def available_steps() -> list[str]:
    """The names of all kinds of step."""
    return registry.names(REGISTRY)


def learning_steps() -> list[str]:
    """The names of the kinds whose drive can be learned."""
    return [name for name in available_steps() if getattr(kind(name), "learns", False)]


def kind(name: str) -> Any:
    """The dataclass of a kind; :class:`~dampyr.errors.InputError` lists them where there is none of that name."""
    return getattr(registry.member(REGISTRY, name), "".join(part.capitalize() for part in name.split("_")))
