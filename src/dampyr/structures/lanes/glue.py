"""A damper's half step as lines over names: its states, force and slopes at the end of a piece of path."""

from __future__ import annotations

import ast
from dataclasses import dataclass

from dampyr.models.composition import Composition


@dataclass(frozen=True)
class Half:
    """One half step of one site: ``lines`` leave the states in ``ends``, the force and its slopes under their names.

    ``by_x`` and ``by_v`` name how each state changes with the displacement and velocity at the end ("" if not at all).
    """

    lines: list[str]
    ends: list[str]
    force: str
    slopes: tuple[str, str]
    by_x: list[str]
    by_v: list[str]


def half_step(
    composition: Composition, site: int, tag: str, states: list[str], values: list[str], motion: dict[str, str]
) -> Half:
    """The half step that begins with ``states``; every new name ends in ``tag``.

    ``motion`` names x0, x1, v0, v1 and dt.
    """
    if composition.in_series:
        return _by_arrays(composition, site, tag, states, values, motion)
    names = _Names(tag, states, values, motion)
    body, force = _body(composition, "slopes"), _body(composition, "force")
    written = {name for line in body for name in _targets(line)}
    lines = [ast.unparse(names.visit(line)) for line in body[:-1]]
    ends = [f"e{k}{tag}" if f"e{k}" in written else states[k] for k in range(composition.n_states)]
    at_end = _Names(tag, ends, values, motion | {"x": motion["x1"], "v": motion["v1"], "a": "zero"})
    result = ast.unparse(at_end.visit(force[-1].value))  # type: ignore[attr-defined]
    lines.append(f"raw{tag} = {result}")
    by = [[f"d{axis}{k}{tag}" if f"d{axis}{k}" in written else "" for k in range(len(ends))] for axis in "xv"]
    return Half(lines, ends, f"raw{tag}", (f"fx{tag}", f"fv{tag}"), by[0], by[1])


def _by_arrays(
    composition: Composition, site: int, tag: str, states: list[str], values: list[str], motion: dict[str, str]
) -> Half:
    """The same through the functions that work on arrays: parts in series are solved for together, in a loop."""
    s, p = f"S{tag}", f"P{tag}"
    lines = [f"{s}, {p} = w[{2 * site}], w[{2 * site + 1}]"]
    lines += [f"{s}[{k}] = {name}" for k, name in enumerate(states)]
    lines += [f"{p}[{k}] = {name}" for k, name in enumerate(values)]
    path = f"{s}, {', '.join(motion[k] for k in ('x0', 'x1', 'v0', 'v1', 'dt'))}, {p}"
    lines.append(f"fx{tag}, fv{tag} = slopes_{site}({path})")
    lines.append(f"advance_{site}({path})")
    lines.append(f"raw{tag} = force_{site}({s}, {motion['x1']}, {motion['v1']}, zero, {p})")
    ends = [f"e{k}{tag}" for k in range(len(states))]
    lines += [f"{name} = {s}[{k}]" for k, name in enumerate(ends)]
    none = [""] * len(ends)
    return Half(lines, ends, f"raw{tag}", (f"fx{tag}", f"fv{tag}"), none, none)


def _body(composition: Composition, name: str) -> list[ast.stmt]:
    tree = ast.parse(composition.source())
    found = next(f for f in tree.body if isinstance(f, ast.FunctionDef) and f.name == f"{name}_0")
    return found.body


def _targets(line: ast.stmt) -> list[str]:
    nodes = ast.walk(line.targets[0]) if isinstance(line, ast.Assign) else ()
    return [node.id for node in nodes if isinstance(node, ast.Name)]


class _Names(ast.NodeTransformer):
    """The names of a composition's glue in the place of its arrays and arguments."""

    def __init__(self, tag: str, states: list[str], values: list[str], motion: dict[str, str]) -> None:
        self.tag, self.arrays, self.motion = tag, {"s": states, "p": values}, motion

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        return ast.Name(self.arrays[node.value.id][node.slice.value], node.ctx)  # type: ignore[attr-defined]

    def visit_Call(self, node: ast.Call) -> ast.Call:
        node.args = [self.visit(argument) for argument in node.args]
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        return ast.Name("one" if node.value else "zero", ast.Load())

    def visit_Name(self, node: ast.Name) -> ast.Name:
        return ast.Name(self.motion.get(node.id, node.id + self.tag), node.ctx)
