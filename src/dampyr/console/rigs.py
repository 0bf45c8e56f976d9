"""The rigs that a console can connect to: the original one, and each ``rigs/NAME/rig.toml`` of its data."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from dampyr.errors import InputError
from dampyr.rig import Rig, RigSettings, connect, load_settings, simulated

Opener = Callable[[Path, str, bool], Rig]
"""``opener(data, name, simulate)`` connects a rig of a data folder."""
FOLDER = "rigs"
ORIGINAL = ""


def rig_names(data: Path) -> list[str]:
    """The names of the folders of rigs."""
    return sorted(path.parent.name for path in (data / FOLDER).glob("*/rig.toml"))


def rig_file(data: Path, name: str) -> Path | None:
    """The file of a rig, None for the original one; :class:`~dampyr.errors.InputError` where there is none of that name."""
    if name == ORIGINAL:
        return None
    if name not in rig_names(data):
        raise InputError(f"rig = {name!r} is not known; choose from {', '.join(rig_names(data)) or 'the original one'}")
    return data / FOLDER / name / "rig.toml"


def rig_settings(data: Path, name: str) -> RigSettings:
    """What a rig is made of."""
    path = rig_file(data, name)
    return RigSettings() if path is None else load_settings(path)


def opened(data: Path, name: str, simulate: bool) -> Rig:
    """The rig, connected: a simulated one in real time, or that at the end of its wires."""
    path = rig_file(data, name)
    if simulate:
        return simulated(path, real_time=True)
    if path is None:
        raise InputError("the original rig has no wires here; simulate it, or describe yours in rigs/NAME/rig.toml")
    return connect(path)
