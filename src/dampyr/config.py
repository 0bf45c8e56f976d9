"""A TOML table as a dataclass: units at the boundary, SI inside, each mistake one sentence that says where it stands.

A field is what its annotation says::

    speed: Annotated[float, Quantity("m/s", low=0), "where the value comes from"] = 0.078

takes ``speed = "78 mm/s"`` or, SI already, ``speed = 0.078``. Dataclasses may hold dataclasses; their tables nest.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin, get_type_hints

from dampyr.errors import FileError, InputError, MissingData, choose_from
from dampyr.units import Quantity, parse

T = TypeVar("T")


class Choices:
    """Note of a field that holds a text or a whole number: what it may hold, and what each means where that is stated."""

    def __init__(self, words: Mapping[Any, str] | Iterable[Any]) -> None:
        self.words = dict(words) if isinstance(words, Mapping) else {value: str(value) for value in words}

    def check(self, where: str, value: Any) -> None:
        """Raise :class:`InputError` unless ``value`` is one of them."""
        if value not in self.words:
            raise InputError(unknown(f"{where} = {value!r}", str(value), list(map(str, self.words))))


MAX_DOTTED = 32  # parts of a key such as a.b.c: no table of ours nests deeper than 4
KEY = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
DOTTED = re.compile(rf"(?<![\w-]){KEY}(?:[ \t]*+\.[ \t]*+{KEY}){{{MAX_DOTTED},}}")
"""A key whose reading would take memory with the square of its length."""


def parse_toml(text: str) -> dict[str, Any]:
    """The tables of a text in TOML, SI values not yet read; :class:`InputError` with what is wrong and where.

    Nested too deeply, a key of more than ``MAX_DOTTED`` parts and a whole number of thousands of digits are refused too.
    """
    if (long := DOTTED.search(text)) is not None:
        line = text.count("\n", 0, long.start()) + 1
        raise InputError(
            f"line {line} has a key of more than {MAX_DOTTED} parts separated by dots; write it with fewer"
        )
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        raise InputError(f"{' '.join(str(problem).split())}; repair that place") from None
    except RecursionError:
        raise InputError("its tables or lists nest too deeply; write them flat") from None
    except ValueError:  # Python refuses to read a whole number of more than 4300 digits
        raise InputError("a number in it has thousands of digits; write a shorter one") from None


def load_toml(path: str | Path) -> dict[str, Any]:
    """The tables of a TOML file; :class:`FileError` where it is not TOML, :class:`MissingData` where it is not there."""
    path = Path(path)
    try:
        return parse_toml(path.read_text("utf-8"))
    except FileNotFoundError:
        raise MissingData(f"{path}: there is no such file; check the path") from None
    except InputError as problem:
        raise FileError(path, f"is not valid TOML: {problem}") from None
    except UnicodeDecodeError as problem:
        raise FileError(path, f"is not TOML in UTF-8 ({problem}); save it as UTF-8 text") from None
    except OSError as problem:
        raise FileError(path, f"cannot be read ({problem.strerror})") from None


def fill(cls: type[T], table: Any, where: str = "") -> T:
    """The dataclass ``cls`` from the table ``table``; ``where`` is the table's name in messages.

    Raises :class:`InputError` for what is not known, is missing, has the wrong type or unit, or leaves its range.
    """
    if not isinstance(table, Mapping):
        raise InputError(f"{where or 'the file'} = {table!r} must be a table")
    hints, fields_by_name = get_type_hints(cls, include_extras=True), {f.name: f for f in fields(cls)}  # type: ignore[arg-type]
    for name in table:
        if name not in fields_by_name:
            raise InputError(unknown(_joined(where, name), name, list(fields_by_name)))
    missing = [name for name, field in fields_by_name.items() if name not in table and is_required(field)]
    if missing:
        _, quantity = split(hints[missing[0]])
        unit = f" in {quantity.unit} or another unit of that kind" if quantity and quantity.unit else ""
        raise InputError(f"{_joined(where, missing[0])} is missing; give it{unit}")
    return cls(**{name: value_of(hints[name], value, _joined(where, name)) for name, value in table.items()})


def unknown(where: str, name: str, available: list[str]) -> str:
    """A sentence about a name that is not known."""
    return f"{where} is not known; {choose_from(name, available)}"


def value_of(hint: Any, value: Any, where: str) -> Any:
    """One value as its annotation wants it."""
    kind, *notes = get_args(hint) if get_origin(hint) is Annotated else (hint,)
    members = get_args(kind) if get_origin(kind) in (Union, UnionType) else (kind,)
    if value is None and NoneType in members:
        return None
    kinds = [member for member in members if member is not NoneType]
    if is_dataclass(kinds[0]):
        return fill(kinds[0], value, where)  # type: ignore[arg-type]
    containers = {get_origin(member): member for member in kinds if get_origin(member) is not None}
    if tuple in containers:
        listed = value if isinstance(value, list | tuple) else [value]
        inner = _noted(get_args(containers[tuple])[0], notes)
        return tuple(value_of(inner, item, where) for item in listed)
    if Mapping in containers and (isinstance(value, Mapping) or len(kinds) == 1):
        if not isinstance(value, Mapping):
            raise InputError(f"{where} = {value!r} must be a mapping of names to values")
        inner = _noted(get_args(containers[Mapping])[1], notes)
        return {name: value_of(inner, item, f"{where}[{name!r}]") for name, item in value.items()}
    for note in notes:
        if isinstance(note, Quantity) and float in kinds:
            return _measured(note, value, where) if str not in kinds else _measured_or_named(note, notes, value, where)
    plain = _plain([kind for kind in kinds if get_origin(kind) is None], value, where)
    for note in notes:
        if isinstance(note, Choices):
            note.check(where, plain)
        if isinstance(note, Quantity) and kinds[0] is int:
            note.check(where, plain)
    return plain


def _noted(kind: Any, notes: list[Any]) -> Any:
    """The annotation of what a container holds: that of the container."""
    return Annotated[(kind, *notes)] if notes else kind


def split(hint: Any) -> tuple[Any, Quantity | None]:
    """The type of an annotation, and its quantity if it has one."""
    if get_origin(hint) is not Annotated:
        return hint, None
    kind, *notes = get_args(hint)
    return kind, next((note for note in notes if isinstance(note, Quantity)), None)


def origin(hint: Any) -> str:
    """Where the default of a field comes from: the text in its annotation."""
    return next((note for note in get_args(hint) if isinstance(note, str)), "") if get_origin(hint) is Annotated else ""


def _measured(quantity: Quantity, value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise InputError(f'{where} = {value!r} must be a quantity such as "1 {quantity.unit}"')
    try:
        parsed = parse(value, quantity.unit)
    except InputError as problem:
        raise InputError(f"{where} = {value!r}: {problem}") from None
    quantity.check(where, parsed)
    return parsed


def _measured_or_named(quantity: Quantity, notes: list[Any], value: Any, where: str) -> float | str:
    """A number, or one of the texts that stand for one."""
    names = [str(text) for note in notes if isinstance(note, Choices) for text in note.words]
    if isinstance(value, str) and value in names:
        return value
    try:
        return _measured(quantity, value, where)
    except InputError as problem:
        raise InputError(f"{problem}; or choose from {', '.join(names)}") from None


def _plain(kinds: list[Any], value: Any, where: str) -> Any:
    """A value of one of several plain types; the first that it is of."""
    for kind in kinds:
        is_of = isinstance(value, (int, float) if kind is float else kind)
        if is_of and (kind is bool or not isinstance(value, bool)):
            return float(value) if kind is float else value
    names = {float: "a number", int: "a whole number", str: "a text", bool: "true or false"}
    allowed = [names[kind] for kind in kinds if kind in names]
    if allowed:
        raise InputError(f"{where} = {value!r} must be {' or '.join(allowed)}")
    return value


def is_required(field: Field[Any]) -> bool:
    """Whether a field of a dataclass has no default."""
    return field.default is MISSING and field.default_factory is MISSING


def _joined(where: str, name: str) -> str:
    return f"{where}.{name}" if where else name
