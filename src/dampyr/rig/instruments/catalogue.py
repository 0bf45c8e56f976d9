"""Catalogue of instruments: the folders of this package, and those of another laboratory beside its ``rig.toml``."""

from __future__ import annotations

import sys
from dataclasses import replace
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType
from typing import Any

from dampyr.config import unknown
from dampyr.errors import FileError, InputError
from dampyr.rig.settings import RigSettings

ROLES = ("acquisition", "drive", "supply")
OUTPUT = "analogue-output"  # the supply that follows an output of the acquisition
PACKAGE = "dampyr.rig.instruments"
FUNCTIONS = {"driver": ("connect",), "simulated": ("in_process",)}


def available(role: str) -> list[str]:
    """The instruments of this package for a role, as ``rig.toml`` names them."""
    folders = sorted(module.name for module in iter_modules([str(Path(__file__).parent)]) if module.ispkg)
    listed = [name.replace("_", "-") for name in folders if role == import_module(f"{PACKAGE}.{name}").ROLE]
    return [OUTPUT, *listed] if role == "supply" else listed


def is_folder(name: str) -> bool:
    """Whether a name in ``rig.toml`` is the path of a folder."""
    return name.startswith(".") or "/" in name or "\\" in name


def with_absolute_folders(rig: RigSettings, folder: Path | None) -> RigSettings:
    """The settings whose folders of instruments can be read from anywhere; relative ones are in ``folder``."""
    named = {role: getattr(rig.wires, role) for role in ROLES}
    paths: dict[str, Any] = {
        role: str((folder or Path()).resolve() / name) for role, name in named.items() if is_folder(name)
    }
    return replace(rig, wires=replace(rig.wires, **paths)) if paths else rig


def part(rig: RigSettings, role: str, name: str) -> ModuleType:
    """The module ``name`` ("driver" or "simulated") of the instrument that ``rig`` names for ``role``.

    Raises :class:`InputError` for a name that is not in the catalogue, :class:`FileError` for a folder that does not hold an
    instrument.
    """
    chosen = getattr(rig.wires, role)
    if is_folder(chosen):
        module = _import_from_folder(Path(chosen).resolve(), role, name)
    elif chosen in available(role):
        module = import_module(f"{PACKAGE}.{chosen.replace('-', '_')}.{name}")
    else:
        raise InputError(
            f"{unknown(f'wires.{role} = {chosen!r}', chosen, available(role))}, or give the path of a folder"
        )
    if not any(callable(getattr(module, function, None)) for function in FUNCTIONS[name]):
        raise FileError(
            place(rig, role), f"{name}.py has no {' and no '.join(f'{function}()' for function in FUNCTIONS[name])}"
        )
    return module


def place(rig: RigSettings, role: str) -> str:
    """The instrument's folder, for messages."""
    chosen = getattr(rig.wires, role)
    return str(Path(chosen).resolve()) if is_folder(chosen) else chosen


def _import_from_folder(folder: Path, role: str, name: str) -> ModuleType:
    """A module of a folder that is not of this package."""
    if not folder.is_dir():
        raise FileError(folder, f"wires.{role} names this folder, and there is none; correct the path")
    if not (folder / f"{name}.py").is_file():
        raise FileError(folder, f"has no {name}.py; wires.{role} names a folder with driver.py and simulated.py")
    package = f"dampyr_instrument_{sha256(str(folder).encode()).hexdigest()[:12]}"
    if package not in sys.modules:
        module = ModuleType(package)
        module.__path__ = [str(folder)]
        sys.modules[package] = module
    try:
        return import_module(f"{package}.{name}")
    except Exception as problem:
        raise FileError(folder / f"{name}.py", f"cannot be imported: {type(problem).__name__}: {problem}") from problem
