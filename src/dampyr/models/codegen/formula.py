"""A model's formulas as data: read once, differentiated exactly, written out for any machine.

A part of a damper is a few lines of plain scalar Python (`parts/dahl.py` shows the form). This module reads these
lines as a syntax tree, so that the same text serves as the kernel (numba), its exact forward derivatives
(tangents), and the exports (C). The language is small on purpose: assignments, ``if``, ``return``, arithmetic,
the functions in ``DERIVATIVES`` and *intrinsics*, which are functions that come with their own partial derivatives.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from dampyr.models.codegen.syntax_trees import expression_of, statements_of

#: d f(a) / da for the functions of one argument, in terms of ``a``
DERIVATIVES = {
    "exp": "exp({a})",
    "log": "1.0/({a})",
    "sqrt": "0.5/sqrt({a})",
    "tanh": "(1.0 - tanh({a})**2)",
    "sin": "cos({a})",
    "cos": "(-sin({a}))",
    "atan": "1.0/(1.0 + ({a})**2)",
    "abs": "copysign(1.0, {a})",
}

_PARTIALS: dict[Callable[..., float], tuple[Callable[..., float], ...]] = {}


def intrinsic(*partials: Callable[..., float]) -> Callable[[Callable[..., float]], Callable[..., float]]:
    """Mark a function as an intrinsic with one partial derivative per argument, in their order.

    A partial takes the value of the function and then its arguments. Without partials it counts as constant
    in derivatives (an iteration whose last step the formula writes out).
    """

    def mark(function: Callable[..., float]) -> Callable[..., float]:
        _PARTIALS[function] = partials
        return function

    return mark


@dataclass(frozen=True)
class Formula:
    """One function of a part: its name, the names of its arguments, its tree and what it calls."""

    name: str
    arguments: tuple[str, ...]
    tree: ast.FunctionDef
    namespace: dict[str, Any]

    @property
    def source(self) -> str:
        """Python text."""
        return ast.unparse(self.tree)

    def intrinsics(self) -> dict[str, Callable[..., float]]:
        """The plain functions that this one calls, by name, with all that these call in turn."""
        functions: dict[str, Callable[..., float]] = {}
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                function = self.namespace.get(node.func.id)
                if inspect.isfunction(function) and node.func.id not in functions:
                    functions.update(read(function, node.func.id).intrinsics())
                    functions[node.func.id] = function
        return functions


@lru_cache(maxsize=512)
def read(function: Callable[..., Any], name: str) -> Formula:
    """The formula of a plain function, under a new name and without hints and docstring."""
    tree = statements_of(textwrap.dedent(inspect.getsource(function))).body[0]
    assert isinstance(tree, ast.FunctionDef)
    if ast.get_docstring(tree):
        tree.body = tree.body[1:]
    tree.name, tree.returns, tree.decorator_list = name, None, []
    for argument in tree.args.args:
        argument.annotation = None
    namespace = function.__globals__
    tree = _Constants(namespace).visit(tree)
    return Formula(name, tuple(a.arg for a in tree.args.args), ast.fix_missing_locations(tree), namespace)


class _Constants(ast.NodeTransformer):
    """Write the module's numeric constants in place, so that the text is self-contained."""

    def __init__(self, namespace: dict[str, Any]) -> None:
        self.namespace = namespace

    def visit_Name(self, node: ast.Name) -> ast.expr:
        value = self.namespace.get(node.id)
        if isinstance(node.ctx, ast.Load) and isinstance(value, int | float) and not isinstance(value, bool):
            return ast.Constant(value)
        return node


def multiplied(formula: Formula, factor: Formula, name: str, prefix: str) -> Formula:
    """``formula`` times ``factor``, which is one expression; its parameters get a ``prefix``, to differ from the formula's."""
    arguments = {a: a if a == "v" else prefix + a for a in factor.arguments}
    (only,) = factor.tree.body
    assert isinstance(only, ast.Return)
    assert only.value is not None
    by = ast.unparse(_Renamed(arguments).visit(expression_of(ast.unparse(only.value))))
    tree = _Multiplied(by).visit(statements_of(formula.source).body[0])
    names = tuple(dict.fromkeys((*formula.arguments, *arguments.values())))
    tree.name, tree.args.args = name, [ast.arg(a) for a in names]
    return Formula(name, names, ast.fix_missing_locations(tree), {**factor.namespace, **formula.namespace})


