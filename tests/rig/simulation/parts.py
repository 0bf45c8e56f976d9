"""Settings of the original rig with some of its parts changed."""

from dataclasses import replace

from dampyr.rig.settings import RigSettings


def settings(**parts: dict[str, float]) -> RigSettings:
    """The original rig with some of its parts changed."""
    rig = RigSettings()
    return replace(rig, **{name: replace(getattr(rig, name), **values) for name, values in parts.items()})
