"""What can be chosen in a call: fields of a frozen dataclass, each declared once.

::

    @dataclass(frozen=True)
    class ScoreOptions(Options):
        \"""Options of `score`.\"""

        settling: Annotated[float, Quantity("s", low=0), "time after the motion starts that is not scored"] = 2.0

From such a class come the keyword arguments of the call (`takes`), the options of the command
(`dampyr.cli._options`), the request and the form of the console (`dampyr.console.option_schemas`), the command line that is
equivalent to a request (`command_words`) and the table of the reference page. `dampyr.config` checks the values.
"""

from __future__ import annotations

import inspect
import math
import textwrap
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, dataclass, fields, replace
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Self, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from dampyr.config import Choices, unknown, value_of
from dampyr.errors import InputError
from dampyr.units import Quantity, from_si, in_si, parse

Call = TypeVar("Call", bound=Callable[..., Any])

NONE = "none"  # what is typed for None, where that is not the default
METAVARS = {bool: "", int: "N", float: "NUMBER", str: "TEXT"}
TYPES = {bool: "true or false", int: "whole number", float: "number", str: "text"}


@dataclass(frozen=True)
class Terminal:
    """Note of a field: the option of the command where it is not called as the field, and what stands for its value.

    ``adds``: what is typed is added to the usual values, and with a minus sign before it taken from them.
    """

    flag: str = ""
    metavar: str = ""
    adds: bool = False


@dataclass(frozen=True)
class ShownIn:
    """Note of a field: the unit in which people type and read it, such as ``"%"`` or ``"mm"``, unless it is the SI unit."""

    unit: str


@dataclass(frozen=True)
class FormGroup:
    """Note of a field: the part of a form, shown when it is opened, that the option is in; a form begins with those of none."""

    name: str


class Options:
    """Base of the dataclasses of options: every value is checked and in SI units once the object is there.

    A field without a note is data that goes with the options, such as the structure of a plan: an argument of the call alone.
    Numbers may be quantities: texts such as ``"5 Hz"``, or those of pint and astropy. Raises
    :class:`~dampyr.errors.InputError` for a value of the wrong kind or unit, outside of its range or not among the choices.
    """

    def __post_init__(self) -> None:
        for option in options_of(type(self)):
            value = getattr(self, option.name)
            if value is not option.default:  # which a test checks
                object.__setattr__(self, option.name, option.checked(value))
        self.check()

    def check(self) -> None:
        """Raise :class:`~dampyr.errors.InputError` for options that exclude one another."""

    @classmethod
    def of(cls, call: str, options: Self | None, keywords: Mapping[str, Any]) -> Self:
        """``options``, or the usual ones, with the keyword arguments that ``call`` was given in their place."""
        names = [field.name for field in fields(cls)]  # type: ignore[arg-type]
        for name in keywords:
            if name not in names:
                raise InputError(unknown(f"{call}(..., {name}=)", name, names))
        if options is not None and not isinstance(options, cls):
            raise InputError(
                f"{call}: options are of the type {type(options).__name__}; give {cls.__name__}, or keyword arguments such as "
                f"{names[0]}="
            )
        return cls(**keywords) if options is None else replace(options, **keywords)  # type: ignore[type-var]

    def as_keywords(self) -> dict[str, Any]:
        """The values by name."""
        return {option.name: getattr(self, option.name) for option in options_of(type(self))}


class Thresholds(Options):
    """Base of the dataclasses of judgements: numbers that someone chose, checked as options are, for calls in Python alone.

    They change what is said of a result and no number in it; what is judged by others than the usual ones says so, by
    `changed`, in its provenance. docs/reference/thresholds.md lists them.
    """

    @property
    def changed(self) -> str:
        """The thresholds that are not as usual, such as ``"misfit = 0.2"``, with their units; empty where all are."""
        changed = [(option, getattr(self, option.name)) for option in options_of(type(self))]
        return ", ".join(f"{o.name} = {value:g} {o.unit}".rstrip() for o, value in changed if value != o.default)


