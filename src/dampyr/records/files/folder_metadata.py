"""``reading.toml``: what the files of a folder do not say themselves, said once beside them.

::

    validation = ["earthquake*"]   # files that no fit may use; the others are for fitting
    ignore = ["calibration*"]      # files that are not records
    current = "*_{}A"              # the input in the files' names; or a number; or a table, see below
    specimen = "damper 3"          # which damper was tested
    measurement_session = {"day1*" = "2026-03-01", "day2*" = "2026-03-02"}

    [units]
    time = "s"
    displacement = "mm"

    [columns]
    force = "Load cell"

    [smoothed]                     # files that a moving average went over: its window in s, or in samples or periods
    "earthquake*" = 0.3
    "sine*" = "0.1 periods"        # also "15 samples", and after a comma: trailing, not undone, channels such as force

    [lowpass]                      # Hz, above which a displacement is noise; "15 f" is 15 times the motion's frequency
    "*" = 20

    [[files]]                      # what holds for some of them only
    pattern = "old rig*"           # or a list of patterns
    header = 0
    force_sign = -1
    [files.columns]
    time = 0
    displacement = 1
    force = 2

What a section ``[[files]]`` says of its files goes before what stands above the sections; two sections that say different
things of one file are an error. ``current``, ``voltage``, ``measurement_session``, ``specimen``, ``smoothed`` and
``lowpass`` may be tables that give names or patterns their values. Patterns are those of the shell (``*``, ``?``) and are
compared with a file's name, with and without its suffix; ``{}`` is a number such as ``0.5``, ``0,5``, ``0p5``, ``0x5`` or
``12``. What a call or the command line says goes before what stands here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from dampyr.config import parse_toml
from dampyr.errors import FileError, InputError
from dampyr.records.conditioning.moving_average import KEYS as WINDOW_KEYS
from dampyr.records.conditioning.moving_average import Declaration
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import CHANNELS

NAME = "reading.toml"
TABLE = "campaign.csv"  # names the files of a campaign (`dampyr.records.files.campaign_folder`)
INPUTS = ("voltage", "current")
DECIMAL = re.compile(r"[,pPxX]")
"""What stands for the point of a number in a file's name."""


@dataclass(frozen=True)
class PatternSection:
    """What is said of the files that one of the ``patterns`` matches, by the names of `KEYS`."""

    path: Path
    patterns: tuple[str, ...]
    values: Mapping[str, Any]

    def holds(self, file: Path) -> bool:
        """Whether this file is meant."""
        return any(matches(file, pattern) for pattern in self.patterns)

    def said_of(self, file: Path, has_input: bool = False) -> dict[str, Any]:
        """What is said of a file, each value its own; with ``has_input`` nothing of its input, which is known."""
        said = {name: value for name, value in self.values.items() if not (has_input and name in INPUTS)}
        own = {name: self._value(name, value, file) for name, value in said.items()}
        return {name: value for name, value in own.items() if value is not None}

    def _value(self, name: str, said: Any, file: Path) -> Any:
        if name in INPUTS and isinstance(said, str):
            return self._from_name(name, said, file)
        if name in ("units", "columns") or not isinstance(said, Mapping):
            return said
        values = {value for pattern, value in said.items() if matches(file, pattern)}
        if len(values) > 1:
            both = " and ".join(sorted(map(_shown, values)))
            unit = f" {CHANNELS[name]}" if name in INPUTS else ""
            raise FileError(self.path, f"{name} gives {file.name} both {both}{unit}; make the patterns exclusive")
        return values.pop() if values else None

    def _from_name(self, name: str, pattern: str, file: Path) -> float:
        for text in (file.stem, file.name):
            match = re.fullmatch(_expression(pattern), text)
            if match:
                return float(DECIMAL.sub(".", match[1]))
        raise FileError(
            self.path, f"{name} = {pattern!r} does not match the file {file.name}; rename or ignore it, or give a table"
        )

    def all_patterns(self) -> Iterator[str]:
        """Its own patterns, and those of its tables."""
        yield from self.patterns
        for name, said in self.values.items():
            if isinstance(said, Mapping) and name not in ("units", "columns"):
                yield from said


