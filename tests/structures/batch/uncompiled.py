"""Functions that numba compiles, run by Python itself: what they compute does not depend on who runs them."""

from collections.abc import Mapping
from types import FunctionType
from typing import Any


def uncompiled(names: Mapping[str, Any]) -> dict[str, Any]:
    """The same names with Python's functions, which call one another; those that were given stay as they are."""
    plain = dict(names)
    for name, value in names.items():
        if hasattr(value, "py_func"):
            function = value.py_func
            plain[name] = FunctionType(function.__code__, dict(function.__globals__), function.__name__)
    functions = {name: value for name, value in plain.items() if isinstance(value, FunctionType)}
    for function in functions.values():
        function.__globals__.update(functions)
    return plain
