"""Compilation of a driver for a composition of parts, and the cache of compiled code.

A *driver* is a plain function in a real file (`dampyr.models.path_integration`, the coupling in ``dampyr.structures``)
that integrates along a path or through an earthquake. It calls the functions of a composition (`BOUND`) by name, and `bind`
gives these names the functions of one or several compositions and compiles the whole with numba.

Compiled code is cached on disk. Every kernel has files of its own, whose names hold a hash of what its machine code depends
on (`dampyr.models.codegen.kernel_key`), so that code of an edited model is never out of date, and what the kernel does not
call compiles nothing again. The name of the folder holds a hash of how kernels are compiled (`KERNEL_SOURCES`). It lies in
the user's cache, or in that of ``DAMPYR_CACHE``.
"""

from __future__ import annotations

import ast
import gc
import hashlib
import math
import os
import shutil
import sys
import tempfile
import time
import uuid
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from types import FunctionType
from typing import Any

from dampyr import compiling
from dampyr.models.codegen.composition import Composition, text_of
from dampyr.models.codegen.kernel_key import instructions, kernel_key
from dampyr.models.codegen.layout import SIGNATURES
from dampyr.models.codegen.syntax_trees import statements_of
from dampyr.models.numerics import fast_math
from dampyr.source_digest import source_digest

BOUND = tuple(SIGNATURES)
KERNEL_SOURCES = ("models/codegen/kernels.py", "models/codegen/kernel_key.py")  # what every kernel depends on
MORE = ("decide", "remember")
QUICK = ("quick_exp", "quick_tanh")
MAX_CACHE_AGE = 30 * 86400.0  # s: a month in which a kernel was not used
SWEEP = 86400.0  # s between two looks for such kernels
FAST = {"contract", "nsz", "arcp"}
_MATH = ("exp", "expm1", "log", "log1p", "sqrt", "tanh", "sin", "cos", "tan", "atan", "copysign")


@lru_cache(maxsize=1)
def cache_folder() -> Path:
    """The folder of compiled kernels, created if need be; a temporary folder where the user's cache is not writable."""
    base = os.environ.get("DAMPYR_CACHE") or _user_cache()
    folder = Path(base) / f"kernels-{source_digest(KERNEL_SOURCES)[:16]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
        _remove_old(folder)
        return folder
    except OSError:
        return Path(tempfile.mkdtemp(prefix="dampyr-kernels-"))


def _remove_old(folder: Path) -> None:
    """Once a day, remove the kernels that have not been used for a month, and the folders that have not been written to.

    The time of last use is that of the last reading, which most systems note once a day; where they do not, a kernel is
    compiled anew a month after it was.
    """
    swept = folder / "swept"
    if swept.exists() and time.time() - swept.stat().st_mtime < SWEEP:
        return
    swept.touch()
    for other in folder.parent.glob("kernels-*"):
        if time.time() - other.stat().st_mtime > MAX_CACHE_AGE:
            shutil.rmtree(other, ignore_errors=True)
    for file in folder.glob("*.nb?"):
        with suppress(OSError):  # another process has removed it
            if time.time() - max(file.stat().st_atime, file.stat().st_mtime) > MAX_CACHE_AGE:
                file.unlink()


def _user_cache() -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home())) / "dampyr"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "dampyr"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "dampyr"


def jit(
    function: Callable[..., Any],
    keep: bool = False,
    reordered: bool = False,
    flags: Iterable[str] = frozenset(FAST),
    inline: bool = False,
) -> Any:
    """``function`` compiled by numba without Python objects; ``keep`` caches the machine code on disk.

    What is not cached is called by kernels only, and has none of the wrappers that Python would call: these took a third of
    the time of compiling. ``inline`` writes it into its callers, whatever its size. Without numba's reference counting
    (``_nrt``): the kernels make no arrays, and counting every row they read took half of their time. A driver that did make
    one would not compile.
    """
    from numba import njit

    fast = {*flags, "reassoc"} if reordered else set(flags)
    inner = {} if keep else {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "pipeline_class": _inner_compiler()}
    # always said, as numba hands the caller's own setting on to what it calls: a part's loops would be written out everywhere
    compiled = njit(error_model="numpy", fastmath=fast, nogil=True, _nrt=False, forceinline=inline, **inner)(function)
    if keep:
        compiled._cache = _cache_class()(function)
        _pause_garbage_collection()
    return compiled


