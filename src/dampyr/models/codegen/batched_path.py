"""The text of ``step_block``: a composition's force and derivatives at several samples of a path at once.

``advance_tangents``, ``force`` and ``jacobian`` take one sample at a time. ``step_block`` takes what it can out of the
recurrence: exponentials that no state enters are computed before it, the states and their tangents are advanced alone, and
the Jacobian is filled after it. All but the recurrence itself are loops over samples that do not wait for each other, so that
the compiler takes several samples at once (see `dampyr.models.numerics.fast_math`). In series nothing can be taken out, and
the samples are taken one by one.

Its argument ``still`` is 1 to fill the Jacobian of the first sample without a step, 0 to step from the first sample to all
others.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable

from dampyr.models.codegen.formula import Formula, InPlace, tangents
from dampyr.models.codegen.layout import SIGNATURES, SITE, Function, Layout, Slot, call
from dampyr.models.codegen.syntax_trees import expression_of

QUICK = {"exp": "quick_exp", "tanh": "quick_tanh"}
PIECE = {"x0": "x[m]", "x1": "x[m + 1]", "v0": "v[m]", "v1": "v[m + 1]", "dt": "(t[m + 1] - t[m])"}
SAMPLE = {"x": "x_at[m]", "v": "v_at[m]", "a": "a_at[m]"}
LOOP = "for m in range(x.size - 1):"


def write_step_block(layout: Layout) -> tuple[list[str], Function, int]:
    """The functions that ``step_block`` calls, as text, ``step_block`` itself, and how many rows of workspace it needs."""
    if layout.in_series:
        return [], _sample_by_sample(layout), 0
    writer = BlockWriter(layout)
    step_block = writer.step_block()
    return writer.functions, step_block, writer.workspace_rows


def _sample_by_sample(layout: Layout) -> Function:
    x, v, a = SAMPLE.values()
    moved = ["if still == 0:", f"    advance_tangents{SITE}s, D, {', '.join(PIECE.values())}, p)"]
    filled = [
        f"rows[{layout.width}, m] = force{SITE}s, {x}, {v}, {a}, p)",
        f"jacobian{SITE}s, D, {x}, {v}, {a}, p, rows[:, m])",
    ]
    return _step_block(_loop(*moved, *filled))


class BlockWriter:
    """Writes ``step_block`` of one composition; ``workspace`` (rows, BLOCK) passes values from one of its loops to the next."""

    def __init__(self, layout: Layout) -> None:
        self.slots = layout.slots
        self.offset = layout.n_parameters
        self.force = layout.width
        self.functions: list[str] = []
        self.workspace_rows = 0
        self.stored: dict[str, str] = {}
        self.filled: set[int] = set()

    def step_block(self) -> Function:
        """``step_block``; the functions that it calls are then in ``functions``."""
        lines = [f"p{k} = p[{k}]" for k in range(self.offset)]
        for slot in self.slots:
            lines += self._states(slot, slot.part.advance) if slot.part.advance else []
        for slot in self.slots:
            lines += self._columns(slot, slot.part.force) if slot.part.force else []
        return _step_block(lines)

    def _row(self) -> str:
        self.workspace_rows += 1
        return f"workspace[{self.workspace_rows - 1}, m]"

    def _states(self, slot: Slot, formula: Formula) -> list[str]:
        """The lines that advance a part's states and their tangents, and store them in ``workspace``."""
        units = {n: k for n, k in slot.values.items() if n in formula.arguments}
        columns = [*units.values(), *(self.offset + k for k in slot.states.values())]
        initial = {f"s{k}": f"s[{k}]" for k in slot.states.values()}
        initial |= {f"D{k}_{c}": f"D[{k}, {c}]" for c in columns for k in slot.states.values()}
        used = [n for n in slot.states if n in formula.arguments]
        seeds = [f"D{slot.states[n]}_{c}" for c in columns for n in used]
        places = PIECE | slot.value_places("p{}") | slot.state_places("s{}")
        ahead, lines = self._ahead(formula, [n for n in formula.arguments if n not in slot.states], places)
        text = tangents(formula, f"moved_{formula.name}", used, [*units, *(None for _ in slot.states)])
        called = self._called(text, formula, places, seeds, ahead)
        rows = {name: self._row() for name in initial}
        self.stored |= rows
        store_lines = [f"{row} = {name}" for name, row in rows.items()]
        lines += [f"{name} = {place}" for name, place in initial.items()]
        lines += ["if still == 1:", *(f"    {line.replace(', m]', ', 0]')}" for line in store_lines), "else:"]
        lines += [f"    {line}" for line in _loop(f"{', '.join(initial)} = {called}", *store_lines)]
        return [*lines, *(f"{place} = {name}" for name, place in initial.items())]

    def _columns(self, slot: Slot, formula: Formula) -> list[str]:
        """The lines that fill a part's columns of the Jacobian and add its force."""
        used = {n: k for n, k in slot.states.items() if n in formula.arguments}
        places = SAMPLE | slot.value_places("p{}") | {n: self.stored[f"s{k}"] for n, k in used.items()}
        units: dict[int, str | None] = {}
        seeds: list[str] = []
        for name, c in [*slot.values.items(), *(("", self.offset + k) for k in slot.states.values())]:
            stored = [self.stored.get(f"D{k}_{c}", "0.0") for k in used.values()]
            if name in formula.arguments or any(seed != "0.0" for seed in stored):
                units[c] = name if name in formula.arguments else None
                seeds += stored
        shared, lines = self._ahead(formula, formula.arguments, places)
        text = tangents(formula, f"filled_{formula.name}", list(used), list(units.values()))
        called = self._called(text, formula, places, seeds, shared)
        first = not any(text.startswith("def filled_") for text in self.functions[:-1])
        added = f"rows[{self.force}, m] = f" if first else f"rows[{self.force}, m] += f"
        shared_columns = [c for c in units if c in self.filled]  # of parameters that several parts share
        targets = ["f", *(f"more{c}" if c in shared_columns else f"rows[{c}, m]" for c in units)]
        self.filled.update(units)
        more = [f"rows[{c}, m] += more{c}" for c in shared_columns]
        return lines + _loop(f"{', '.join(targets)} = {called}", added, *more)

    def _ahead(
        self, formula: Formula, available: Iterable[str], places: dict[str, str]
    ) -> tuple[dict[str, str], list[str]]:
        """The calls that are computed in loops of their own: their text -> where their values are, and these loops."""
        rows = {ast.unparse(node): self._row() for node in _calls(formula, available)}
        lines = [line for text, row in rows.items() for line in _loop(f"{row} = {_quickly(text, places)}")]
        return rows, lines

    def _called(
        self, text: str, formula: Formula, places: dict[str, str], seeds: list[str], ahead: dict[str, str]
    ) -> str:
        """A call of the function of ``text``, which takes the values of the calls ``ahead`` as further arguments."""
        head, _, body = text.partition("):\n")
        for k, expression in enumerate(ahead):
            head, body = f"{head}, call{k}", body.replace(expression, f"call{k}")
        self.functions.append(f"{head}):\n{body}")
        name = head.partition("(")[0].removeprefix("def ")
        return call(formula, places, *seeds, *ahead.values(), name=name)


def _step_block(lines: list[str]) -> Function:
    at = [f"{n}_at = {n}[1 - still:]" for n in SAMPLE if any(f"{n}_at[" in line for line in lines)]
    return Function("step_block", SIGNATURES["step_block"], [*at, *lines, "return"])


def _loop(*lines: str) -> list[str]:
    return [LOOP, *(f"    {line}" for line in lines)]


def _calls(formula: Formula, available: Iterable[str]) -> list[ast.Call]:
    """The calls of `QUICK` outside branches whose arguments are ``available``: the outer before the inner."""
    calls = []
    assigned = {n.id for n in ast.walk(formula.tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    allowed = set(available) - assigned | {"abs", "log"}
    for statement in formula.tree.body:
        for node in ast.walk(statement) if not isinstance(statement, ast.If) else ():
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in QUICK:
                names = {n.id for a in node.args for n in ast.walk(a) if isinstance(n, ast.Name)}
                if names <= allowed:
                    calls.append(node)
    return calls


def _quickly(text: str, places: dict[str, str]) -> str:
    """The text of a call with its arguments in their places and the function in its quick form."""
    return ast.unparse(InPlace(places | QUICK).visit(expression_of(text)))
