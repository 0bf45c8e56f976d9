"""C text of the functions of a damper: the syntax trees that the kernels compile, written out in C99."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from copy import deepcopy
from dataclasses import dataclass

LIBM = ("exp", "expm1", "log", "log1p", "sqrt", "tanh", "sin", "cos", "atan", "pow")
"""The functions that need the mathematics library; fabs, copysign and isfinite are the compiler's own."""
COMPOSED = ("expm1", "log1p")
"""Those that avr-libc lacks: in single precision they are composed of exp and log."""
COARSEST = 3e-7  # five times the spacing of single precision near 1: a finer tolerance would never be met
OPERATORS: dict[type[ast.AST], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.USub: "-", ast.UAdd: "+",
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
    ast.And: "&&", ast.Or: "||",
}  # fmt: skip


@dataclass(frozen=True)
class Precision:
    """How C writes its numbers: ``real`` is their type, ``suffix`` that of literals and of the functions of math.h."""

    real: str = "double"
    suffix: str = ""

    def number(self, value: float) -> str:
        """A literal with all its digits."""
        text = f"{float(value)!r}{self.suffix}"
        return text if value >= 0 else f"({text})"


DOUBLE, SINGLE = Precision(), Precision("float", "f")


def function(
    tree: ast.FunctionDef, prefix: str, defined: set[str], arrays: Iterable[str] = (), precision: Precision = DOUBLE
) -> str:
    """One static C function; calls to the names in ``own`` are prefixed, arguments named in ``arrays`` are arrays.

    A tuple is returned through a further argument, ``out``. In single precision a tolerance of a comparison is at least
    `COARSEST`. ``abs``, ``min`` and ``max`` of Python become fabs, ``{prefix}min`` and ``{prefix}max``.
    """
    tree = Flat().visit(deepcopy(tree))
    real = precision.real
    writer = CWriter(prefix, defined, read_names(tree), precision)
    body = writer.block(tree.body, 1)
    values = [n.value for n in ast.walk(tree) if isinstance(n, ast.Return) and n.value is not None]
    several = any(isinstance(value, ast.Tuple) for value in values)
    names = [a.arg for a in tree.args.args]
    written = {name for name in arrays if stores_to(tree, name)}
    kinds = {name: f"{real} *" if name in written else f"const {real} *" for name in arrays}
    arguments = [f"{kinds.get(name, f'{real} ')}{name}" for name in names]
    head = f"static {real if values and not several else 'void'} {prefix}{tree.name}"
    lines = [f"{head}({', '.join([*arguments, *([f'{real} *out'] if several else [])])})", "{"]
    if local := sorted(assigned_names(tree) & writer.read - set(names) - writer.counters):
        lines.append(f"    {real} {', '.join(local)};")
    if unused := [name for name in names if name not in writer.read | written]:
        lines.append("    " + " ".join(f"(void){name};" for name in unused))
    return "\n".join([*lines, *body, "}"])


def extremes(text: str, prefix: str, precision: Precision) -> list[str]:
    """The functions ``{prefix}min`` and ``{prefix}max``, of which ``text`` calls."""
    real = precision.real
    return [
        f"static {real} {prefix}{which}({real} a, {real} b)\n{{\n    return a {sign} b ? a : b;\n}}"
        for which, sign in (("min", "<"), ("max", ">"))
        if f"{prefix}{which}(" in text
    ]


def assigned_names(tree: ast.AST) -> set[str]:
    """The names that a function assigns to."""
    return {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}


def stores_to(tree: ast.AST, array: str) -> bool:
    """Whether a function writes to the elements of an array."""
    nodes = (n.value for n in ast.walk(tree) if isinstance(n, ast.Subscript) and isinstance(n.ctx, ast.Store))
    return any(isinstance(n, ast.Name) and n.id == array for n in nodes)


