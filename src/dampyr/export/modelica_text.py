"""Modelica text of the formulas of a damper: equations where a formula has no branch, functions where it has.

A line ``h = ...`` of a formula becomes a variable of the model with its equation, and what is returned an expression over
these, so that the model reads as the equations of the part's page.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field

from dampyr.export.c_text import DOUBLE, CWriter, Flat, assigned_names, read_names
from dampyr.models.codegen.formula import Formula, InPlace, read

OPERATORS: dict[type[ast.AST], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.USub: "-", ast.UAdd: "+",
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "<>",
    ast.And: "and", ast.Or: "or",
}  # fmt: skip
BINDS: dict[type[ast.AST], int] = {ast.Add: 1, ast.Sub: 1, ast.Mult: 2, ast.Div: 2, ast.Pow: 3}
KEYWORDS = {
    "algorithm", "and", "annotation", "assert", "block", "break", "class", "connect", "connector", "constant",
    "constrainedby", "der", "discrete", "each", "else", "elseif", "elsewhen", "encapsulated", "end", "enumeration",
    "equation", "expandable", "extends", "external", "false", "final", "flow", "for", "function", "if", "import",
    "impure", "in", "initial", "inner", "input", "loop", "model", "not", "operator", "or", "outer", "output",
    "package", "parameter", "partial", "protected", "public", "pure", "record", "redeclare", "replaceable", "return",
    "stream", "then", "true", "type", "when", "while", "within", "Real", "Integer", "Boolean", "String", "time",
}  # fmt: skip
UNITS = {
    "": "1", "m": "m", "m/s": "m/s", "N": "N", "V": "V", "A": "A", "s": "s", "kg": "kg", "1/m": "1/m", "1/s": "1/s",
    "N/m": "N/m", "N s/m": "N.s/m", "m/N": "m/N", "N s/m^3": "N.s/m3", "m/s^2": "m/s2",
}  # fmt: skip


def number(value: float) -> str:
    """A number with all its digits."""
    text = repr(float(value))
    return text if value >= 0 else f"({text})"


@dataclass
class Equations:
    """What formulas have become: the functions that they need, the variables that they define, and their equations."""

    functions: dict[str, str] = field(default_factory=dict)
    variables: dict[str, str] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)

    def value_of(self, formula: Formula, places: Mapping[str, str]) -> list[str]:
        """The expressions of what a formula returns, with its arguments in their ``places``; adds what they need."""
        for name, called in formula.intrinsics().items():
            self.functions.setdefault(name, modelica_function(read(called, name).tree))
        tree = Flat().visit(deepcopy(formula.tree))
        if not _is_straight(tree):
            return self._by_function(formula, tree, places)
        own = {name: f"{formula.name}_{name}" for name in assigned_names(tree)}
        everywhere = dict(places) | own
        *assignments, last = tree.body
        for statement in assignments:
            target = statement.targets[0].id
            self.variables[own[target]] = f"in the equations of {formula.name.replace('_', ' ')}"
            self.lines.append(f"{own[target]} = {expression(statement.value, everywhere)};")
        values = last.value.elts if isinstance(last.value, ast.Tuple) else [last.value]
        return [expression(value, everywhere) for value in values]

    def _by_function(self, formula: Formula, tree: ast.FunctionDef, places: Mapping[str, str]) -> list[str]:
        self.functions[formula.name] = modelica_function(tree)
        call = f"{formula.name}({', '.join(places.get(name, name) for name in formula.arguments)})"
        count = _count_results(tree)
        if count == 1:
            return [call]
        names = [f"{formula.name}_{k + 1}" for k in range(count)]
        self.variables |= dict.fromkeys(names, f"what {formula.name} returns")
        self.lines.append(f"({', '.join(names)}) = {call};")
        return names


def expression(node: ast.expr, places: Mapping[str, str]) -> str:
    """One expression of a formula, with its names in their ``places``."""
    placed = InPlace(dict(places)).visit(deepcopy(node))
    return ModelicaWriter().of(placed)


def modelica_function(tree: ast.FunctionDef) -> str:
    """A function of a formula's tree; what it returns has the names ``result_1``, ..."""
    tree = Flat().visit(deepcopy(tree))
    tree.body = _with_one_end(tree.body)
    results = [f"result_{k + 1}" for k in range(_count_results(tree))]
    inputs = [f"    input Real {argument.arg};" for argument in tree.args.args]
    local = sorted((assigned_names(tree) & read_names(tree)) - {argument.arg for argument in tree.args.args})
    writer = ModelicaWriter(results)
    return "\n".join(
        [
            f"  function {tree.name}",
            *inputs,
            *(f"    output Real {name};" for name in results),
            *(["  protected", *(f"    Real {name};" for name in local)] if local else []),
            "  algorithm",
            *writer.block(tree.body, 2),
            f"  end {tree.name};",
        ]
    )


