"""``reading.toml``: what the files of a folder do not state themselves, stated once beside them.

::

    validation = ["earthquake*"]   # files that no fit may use; the others are for fitting
    ignore = ["calibration*"]      # files that are not records
    current = "*_{}A"              # the input in the files' names; or a number; or a table, see below; or, of dampers
                                   # without an input, no_input = true in its place
    specimen = "damper 3"          # which damper was tested
    measurement_session = {"day1*" = "2026-03-01", "day2*" = "2026-03-02"}

    [units]
    time = "s"
    displacement = "mm"

    [columns]
    force = "Load cell"

    [factors]                      # what one in the files is: of counts, volts
    displacement = "0.005 mm"

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
things of the same file are an error. ``current``, ``voltage``, ``measurement_session``, ``specimen``, ``smoothed`` and
``lowpass`` may be tables that give names or patterns their values. Patterns are those of the shell (``*``, ``?``) and are
compared with a file's name, with and without its suffix; ``{}`` is a number such as ``0.5``, ``0,5``, ``0p5``, ``0x5`` or
``12``. What a call or the command line says goes before what stands here. A table ``[motions]`` is of ground motions in the
folder (:mod:`dampyr.ground_motions.motion_reading`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from dampyr.config import load_toml
from dampyr.errors import FileError, InputError
from dampyr.records.conditioning.moving_average import KEYS as WINDOW_KEYS
from dampyr.records.conditioning.moving_average import Declaration
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import CHANNELS

NAME = "reading.toml"
TABLE = "campaign.csv"  # names the files of a campaign (`dampyr.records.files.campaign_folder`)
INPUTS = ("voltage", "current", "no_input")  # of which a record has one
TABLES = ("units", "columns", "factors", "offsets")  # options that hold a value for each channel
DECIMAL = re.compile(r"[,pPxX]")
"""What stands for the point of a number in a file's name."""


