"""``reading.toml``: what the files of a folder do not say themselves, said once beside them.

::

    validation = ["earthquake*"]   # files that no fit may use; the others are for fitting
    ignore = ["calibration*"]      # files that are no records
    current = "*_{}A"              # the input in the files' names; or a number; or a table, see below

    [units]
    time = "s"
    displacement = "mm"

    [columns]
    force = "Load cell"

As a table, ``current`` (or ``voltage``) gives names or patterns their values: ``current = {"run1" = 0.5, "run2*" = 1.0}``.
Patterns are those of the shell (``*``, ``?``) and are compared with a file's name, with and without its suffix; ``{}`` is a
number such as ``0.5``, ``0,5`` or ``12``. What a call or the command line says goes before what stands here.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from dampyr.errors import FileError
from dampyr.records.record import CHANNELS

NAME = "reading.toml"
INPUTS = ("voltage", "current")
KEYS = ("units", "columns", *INPUTS, "validation", "ignore")
NUMBER = r"(?<![\d.,])(\d+(?:[.,]\d+)?)"


@dataclass(frozen=True)
class FolderReading:
    """What ``reading.toml`` says about the files of its folder; nothing where there is none."""

    path: Path
    units: Mapping[str, str] = field(default_factory=dict)
    columns: Mapping[str, str | int] = field(default_factory=dict)
    inputs: Mapping[str, Any] = field(default_factory=dict)
    validation: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()

    def is_validation(self, file: Path) -> bool:
        """Whether this file is kept from fits."""
        return any(matches(file, pattern) for pattern in self.validation)

    def is_ignored(self, file: Path) -> bool:
        """Whether this file is no record."""
        return any(matches(file, pattern) for pattern in self.ignore)

    def input_of(self, file: Path) -> dict[str, float]:
        """The constant input of a file, ``{"current": 0.5}``; empty where nothing is said about it."""
        inputs = {name: self._value(name, said, file) for name, said in self.inputs.items()}
        return {name: value for name, value in inputs.items() if value is not None}

    def _value(self, name: str, said: Any, file: Path) -> float | None:
        if isinstance(said, str):
            return self._from_name(name, said, file)
        if not isinstance(said, Mapping):
            return float(said)
        values = {float(value) for pattern, value in said.items() if matches(file, pattern)}
        if len(values) > 1:
            both = " and ".join(f"{value:g}" for value in sorted(values))
            raise FileError(
                self.path, f"{name} gives {file.name} both {both} {CHANNELS[name]}; make the patterns exclusive"
            )
        return values.pop() if values else None

    def _from_name(self, name: str, pattern: str, file: Path) -> float:
        for text in (file.stem, file.name):
            match = re.fullmatch(_expression(pattern), text)
            if match:
                return float(match[1].replace(",", "."))
        raise FileError(
            self.path, f"{name} = {pattern!r} does not match the file {file.name}; rename or ignore it, or give a table"
        )

    def check_patterns(self, files: list[Path]) -> None:
        """Raise :class:`FileError` where a pattern is of no file of the folder, as a slip of the pen is."""
        tables = [said for said in self.inputs.values() if isinstance(said, Mapping)]
        for pattern in (*self.validation, *self.ignore, *(p for table in tables for p in table)):
            if not any(matches(file, pattern) for file in files):
                raise FileError(self.path, f"{pattern!r} matches no file of the folder; correct or remove it")


def reading_of(folder: Path) -> FolderReading:
    """The ``reading.toml`` of a folder, checked; an empty one where there is none.

    Raises
    ------
    FileError
        It is no TOML, or says what is not known.
    """
    path = folder / NAME
    if not path.is_file():
        return FolderReading(path)
    try:
        settings = tomllib.loads(path.read_text("utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as problem:
        raise FileError(path, f"is no TOML ({' '.join(str(problem).split())}); repair that place") from None
    unknown = sorted(set(settings) - set(KEYS))
    if unknown:
        raise FileError(path, f"{unknown[0]!r} is not known; choose from {', '.join(KEYS)}")
    return FolderReading(
        path,
        units=_channels(path, settings, "units", str),
        columns=_channels(path, settings, "columns", (str, int)),
        inputs=_inputs(path, settings),
        validation=_patterns(path, settings, "validation"),
        ignore=_patterns(path, settings, "ignore"),
    )


def matches(file: Path, pattern: str) -> bool:
    """Whether a pattern of the shell is of this file's name, with or without its suffix."""
    return fnmatchcase(file.name, pattern) or fnmatchcase(file.stem, pattern)


def _expression(pattern: str) -> str:
    escaped = re.escape(pattern).replace(re.escape("{}"), NUMBER)
    return escaped.replace(r"\*", ".*").replace(r"\?", ".")


def _channels(path: Path, settings: dict[str, Any], key: str, kind: Any) -> dict[str, Any]:
    table = settings.get(key, {})
    if not isinstance(table, dict):
        raise FileError(path, f"{key} = {table!r} is no table; write it below [{key}], such as displacement = ...")
    for channel, value in table.items():
        if channel not in CHANNELS:
            raise FileError(path, f"{key} names {channel!r}, which is no channel; choose from {', '.join(CHANNELS)}")
        if not isinstance(value, kind) or isinstance(value, bool):
            raise FileError(path, f"{key}: {channel} = {value!r} is no text; write it in quotes")
    return table


def _inputs(path: Path, settings: dict[str, Any]) -> dict[str, Any]:
    inputs = {name: settings[name] for name in INPUTS if name in settings}
    if len(inputs) > 1:
        raise FileError(path, "voltage and current are both given; a record has one input, so leave one of them out")
    for name, said in inputs.items():
        if isinstance(said, str) and said.count("{}") != 1:
            raise FileError(path, f"{name} = {said!r} must hold {{}} once, where the number stands in a file's name")
        values = said.values() if isinstance(said, dict) else [said]
        if not isinstance(said, str) and not all(_is_number(value) for value in values):
            raise FileError(
                path, f"{name} = {said!r} is neither a number, nor a pattern with {{}}, nor a table of numbers"
            )
    return inputs


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _patterns(path: Path, settings: dict[str, Any], key: str) -> tuple[str, ...]:
    given = settings.get(key, [])
    if not isinstance(given, list) or not all(isinstance(each, str) for each in given):
        raise FileError(path, f'{key} = {given!r} is no list of patterns; write it as in ["earthquake*"]')
    return tuple(given)
