"""The functions of a composition as a differential equation in time, for solvers of other tools.

A kernel of dampyr steps along a path; a solver that chooses its own steps asks for the derivatives of the states instead, and
for what changes its sign where they have a kink. Parts that follow a differential equation have both in their files.
"""

from __future__ import annotations

import ast

from dampyr.errors import InputError
from dampyr.models.codegen.composition import Composition
from dampyr.models.codegen.formula import Formula, InPlace, read
from dampyr.models.codegen.layout import Function, Slot, call, indexed
from dampyr.models.codegen.syntax_trees import expression_of


def check_has_rates(composition: Composition) -> None:
    """Raise :class:`InputError` for parts whose states or force follow no differential equation."""
    for p in composition.parts:
        reason = ""
        if p.stretch is not None:
            reason = "is in series, where the force is the root of an equation at each sample"
        elif p.delay is not None:
            reason = "needs the force of a time ago"
        elif p.needs_acceleration:
            reason = "needs the acceleration"
        elif p.states and p.rates is None:
            follows = "follow the change of the velocity" if p.follows_velocity else "are held at stops"
            reason = f"has states that {follows} and no time derivative that a solver can integrate"
        if reason:
            raise InputError(
                f"{p.name} is no differential equation for a solver: it {reason}; export for co-simulation or to c, or "
                f"damper.without({p.name!r}) where that is a damper"
            )


def formulas(composition: Composition) -> list[Formula]:
    """The forces and rates of the parts, with what they call first, each name once."""
    listed: list[Formula] = []
    for p in composition.parts:
        for formula in (p.rates, p.force):
            if formula is not None:
                listed += [*(read(f, n) for n, f in formula.intrinsics().items()), formula]
    return list({formula.name: formula for formula in listed}.values())


def functions(composition: Composition) -> list[Function]:
    """``force``, ``rates``, which fills ``rate``, and ``switches``, which fills ``sign``."""
    slots = composition.layout.slots
    terms = [call(slot.part.force, _places(slot)) for slot in slots if slot.part.force]
    rates = [
        f"{indexed(slot.states.values(), 'rate[{}]')} = {call(slot.part.rates, _places(slot))}"
        for slot in slots
        if slot.part.rates
    ]
    signs = [f"sign[{k}] = {text}" for k, text in enumerate(switch_texts(composition))]
    return [
        Function("force", "s, x, v, a, p", ["return " + " + ".join(terms)]),
        Function("rates", "s, x, v, p, rate", [*rates, "return"]),
        Function("switches", "s, x, v, p, sign", [*signs, "return"]),
    ]


def switch_texts(composition: Composition) -> list[str]:
    """What changes its sign at a kink, over s, x, v and p; each expression once."""
    texts: list[str] = []
    for slot in composition.layout.slots:
        if slot.part.switches is None:
            continue
        [only] = slot.part.switches.tree.body
        assert isinstance(only, ast.Return)
        assert only.value is not None
        whole = InPlace(_places(slot)).visit(expression_of(ast.unparse(only.value)).body)
        texts += [ast.unparse(each) for each in (whole.elts if isinstance(whole, ast.Tuple) else [whole])]
    return list(dict.fromkeys(texts))


def _places(slot: Slot) -> dict[str, str]:
    return slot.state_places() | slot.value_places()