@lru_cache(maxsize=1)
def _inner_compiler() -> Any:
    """Numba's compiler for functions that kernels alone call: to the compiler's own language, no further.

    Numba optimises every function with all that it calls, makes machine code of it, and does so again in each caller. Of an
    inner function no machine code is ever run: the kernel takes its text, and is optimised as a whole, once.
    """
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import Compiler

    class UncompiledLibrary(JITCodeLibrary):
        def _optimize_final_module(self) -> None:
            pass

        def _finalize_final_module(self) -> None:
            self._finalized = True

        def get_pointer_to_function(self, name: str) -> int:
            self._ensure_finalized()
            return 0  # as numba says of a function without a wrapper for Python

        @property
        def codegen(self) -> Any:
            return self

        def set_env(self, name: str, environment: Any) -> None:
            """There is no machine code that could hold the Python objects of an error."""

    class InnerCompiler(Compiler):
        def __init__(self, typing: Any, target: Any, library: Any, *more: Any) -> None:
            super().__init__(typing, target, UncompiledLibrary(target.codegen(), "inner"), *more)

    return InnerCompiler


@lru_cache(maxsize=1)
def _pause_garbage_collection() -> None:
    """Let Python's collector rest while numba compiles: a tenth of that time went into looking through what is still in use."""
    from numba.core.event import Listener, register

    class Pause(Listener):
        depth, resumes = 0, False  # functions that are being compiled, one within another; whether the collector was on

        def on_start(self, event: Any) -> None:
            if self.depth == 0:
                self.resumes = gc.isenabled()
                gc.disable()
            self.depth += 1

        def on_end(self, event: Any) -> None:
            self.depth -= 1
            if self.depth == 0 and self.resumes:
                gc.enable()

    register("numba:compile", Pause())


@lru_cache(maxsize=1)
def _cache_class() -> Any:
    from numba.core import caching

    class Locator(caching._CacheLocator):
        """Our folder; the file's name carries the kernel's key, so the stamp need not."""

        def __init__(self, function: Any) -> None:
            self.key = hashlib.sha256(f"{function.__qualname__} {kernel_key(function)}".encode()).hexdigest()[:24]

        def get_cache_path(self) -> str:
            return str(cache_folder())

        def get_source_stamp(self) -> str:
            return cache_folder().name

        def get_disambiguator(self) -> str:
            return self.key

        @classmethod
        def from_function(cls, function: Any, file: str) -> Any:
            return cls(function)

    class Implementation(caching.CompileResultCacheImpl):
        _locator_classes = [Locator]  # noqa: RUF012

    class Files(caching.IndexDataCacheFile):
        """Every saved signature has a file name of its own.

        Numba counts its files. Two processes that save two signatures of a kernel at once then count alike, and the index of
        one leads to the machine code of the other: what runs is made for other arguments and writes where it may not.
        """

        def save(self, key: Any, data: Any) -> None:
            name = self._load_index().get(key, self._data_name(uuid.uuid4().int))
            self._save_data(name, data)
            self._save_index(self._load_index() | {key: name})

    class Cache(caching.FunctionCache):
        _impl_class = Implementation

        def __init__(self, function: Any) -> None:
            super().__init__(function)
            place, stamp = self._impl.locator.get_cache_path(), self._impl.locator.get_source_stamp()
            self._cache_file = Files(place, self._impl.filename_base, stamp)

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            found = super().load_overload(sig, target_context)
            _used.add(Path(self._cache_file._index_path).name)
            if found is None:
                compiling.note(begins=True)
            return found

        def save_overload(self, sig: Any, data: Any) -> None:
            super().save_overload(sig, data)
            compiling.note(begins=False)

    return Cache


def used_kernels() -> set[str]:
    """The files of the kernels that this process has loaded or compiled so far: of each the index, ``*.nbi``."""
    return set(_used)


_used: set[str] = set()


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