@dataclass(frozen=True)
class Option:
    """A field of `Options`, with all that its annotation says.

    ``kind`` is the type of a value: bool, int, float or str, of several the first; of ``several``, a tuple, that of each,
    and of ``pairs``, a mapping by names, that of the values. ``for_all``: one value for all names may stand in the place of
    the mapping. A float with ``choices`` is a number or one of these texts.
    """

    name: str
    hint: Any
    default: Any
    kind: type
    words: str
    several: bool = False
    pairs: bool = False
    for_all: bool = False
    optional: bool = False
    quantity: Quantity | None = None
    choices: Mapping[Any, str] | None = None
    flag: str = ""
    metavar: str = ""
    adds: bool = False
    shown_in: str = ""
    group: str = ""

    @property
    def unit(self) -> str:
        """The SI unit of a number; empty without one."""
        return self.quantity.unit if self.quantity else ""

    @property
    def factor(self) -> float:
        """What a value in SI is multiplied by where people read it, in the unit ``shown_in``."""
        return float(from_si(1.0, self.shown_in, self.unit)) if self.shown_in != self.unit else 1.0

    def checked(self, value: Any) -> Any:
        """A value in SI units, of the type that the field declares."""
        if isinstance(value, np.ndarray | np.generic):
            value = value.tolist()
        named = self.choices is not None and isinstance(value, str)
        if self.kind is float and self.quantity and not isinstance(value, Mapping) and not named:
            value = list(map(self._in_si, value)) if isinstance(value, list | tuple) else self._in_si(value)
        try:
            return value_of(self.hint, value, self.name)
        except InputError as problem:
            percent = "; 0.1 is 10 %" if self.shown_in == "%" and "not allowed" in str(problem) else ""
            raise InputError(f"{problem}{percent}") from None

    def is_choice(self, value: Any) -> bool:
        """Whether ``value`` is one of the texts that may be chosen."""
        return self.choices is not None and isinstance(value, str) and value in self.choices

    def _in_si(self, value: Any) -> Any:
        return value if value is None else in_si(value, self.unit, self.name)

    def from_terminal(self, typed: Any) -> Any:
        """The value of what was typed: a flag, a text, or a tuple of texts; None where nothing was."""
        if self.kind is bool:
            return bool(typed)
        if self.pairs:
            return self._mapping(typed or ())
        if self.adds:
            without = [text[1:] for text in typed or () if text.startswith("-")]
            added = [text for text in typed or () if not text.startswith("-") and text not in self.default]
            return (*(name for name in self.default if name not in without), *added)
        if self.several:
            return () if typed == (NONE,) else tuple(map(self.from_text, typed)) if typed else self.default
        return self.default if typed is None else self.from_text(typed)

    def _mapping(self, texts: Iterable[str]) -> Any:
        values: dict[str, Any] = {}
        for text in texts:
            name, sign, value = text.partition("=")
            if not sign and not self.for_all:
                raise InputError(f"{self.flag} {text!r} has no '='; write it as in {self.metavar}")
            name, value = (name, value) if sign else ("*", text)
            if name in values:
                raise InputError(
                    f"{self.flag} {name if sign else values[name]} and {self.flag} {text} are both for "
                    f"{name if sign else 'all parameters'}; leave one of them out"
                )
            values[name] = self.from_text(value)
        return values["*"] if list(values) == ["*"] else values or self.default

    def from_text(self, text: str) -> Any:
        """A single value of the option, of what was typed."""
        if self.optional and text.strip().lower() == NONE:
            return None
        if self.kind is str or self.is_choice(text):
            return text
        try:
            if self.kind is int:
                return int(text)
            return parse(text, self.unit) if self.quantity else float(text)
        except InputError as problem:
            also = f"; or choose from {', '.join(self.choices)}" if self.choices else ""
            raise InputError(f"{self.flag} {text}: {problem}{also}") from None
        except ValueError:
            what = "a whole number" if self.kind is int else "a number in SI units"
            raise InputError(f"{self.flag} {text}: {text!r} is not {what}") from None

    def to_terminal(self, value: Any) -> list[str]:
        """The words of a command line that give this value; none where it is the usual one."""
        if value == self.default:
            return []
        if self.kind is bool:
            return [self.flag]
        if self.adds:
            texts = [f"-{name}" for name in self.default if name not in value]
            texts += [name for name in value if name not in self.default]
        elif isinstance(value, Mapping):
            texts = [
                self.to_text(v) if self.for_all and k == "*" else f"{k}={self.to_text(v)}" for k, v in value.items()
            ]
        elif self.several:
            texts = [self.to_text(item) for item in value] or [NONE]
        else:
            texts = [self.to_text(value)]
        return [word for text in texts for word in (self.flag, text)]

    def to_text(self, value: Any) -> str:
        """A single value as it is typed, a number in the unit that people read."""
        if value is None:
            return NONE
        if self.kind is not float or isinstance(value, str):
            return str(value)
        if self.shown_in == self.unit:
            return f"{value:.15g}"
        return f"{from_si(value, self.shown_in, self.unit):.12g}{self.shown_in}"

    @property
    def default_text(self) -> str:
        """The default as it is typed; empty where nothing is chosen without the option."""
        if self.several:
            return " ".join(map(self.to_text, self.default or ()))
        return "" if self.kind is bool or self.pairs or self.default is None else self.to_text(self.default)

    def values(self, si: bool = False) -> str:
        """What may be given, in words: the choices, or the type, unit and range.

        ``si``: as a program gives it, in SI units and with names in quotes; else as a person types it.
        """
        kind = TYPES[self.kind]
        if self.choices is not None:
            choices = [f'"{choice}"' if si and isinstance(choice, str) else str(choice) for choice in self.choices]
            kind = ", ".join([*choices, *([kind] if self.kind is float else [])])
        several = f"several of {kind}" if self.several else f"name: {kind}" if self.pairs else kind
        if self.for_all:
            several = f"{kind}, or {several}"
        if self.quantity is None:
            return several
        unit, factor = (self.unit, 1.0) if si else (self.shown_in, self.factor)
        low, high = self.quantity.low * factor, self.quantity.high * factor
        above = "above" if self.quantity.open_low else "from"
        bounds = [f"{above} {low:g}"] * math.isfinite(low) + [f"to {high:g}"] * math.isfinite(high)
        return ", ".join(part for part in (f"{several} in {unit}" if unit else several, " ".join(bounds)) if part)


