r"""The functions of a composition whose parts are in series with an element that stretches.

The parts feel the motion less the stretch, which the force itself makes:

.. math:: F_1 = \Phi(F_1), \qquad \Phi(F) = \sum_\text{parts} F_k\big(x_1 - z(F),\; v_1 - \frac{z(F) - z(F_0)}{\Delta t}\big)

z is the stretch under the parameters of the step at either force: where the input varies, and a parameter of the stretch with
it, that change alone moves no memory.

Phi falls as F rises, wherever no part gives less force at a higher velocity, so the equation has one root, no farther from F
than F - Phi(F). A part whose own law does not keep to that has a law of its own in series, ``force_in_series`` in its file:
where Phi rises faster than F there are several roots, and rounding chooses among them from step to step.
It is found by regula falsi with Illinois weights; derivatives are those of the implicit function. The force is a state, the
last one. A force that needs the acceleration acts in parallel with the whole, at the outer end.

A part whose state follows its velocity (``v0`` in its ``advance``) needs the velocity at the start of the step too,
:math:`v_0 - \dot z_0`. The rate of the stretch at the end of the step before is a state then, the one before the force. Along
a path whose past is unknown there is none before the first step: that step takes the rate at its end for both ends.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass

from dampyr.models.codegen.formula import Formula, tangents
from dampyr.models.codegen.layout import SIGNATURES, Function, Layout, Slot, call
from dampyr.models.part import Part

FORCE = "series.f"
RATE = "series.rate"
UNKNOWN = 1e9  # m/s, faster than anything: the rate of the stretch where the past is unknown


def functions(layout: Layout) -> list[Function]:
    """``phi``, ``solve``, ``advance``, ``force``, ``slopes``, ``jacobian`` and ``advance_tangents``."""
    return [write(layout) for write in (_phi, _solve, _advance, _force, _slopes, _jacobian, _advance_tangents)]


def derivatives(p: Part) -> dict[str, str]:
    """The formulas of a part with their derivatives: along any direction, and by each argument."""
    texts = {}
    for formula in (p.force_in_series, p.stretch):
        if formula is not None:
            name = f"{formula.name}_towards"
            texts[name] = tangents(formula, name, _active(formula), [None])
    for formula in (p.advance, p.force_in_series):
        if formula is not None:
            name = f"{formula.name}_partials"
            texts[name] = tangents(formula, name, (), _active(formula))
    return texts


def _active(formula: Formula) -> list[str]:
    return [a for a in formula.arguments if a != "dt"]


def _inner(layout: Layout) -> list[Slot]:
    return [slot for slot in layout.slots if not slot.part.needs_acceleration]


def _stretch(layout: Layout, f: str) -> str:
    """The whole stretch under the force ``f``."""
    terms = []
    for slot in layout.slots:
        if slot.part.stretch:
            terms.append(call(slot.part.stretch, {"f": f} | slot.value_places()))
    return " + ".join(terms)


INNER = {"x0": "a0", "x1": "a1", "v0": "u0", "v1": "u1", "dt": "dt", "x": "a1", "v": "u1", "a": "0.0"}


def _shrunk(layout: Layout, at_start: str, at_end: str) -> list[str]:
    """Lines that leave in a0, a1, u0, u1 the motion less the stretch, and in r its rate, which is ``at_end``."""
    before = [f"u0 = v0 - {at_start}"] if layout.has_rate else []
    return ["a0, a1 = x0 - z0, x1 - z1", f"r = {at_end}", *before, "u1 = v1 - r"]


def _shrunk_in_kernel(layout: Layout) -> list[str]:
    past = _past(layout, "s[{}]", "0.0")
    return _shrunk(layout, _past(layout, "s[{}]", "r"), f"(z1 - z0)/dt if dt > 0.0 else {past}")


def _past(layout: Layout, form: str, unknown: str) -> str:
    """The rate of the stretch at the start of a step by ``form``, or ``unknown`` where no step was before."""
    place = layout.rate_state
    return unknown if place is None else f"({unknown} if s[{place}] >= {UNKNOWN} else {form.format(place)})"


def _ends(layout: Layout) -> list[str]:
    """Lines that put the states at the end of a piece into e0, e1, ..."""
    lines = []
    for slot in _inner(layout):
        if slot.part.advance:
            places = INNER | slot.state_places("s[{}]") | slot.value_places()
            targets = ", ".join(f"e{k}" for k in slot.states.values())
            lines.append(f"{targets} = {call(slot.part.advance, places)}")
    return lines


def _phi(layout: Layout) -> Function:
    terms = []
    for slot in _inner(layout):
        if slot.part.force_in_series:
            terms.append(call(slot.part.force_in_series, INNER | slot.state_places("e{}") | slot.value_places()))
    lines = [
        f"z1 = {_stretch(layout, 'f')}",
        *_shrunk_in_kernel(layout),
        *_ends(layout),
        f"return {' + '.join(terms)}",
    ]
    return Function("phi", "s, z0, f, x0, x1, v0, v1, dt, p", lines)


def _solve(layout: Layout) -> Function:
    phi = "phi_SITE(s, z0, {}, x0, x1, v0, v1, dt, p)"
    lines = f"""
