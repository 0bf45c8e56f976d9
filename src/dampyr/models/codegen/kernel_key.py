"""Key of a kernel: a hash of all that its machine code depends on, and of nothing else.

A kernel is made of its own instructions, those of every function that it calls, the numbers that these read from their
modules, and the settings of the compiler. The key is a hash of these, read from what Python has loaded: a comment, a
docstring or a function that the kernel does not call changes no key. What is not known to be read in this way, such as an
object of dampyr's own, stands for all sources of the package, which is the safe side.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dis import get_instructions
from functools import lru_cache
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from dampyr.source_digest import source_digest

GLOBAL = ("LOAD_GLOBAL", "LOAD_NAME")
PLAIN = (type(None), bool, int, float, complex, str, bytes, type(Ellipsis))


def kernel_key(function: Callable[..., Any]) -> str:
    """The SHA-256, 64 hexadecimal digits, of what the compiled ``function`` depends on."""
    import llvmlite
    import numba

    words = [f"numba {numba.__version__}", f"llvmlite {llvmlite.__version__}"]
    _describe(function, words, {})
    return hashlib.sha256("\0".join(words).encode()).hexdigest()


def _describe(value: Any, words: list[str], seen: dict[int, int]) -> None:
    """Append to ``words`` what ``value`` is; ``seen`` holds the places of the functions that stand there already."""
    if isinstance(value, PLAIN):
        words.append(f"{type(value).__name__} {value!r}")
    elif isinstance(value, np.generic | np.ndarray):
        words.append(f"{value.dtype} {value.shape} {value.tobytes().hex()}")
    elif isinstance(value, tuple | list):
        words.append(f"{type(value).__name__} of {len(value)}")
        for item in value:
            _describe(item, words, seen)
    elif isinstance(value, set | frozenset):
        words.append(f"set {sorted(map(repr, value))}")
    elif isinstance(value, dict):
        words.append(f"dict of {len(value)}")
        for name in sorted(value, key=repr):
            words.append(repr(name))
            _describe(value[name], words, seen)
    elif isinstance(value, CodeType):
        _describe_code(value, words, seen)
    elif id(value) in seen:
        words.append(f"again {seen[id(value)]}")
    elif isinstance(value, FunctionType):
        seen[id(value)] = len(seen)
        _describe_function(value, words, seen)
    elif isinstance(getattr(value, "py_func", None), FunctionType):  # compiled by numba
        seen[id(value)] = len(seen)
        words.append("compiled")
        _describe(value.targetoptions, words, seen)
        _describe(value.py_func, words, seen)
    else:
        words.append(_name_of(value))


def _name_of(value: Any) -> str:
    """A name that stands for all of ``value``, where it is another package's; the digest of dampyr's sources otherwise."""
    if isinstance(value, ModuleType):
        name = value.__name__
    elif isinstance(value, BuiltinFunctionType | type | np.ufunc):
        name = f"{getattr(value, '__module__', None) or 'numpy'}.{value.__name__}"
    else:
        return f"{type(value)} {source_digest()}"
    # the compiler's own classes are in a file of the folder's digest
    own = name.startswith("dampyr.") and not name.startswith("dampyr.models.codegen.kernel_compilers.")
    return f"{name} {source_digest()}" if own else name


def _describe_function(function: FunctionType, words: list[str], seen: dict[int, int]) -> None:
    code = function.__code__
    words.append(f"function {function.__name__}")
    _describe_code(code, words, seen)
    for values in (function.__defaults__, function.__kwdefaults__):
        _describe(values, words, seen)
    for cell in function.__closure__ or ():
        _describe(cell.cell_contents, words, seen)
    for name in _globals_of(code):
        words.append(f"global {name}")
        if name in function.__globals__:
            _describe(function.__globals__[name], words, seen)


def _describe_code(code: CodeType, words: list[str], seen: dict[int, int]) -> None:
    """The instructions with the values that they load; neither line numbers nor the docstring, which no instruction loads."""
    arguments = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    words.append(f"{arguments} {code.co_posonlyargcount} {code.co_kwonlyargcount} {code.co_flags}")
    for name, value in instructions(code):
        words.append(name)
        _describe(value, words, seen)


@lru_cache(maxsize=4096)
def instructions(code: CodeType) -> tuple[tuple[str, Any], ...]:
    """The instructions of ``code`` by name, each with what it loads, stores or jumps to; read once in a process."""
    return tuple((each.opname, each.argval) for each in get_instructions(code))


def _globals_of(code: CodeType) -> list[str]:
    """The names that ``code`` and the code within it read from their module, sorted."""
    found = {value for name, value in instructions(code) if name in GLOBAL}
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            found.update(_globals_of(inner))
    return sorted(found)