class InPlace(ast.NodeTransformer):
    """Writes each name as the expression that stands for it."""

    def __init__(self, places: dict[str, str]) -> None:
        self.places = places

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return expression_of(self.places.get(node.id, node.id)).body


class _Renamed(ast.NodeTransformer):
    def __init__(self, names: dict[str, str]) -> None:
        self.names = names

    def visit_Name(self, node: ast.Name) -> ast.Name:
        return ast.Name(self.names.get(node.id, node.id), node.ctx)


class _Multiplied(ast.NodeTransformer):
    def __init__(self, by: str) -> None:
        self.by = by

    def visit_Return(self, node: ast.Return) -> ast.stmt:
        assert node.value is not None
        return statements_of(f"return ({self.by})*({ast.unparse(node.value)})").body[0]


def tangent(formula: Formula, name: str, active: Iterable[str], unit: str | None = None) -> str:
    """Python text of the forward derivative of ``formula`` in one direction.

    The function takes the arguments of the formula and then a tangent ``d0_a`` for each ``a`` of ``active``; the
    argument called ``unit`` has the tangent 1. It returns the tangent of what the formula returns.
    """
    return _function(formula, name, tuple(active), [unit], values=False)


def tangents(formula: Formula, name: str, active: Iterable[str], units: Iterable[str | None]) -> str:
    """Python text of ``formula`` with its derivatives in several directions, one for each of ``units``.

    After the arguments of the formula come the tangents of ``active`` for the first direction, then for the second, and so
    on. It returns one flat tuple: what the formula returns, then the tangents of it, direction by direction. What the
    directions have in common is computed once.
    """
    return _function(formula, name, tuple(active), list(units), values=True)


def _function(formula: Formula, name: str, active: tuple[str, ...], units: list[str | None], values: bool) -> str:
    seeds = []
    for k, unit in enumerate(units):
        seeds.append({a: f"d{k}_{a}" for a in active} | ({unit: "1.0"} if unit is not None else {}))
    body, _ = _Tangent(formula.namespace, values).block(formula.tree.body, seeds)
    incoming = [f"d{k}_{a}" for k in range(len(units)) for a in active]
    arguments = ", ".join((*formula.arguments, *incoming))
    return f"def {name}({arguments}):\n" + textwrap.indent("\n".join(body), "    ")


Seeds = dict[str, str]


