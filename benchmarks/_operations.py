"""How many floating-point operations a lanes kernel makes per step, counted from its own text.

The text is run once with symbols in the place of numbers. An expression that occurs twice counts once, what nothing keeps does
not count, nor what is the same for all histories, nor a product with 1 or a sum with 0: about what a compiler leaves. Sums and
products count one each (so a fused multiply-add counts two), a division one; comparisons, signs, changes of a number's bits and
whole numbers count nothing, though they take time.
"""

from __future__ import annotations

import inspect
from collections import Counter
from collections.abc import Iterable
from types import FunctionType
from typing import Any

import numpy as np

from dampyr.models.codegen.composition import text_of
from dampyr.structures.batch import branchless_math, run_blocks
from dampyr.structures.batch.engine import Engine

COUNTED = ("+", "-", "*", "/")


class Symbol:
    """The result of an operation; ``shared`` by all histories or not, ``whole`` if it stands for bits."""

    def __init__(self, kind: str, operands: tuple[Any, ...], shared: bool, whole: bool = False) -> None:
        self.kind, self.operands, self.shared, self.whole = kind, operands, shared, whole


class Sheet:
    """All symbols of one run, equal ones the same object."""

    def __init__(self) -> None:
        self.symbols: dict[Any, Symbol] = {}

    def given(self, name: str, shared: bool) -> Symbol:
        """A number from outside."""
        return self.symbols.setdefault(name, Symbol(name, (), shared))

    def made(self, kind: str, *operands: Any) -> Any:
        """The result of an operation, simplified as a compiler may that need not care for the sign of zero."""
        simple = _simple(kind, operands)
        if simple is not None:
            return simple
        named = [id(each) if isinstance(each, Symbol) else f"{each!r}" for each in operands]
        key = (kind, *(sorted(named, key=str) if kind in ("+", "*", "min", "max") else named))
        if key not in self.symbols:
            symbols = [each for each in operands if isinstance(each, Symbol)]
            whole = kind == "bits" or (kind != "number" and any(each.whole for each in symbols))
            self.symbols[key] = Symbol(kind, operands, all(each.shared for each in symbols), whole)
        return self.symbols[key]


def _simple(kind: str, operands: tuple[Any, ...]) -> Any:
    """What sums with 0 and products with 0 or 1 come to; None where nothing is to be had."""
    if kind not in COUNTED:
        return None
    a, b = operands
    if kind == "*" and (_is(a, 0) or _is(b, 0)):
        return 0.0
    if (kind in "+-" and _is(b, 0)) or (kind in "*/" and _is(b, 1)):
        return a
    if (kind == "+" and _is(a, 0)) or (kind == "*" and _is(a, 1)):
        return b
    return None


def _is(value: Any, number: int) -> bool:
    return not isinstance(value, Symbol) and value == number


def _operators(sheet: Sheet) -> None:
    """Give symbols the operators of numbers, on a sheet."""
    for name, kind in (
        ("add", "+"),
        ("sub", "-"),
        ("mul", "*"),
        ("truediv", "/"),
        ("lshift", "<<"),
        ("and", "&"),
        ("or", "|"),
    ):
        setattr(Symbol, f"__{name}__", lambda a, b, kind=kind: sheet.made(kind, a, b))
        setattr(Symbol, f"__r{name}__", lambda a, b, kind=kind: sheet.made(kind, b, a))
    Symbol.view = lambda a, kind: sheet.made("bits" if kind is _whole else "number", a)
    for name in ("neg", "abs"):
        setattr(Symbol, f"__{name}__", lambda a, name=name: sheet.made(name, a))


def total(engine: Engine) -> int:
    """Sums, products and divisions of a history's step together."""
    counts = per_step(engine)
    return sum(counts[kind] for kind in COUNTED)


def per_step(engine: Engine) -> Counter[str]:
    """Operation -> how many a history's step takes, of an engine whose sums are written out (up to two floors)."""
    sheet = Sheet()
    _operators(sheet)
    names, rows = _names(engine, sheet), _Rows(sheet)
    exec(engine.text.source.replace(f"range({engine.text.block_width})", "range(1)"), names)
    given = {
        "ground": {(k, 0): sheet.given(f"ground {k}", shared=False) for k in range(2)},
        "motion": [0],
        "scale": [1.0],  # the ground is scaled once for all steps between two samples
        "times": _Numbers(sheet, "step", shared=True),
        "c": _Numbers(sheet, "coefficient", shared=True),
        "b": rows,
    }
    counts = {"last": 1, "parts": 1}  # one step of one history
    kernel = names["integrate_block"]
    kernel(**{name: given.get(name, counts.get(name, 0)) for name in inspect.signature(kernel).parameters})
    return _counted(rows.values.values())


def _names(engine: Engine, sheet: Sheet) -> dict[str, Any]:
    """What the text calls: its damper's formulas and the arithmetic of the lanes, all of them on symbols."""
    constants = branchless_math.constants(64)
    numbers = {name: value.item() for name, value in constants.items() if isinstance(value, np.generic)}
    names: dict[str, Any] = {kind: _operation(sheet, kind) for kind in ("min", "max", *run_blocks.MATH)}
    names |= {"real": _same, "whole": _whole}
    names |= numbers | run_blocks.CONSTANTS
    for name, value in vars(branchless_math).items():
        if isinstance(value, FunctionType) and value.__module__ == branchless_math.__name__ and name[0] != "_":
            names[name] = FunctionType(value.__code__, names, name)
    exec(text_of(engine.compositions) if engine.compositions else "", names)
    return names


class _Plain(float):
    """A number that is known, whose bits can be taken."""

    def view(self, kind: Any) -> int:
        return int(np.float64(self).view(np.int64))


def _same(number: Any) -> Any:
    """A number of the kernel's precision: itself."""
    return number if isinstance(number, Symbol) else _Plain(number)


def _whole(number: Any) -> Any:
    """Bits taken for an integer: themselves."""
    return number


def _operation(sheet: Sheet, kind: str) -> Any:
    return lambda *operands: sheet.made(kind, *operands)


class _Numbers:
    """Numbers from outside by their place."""

    def __init__(self, sheet: Sheet, name: str, shared: bool) -> None:
        self.sheet, self.name, self.shared = sheet, name, shared

    def __getitem__(self, k: int) -> Symbol:
        return self.sheet.given(f"{self.name} {k}", self.shared)


class _Rows:
    """The block of histories, of which one is looked at."""

    def __init__(self, sheet: Sheet) -> None:
        self.sheet = sheet
        self.values: dict[int, Any] = {}

    def __getitem__(self, k: int) -> Any:
        return self.values[k] if k in self.values else self.sheet.given(f"row {k}", shared=False)

    def __setitem__(self, k: int, value: Any) -> None:
        self.values[k] = value


def _counted(outputs: Iterable[Any]) -> Counter[str]:
    """The operations that lead to what is kept, each once."""
    counts: Counter[str] = Counter()
    seen: set[int] = set()
    waiting = list(outputs)
    while waiting:
        each = waiting.pop()
        if isinstance(each, Symbol) and not each.shared and id(each) not in seen:
            seen.add(id(each))
            waiting += each.operands
            if each.operands:
                counts[f"{each.kind} of whole numbers" if each.whole else each.kind] += 1
    return counts
