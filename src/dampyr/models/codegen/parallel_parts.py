"""The functions of a composition whose parts act side by side: each feels the whole motion, and their forces add up."""

from __future__ import annotations

from dampyr.models.codegen.formula import partials_of, read, tangent, tangents
from dampyr.models.codegen.layout import SIGNATURES, Function, Layout, Slot, call, indexed
from dampyr.models.part import Part


def functions(layout: Layout) -> list[Function]:
    """``advance``, ``force``, ``slopes``, ``jacobian`` and ``advance_tangents``."""
    return [write(layout) for write in (_advance, _force, _slopes, _jacobian, _advance_tangents)]


def derivatives(p: Part) -> dict[str, str]:
    """Derivatives of a part's two formulas: along its states, and along one more argument at a time."""
    texts: dict[str, str] = {}
    for formula in (p.advance, p.force):
        if formula is None:
            continue
        states = [s for s in p.states if s in formula.arguments]
        for name, function in partials_of(formula).items():
            for inner, f in read(function, name).intrinsics().items():
                texts.setdefault(inner, read(f, inner).source)
            texts[name] = read(function, name).source
        if formula is p.force:
            for unit in (None, *(a for a in formula.arguments if a not in p.states)):
                name = f"{formula.name}_by_{unit or 'states'}"
                texts[name] = tangent(formula, name, states, unit)
    if p.advance is not None:
        used = [s for s in p.states if s in p.advance.arguments]
        at_end, everywhere = f"{p.advance.name}_and_slopes", f"{p.advance.name}_and_tangents"
        units = [name for name in p.parameters if name in p.advance.arguments]
        texts[at_end] = tangents(p.advance, at_end, used, [f"{axis}1" for axis in _axes(p)])
        texts[everywhere] = tangents(p.advance, everywhere, used, [*units, *(None for _ in p.states)])
    return texts


def _places(slot: Slot) -> dict[str, str]:
    return slot.state_places() | slot.value_places()


def _advance(layout: Layout) -> Function:
    lines = [
        f"{indexed(slot.states.values(), 's[{}]')} = {call(slot.part.advance, _places(slot))}"
        for slot in layout.slots
        if slot.part.advance
    ]
    return Function("advance", SIGNATURES["advance"], [*lines, "return"])


def _force(layout: Layout) -> Function:
    terms = [call(slot.part.force, _places(slot)) for slot in layout.slots if slot.part.force]
    return Function("force", SIGNATURES["force"], ["return " + " + ".join(terms)])


def _slopes(layout: Layout) -> Function:
    """dF/dx1 and dF/dv1 of the force at the end of a piece, through the states and directly."""
    lines = ["fx, fv, x, v, a = 0.0, 0.0, x1, v1, 0.0"]
    for slot in layout.slots:
        p = slot.part
        if p.force is None:
            continue
        if p.advance:
            lines.append(_states_and_slopes(slot))
        at_end = _places(slot) | slot.state_places("e{}")
        used = [k for s, k in slot.states.items() if s in p.force.arguments]
        for axis, total in (("x", "fx"), ("v", "fv")):
            moving = [f"d{axis}{k}" for k in used] if axis in _axes(p) else []
            if axis in p.force.arguments or moving:
                suffix = f"_by_{axis}" if axis in p.force.arguments else "_by_states"
                lines.append(f"{total} += {call(p.force, at_end, *(moving or ['0.0'] * len(used)), suffix=suffix)}")
    return Function("slopes", SIGNATURES["slopes"], [*lines, "return fx, fv"])


def _axes(p: Part) -> list[str]:
    """What the states at the end of a piece change with: x1, v1 or both."""
    return [axis for axis in "xv" if p.advance is not None and f"{axis}1" in p.advance.arguments]


def _states_and_slopes(slot: Slot) -> str:
    """The line with a part's states at the end and how they change with x1 and v1, in one call."""
    p, places = slot.part, slot.states.values()
    assert p.advance is not None
    zeros = ["0.0"] * (len(_axes(p)) * sum(s in p.advance.arguments for s in p.states))
    targets = [indexed(places, "e{}"), *(indexed(places, f"d{axis}{{}}") for axis in _axes(p))]
    return f"{', '.join(targets)} = {call(p.advance, _places(slot), *zeros, suffix='_and_slopes')}"


def _jacobian(layout: Layout) -> Function:
    """dF/dp_k and dF/ds_j(start), from the tangents D of the states."""
    lines, filled = [], set[int]()
    for slot in layout.slots:
        p = slot.part
        if p.force is None:
            continue
        used = [k for s, k in slot.states.items() if s in p.force.arguments]
        columns = {k: name for name, k in slot.values.items() if used or name in p.force.arguments}
        columns |= {layout.n_parameters + k: "states" for k in slot.states.values()}
        for column, name in columns.items():
            suffix = f"_by_{name}" if name in p.force.arguments else "_by_states"
            seeds = [f"D[{j}, {column}]" for j in used]
            to = "+=" if column in filled else "="  # a parameter that several parts share
            lines.append(f"J[{column}] {to} {call(p.force, _places(slot), *seeds, suffix=suffix)}")
            filled.add(column)
    return Function("jacobian", SIGNATURES["jacobian"], [*lines, "return"])


def _advance_tangents(layout: Layout) -> Function:
    """Move the states and their tangents D along one piece."""
    lines = []
    for slot in layout.slots:
        p = slot.part
        if p.advance is None:
            continue
        used = [k for s, k in slot.states.items() if s in p.advance.arguments]
        columns = [k for name, k in slot.values.items() if name in p.advance.arguments]
        columns += [layout.n_parameters + k for k in slot.states.values()]
        seeds = [f"D[{j}, {column}]" for column in columns for j in used]
        places = slot.states.values()
        targets = [indexed(places, "s[{}]"), *(indexed(places, f"D[{{}}, {column}]") for column in columns)]
        lines.append(f"{', '.join(targets)} = {call(p.advance, _places(slot), *seeds, suffix='_and_tangents')}")
    return Function("advance_tangents", SIGNATURES["advance_tangents"], [*lines, "return"])