@dataclass(frozen=True)
class FolderReading:
    """What ``reading.toml`` says about the files of its folder; nothing where there is none."""

    path: Path
    base: PatternSection
    sections: tuple[PatternSection, ...] = ()
    validation: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()

    def is_validation(self, file: Path) -> bool:
        """Whether this file is kept from fits."""
        return any(matches(file, pattern) for pattern in self.validation)

    def is_ignored(self, file: Path) -> bool:
        """Whether this file is no record."""
        return any(matches(file, pattern) for pattern in self.ignore)

    def said_of(self, file: Path, has_input: bool = False) -> dict[str, Any]:
        """What is said of a file, such as ``{"units": {...}, "current": 0.5}``: arguments of :func:`dampyr.records.read`.

        ``has_input``: the caller states the input. Raises :class:`FileError` where two sections contradict one another.
        """
        together = _Together(self.path, file)
        for section in self.sections:
            if section.holds(file):
                together.add(section, section.said_of(file, has_input))
        special = together.said
        general = self.base.said_of(file, has_input or any(name in special for name in INPUTS))
        merged = {**general, **special}
        for name in ("units", "columns"):
            if name in general and name in special:
                merged[name] = {**general[name], **special[name]}
        return merged

    def check_patterns(self, files: list[Path]) -> None:
        """Raise :class:`FileError` where a pattern is of no file of the folder, as a slip of the pen is."""
        of_sections = [pattern for section in (self.base, *self.sections) for pattern in section.all_patterns()]
        for pattern in (*self.validation, *self.ignore, *of_sections):
            if not any(matches(file, pattern) for file in files):
                raise FileError(self.path, f"{pattern!r} matches no file of the folder; correct or remove it")


@dataclass
class _Together:
    """What several sections say of one file, and which pattern said it."""

    path: Path
    file: Path
    said: dict[str, Any] = field(default_factory=dict)
    by: dict[str, str] = field(default_factory=dict)

    def add(self, section: PatternSection, said: Mapping[str, Any]) -> None:
        """Enter what a section says; :class:`FileError` where another one has said something else."""
        pattern = next(each for each in section.patterns if matches(self.file, each))
        for name, value in said.items():
            if name in ("units", "columns"):
                table = self.said.setdefault(name, {})
                for channel, each in value.items():
                    self._check(f"{name}.{channel}", table.get(channel), each, pattern)
                    table[channel] = each
            else:
                self._check("the input" if name in INPUTS else name, self.said.get(name), value, pattern)
                self.said[name] = value
        if all(name in self.said for name in INPUTS):
            raise FileError(
                self.path,
                f"{self.by['the input']!r} and {pattern!r} give {self.file.name} a voltage and a current; "
                "a record has one input, so leave one of them out",
            )

    def _check(self, what: str, before: Any, value: Any, pattern: str) -> None:
        if before is not None and before != value:
            raise FileError(
                self.path,
                f"{self.by[what]!r} and {pattern!r} give {self.file.name} two values of {what}, {_shown(before)} and "
                f"{_shown(value)}; make the patterns exclusive",
            )
        self.by.setdefault(what, pattern)


