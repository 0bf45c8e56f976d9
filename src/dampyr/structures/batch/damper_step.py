"""A damper's half step as lines over names: its states, force and slopes at the end of a piece of path."""

from __future__ import annotations

import ast
from dataclasses import dataclass

from dampyr.models.codegen import series
from dampyr.models.codegen.composition import Composition
from dampyr.models.codegen.syntax_trees import statements_of


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


_NUMBERS: dict[object, str] = {0.0: "zero", 0.5: "half", 1.0: "one"}


def half_step(
    composition: Composition,
    tag: str,
    states: list[str],
    values: list[str],
    motion: dict[str, str],
    at_end: list[str] | None = None,
) -> Half:
    """The half step that begins with ``states``; every new name ends in ``tag``.

    ``values`` are the parameters along it, ``at_end`` those of the force at its end where they differ. ``motion`` names x0, x1,
    v0, v1 and dt, and g0 and g1: the force at the start and the guess of it at the end.
    """
    if composition.in_series:
        return _in_series(composition, tag, states, values, motion)
    names = _Names(tag, states, values, motion)
    body = _body(composition, "slopes")
    written = {name for line in body for name in _targets(line)}
    lines = [ast.unparse(names.visit(line)) for line in body[:-1]]
    ends = [f"e{k}{tag}" if f"e{k}" in written else states[k] for k in range(composition.n_states)]
    end = {"x": motion["x1"], "v": motion["v1"], "a": "zero"}
    lines.append(f"raw{tag} = {force_now(composition, tag, ends, at_end or values, motion | end)}")
    by = [[f"d{axis}{k}{tag}" if f"d{axis}{k}" in written else "" for k in range(len(ends))] for axis in "xv"]
    return Half(lines, ends, f"raw{tag}", (f"fx{tag}", f"fv{tag}"), by[0], by[1])


def force_now(composition: Composition, tag: str, states: list[str], values: list[str], motion: dict[str, str]) -> str:
    """The force of states, parameters and ``motion`` (x, v and a), of dampers that nothing stretches in series with."""
    [*_, result] = _body(composition, "force")
    return ast.unparse(_Names(tag, states, values, motion).visit(result.value))  # type: ignore[attr-defined]


def _in_series(
    composition: Composition, tag: str, states: list[str], values: list[str], motion: dict[str, str]
) -> Half:
    """The same where something stretches under the force; the last state is the force itself."""
    names, hidden = _Names(tag, states, values, motion), len(states) - 1
    lines = [ast.unparse(names.visit(statements_of(line).body[0])) for line in series.law(composition.layout)]
    ends = [f"e{k}{tag}" for k in range(hidden)]
    by = [[f"f{axis}{k}{tag}" for k in range(hidden)] for axis in "xv"]
    return Half(lines, ends, f"raw{tag}", (f"fx{tag}", f"fv{tag}"), by[0], by[1])


def _body(composition: Composition, name: str) -> list[ast.stmt]:
    tree = statements_of(composition.source())
    function = next(f for f in tree.body if isinstance(f, ast.FunctionDef) and f.name == f"{name}_site0")
    return function.body


def _targets(line: ast.stmt) -> list[str]:
    nodes = ast.walk(line.targets[0]) if isinstance(line, ast.Assign) else ()
    return [node.id for node in nodes if isinstance(node, ast.Name)]


class _Names(ast.NodeTransformer):
    """The names of a composition's glue in the place of its arrays and arguments."""

    def __init__(self, tag: str, states: list[str], values: list[str], motion: dict[str, str]) -> None:
        self.tag, self.arrays, self.motion = tag, {"s": states, "p": values}, motion

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        if not isinstance(node.value, ast.Name):
            return ast.Subscript(self.visit(node.value), node.slice, node.ctx)
        return ast.Name(self.arrays[node.value.id][node.slice.value], node.ctx)  # type: ignore[attr-defined]

    def visit_Call(self, node: ast.Call) -> ast.Call:
        node.args = [self.visit(argument) for argument in node.args]
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        return ast.Name(_NUMBERS[node.value], ast.Load())

    def visit_Name(self, node: ast.Name) -> ast.Name:
        return ast.Name(self.motion.get(node.id, node.id + self.tag), node.ctx)