@dataclass(frozen=True)
class PatternSection:
    """The options of the files that one of the ``patterns`` matches, by the names of `KEYS`."""

    path: Path
    patterns: tuple[str, ...]
    values: Mapping[str, Any]

    def holds(self, file: Path) -> bool:
        """Whether this file is meant."""
        return any(matches(file, pattern) for pattern in self.patterns)

    def options_of(self, file: Path, has_input: bool = False) -> dict[str, Any]:
        """The options of a file, of a table by pattern its value; with ``has_input`` without its input, which is known."""
        settings = {name: setting for name, setting in self.values.items() if not (has_input and name in INPUTS)}
        options = {name: self._value(name, setting, file) for name, setting in settings.items()}
        return {name: value for name, value in options.items() if value is not None}

    def _value(self, name: str, setting: Any, file: Path) -> Any:
        if name in INPUTS and isinstance(setting, str):
            return self._from_name(name, setting, file)
        if name in TABLES or not isinstance(setting, Mapping):
            return setting
        values = {value for pattern, value in setting.items() if matches(file, pattern)}
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
        for name, setting in self.values.items():
            if isinstance(setting, Mapping) and name not in TABLES:
                yield from setting


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

    def options_of(self, file: Path, has_input: bool = False) -> dict[str, Any]:
        """The options of a file, such as ``{"units": {...}, "current": 0.5}``: arguments of :func:`dampyr.records.read`.

        ``has_input``: the caller states the input. Raises :class:`FileError` where two sections contradict one another.
        """
        special = self._of_sections(file, has_input)
        general = self.base.options_of(file, has_input or any(name in special for name in INPUTS))
        tables = {name: {**general[name], **special[name]} for name in TABLES if name in general and name in special}
        return {**general, **special, **tables}

    def text_options(self, file: Path, options: ReadOptions | None = None) -> ReadOptions:
        """The options by which a text is told from prose, its encoding and its delimiter; those of a caller go before."""
        of_folder = self.options_of(file, has_input=True)
        stated = options or ReadOptions()
        return ReadOptions(
            encoding=stated.encoding or of_folder.get("encoding"),
            delimiter=stated.delimiter or of_folder.get("delimiter"),
        )

    def _of_sections(self, file: Path, has_input: bool) -> dict[str, Any]:
        """What the sections that hold a file say of it together; :class:`FileError` where two of them say different things."""
        merged: dict[str, Any] = {}
        stated_by: dict[str, str] = {}  # the pattern of the section that said it first
        for section in (section for section in self.sections if section.holds(file)):
            pattern = next(pattern for pattern in section.patterns if matches(file, pattern))
            for name, value in section.options_of(file, has_input).items():
                target = merged.setdefault(name, {}) if name in TABLES else merged
                for key, entry in value.items() if name in TABLES else [(name, value)]:
                    what = f"{name}.{key}" if name in TABLES else "the input" if name in INPUTS else name
                    if target.get(key) not in (None, entry):
                        raise FileError(
                            self.path,
                            f"{stated_by[what]!r} and {pattern!r} give {file.name} two values of {what}, "
                            f"{_shown(target[key])} and {_shown(entry)}; make the patterns exclusive",
                        )
                    stated_by.setdefault(what, pattern)
                    target[key] = entry
            if len(both := [name for name in INPUTS if name in merged]) > 1:
                raise FileError(
                    self.path,
                    f"{stated_by['the input']!r} and {pattern!r} give {file.name} {' and '.join(map(_named, both))}; "
                    "a record has one input, so leave one of them out",
                )
        return merged

    def check_patterns(self, files: list[Path]) -> None:
        """Raise :class:`FileError` where a pattern is of no file of the folder, as a slip of the pen is."""
        of_sections = [pattern for section in (self.base, *self.sections) for pattern in section.all_patterns()]
        for pattern in (*self.validation, *self.ignore, *of_sections):
            if not any(matches(file, pattern) for file in files):
                raise FileError(self.path, f"{pattern!r} matches no file of the folder; correct or remove it")


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
    settings = load_toml(path)
    _check_keys(path, settings, (*KEYS, "validation", "ignore", "files", "motions"), "")
    tables = settings.get("files", [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise FileError(path, f"files = {tables!r} is not a list of tables; write each as [[files]] with its pattern")
    return FolderReading(
        path,
        base=_section(path, settings, (), ""),
        sections=tuple(
            _section(path, table, _section_patterns(path, table, number), f"[[files]] {number}: ")
            for number, table in enumerate(tables, 1)
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
    pattern = table.get("pattern")
    patterns = [pattern] if isinstance(pattern, str) else pattern
    if not isinstance(patterns, list) or not patterns or not all(isinstance(text, str) for text in patterns):
        raise FileError(
            path, f'{where}pattern = {pattern!r} is not a pattern; write it as in "quake*", or a list of them'
        )
    return tuple(patterns)


def _section(path: Path, table: Mapping[str, Any], patterns: tuple[str, ...], where: str) -> PatternSection:
    values = {}
    for name, check in KEYS.items():
        if name in table:
            try:
                values[name] = check(name, table[name])
            except InputError as problem:
                raise FileError(path, f"{where}{problem}") from None
    if len(both := [name for name in INPUTS if values.get(name) is not None]) > 1:
        raise FileError(
            path, f"{where}{' and '.join(both)} are both given; a record has one input, so leave one of them out"
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


def _option(name: str, setting: Any) -> Any:
    return getattr(ReadOptions(**{name: setting}), name)


def _table(name: str, setting: Any) -> Any:
    if not isinstance(setting, dict):
        raise InputError(f"{name} = {setting!r} is not a table; write it below [{name}], such as displacement = ...")
    return _option(name, setting)


def _by_pattern(name: str, setting: Any) -> Any:
    return (
        {pattern: _option(name, value) for pattern, value in setting.items()}
        if isinstance(setting, dict)
        else _option(name, setting)
    )


def _no_input(name: str, setting: Any) -> Any:
    if not isinstance(setting, bool):
        raise InputError(f"{name} = {setting!r} is not allowed; write true where the dampers have no input")
    return setting or None


def _input(name: str, setting: Any) -> Any:
    if isinstance(setting, str):
        if setting.count("{}") != 1:
            raise InputError(f"{name} = {setting!r} must hold {{}} once, where the number stands in a file's name")
        return setting
    values = setting.values() if isinstance(setting, dict) else [setting]
    if not all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        raise InputError(f"{name} = {setting!r} is neither a number, nor a pattern with {{}}, nor a table of numbers")
    return (
        {pattern: float(value) for pattern, value in setting.items()} if isinstance(setting, dict) else float(setting)
    )


def _smoothed(name: str, setting: Any) -> Any:
    """One declaration, which may be a table of its fields, or a table of declarations by pattern."""
    return (
        Declaration.of(setting)
        if isinstance(setting, dict) and set(setting) & set(WINDOW_KEYS)
        else _by_pattern(name, setting)
    )


KEYS: Mapping[str, Callable[[str, Any], Any]] = {
    "units": _table,
    "columns": _table,
    "factors": _table,
    "offsets": _table,
    "thousands": _option,
    "encoding": _option,
    "delimiter": _option,
    "voltage": _input,
    "current": _input,
    "no_input": _no_input,
    "dt": _option,
    "variable": _option,
    "header": _option,
    "repair": _option,
    "force_sign": _option,
    "force_delay": _option,
    "measurement_session": _by_pattern,
    "specimen": _by_pattern,
    "smoothed": _smoothed,
    "lowpass": _by_pattern,
}
"""The options of files, all of them or those of a section: each key with the check that gives its value, named as the
option of `dampyr.records.ReadOptions`."""


def _named(input_key: str) -> str:
    return "no input" if input_key == "no_input" else f"a {input_key}"


def _shown(value: Any) -> str:
    if isinstance(value, Declaration):
        return repr(str(value))
    return f"{value:g}" if isinstance(value, float) else repr(value)


def _patterns(path: Path, settings: dict[str, Any], key: str) -> tuple[str, ...]:
    patterns = settings.get(key, [])
    if not isinstance(patterns, list) or not all(isinstance(pattern, str) for pattern in patterns):
        raise FileError(path, f'{key} = {patterns!r} is not a list of patterns; write it as in ["earthquake*"]')
    return tuple(patterns)
