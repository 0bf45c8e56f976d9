"""Registries of the kinds of step and of protocol."""

from __future__ import annotations

from typing import Any

from dampyr import registry

REGISTRY = "dampyr.campaigns.steps"
PROTOCOLS = "dampyr.campaigns.protocols"


def available_steps() -> list[str]:
    """The names of all kinds of step."""
    return registry.names(REGISTRY)


def learning_steps() -> list[str]:
    """The names of the kinds whose drive can be learned."""
    return [name for name in available_steps() if getattr(kind(name), "learns", False)]


def kind(name: str) -> Any:
    """The dataclass of a kind; :class:`~dampyr.errors.InputError` lists them where there is none of that name."""
    return _class_of(REGISTRY, name)


def available_protocols() -> list[str]:
    """The names of all kinds of protocol."""
    return registry.names(PROTOCOLS)


def protocol_kind(name: str) -> Any:
    """The dataclass of a kind of protocol; :class:`~dampyr.errors.InputError` lists them where there is none of that name."""
    return _class_of(PROTOCOLS, name)


def _class_of(package: str, name: str) -> Any:
    return getattr(registry.member(package, name), "".join(part.capitalize() for part in name.split("_")))