def options_of(cls: Any) -> tuple[Option, ...]:
    """The options that a dataclass declares, in the order of its fields."""
    return _options_of(cls)


@cache  # beside a typed door: mypy takes a class of dataclasses for unhashable
def _options_of(cls: Any) -> tuple[Option, ...]:
    hints = get_type_hints(cls, include_extras=True)
    return tuple(
        _option(f.name, hints[f.name], f.default if f.default_factory is MISSING else f.default_factory())
        for f in fields(cls)
        if get_origin(hints[f.name]) is Annotated
    )


def _option(name: str, hint: Any, default: Any) -> Option:
    declared, *notes = get_args(hint)
    members = get_args(declared) if get_origin(declared) in (Union, UnionType) else (declared,)
    types = [member for member in members if member is not NoneType]
    container = next((t for t in types if get_origin(t) is not None), types[0])
    several = get_origin(container) is tuple
    pairs = not several and get_origin(container) is not None
    choices = next((note.words for note in notes if isinstance(note, Choices)), None)
    inner = get_args(container)[-1 if pairs else 0] if several or pairs else container
    kind = next(iter(get_args(inner)), inner)  # of several plain types the first, in which it is typed
    kind = float if choices is not None and float in types else kind  # a number, or one of the texts
    if kind is bool and default:
        raise TypeError(f"{name}: a flag is False where it is not typed; declare the opposite, with the default False")
    quantity = next((note for note in notes if isinstance(note, Quantity)), None)
    terminal = next((note for note in notes if isinstance(note, Terminal)), Terminal())
    shown_in = next((note.unit for note in notes if isinstance(note, ShownIn)), quantity.unit if quantity else "")
    metavar = terminal.metavar or (
        "|".join([*map(str, choices), *(["NUMBER"] if kind is float else [])])
        if choices
        else "NAME=VALUE"
        if pairs
        else shown_in.upper() or METAVARS[kind]
    )
    return Option(
        name,
        hint,
        default,
        kind,
        next(note for note in notes if isinstance(note, str)),
        several,
        pairs,
        for_all=pairs and kind in types,
        optional=NoneType in members,
        quantity=quantity,
        choices=choices,
        flag=terminal.flag or f"--{name.replace('_', '-')}",
        metavar=metavar,
        adds=terminal.adds,
        group=next((note.name for note in notes if isinstance(note, FormGroup)), ""),
        shown_in=shown_in,
    )


def command_words(options: Options) -> list[str]:
    """The words of a command line that choose these options; those as usual are left out."""
    return [word for option in options_of(type(options)) for word in option.to_terminal(getattr(options, option.name))]


def takes(cls: type[Options]) -> Callable[[Call], Call]:
    """Decorator of a call with ``**keywords``: its signature and its docstring name the options of ``cls``."""

    def add(call: Call) -> Call:
        signature = inspect.signature(call)
        declared = [p for p in signature.parameters.values() if p.kind is not inspect.Parameter.VAR_KEYWORD]
        keywords = [
            inspect.Parameter(option.name, inspect.Parameter.KEYWORD_ONLY, default=option.default)
            for option in options_of(cls)
            if option.name not in signature.parameters
        ]
        call.__signature__ = signature.replace(parameters=[*declared, *keywords])  # type: ignore[attr-defined]
        call.__doc__ = f"{inspect.cleandoc(call.__doc__ or '')}\n\n{_docstring(cls)}"
        return call

    return add


def _docstring(cls: type[Options]) -> str:
    lines = ["Other Parameters", "----------------"]
    for option in options_of(cls):
        lines += [f"{option.name} : {option.values(si=True)}", *textwrap.wrap(f"{option.words}.", 120, initial_indent="    ",
                  subsequent_indent="    ")]  # fmt: skip
    return "\n".join(lines)
