"""Compilation of a driver for a composition of parts, and the cache of compiled code.

A *driver* is a plain function in a real file (`dampyr.models.path_integration`, the coupling in ``dampyr.structures``)
that integrates along a path or through an earthquake. It calls the functions of a composition (`BOUND`) by name, and `bind`
gives these names the functions of one or several compositions and compiles the whole with numba.

Compiled code is cached on disk (`dampyr.models.codegen.kernel_cache`), so that code of an edited model is never out of date,
and what a kernel does not call compiles nothing again.
"""

from __future__ import annotations

import ast
import hashlib
import math
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from types import FunctionType
from typing import Any

from dampyr.models.codegen.composition import Composition, text_of
from dampyr.models.codegen.kernel_cache import cache_class
from dampyr.models.codegen.kernel_compilers import inner_compiler, kernel_compiler, pause_garbage_collection
from dampyr.models.codegen.kernel_key import instructions
from dampyr.models.codegen.layout import SIGNATURES
from dampyr.models.codegen.syntax_trees import statements_of
from dampyr.models.numerics import fast_math

BOUND = tuple(SIGNATURES)
MORE = ("decide", "remember")
QUICK = ("quick_exp", "quick_tanh")
FAST = {"contract", "nsz", "arcp"}
_MATH = ("exp", "expm1", "log", "log1p", "sqrt", "tanh", "sin", "cos", "tan", "atan", "copysign")


def jit(
    function: Callable[..., Any],
    keep: bool = False,
    reordered: bool = False,
    vectorised: bool = True,
    flags: Iterable[str] = frozenset(FAST),
    inline: bool = False,
) -> Any:
    """``function`` compiled by numba without Python objects; ``keep`` caches the machine code on disk.

    What is not cached is called by kernels only, and has none of the wrappers that Python would call: these took a third of
    the time of compiling. ``inline`` writes it into its callers, whatever its size; ``vectorised`` is of a
    kernel (`kernel_compiler`). Without numba's reference counting
    (``_nrt``): the kernels make no arrays, and counting every row they read took half of their time. A driver that did make
    one would not compile.
    """
    from numba import njit

    fast = {*flags, "reassoc"} if reordered else set(flags)
    options = {"no_cpython_wrapper": not keep, "no_cfunc_wrapper": True}
    options["pipeline_class"] = kernel_compiler(vectorised) if keep else inner_compiler()
    # always said, as numba hands the caller's own setting on to what it calls: a part's loops would be written out everywhere
    compiled = njit(error_model="numpy", fastmath=fast, nogil=True, _nrt=False, forceinline=inline, **options)(function)
    if keep:
        function.settings = sorted(fast), vectorised  # type: ignore[attr-defined]
        compiled._cache = cache_class()(function)
        pause_garbage_collection()
    return compiled


def named(function: FunctionType, module: str, key: str) -> FunctionType:
    """``function`` with a name that no other one has, if ``key`` tells what it computes apart from what others of its name do.

    Numba makes a symbol of a function's module, name, arguments and a number that it counts in each process. Where two
    processes each cached a kernel and a third one loads both, the linker takes functions of the same symbol for one function,
    and one kernel calls what belongs to the other (https://github.com/numba/numba/issues/10486).
    """
    function.__module__, function.__qualname__ = module, f"{module}.{function.__name__}.{key}"
    return function


@lru_cache(maxsize=256)
def bind(driver: Callable[..., Any], compositions: tuple[Composition, ...], more: str = "", keep: bool = True) -> Any:
    """``driver`` compiled with the functions of ``compositions`` in the place of the names in `BOUND`.

    ``site`` in the driver's calls says which of the compositions is meant. Functions that it calls are bound with it where they
    are in its own module or in one that its module names in ``BOUND_WITH``. ``more`` is the text of further functions, of
    which ``decide`` is given to the driver too.

    A kernel is one for all compositions whose functions are the same as far as the driver calls them: a delay, which has no
    formula, makes no building's kernel compile anew. Without ``keep`` it is a function that another kernel may call.
    """
    text = text_of(compositions)
    called = [name for name in (*BOUND, *MORE) if _reaches(driver, frozenset([name]))]
    return _bound(driver, _needed(f"{text}\n\n{more}" if more else text, called), keep)


def _needed(text: str, wanted: Iterable[str]) -> str:
    """The functions of ``text`` that are called ``wanted``, with those that they call, in their order."""
    functions = {node.name: node for node in statements_of(text).body if isinstance(node, ast.FunctionDef)}
    lines, open_, needed = text.split("\n"), list(wanted), set[str]()
    while open_:
        name = open_.pop()
        if name in functions and name not in needed:
            needed.add(name)
            open_ += [node.id for node in ast.walk(functions[name]) if isinstance(node, ast.Name)]
    kept = (node for name, node in functions.items() if name in needed)
    return "\n\n".join("\n".join(lines[node.lineno - 1 : node.end_lineno]) for node in kept)


@lru_cache(maxsize=256)
def _bound(driver: Callable[..., Any], text: str, keep: bool = True) -> Any:
    """``driver`` with the functions of ``text``."""
    names: dict[str, Any] = {"__name__": __name__} | {name: getattr(math, name) for name in _MATH}
    names.update((name, _rebound(getattr(fast_math, name), {}, "alone", _shared)) for name in QUICK)
    exec(compile(text, f"<functions of {driver.__name__}>", "exec"), names)
    key = hashlib.sha256(text.encode()).hexdigest()[:16]
    for name, value in list(names.items()):
        if isinstance(value, FunctionType):
            names[name] = jit(named(value, __name__, key))
    return _rebound(driver, {name: names[name] for name in (*BOUND, *MORE) if name in names}, key, {}, keep)


_shared: dict[Any, Any] = {}  # compiled functions that reach no part of a damper: one for all kernels


def _rebound(function: Any, bound: dict[str, Any], key: str, done: dict[Any, Any], keep: bool = False) -> Any:
    if not keep and not _reaches(function, frozenset(bound)):
        bound, key, done = {}, "alone", _shared
    if function in done and not keep:
        return done[function]
    names = {**function.__globals__, **bound}
    names |= {name: _rebound(called, bound, key, done) for name, called in _called(function) if name not in bound}
    copy = FunctionType(function.__code__, names, function.__name__, function.__defaults__)
    unique = key if keep else f"{key}.inner"  # what is a kernel of its own may be within another one, and inlined there
    compiled = jit(
        named(copy, function.__module__, unique), keep, getattr(function, "reordered", False), inline=not keep
    )
    if not keep:
        done[function] = compiled
    return compiled


@lru_cache(maxsize=1024)
def _reaches(function: FunctionType, bound: frozenset[str]) -> bool:
    """Whether a function, or one that is bound with it, calls by one of these names."""
    return any(name in bound or _reaches(called, bound) for name, called in _called(function))


def _called(function: FunctionType) -> Iterator[tuple[str, FunctionType]]:
    """The functions that are bound with ``function``, by the names by which it calls them."""
    modules = (function.__module__, *function.__globals__.get("BOUND_WITH", ()))
    for name in {loaded for kind, loaded in instructions(function.__code__) if kind == "LOAD_GLOBAL"}:
        called = function.__globals__.get(name)
        if isinstance(called, FunctionType) and called.__module__ in modules:
            yield name, called


@lru_cache(maxsize=64)
def compile_cached(function: Callable[..., Any]) -> Any:
    """A function that needs no composition, compiled with those of its own module that it calls, and cached on disk."""
    return _rebound(function, {}, "alone", _shared, keep=True)