class _Tangent:
    """Writes a block of statements with their tangents; a name without an entry in ``seeds`` has tangent zero."""

    def __init__(self, namespace: dict[str, Any], values: bool) -> None:
        self.namespace = namespace
        self.values = values
        self.computed: dict[str, str] = {}

    def block(self, statements: list[ast.stmt], seeds: list[Seeds]) -> tuple[list[str], list[Seeds]]:
        lines: list[str] = []
        for statement in statements:
            if isinstance(statement, ast.Return):
                assert statement.value is not None
                lines += self._return(statement.value, seeds)
            elif isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name):
                lines += self._assign(statement.targets[0].id, statement.value, seeds)
            elif isinstance(statement, ast.If):
                lines += self._branch(statement, seeds)
            else:
                raise TypeError(f"a formula cannot contain: {ast.unparse(statement)}")
        return lines, seeds

    def _return(self, value: ast.expr, seeds: list[Seeds]) -> list[str]:
        parts = value.elts if isinstance(value, ast.Tuple) else [value]
        out = [self.of(e, direction) or "0.0" for direction in seeds for e in parts]
        if self.values:
            out = [*(self._plain(e) for e in parts), *out]
        text = f"({', '.join(out)})" if len(out) > 1 else out[0]
        return [*self._shared(), f"return {text}"]

    def _assign(self, target: str, value: ast.expr, seeds: list[Seeds]) -> list[str]:
        derivatives = [self.of(value, direction) for direction in seeds]
        plain = self._plain(value)
        lines = self._shared()
        for k, (direction, derivative) in enumerate(zip(seeds, derivatives, strict=True)):
            direction.pop(target, None)
            if derivative:
                lines.append(f"d{k}_{target} = {derivative}")
                direction[target] = f"d{k}_{target}"
        return [*lines, f"{target} = {plain}"]

    def _branch(self, statement: ast.If, seeds: list[Seeds]) -> list[str]:
        sides = [
            self.block(side, [dict(direction) for direction in seeds]) for side in (statement.body, statement.orelse)
        ]
        for k, direction in enumerate(seeds):
            for name in sorted(set(sides[0][1][k]) | set(sides[1][1][k])):
                ends = [side[1][k].get(name) for side in sides]
                if ends[0] == ends[1]:
                    direction[name] = ends[0] or "0.0"
                    continue
                direction[name] = f"d{k}_{name}"
                for (lines, _), end in zip(sides, ends, strict=True):
                    if end != direction[name]:
                        lines.append(f"{direction[name]} = {end or '0.0'}")
        text = [f"if {ast.unparse(statement.test)}:", *("    " + line for line in sides[0][0] or ["pass"])]
        if sides[1][0]:
            text += ["else:", *("    " + line for line in sides[1][0])]
        return text

    def _plain(self, value: ast.expr) -> str:
        """The expression itself, with what the derivatives have computed already."""
        text = ast.unparse(value)
        for call, name in self.computed.items():
            text = text.replace(call, name)
        return text

    def _shared(self) -> list[str]:
        """What the next line needs of the intrinsics: their values and partial derivatives, each computed once."""
        lines = [f"{name} = {text}" for text, name in self.computed.items()]
        self.computed = {}
        return lines

    def _once(self, text: str) -> str:
        return self.computed.setdefault(text, f"shared{len(self.computed)}")

    def of(self, node: ast.expr, seeds: dict[str, str]) -> str | None:
        """The tangent of an expression as text, or None where it is zero."""
        if isinstance(node, ast.Constant):
            return None
        if isinstance(node, ast.Name):
            return seeds.get(node.id)
        if isinstance(node, ast.UnaryOp):
            inner = self.of(node.operand, seeds)
            return inner and f"(-{inner})" if isinstance(node.op, ast.USub) else inner
        if isinstance(node, ast.BinOp):
            return self._binary(node, seeds)
        if isinstance(node, ast.Call):
            return self._call(node, seeds)
        raise TypeError(f"a formula cannot contain: {ast.unparse(node)}")

    def _binary(self, node: ast.BinOp, seeds: dict[str, str]) -> str | None:
        a, b = ast.unparse(node.left), ast.unparse(node.right)
        da, db = self.of(node.left, seeds), self.of(node.right, seeds)
        if da is None and db is None:
            return None
        if isinstance(node.op, ast.Add | ast.Sub):
            sign = "+" if isinstance(node.op, ast.Add) else "-"
            if db is None:
                return da
            return f"({da} {sign} {db})" if da else (db if sign == "+" else f"(-{db})")
        if isinstance(node.op, ast.Mult):
            return _sum(da and f"{da}*({b})", db and f"({a})*{db}")
        if isinstance(node.op, ast.Div):
            return _sum(da and f"{da}/({b})", db and f"(-(({a})/({b}))/({b})*{db})")
        if isinstance(node.op, ast.Pow) and db is None:
            return f"({b})*({a})**(({b}) - 1.0)*{da}"
        raise TypeError(f"a formula cannot contain: {ast.unparse(node)}")

    def _call(self, node: ast.Call, seeds: dict[str, str]) -> str | None:
        assert isinstance(node.func, ast.Name)
        name, texts = node.func.id, [ast.unparse(a) for a in node.args]
        tangents = [self.of(a, seeds) for a in node.args]
        if name == "copysign":
            return tangents[0] and f"copysign(1.0, {texts[1]})*copysign(1.0, {texts[0]})*{tangents[0]}"
        if name in DERIVATIVES:
            return tangents[0] and f"{DERIVATIVES[name].format(a=texts[0])}*{tangents[0]}"
        partials = _PARTIALS[self.namespace[name]]
        if not any(tangents) or not partials:
            return None
        value = self._once(ast.unparse(node))
        arguments = ", ".join([value, *texts])
        terms = [
            f"{self._once(f'{partial.__name__}({arguments})')}*{t}"
            for partial, t in zip(partials, tangents, strict=True)
            if t
        ]
        return f"({' + '.join(terms)})"


def _sum(a: str | None, b: str | None) -> str | None:
    if a and b:
        return f"({a} + {b})"
    return (a and f"({a})") or (b and f"({b})")


def partials_of(formula: Formula) -> dict[str, Callable[..., float]]:
    """The partial derivatives of the intrinsics that a formula calls, by name."""
    partials: dict[str, Callable[..., float]] = {}
    for function in formula.intrinsics().values():
        for partial in _PARTIALS.get(function, ()):
            partials[partial.__name__] = partial
    return partials