def reading_of(folder: Path) -> FolderReading:
    """The ``reading.toml`` of a folder, checked; an empty one where there is none.

    Raises
    ------
    FileError
        It is not TOML, or holds an unknown key.
    """
    path = folder / NAME
    if not path.is_file():
        return FolderReading(path, PatternSection(path, (), {}))
    try:
        settings = parse_toml(path.read_text("utf-8"))
    except InputError as problem:
        raise FileError(path, f"is no TOML that can be read: {problem}") from None
    except UnicodeDecodeError as problem:
        raise FileError(path, f"is no TOML ({problem}); save it as UTF-8 text") from None
    _check_keys(path, settings, (*KEYS, "validation", "ignore", "files"), "")
    tables = settings.get("files", [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise FileError(path, f"files = {tables!r} is not a list of tables; write each as [[files]] with its pattern")
    return FolderReading(
        path,
        base=_section(path, settings, (), ""),
        sections=tuple(
            _section(path, t, _section_patterns(path, t, k), f"[[files]] {k}: ") for k, t in enumerate(tables, 1)
        ),
        validation=_patterns(path, settings, "validation"),
        ignore=_patterns(path, settings, "ignore"),
    )


def matches(file: Path, pattern: str) -> bool:
    """Whether a pattern of the shell is of this file's name, with or without its suffix."""
    return fnmatchcase(file.name, pattern) or fnmatchcase(file.stem, pattern)


def _check_keys(path: Path, table: Mapping[str, Any], allowed: tuple[str, ...], where: str) -> None:
    unknown = sorted(set(table) - set(allowed))
    if unknown:
        raise FileError(path, f"{where}{unknown[0]!r} is not known; choose from {', '.join(allowed)}")


def _section_patterns(path: Path, table: Mapping[str, Any], number: int) -> tuple[str, ...]:
    where = f"[[files]] {number}: "
    _check_keys(path, table, ("pattern", *KEYS), where)
    said = table.get("pattern")
    patterns = [said] if isinstance(said, str) else said
    if not isinstance(patterns, list) or not patterns or not all(isinstance(each, str) for each in patterns):
        raise FileError(path, f'{where}pattern = {said!r} is not a pattern; write it as in "quake*", or a list of them')
    return tuple(patterns)


def _section(path: Path, table: Mapping[str, Any], patterns: tuple[str, ...], where: str) -> PatternSection:
    values = {}
    for name, check in KEYS.items():
        if name in table:
            try:
                values[name] = check(name, table[name])
            except InputError as problem:
                raise FileError(path, f"{where}{problem}") from None
    if all(name in values for name in INPUTS):
        raise FileError(
            path, f"{where}voltage and current are both given; a record has one input, so leave one of them out"
        )
    return PatternSection(path, patterns, values)


def _expression(pattern: str) -> str:
    """The regular expression of a pattern in which ``{}`` is a number that is whole: no digits stand before it.

    ``0x25`` is one number, so that its 25 is none, except where the pattern itself has the x before the number.
    """
    before = pattern.partition("{}")[0]
    start = r"(?<![\d.,])" if before[-1:] in tuple("pPxX") else r"(?<![\d.,])(?<!\d[pPxX])"
    number = rf"{start}(\d+(?:[.,pPxX]\d+)?)"
    escaped = re.escape(pattern).replace(re.escape("{}"), number)
    return escaped.replace(r"\*", ".*").replace(r"\?", ".")


def _option(name: str, said: Any) -> Any:
    return getattr(ReadOptions(**{name: said}), name)


def _table(name: str, said: Any) -> Any:
    if not isinstance(said, dict):
        raise InputError(f"{name} = {said!r} is not a table; write it below [{name}], such as displacement = ...")
    return _option(name, said)


def _by_pattern(name: str, said: Any) -> Any:
    return (
        {pattern: _option(name, each) for pattern, each in said.items()}
        if isinstance(said, dict)
        else _option(name, said)
    )


def _input(name: str, said: Any) -> Any:
    if isinstance(said, str):
        if said.count("{}") != 1:
            raise InputError(f"{name} = {said!r} must hold {{}} once, where the number stands in a file's name")
        return said
    values = said.values() if isinstance(said, dict) else [said]
    if not all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        raise InputError(f"{name} = {said!r} is neither a number, nor a pattern with {{}}, nor a table of numbers")
    return {pattern: float(value) for pattern, value in said.items()} if isinstance(said, dict) else float(said)


def _smoothed(name: str, said: Any) -> Any:
    """One declaration, which may be a table of its fields, or a table of declarations by pattern."""
    return Declaration.of(said) if isinstance(said, dict) and set(said) & set(WINDOW_KEYS) else _by_pattern(name, said)


KEYS: Mapping[str, Callable[[str, Any], Any]] = {
    "units": _table,
    "columns": _table,
    "voltage": _input,
    "current": _input,
    "dt": _option,
    "variable": _option,
    "header": _option,
    "force_sign": _option,
    "measurement_session": _by_pattern,
    "specimen": _by_pattern,
    "smoothed": _smoothed,
    "lowpass": _by_pattern,
}
"""What may be said of files, all of them or those of a section: each key with the check that gives its value, named as the
option of `dampyr.records.ReadOptions`."""


def _shown(value: Any) -> str:
    if isinstance(value, Declaration):
        return repr(str(value))
    return f"{value:g}" if isinstance(value, float) else repr(value)


def _patterns(path: Path, settings: dict[str, Any], key: str) -> tuple[str, ...]:
    given = settings.get(key, [])
    if not isinstance(given, list) or not all(isinstance(each, str) for each in given):
        raise FileError(path, f'{key} = {given!r} is not a list of patterns; write it as in ["earthquake*"]')
    return tuple(given)