def read_names(tree: ast.FunctionDef) -> set[str]:
    """The names whose values a function uses; an assignment to any other name is left out of the C."""
    read: set[str] = set()
    while True:
        loads = (n for use in _uses(tree, read) for n in ast.walk(use))
        names = {n.id for n in loads if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
        if names == read:
            return read
        read = names


def _uses(tree: ast.FunctionDef, read: set[str]) -> Iterator[ast.AST]:
    """What the statements evaluate, less assignments to names that are not in ``read``."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            target = node.targets[0]
            yield from () if isinstance(target, ast.Name) and target.id not in read else (target, node.value)
        elif isinstance(node, ast.If):
            yield node.test
        elif isinstance(node, ast.For):
            yield node.iter
        elif isinstance(node, ast.Return) and node.value is not None:
            yield node.value


class Flat(ast.NodeTransformer):
    """Turns ``a, b = c, d`` into two assignments."""

    def visit_Assign(self, node: ast.Assign) -> ast.Assign | list[ast.Assign]:
        target, value = node.targets[0], node.value
        if not (isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple)):
            return node
        pairs = list(zip(target.elts, value.elts, strict=True))
        for k, (_, later) in enumerate(pairs):
            needed = {ast.unparse(n) for n in ast.walk(later)}
            if any(ast.unparse(earlier) in needed for earlier, _ in pairs[:k]):
                raise TypeError(f"no C form for: {ast.unparse(node)}")
        return [ast.Assign([target], expression) for target, expression in pairs]


class CWriter:
    """Writes statements and expressions."""

    def __init__(self, prefix: str, defined: set[str], read: set[str], precision: Precision) -> None:
        self.prefix, self.defined, self.read, self.precision = prefix, defined, read, precision
        self.counters: set[str] = set()
        self.compared = False

    def block(self, statements: list[ast.stmt], depth: int) -> list[str]:
        """Indented lines."""
        return [line for statement in statements for line in self.statement(statement, depth)]

    def statement(self, node: ast.stmt, depth: int) -> list[str]:
        """One statement as lines."""
        pad = "    " * depth
        if isinstance(node, ast.Assign):
            return [pad + line for line in self.assigned(node.targets[0], node.value)]
        if isinstance(node, ast.Return):
            return [pad + line for line in self.returned(node.value)]
        if isinstance(node, ast.If):
            lines = [f"{pad}if ({self.of(node.test)}) {{", *self.block(node.body, depth + 1)]
            if node.orelse:
                lines += [f"{pad}}} else {{", *self.block(node.orelse, depth + 1)]
            return [*lines, f"{pad}}}"]
        if isinstance(node, ast.For) and isinstance(node.target, ast.Name) and isinstance(node.iter, ast.Call):
            k, (*start, stop) = node.target.id, (self.of(argument) for argument in node.iter.args)
            self.counters.add(k)
            head = f"{pad}for (int {k} = {start[0] if start else 0}; {k} < {stop}; {k}++) {{"
            return [head, *self.block(node.body, depth + 1), f"{pad}}}"]
        if isinstance(node, ast.Break):
            return [f"{pad}break;"]
        raise TypeError(f"no C form for: {ast.unparse(node)}")

    def assigned(self, target: ast.expr, value: ast.expr) -> list[str]:
        """The lines of an assignment; several targets take what a function of a part returns through ``out``."""
        if isinstance(target, ast.Tuple):
            call = self.of(value).removesuffix(")")
            results = [f"{self.of(each)} = out[{k}];" for k, each in enumerate(target.elts)]
            return [f"{{ {self.precision.real} out[{len(results)}]; {call}, out); {' '.join(results)} }}"]
        if isinstance(target, ast.Name) and target.id not in self.read:
            return []
        return [f"{self.of(target)} = {self.of(value)};"]

    def returned(self, value: ast.expr | None) -> list[str]:
        """The lines of a return."""
        if value is None:
            return ["return;"]
        if isinstance(value, ast.Tuple):
            return [*(f"out[{k}] = {self.of(e)};" for k, e in enumerate(value.elts)), "return;"]
        return [f"return {self.of(value)};"]

    def literal(self, value: object) -> str:
        """A number; in single precision no tolerance of a comparison is below `COARSEST`."""
        assert isinstance(value, int | float)
        if isinstance(value, int):
            return str(value)
        tolerance = self.compared and self.precision == SINGLE and value > 0.0
        return self.precision.number(max(value, COARSEST) if tolerance else value)

    def variable(self, name: str) -> str:
        """A variable; a counter as a real number."""
        return f"({self.precision.real}){name}" if name in self.counters else name

    def power(self, base: ast.expr, exponent: ast.expr) -> str:
        """A power; a square or a cube of a name as a product."""
        value = exponent.value if isinstance(exponent, ast.Constant) else None
        if isinstance(value, int | float) and value in (2, 3) and isinstance(base, ast.Name):
            return "(" + "*".join([self.of(base)] * int(value)) + ")"
        return f"pow{self.precision.suffix}({self.of(base)}, {self.of(exponent)})"

    def of(self, node: ast.expr) -> str:
        """An expression."""
        if isinstance(node, ast.Constant):
            return self.literal(node.value)
        if isinstance(node, ast.Name):
            return self.variable(node.id)
        if isinstance(node, ast.Subscript):
            index = node.slice.id if isinstance(node.slice, ast.Name) else self.of(node.slice)
            return f"{self.of(node.value)}[{index}]"
        if isinstance(node, ast.IfExp):
            return f"({self.of(node.test)} ? {self.of(node.body)} : {self.of(node.orelse)})"
        if isinstance(node, ast.UnaryOp):
            return f"({OPERATORS[type(node.op)]}{self.of(node.operand)})"
        if isinstance(node, ast.BinOp):
            if isinstance(node.op, ast.Pow):
                return self.power(node.left, node.right)
            return f"({self.of(node.left)} {OPERATORS[type(node.op)]} {self.of(node.right)})"
        if isinstance(node, ast.BoolOp):
            return "(" + f" {OPERATORS[type(node.op)]} ".join(map(self.of, node.values)) + ")"
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            outer, self.compared = self.compared, True
            sides = self.of(node.left), self.of(node.comparators[0])
            self.compared = outer
            return f"({sides[0]} {OPERATORS[type(node.ops[0])]} {sides[1]})"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            name = node.func.id
            arguments = ", ".join(map(self.of, node.args))
            if name in self.defined or name in ("min", "max") or (name in COMPOSED and self.precision == SINGLE):
                return f"{self.prefix}{name}({arguments})"
            return f"{'fabs' if name == 'abs' else name}{self.precision.suffix}({arguments})"
        raise TypeError(f"no C form for: {ast.unparse(node)}")
