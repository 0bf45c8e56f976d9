"""MATLAB text of the functions of a damper: the syntax trees that the kernels compile, for MATLAB and GNU Octave."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from copy import deepcopy

from dampyr.export.c_text import DOUBLE, CWriter, Flat, assigned_names, read_names, stores_to

OPERATORS: dict[type[ast.AST], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.USub: "-", ast.UAdd: "+",
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "~=",
    ast.And: "&&", ast.Or: "||",
}  # fmt: skip
KEYWORDS = {"break", "case", "catch", "continue", "else", "elseif", "end", "for", "function", "global", "if", "otherwise",
            "parfor", "persistent", "return", "spmd", "switch", "try", "while"}  # fmt: skip
CHOOSE, COPYSIGN = "choose", "copysign"
SUPPORT = f"""\
function r = {{prefix}}{CHOOSE}(condition, a, b)
    if condition, r = a; else, r = b; end
end

function r = {{prefix}}{COPYSIGN}(a, b)
    r = abs(a);
    if b < 0 || (b == 0 && 1/b < 0), r = -r; end
end
"""


def number(value: float) -> str:
    """A number with all its digits."""
    return repr(float(value)) if value >= 0 else f"({float(value)!r})"


def function(tree: ast.FunctionDef, prefix: str, defined: set[str], arrays: Iterable[str] = ()) -> str:
    """One function; calls to the names in ``own`` are prefixed. An array that it writes to is returned first."""
    tree = Flat().visit(deepcopy(tree))
    written = [name for name in arrays if stores_to(tree, name) or (tree.name, name) == ("advance", "s")]
    values = [n.value for n in ast.walk(tree) if isinstance(n, ast.Return) and n.value is not None]
    count = max((len(v.elts) if isinstance(v, ast.Tuple) else 1 for v in values), default=0)
    results = written or [f"result_{k}" for k in range(count)]
    writer = MatlabWriter(prefix, defined, read_names(tree) | set(written), results)
    names = [a.arg for a in tree.args.args]
    unused = [name for name in names if name not in writer.read]
    head = f"function [{', '.join(results)}] = {prefix}{tree.name}({', '.join(map(writer.variable, names))})"
    note = f" %#ok<INUSD> {' '.join(map(writer.variable, unused))}" if unused else ""
    assert assigned_names(tree).isdisjoint(results), "a result has the name of a variable"
    return "\n".join([head + note, *writer.block(tree.body, 1), "end"])


class MatlabWriter(CWriter):
    """Writes statements and expressions of MATLAB; ``results`` are the names of what the function returns."""

    def __init__(self, prefix: str, defined: set[str], read: set[str], results: list[str]) -> None:
        super().__init__(prefix, defined, read, DOUBLE)
        self.results = results

    def statement(self, node: ast.stmt, depth: int) -> list[str]:
        """One statement as lines."""
        pad = "    " * depth
        if isinstance(node, ast.If):
            lines = [f"{pad}if {self.of(node.test)}", *self.block(node.body, depth + 1)]
            if node.orelse:
                lines += [f"{pad}else", *self.block(node.orelse, depth + 1)]
            return [*lines, f"{pad}end"]
        if isinstance(node, ast.For) and isinstance(node.target, ast.Name) and isinstance(node.iter, ast.Call):
            *start, stop = (self.of(argument) for argument in node.iter.args)
            counter = self.variable(node.target.id)
            return [
                f"{pad}for {counter} = {start[0] if start else 0}:({stop} - 1)",
                *self.block(node.body, depth + 1),
                f"{pad}end",
            ]
        return super().statement(node, depth)

    def assigned(self, target: ast.expr, value: ast.expr) -> list[str]:
        """The line of an assignment, also of several targets."""
        if isinstance(target, ast.Tuple):
            return [f"[{', '.join(self.of(each) for each in target.elts)}] = {self.of(value)};"]
        return super().assigned(target, value)

    def returned(self, value: ast.expr | None) -> list[str]:
        """The lines of a return."""
        if value is None:
            return ["return;"]
        values = value.elts if isinstance(value, ast.Tuple) else [value]
        return [*(f"{name} = {self.of(e)};" for name, e in zip(self.results, values, strict=True)), "return;"]

    def literal(self, value: object) -> str:
        """A number."""
        assert isinstance(value, int | float)
        return str(value) if isinstance(value, int) else number(value)

    def variable(self, name: str) -> str:
        """A variable; MATLAB's names begin with a letter and are no keywords."""
        return (f"{name}_" if name in KEYWORDS else name) if name[0].isalpha() else f"n{name}"

    def power(self, base: ast.expr, exponent: ast.expr) -> str:
        """A power."""
        return f"({self.of(base)}^{self.of(exponent)})"

    def of(self, node: ast.expr) -> str:
        """An expression."""
        if isinstance(node, ast.Subscript):
            index = node.slice
            shown = str(index.value + 1) if isinstance(index, ast.Constant) else f"{self.of(index)} + 1"  # type: ignore[operator]
            return f"{self.of(node.value)}({shown})"
        if isinstance(node, ast.IfExp):
            return f"{self.prefix}{CHOOSE}({self.of(node.test)}, {self.of(node.body)}, {self.of(node.orelse)})"
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            return f"({self.of(node.left)} {OPERATORS[type(node.ops[0])]} {self.of(node.comparators[0])})"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            name = node.func.id
            own = name in self.defined or name == COPYSIGN
            return f"{self.prefix if own else ''}{name}({', '.join(map(self.of, node.args))})"
        return super().of(node)