def _is_straight(tree: ast.FunctionDef) -> bool:
    """Whether a function is assignments to new names, each once, and then one return."""
    *assignments, last = tree.body
    targets = [each.targets[0].id for each in assignments if isinstance(each, ast.Assign) and _is_name(each.targets[0])]  # type: ignore[attr-defined]
    new = set(targets) - {argument.arg for argument in tree.args.args}
    return isinstance(last, ast.Return) and len(targets) == len(assignments) == len(new)


def _with_one_end(body: list[ast.stmt]) -> list[ast.stmt]:
    """The statements with what follows a branch that returns in its other branch, so that nothing follows a return."""
    for k, statement in enumerate(body):
        if isinstance(statement, ast.If) and any(isinstance(each, ast.Return) for each in ast.walk(statement)):
            if not isinstance(statement.body[-1], ast.Return | ast.If):
                raise TypeError(f"no Modelica form for: {ast.unparse(statement)}")
            rest = [*statement.orelse, *body[k + 1 :]]
            return [*body[:k], ast.If(statement.test, _with_one_end(statement.body), _with_one_end(rest))]
    return body


def _is_name(node: ast.expr) -> bool:
    return isinstance(node, ast.Name)


def _count_results(tree: ast.FunctionDef) -> int:
    values = [n.value for n in ast.walk(tree) if isinstance(n, ast.Return)]
    return max(len(value.elts) if isinstance(value, ast.Tuple) else 1 for value in values)


class ModelicaWriter(CWriter):
    """Writes statements and expressions of Modelica; ``results`` are the names of what a function returns."""

    def __init__(self, results: list[str] | None = None) -> None:
        super().__init__("", set(), set(), DOUBLE)
        self.results = results or []

    def statement(self, node: ast.stmt, depth: int) -> list[str]:
        """One statement as lines."""
        pad = "  " * depth
        if isinstance(node, ast.If):
            lines = [f"{pad}if {self.of(node.test)} then", *self.block(node.body, depth + 1)]
            if node.orelse:
                lines += [f"{pad}else", *self.block(node.orelse, depth + 1)]
            return [*lines, f"{pad}end if;"]
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            return [f"{pad}{node.targets[0].id} := {self.of(node.value)};"]
        if isinstance(node, ast.Return) and node.value is not None:
            values = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
            return [f"{pad}{name} := {self.of(value)};" for name, value in zip(self.results, values, strict=True)]
        raise TypeError(f"no Modelica form for: {ast.unparse(node)}")

    def literal(self, value: object) -> str:
        """A number."""
        assert isinstance(value, int | float)
        return number(value)

    def variable(self, name: str) -> str:
        """A variable."""
        return name

    def choice(self, test: str, yes: str, no: str) -> str:
        """One of two values; in an equation the solver is not to look for the time at which the choice changes."""
        text = f"if {test} then {yes} else {no}"
        return f"({text})" if self.results else f"noEvent({text})"

    def beside(self, node: ast.expr, at_least: int) -> str:
        """An operand, in brackets where it binds less than its operator; Modelica's order is that of Python."""
        text = self.of(node)
        binds = BINDS[type(node.op)] if isinstance(node, ast.BinOp) else 9
        return text if binds >= at_least else f"({text})"

    def of(self, node: ast.expr) -> str:
        """An expression."""
        if isinstance(node, ast.IfExp):
            return self.choice(*map(self.of, (node.test, node.body, node.orelse)))
        if isinstance(node, ast.UnaryOp):
            return f"({OPERATORS[type(node.op)]}{self.beside(node.operand, 2)})"
        if isinstance(node, ast.BinOp):
            binds, sign = BINDS[type(node.op)], "^" if isinstance(node.op, ast.Pow) else OPERATORS[type(node.op)]
            left = self.beside(node.left, binds + isinstance(node.op, ast.Pow))
            space = "" if binds > 1 else " "
            return f"{left}{space}{sign}{space}{self.beside(node.right, binds + 1)}"
        if isinstance(node, ast.BoolOp):
            return "(" + f" {OPERATORS[type(node.op)]} ".join(map(self.of, node.values)) + ")"
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            return f"{self.of(node.left)} {OPERATORS[type(node.ops[0])]} {self.of(node.comparators[0])}"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            arguments = [self.of(argument) for argument in node.args]
            if node.func.id == "copysign":
                size = arguments[0] if isinstance(node.args[0], ast.Constant) else f"abs({arguments[0]})"
                return self.choice(f"{arguments[1]} >= 0.0", size, f"-{size}")
            return f"{node.func.id}({', '.join(arguments)})"
        return super().of(node)
