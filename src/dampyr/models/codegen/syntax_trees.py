"""Syntax trees of texts, one at a time: threads of an ensemble make them beside each other.

CPython 3.11 counts for all threads together how deep it is in a tree. Where garbage is collected within it, and what is called
then lets another thread go on, as callbacks of dask do, that thread may parse meanwhile, and one of both ends with the error
"AST constructor recursion depth mismatch" (https://github.com/python/cpython/issues/106905).
"""

from __future__ import annotations

import ast
from threading import RLock

_PARSING = RLock()


def statements_of(text: str) -> ast.Module:
    """The tree of a text of statements."""
    with _PARSING:
        return ast.parse(text)


def expression_of(text: str) -> ast.Expression:
    """The tree of one expression."""
    with _PARSING:
        return ast.parse(text, mode="eval")
