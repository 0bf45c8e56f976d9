"""Formulas as C: the same trees that the kernels compile, written out in C99."""

from __future__ import annotations

import ast

from dampyr.models.codegen.formula import Formula

FUNCTIONS = {"abs": "fabs", "min": "fmin", "max": "fmax"}
OPERATORS: dict[type[ast.AST], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.USub: "-", ast.UAdd: "+",
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
    ast.And: "&&", ast.Or: "||",
}  # fmt: skip


def number(value: float) -> str:
    """A C double with all its digits."""
    text = repr(float(value))
    return text if value >= 0 else f"({text})"


def function(formula: Formula, prefix: str, own: set[str]) -> str:
    """One static C function; calls to the names in ``own`` are prefixed. A tuple is returned through ``out``."""
    writer = _Writer(prefix, own)
    body = writer.block(formula.tree.body, 1)
    several = any(isinstance(n, ast.Return) and isinstance(n.value, ast.Tuple) for n in ast.walk(formula.tree))
    arguments = ", ".join([*(f"double {a}" for a in formula.arguments), *(["double *out"] if several else [])])
    names = sorted(_assigned(formula.tree) - set(formula.arguments) - writer.counters)
    head = [f"static {'void' if several else 'double'} {prefix}{formula.name}({arguments})", "{"]
    if names:
        head.append(f"    double {', '.join(names)};")
    return "\n".join([*head, *body, "}"])


def _assigned(tree: ast.AST) -> set[str]:
    return {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}


class _Writer:
    """Writes statements and expressions."""

    def __init__(self, prefix: str, own: set[str]) -> None:
        self.prefix, self.own = prefix, own
        self.counters: set[str] = set()

    def block(self, statements: list[ast.stmt], depth: int) -> list[str]:
        """Indented lines."""
        return [line for statement in statements for line in self.statement(statement, depth)]

    def statement(self, node: ast.stmt, depth: int) -> list[str]:
        """One statement as lines."""
        pad = "    " * depth
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            return [f"{pad}{node.targets[0].id} = {self.of(node.value)};"]
        if isinstance(node, ast.Return) and node.value is not None:
            return [pad + line for line in self.returned(node.value)]
        if isinstance(node, ast.If):
            lines = [f"{pad}if ({self.of(node.test)}) {{", *self.block(node.body, depth + 1)]
            if node.orelse:
                lines += [f"{pad}}} else {{", *self.block(node.orelse, depth + 1)]
            return [*lines, f"{pad}}}"]
        if isinstance(node, ast.For) and isinstance(node.target, ast.Name) and isinstance(node.iter, ast.Call):
            k, stop = node.target.id, self.of(node.iter.args[0])
            self.counters.add(k)
            head = f"{pad}for (int {k} = 0; {k} < {stop}; {k}++) {{"
            return [head, *self.block(node.body, depth + 1), f"{pad}}}"]
        if isinstance(node, ast.Break):
            return [f"{pad}break;"]
        raise TypeError(f"C cannot say: {ast.unparse(node)}")

    def returned(self, value: ast.expr) -> list[str]:
        """The lines of a return."""
        if isinstance(value, ast.Tuple):
            return [*(f"out[{k}] = {self.of(e)};" for k, e in enumerate(value.elts)), "return;"]
        return [f"return {self.of(value)};"]

    def of(self, node: ast.expr) -> str:
        """An expression."""
        if isinstance(node, ast.Constant):
            assert isinstance(node.value, int | float)
            return str(node.value) if isinstance(node.value, int) else number(node.value)
        if isinstance(node, ast.Name):
            return node.id
        if isinstance(node, ast.UnaryOp):
            return f"({OPERATORS[type(node.op)]}{self.of(node.operand)})"
        if isinstance(node, ast.BinOp):
            if isinstance(node.op, ast.Pow):
                return f"pow({self.of(node.left)}, {self.of(node.right)})"
            return f"({self.of(node.left)} {OPERATORS[type(node.op)]} {self.of(node.right)})"
        if isinstance(node, ast.BoolOp):
            return "(" + f" {OPERATORS[type(node.op)]} ".join(map(self.of, node.values)) + ")"
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            return f"({self.of(node.left)} {OPERATORS[type(node.ops[0])]} {self.of(node.comparators[0])})"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            name = node.func.id
            name = self.prefix + name if name in self.own else FUNCTIONS.get(name, name)
            return f"{name}({', '.join(map(self.of, node.args))})"
        raise TypeError(f"C cannot say: {ast.unparse(node)}")
