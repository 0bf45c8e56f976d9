"""The layout of a composition's vectors, and the functions that are written over it.

`Slot` says where a part's states and parameters are; `Function` is one generated function, with lines of Python as its
body. ``parallel``, ``series`` and ``batched_path`` write such functions for the compiled kernels, and
``dampyr.export.c_text`` turns the same functions into C.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

from dampyr.models.codegen.formula import Formula
from dampyr.models.codegen.syntax_trees import statements_of
from dampyr.models.part import Part

#: Arguments of the functions that every composition has, by name: what the drivers of `dampyr.models.codegen.kernels` call.
SIGNATURES = {
    "advance": "s, x0, x1, v0, v1, dt, p",
    "force": "s, x, v, a, p",
    "slopes": "s, x0, x1, v0, v1, dt, p",
    "jacobian": "s, D, x, v, a, p, J",
    "advance_tangents": "s, D, x0, x1, v0, v1, dt, p",
    "step_block": "still, t, x, v, a, p, s, D, workspace, rows",
}
#: Marks a call of another function of the same composition; a suffix for the composition takes its place.
SITE = "_SITE("


@dataclass(frozen=True)
class Slot:
    """One part with the indices of its states and of its parameters, by name."""

    part: Part
    states: dict[str, int]
    values: dict[str, int]

    def state_places(self, form: str = "s[{}]") -> dict[str, str]:
        """State name -> expression."""
        return {name: form.format(k) for name, k in self.states.items()}

    def value_places(self, form: str = "p[{}]") -> dict[str, str]:
        """Parameter name -> expression."""
        return {name: form.format(k) for name, k in self.values.items()}


@dataclass(frozen=True)
class Layout:
    """The slots of all parts, in their order; parts in series add the rate of the stretch and the force as states."""

    parts: tuple[Part, ...]

    @cached_property
    def slots(self) -> tuple[Slot, ...]:
        """Each part with its indices."""
        slots, i, j = [], 0, 0
        for p in self.parts:
            states = {name: j + k for k, name in enumerate(p.states)}
            values = {name: i + k for k, name in enumerate(p.parameters)}
            slots.append(Slot(p, states, values))
            i, j = i + len(values), j + len(states)
        flat = {f"{slot.part.name}.{key}": k for slot in slots for key, k in slot.values.items()}
        for slot in slots:
            slot.values.update({argument: flat[name] for argument, name in slot.part.shared.items()})
        return tuple(slots)

    @cached_property
    def in_series(self) -> bool:
        """Whether the parts are in series with an element that stretches under the force."""
        return any(p.stretch for p in self.parts)

    @cached_property
    def has_rate(self) -> bool:
        """Whether the rate of the stretch in series is a state, because a part's states follow its velocity."""
        return self.in_series and any(p.follows_velocity for p in self.parts)

    @cached_property
    def n_parameters(self) -> int:
        """Number of parameters."""
        return sum(len(p.parameters) for p in self.parts)

    @cached_property
    def n_states(self) -> int:
        """Number of states."""
        return sum(len(slot.states) for slot in self.slots) + self.has_rate + self.in_series

    @property
    def force_state(self) -> int:
        """In series, the index of the force among the states: the last one."""
        return self.n_states - 1

    @property
    def rate_state(self) -> int | None:
        """The index of the rate of the stretch among the states, if a part needs it."""
        return self.n_states - 2 if self.has_rate else None

    @property
    def width(self) -> int:
        """Number of derivatives of the force: by the parameters, then by the states at the start."""
        return self.n_parameters + self.n_states


@dataclass(frozen=True)
class Function:
    """One function of a composition; its body is lines of Python, which the exports read as a syntax tree."""

    name: str
    arguments: str
    body: list[str]

    def python(self, suffix: str = "") -> str:
        """Python text; the function and those of the same composition that it calls have names ending in ``suffix``."""
        lines = (line.replace(SITE, f"{suffix}(") for line in self.body)
        return "\n    ".join([f"def {self.name}{suffix}({self.arguments}):", *lines])

    def tree(self) -> ast.FunctionDef:
        """The syntax tree of the Python text."""
        tree = statements_of(self.python()).body[0]
        assert isinstance(tree, ast.FunctionDef)
        return tree


def call(formula: Formula, places: Mapping[str, str], *more: str, name: str = "", suffix: str = "") -> str:
    """A call of ``formula`` with its arguments in their places, a name without a place as itself, then ``more``."""
    arguments = [*(places.get(a, a) for a in formula.arguments), *more]
    return f"{name or formula.name}{suffix}({', '.join(arguments)})"


def indexed(indices: Iterable[int], form: str) -> str:
    """``form`` with each of the indices, separated by commas."""
    return ", ".join(form.format(k) for k in indices)
