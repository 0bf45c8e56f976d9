"""C text of the functions of a damper: the syntax trees that the kernels compile, written out in C99."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from copy import deepcopy

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


def function(tree: ast.FunctionDef, prefix: str, own: set[str], arrays: Iterable[str] = ()) -> str:
    """One static C function; calls to the names in ``own`` are prefixed, arguments named in ``arrays`` are arrays.

    A tuple is returned through a further argument, ``out``.
    """
    tree = _Flat().visit(deepcopy(tree))
    writer = _Writer(prefix, own, _read(tree))
    body = writer.block(tree.body, 1)
    values = [n.value for n in ast.walk(tree) if isinstance(n, ast.Return) and n.value is not None]
    several = any(isinstance(value, ast.Tuple) for value in values)
    names = [a.arg for a in tree.args.args]
    written = {name for name in arrays if _stores(tree, name)}
    kinds = {name: "double *" if name in written else "const double *" for name in arrays}
    arguments = [f"{kinds.get(name, 'double ')}{name}" for name in names]
    head = f"static {'double' if values and not several else 'void'} {prefix}{tree.name}"
    lines = [f"{head}({', '.join([*arguments, *(['double *out'] if several else [])])})", "{"]
    if local := sorted(_assigned(tree) & writer.read - set(names) - writer.counters):
        lines.append(f"    double {', '.join(local)};")
    if unused := [name for name in names if name not in writer.read | written]:
        lines.append("    " + " ".join(f"(void){name};" for name in unused))
    return "\n".join([*lines, *body, "}"])


def _assigned(tree: ast.AST) -> set[str]:
    return {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}


def _stores(tree: ast.AST, array: str) -> bool:
    """Whether a function writes to the elements of an array."""
    nodes = (n.value for n in ast.walk(tree) if isinstance(n, ast.Subscript) and isinstance(n.ctx, ast.Store))
    return any(isinstance(n, ast.Name) and n.id == array for n in nodes)


def _read(tree: ast.FunctionDef) -> set[str]:
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


class _Flat(ast.NodeTransformer):
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
        return [ast.Assign([each], expression) for each, expression in pairs]


class _Writer:
    """Writes statements and expressions."""

    def __init__(self, prefix: str, own: set[str], read: set[str]) -> None:
        self.prefix, self.own, self.read = prefix, own, read
        self.counters: set[str] = set()

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
            k, stop = node.target.id, self.of(node.iter.args[0])
            self.counters.add(k)
            head = f"{pad}for (int {k} = 0; {k} < {stop}; {k}++) {{"
            return [head, *self.block(node.body, depth + 1), f"{pad}}}"]
        if isinstance(node, ast.Break):
            return [f"{pad}break;"]
        raise TypeError(f"no C form for: {ast.unparse(node)}")

    def assigned(self, target: ast.expr, value: ast.expr) -> list[str]:
        """The lines of an assignment; several targets take what a function of a part returns through ``out``."""
        if isinstance(target, ast.Tuple):
            call = self.of(value).removesuffix(")")
            results = [f"{self.of(each)} = out[{k}];" for k, each in enumerate(target.elts)]
            return [f"{{ double out[{len(results)}]; {call}, out); {' '.join(results)} }}"]
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

    def of(self, node: ast.expr) -> str:
        """An expression."""
        if isinstance(node, ast.Constant):
            assert isinstance(node.value, int | float)
            return str(node.value) if isinstance(node.value, int) else number(node.value)
        if isinstance(node, ast.Name):
            return node.id
        if isinstance(node, ast.Subscript):
            return f"{self.of(node.value)}[{self.of(node.slice)}]"
        if isinstance(node, ast.IfExp):
            return f"({self.of(node.test)} ? {self.of(node.body)} : {self.of(node.orelse)})"
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
        raise TypeError(f"no C form for: {ast.unparse(node)}")
