"""The tree in the docstring of ``dampyr.errors`` is the tree of its classes."""

import inspect
import re
from pathlib import Path

import pytest

from dampyr import errors

LINE = re.compile(r"^ {4}(?P<indent>[│├└─ ]*)(?P<name>\w+)(?: \((?P<builtin>\w+)\))?")


def drawn() -> dict[str, tuple[str, str | None]]:
    """What the docstring draws: name -> (parent or "", builtin base or None)."""
    tree: dict[str, tuple[str, str | None]] = {}
    path: list[str] = []
    block = (inspect.getdoc(errors) or "").split("::\n", 1)[1].split("\nEach message", 1)[0]
    for match in filter(None, map(LINE.match, block.splitlines())):
        depth = len(match["indent"]) // 4
        path[depth:] = [match["name"]]
        tree[match["name"]] = (path[depth - 1] if depth else "", match["builtin"])
    return tree


def coded() -> dict[str, tuple[str, str | None]]:
    """What the classes are."""
    tree: dict[str, tuple[str, str | None]] = {}
    for name, cls in inspect.getmembers(errors, inspect.isclass):
        if cls.__module__ != errors.__name__:
            continue
        ours = [base.__name__ for base in cls.__bases__ if base.__module__ == errors.__name__]
        builtin = [b.__name__ for b in cls.__bases__ if b.__module__ == "builtins" and b is not Exception]
        tree[name] = (ours[0] if ours else "", builtin[0] if builtin else None)
    return tree


def test_the_tree_in_the_docstring_is_the_tree_of_classes() -> None:
    assert drawn() == coded()
    assert len(drawn()) > 5


def test_a_file_error_starts_with_the_path() -> None:
    error = errors.FileError("folder/a.csv", "column 2 has no unit")
    assert str(error) == "folder/a.csv: column 2 has no unit"
    assert error.path == Path("folder/a.csv")


def test_callers_may_catch_the_builtin() -> None:
    with pytest.raises(ValueError, match="wrong"):
        raise errors.RangeError("wrong")
    with pytest.raises(FileNotFoundError, match="fetch it"):
        raise errors.MissingData("fetch it")
    assert str(errors.MissingData("fetch it")) == "fetch it"
    assert str(errors.MissingData())