f0 = s[{layout.force_state}]
if dt <= 0.0: return f0
z0 = {_stretch(layout, "f0")}
g0 = f0 - {phi.format("f0")}
if g0 == 0.0: return f0
reach = g0
f1 = f0 - reach
g1 = f1 - {phi.format("f1")}
for _ in range(60):
    if g0*g1 <= 0.0: break
    reach = 2.0*reach
    f1 = f0 - reach
    g1 = f1 - {phi.format("f1")}
f = f1
for _ in range(200):
    f = f1 - g1*(f1 - f0)/(g1 - g0) if g1 != g0 else f1
    g = f - {phi.format("f")}
    if abs(g) <= 1e-13*abs(f) + 1e-12: break
    if g*g1 < 0.0:
        f0, g0 = f1, g1
    else:
        g0 = 0.5*g0
    f1, g1 = f, g
return f"""
    return Function("solve", SIGNATURES["advance"], lines.strip().split("\n"))


def _solve_lines(layout: Layout) -> list[str]:
    """Lines that find the force ``f1`` at the end of a piece, and the motion that is left."""
    return [
        f"f0 = s[{layout.force_state}]",
        "f1 = solve_SITE(s, x0, x1, v0, v1, dt, p)",
        f"z0 = {_stretch(layout, 'f0')}",
        f"z1 = {_stretch(layout, 'f1')}",
        *_shrunk_in_kernel(layout),
    ]


def _advance(layout: Layout) -> Function:
    lines = [*_solve_lines(layout), *_ends(layout), *_store_lines(layout), "return"]
    return Function("advance", SIGNATURES["advance"], lines)


def _store_lines(layout: Layout) -> list[str]:
    lines = []
    for slot in _inner(layout):
        lines += [f"s[{k}] = e{k}" for k in slot.states.values()]
    if (place := layout.rate_state) is not None:
        lines.append(f"s[{place}] = r")
    return [*lines, f"s[{layout.force_state}] = f1"]


def _outer_forces(layout: Layout) -> list[tuple[Slot, Formula]]:
    return [(slot, slot.part.force) for slot in layout.slots if slot.part.force and slot.part.needs_acceleration]


def _force(layout: Layout) -> Function:
    places = {"x": "x", "v": "v", "a": "a"}
    terms = [f"s[{layout.force_state}]"]
    terms += [call(formula, places | slot.value_places()) for slot, formula in _outer_forces(layout)]
    return Function("force", SIGNATURES["force"], [f"return {' + '.join(terms)}"])


@dataclass(frozen=True)
class Direction:
    """Seeds of a derivative: expressions by what they are the tangent of."""

    motion: dict[str, str]
    states: str
    values: str

    def lines(self, layout: Layout, out: str) -> list[str]:
        """Lines that leave the tangents of the states in ``out0, ...`` and the one of Phi in ``out``."""
        lines, terms = [], []
        for slot in _inner(layout):
            seeds = self.motion | slot.state_places(self.states) | slot.value_places(self.values)
            if slot.part.advance:
                for k in slot.states.values():
                    lines.append(f"{out}{k} = {_sum(slot.part.advance, str(k), seeds)}")
            if slot.part.force_in_series:
                seeds |= slot.state_places(out + "{}") | {"x": self.motion["x1"], "v": self.motion["v1"]}
                terms.append(_sum(slot.part.force_in_series, "", seeds))
        return [*lines, f"{out} = {' + '.join(terms)}"]


def _sum(formula: Formula, state: str, seeds: dict[str, str]) -> str:
    """The tangent of a formula from its partial derivatives, which have names of their own."""
    terms = [f"{formula.name}{state}_{a}*({seeds[a]})" for a in _active(formula) if seeds[a] != "0.0"]
    return " + ".join(terms) or "0.0"


# along the displacement and along the velocity at the end of a step
BY_X = Direction({"x0": "0.0", "x1": "1.0", "v0": "0.0", "v1": "0.0"}, "0.0", "0.0")
BY_V = Direction({"x0": "0.0", "x1": "0.0", "v0": "0.0", "v1": "1.0"}, "0.0", "0.0")
ROUNDS = 5  # of Newton's method inside its bracket
ROUNDS_WITH_KINKS = 9  # enough for a law of straight pieces, in 20,000 random steps between guesses 30 N off
# behind free play, whose slope changes a hundredfold as the force changes sign: guesses that were off by a fifth of the largest
# force left 8 % of it after five rounds and 0.5 % after nine
ROUNDS_WITH_PLAY = 14


def _rounds(layout: Layout) -> int:
    parts = [slot.part for slot in _inner(layout)]
    stretches = [slot.part.stretch for slot in layout.slots if slot.part.stretch]
    if any(isinstance(node, ast.Call) for stretch in stretches for node in ast.walk(stretch.tree)):
        return ROUNDS_WITH_PLAY
    slips = any("slip" in f.intrinsics() for p in parts for f in (p.advance, p.force_in_series) if f)
    formulas = [p.force_in_series for p in parts if p.force_in_series]
    branches = any(isinstance(node, ast.If) for f in formulas for node in ast.walk(f.tree))
    return ROUNDS_WITH_KINKS if slips or branches else ROUNDS


def law(layout: Layout) -> list[str]:
    """Lines for the law without a loop that ends by itself: from the force ``g0`` at the start and a guess ``g1`` they make
    ``raw``, the force at the end, its slopes ``fx`` and ``fv``, and the states e0, ...

    The root lies between a guess and what the parts would give under it, or as far beyond that where they may rise with the
    guess, by half of it at most; Newton's method stays in that bracket, which shrinks. Where it would leave, or its step is
    more than half of the last one, the bracket is halved.
    """
    lines = ["q = 1.0/dt", f"z0 = {_stretch(layout, 'g0')}", "f1 = g1", *_under_guess(layout)]
    end = "phi + (phi - f1)" if any(slot.part.rises_in_series for slot in _inner(layout)) else "phi"
    lines += [f"low, high = min(f1, {end}), max(f1, {end})", "step = (high - low) + (high - low)"]
    for _ in range(_rounds(layout)):
        lines += [
            "best = f1 + (phi - f1)/(1.0 - fg)",
            "best = best if low <= best and best <= high and abs(best - f1) <= 0.5*step else 0.5*(low + high)",
            "step = abs(best - f1)",
            "f1 = best",
            *_under_guess(layout),
            f"low, high = max(low, min(f1, {end})), min(high, max(f1, {end}))",
        ]
    states = [k for slot in _inner(layout) for k in slot.states.values()]
    place = layout.rate_state
    lines += ["last = (phi - f1)/(1.0 - fg)", "raw = f1 + last"]
    if place is not None:
        states.append(place)
        lines += [f"fg{place} = dz*q", f"e{place} = r"]
    lines += [f"e{k} = e{k} + fg{k}*last" for k in states]
    for way, out in ((BY_X, "fx"), (BY_V, "fv")):
        lines += [*way.lines(layout, out), f"{out} = {out}/(1.0 - fg)"]
        others = [f"{out}{k} + " if k != place else "" for k in states]
        lines += [f"{out}{k} = {direct}fg{k}*{out}" for k, direct in zip(states, others, strict=True)]
    return lines


def _under_guess(layout: Layout) -> list[str]:
    """Lines for ``phi``, the force of the parts under the guess f1, ``fg``, its slope by the guess, and the states there."""
    by_g = Direction({"x0": "0.0", "x1": "-dz", "v0": "0.0", "v1": "-dz*q"}, "0.0", "0.0")
    forces = [slot.part.force_in_series.name for slot in _inner(layout) if slot.part.force_in_series]
    return [
        f"z1 = {_stretch(layout, 'f1')}",
        f"dz = {_stretched(layout, 'f1', '1.0', '0.0')}",
        *_shrunk(layout, f"s[{layout.rate_state}]", "(z1 - z0)*q"),
        *_by_arguments(layout),
        "phi = " + " + ".join(f"{name}_value" for name in forces),
        *by_g.lines(layout, "fg"),
    ]


def _by_arguments(layout: Layout) -> list[str]:
    """Lines with the states at the end of a piece and all partial derivatives there, each computed once."""
    lines = []
    for slot in _inner(layout):
        places = INNER | slot.state_places("s[{}]") | slot.value_places()
        if slot.part.advance:
            formula, states = slot.part.advance, list(slot.states.values())
            targets = [f"e{k}" for k in states] + [f"{formula.name}{k}_{a}" for a in _active(formula) for k in states]
            lines.append(f"{', '.join(targets)} = {call(formula, places, suffix='_partials')}")
        if slot.part.force_in_series:
            formula = slot.part.force_in_series
            targets = [f"{formula.name}_value", *(f"{formula.name}_{a}" for a in _active(formula))]
            lines.append(
                f"{', '.join(targets)} = {call(formula, places | slot.state_places('e{}'), suffix='_partials')}"
            )
    return lines


def _towards(formula: Formula, places: dict[str, str], seeds: dict[str, str]) -> str:
    return call(formula, places, *(seeds[a] for a in _active(formula)), suffix="_towards")


def _stretched(layout: Layout, f: str, df: str, values: str) -> str:
    """The tangent of the whole stretch."""
    terms = []
    for slot in layout.slots:
        if slot.part.stretch:
            places = {"f": f} | slot.value_places()
            seeds = {"f": df} | slot.value_places(values)
            terms.append(f"{_towards(slot.part.stretch, places, seeds)}[1]")
    return " + ".join(terms)


def _by_force(layout: Layout) -> list[str]:
    """Lines for ``b`` = dPhi/dF and the tangents b0, ... of the states by F."""
    at_start = _past(layout, "0.0", "-dz*q") if layout.has_rate else "0.0"
    unit = Direction({"x0": "0.0", "x1": "-dz", "v0": at_start, "v1": "-dz*q"}, "0.0", "0.0")
    return [
        "q = 1.0/dt if dt > 0.0 else 0.0",
        f"dz = {_stretched(layout, 'f1', '1.0', '0.0')}",
        *unit.lines(layout, "b"),
    ]


def _slopes(layout: Layout) -> Function:
    lines = [
        *_solve_lines(layout),
        *_by_arguments(layout),
        *_by_force(layout),
        *BY_X.lines(layout, "h"),
        "fx = h/(1.0 - b)",
    ]
    lines += [*BY_V.lines(layout, "h"), "fv = h/(1.0 - b)"]
    for slot, formula in _outer_forces(layout):
        places = {"x": "x1", "v": "v1", "a": "0.0"} | slot.value_places()
        zeros = dict.fromkeys([*slot.values, "x", "v", "a"], "0.0")
        lines += [f"f{axis} += {_towards(formula, places, zeros | {axis: '1.0'})}[1]" for axis in "xv"]
    return Function("slopes", SIGNATURES["slopes"], [*lines, "return fx, fv"])


def _jacobian(layout: Layout) -> Function:
    lines = [f"for m in range({layout.width}):", f"    J[m] = D[{layout.force_state}, m]"]
    for slot, formula in _outer_forces(layout):
        places = {"x": "x", "v": "v", "a": "a"} | slot.value_places()
        zeros = dict.fromkeys([*slot.values, "x", "v", "a"], "0.0")
        lines += [f"J[{k}] += {_towards(formula, places, zeros | {name: '1.0'})}[1]" for name, k in slot.values.items()]
    return Function("jacobian", SIGNATURES["jacobian"], [*lines, "return"])


def _advance_tangents(layout: Layout) -> Function:
    last = layout.force_state
    unit = "(1.0 if m == {} else 0.0)"
    place = layout.rate_state
    at_start = _past(layout, "-D[{}, m]", "-c")
    any_way = Direction({"x0": "-c0", "x1": "-c1", "v0": at_start, "v1": "-c"}, "D[{}, m]", unit)
    loop = [
        f"c0 = {_stretched(layout, 'f0', f'D[{last}, m]', unit)}",
        f"c1 = {_stretched(layout, 'f1', '0.0', unit)}",
        "c = (c1 - c0)*q",
        *any_way.lines(layout, "h"),
        "df = h/(1.0 - b)",
    ]
    for slot in _inner(layout):
        loop += [f"D[{k}, m] = h{k} + b{k}*df" for k in slot.states.values()]
    loop += [f"D[{place}, m] = c + dz*q*df"] if place is not None else []
    loop.append(f"D[{last}, m] = df")
    lines = [
        *_solve_lines(layout),
        *_by_arguments(layout),
        *_by_force(layout),
        f"for m in range({layout.width}):",
    ]
    lines += ["    " + line for line in loop]
    return Function("advance_tangents", SIGNATURES["advance_tangents"], [*lines, *_store_lines(layout), "return"])
