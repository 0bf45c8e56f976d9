"""Compilation of a kernel's text, with the functions and numbers that it uses."""

from __future__ import annotations

import ast
import hashlib
import math
from functools import lru_cache
from types import FunctionType
from typing import Any

import numpy as np

from dampyr.models.codegen.composition import Composition, text_of
from dampyr.models.codegen.formula import read
from dampyr.models.codegen.kernels import bind, jit, named
from dampyr.models.codegen.syntax_trees import statements_of
from dampyr.structures.batch import bouc_wen_branchless, branchless_math
from dampyr.structures.batch.lane_inverse import command_of
from dampyr.structures.time_history.kernel_math import quadratic

FAST = {"contract", "nsz", "arcp", "nnan", "ninf"}
MATH = ("sqrt", "log", "log1p", "expm1", "sin", "cos", "tan", "atan")
# Numbers that generated code names, so that each has the precision of the run.
CONSTANTS = {"zero": 0.0, "one": 1.0, "two": 2.0, "four": 4.0, "half": 0.5, "quarter": 0.25}


@lru_cache(maxsize=64)
def compiled(
    source: str,
    compositions: tuple[Composition, ...],
    precision: int,
    branchless: bool = False,
    more: str = "",
    searches: tuple[tuple[str, Composition], ...] = (),
) -> Any:
    """The kernel of a text, cached on disk; ``branchless`` takes the branch-free Bouc-Wen state, ``more`` are functions.

    ``searches`` are the names of `dampyr.structures.batch.lane_inverse.command_of` in the text, and the damper of each."""
    text = functions_of(compositions) + (f"\n\n{more}" if more else "")
    text += "\n\n" + bouc_wen_branchless.source() if branchless else ""
    names = _parts(text, precision)
    names |= {name: bind(command_of, (composition,), keep=False) for name, composition in searches}
    exec(compile(source, "<block>", "exec"), names)
    key = hashlib.sha256(f"{source}{text}{precision}".encode()).hexdigest()[:16]
    return jit(named(names["integrate_block"], __name__, key), keep=True, flags=FAST)


def functions_of(compositions: tuple[Composition, ...]) -> str:
    """The text of the functions that a kernel of these dampers calls."""
    text = text_of(compositions) if compositions else ""
    delayed = any(composition.has_delay for composition in compositions)
    return f"{text}\n\n{read(quadratic, 'quadratic').source}" if delayed else text


def _parts(text: str, precision: int) -> dict[str, Any]:
    """The formulas of the parts, for numba to write into the kernel, and the numbers of the step, in one precision."""
    kind = np.float64 if precision == 64 else np.float32
    tree, numbers = statements_of(text), Numbers()
    numbers.visit(tree)
    names: dict[str, Any] = {name: getattr(math, name) for name in MATH}
    names |= (
        {"floor": math.floor, "real": kind}
        | branchless_math.functions(precision)
        | {name: kind(value) for name, value in numbers.exists.items()}
    )
    exec(compile(ast.fix_missing_locations(tree), "<parts>", "exec"), names)
    key = hashlib.sha256(f"{text}{precision}".encode()).hexdigest()[:16]
    for name, value in list(names.items()):
        if isinstance(value, FunctionType):
            names[name] = jit(named(value, __name__, key), flags=FAST, inline=_straight(tree, name))
    return (
        names
        | {name: kind(value) for name, value in CONSTANTS.items()}
        | {"tiny": branchless_math.constants(precision)["tiny"]}
    )


def _straight(tree: ast.Module, name: str) -> bool:
    """Whether a formula runs straight through, so that inlining it lets the compiler take eight histories at a time."""
    function = next(node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == name)
    return not any(isinstance(node, ast.For | ast.While) for node in ast.walk(function)) and len(function.body) < 12


class Numbers(ast.NodeTransformer):
    """Names in the place of numbers, so that their precision can be chosen."""

    def __init__(self) -> None:
        self.exists: dict[str, float] = {}

    def visit_Subscript(self, node: ast.Subscript) -> ast.Subscript:
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        if not isinstance(node.value, float):
            return node
        name = f"number_{len(self.exists)}"
        self.exists[name] = node.value
        return ast.Name(name, ast.Load())
