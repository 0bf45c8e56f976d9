r"""The functions of a composition whose parts stand in series with something that stretches.

The parts feel the motion less the stretch, which the force itself makes:

.. math:: F_1 = \Phi(F_1), \qquad \Phi(F) = \sum_\text{parts} F_k\big(x_1 - z(F),\; v_1 - \frac{z(F) - z(F_0)}{\Delta t}\big)

Phi falls as F rises, wherever the parts resist the motion, so the equation has one root, no farther from F than F - Phi(F).
It is found by regula falsi with Illinois weights; derivatives are those of the implicit function. The force is a state, the
last one. A force that needs the acceleration acts beside the whole, at the outer end.

A part whose state follows its velocity (``v0`` in its ``advance``) needs the velocity at the start of the step too,
:math:`v_0 - \dot z_0`. The rate of the stretch at the end of the step before is a state then, the one before the force. Along
a path whose past is unknown there is none before the first step: that step takes the rate at its end for both ends.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from dampyr.models.codegen.formula import Formula, tangents

if TYPE_CHECKING:
    from dampyr.models.codegen.composition import Composition
    from dampyr.models.part import Part

FORCE = "series.f"
RATE = "series.rate"
UNKNOWN = 1e9  # m/s, faster than anything: the rate of the stretch where the past is unknown
MOTION = ("x0", "x1", "v0", "v1", "dt")


@dataclass(frozen=True)
class Slot:
    """A part with its places: states s[j], parameters p[i]."""

    part: Part
    states: dict[str, int]
    values: dict[str, int]


def follows_velocity(p: Part) -> bool:
    """Whether the states of the part follow its velocity, so that they need the one at the start of a step."""
    return p.advance is not None and "v0" in p.advance.arguments


def outside(p: Part) -> bool:
    """Whether the part acts beside the series, because its force needs the acceleration."""
    return p.force is not None and "a" in p.force.arguments


def slots(composition: Composition) -> Iterator[Slot]:
    """The parts in their order."""
    i, j = 0, 0
    for p in composition.parts:
        yield Slot(
            p,
            {n: j + k for k, n in enumerate(p.states)},
            {n: i + k for k, n in enumerate(p.parameters)},
        )
        i, j = i + len(p.parameters), j + len(p.states)


def sources(composition: Composition, site: int) -> list[str]:
    """The text of ``solve``, ``advance``, ``force``, ``slopes``, ``columns`` and ``spread``."""
    makers: list[Callable[[Composition], tuple[str, list[str]]]] = [_phi, _solve, _advance, _force, _slopes]
    makers += [_columns, _spread]
    return [_define(*maker(composition), site) for maker in makers]


def towards(p: Part) -> dict[str, str]:
    """The formulas of a part with their derivatives: along any direction, and by each argument."""
    texts = {}
    for formula in (p.force, p.stretch):
        if formula is not None:
            texts[_along(formula)] = tangents(formula, _along(formula), _active(formula), [None])
    for formula in (p.advance, p.force):
        if formula is not None:
            texts[_partials(formula)] = tangents(formula, _partials(formula), (), _active(formula))
    return texts


def _partials(formula: Formula) -> str:
    return f"{formula.name}_partials"


def _along(formula: Formula) -> str:
    return f"{formula.name}_towards"


def _active(formula: Formula) -> list[str]:
    return [a for a in formula.arguments if a != "dt"]


def _define(name: str, lines: list[str], site: int) -> str:
    head, _, arguments = name.partition("(")
    body = [line.replace("_SITE(", f"_{site}(") for line in lines]
    return "\n    ".join([f"def {head}_{site}({arguments}:", *body])


def _last(composition: Composition) -> int:
    return composition.n_states - 1


def rate(composition: Composition) -> int | None:
    """Where the rate of the stretch stands among the states, if a part needs it."""
    return composition.n_states - 2 if composition.keeps_rate else None


def _inner(composition: Composition) -> list[Slot]:
    return [slot for slot in slots(composition) if not outside(slot.part)]


def _stretch(composition: Composition, f: str) -> str:
    """The whole stretch under the force ``f``."""
    terms = []
    for slot in slots(composition):
        if slot.part.stretch:
            names = {"f": f} | {n: f"p[{k}]" for n, k in slot.values.items()}
            terms.append(f"{slot.part.stretch.name}({', '.join(names[a] for a in slot.part.stretch.arguments)})")
    return " + ".join(terms)


INNER = {"x0": "a0", "x1": "a1", "v0": "u0", "v1": "u1", "dt": "dt", "x": "a1", "v": "u1", "a": "0.0"}


def _shrunk(composition: Composition, at_start: str, at_end: str) -> list[str]:
    """Lines that leave in a0, a1, u0, u1 the motion less the stretch, and in r its rate, which is ``at_end``."""
    before = [f"u0 = v0 - {at_start}"] if composition.keeps_rate else []
    return ["a0, a1 = x0 - z0, x1 - z1", f"r = {at_end}", *before, "u1 = v1 - r"]


def _shrunk_in_kernel(composition: Composition) -> list[str]:
    past = _past(composition, "s[{}]", "0.0")
    return _shrunk(composition, _past(composition, "s[{}]", "r"), f"(z1 - z0)/dt if dt > 0.0 else {past}")


def _past(composition: Composition, form: str, unknown: str) -> str:
    """What ``form`` says of the rate of the stretch at the start of a step, or ``unknown`` where no step was before."""
    place = rate(composition)
    return unknown if place is None else f"({unknown} if s[{place}] >= {UNKNOWN} else {form.format(place)})"


def _ends(composition: Composition) -> list[str]:
    """Lines that put the states at the end of a piece into e0, e1, ..."""
    lines = []
    for slot in _inner(composition):
        if slot.part.advance:
            places = INNER | _states(slot, "s[{}]") | _values(slot)
            targets = ", ".join(f"e{k}" for k in slot.states.values())
            lines.append(f"{targets} = {_called(slot.part.advance, places)}")
    return lines


def _called(formula: Formula, places: dict[str, str], name: str = "") -> str:
    return f"{name or formula.name}({', '.join(places[a] for a in formula.arguments)})"


def _states(slot: Slot, form: str) -> dict[str, str]:
    return {n: form.format(k) for n, k in slot.states.items()}


def _values(slot: Slot) -> dict[str, str]:
    return {n: f"p[{k}]" for n, k in slot.values.items()}


def _phi(composition: Composition) -> tuple[str, list[str]]:
    terms = []
    for slot in _inner(composition):
        if slot.part.force:
            terms.append(_called(slot.part.force, INNER | _states(slot, "e{}") | _values(slot)))
    lines = [
        f"z1 = {_stretch(composition, 'f')}",
        *_shrunk_in_kernel(composition),
        *_ends(composition),
        f"return {' + '.join(terms)}",
    ]
    return "phi(s, z0, f, x0, x1, v0, v1, dt, p)", lines


def _solve(composition: Composition) -> tuple[str, list[str]]:
    phi = "phi_SITE(s, z0, {}, x0, x1, v0, v1, dt, p)"
    lines = f"""
f0 = s[{_last(composition)}]
if dt <= 0.0: return f0
z0 = {_stretch(composition, "f0")}
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
    return "solve(s, x0, x1, v0, v1, dt, p)", lines.strip().split("\n")


def _solve_lines(composition: Composition) -> list[str]:
    """Lines that find the force ``f1`` at the end of a piece, and the motion that is left."""
    return [
        f"f0 = s[{_last(composition)}]",
        "f1 = solve_SITE(s, x0, x1, v0, v1, dt, p)",
        f"z0 = {_stretch(composition, 'f0')}",
        f"z1 = {_stretch(composition, 'f1')}",
        *_shrunk_in_kernel(composition),
    ]


def _advance(composition: Composition) -> tuple[str, list[str]]:
    lines = [*_solve_lines(composition), *_ends(composition), *_store_lines(composition), "return"]
    return "advance(s, x0, x1, v0, v1, dt, p)", lines


def _store_lines(composition: Composition) -> list[str]:
    lines = []
    for slot in _inner(composition):
        lines += [f"s[{k}] = e{k}" for k in slot.states.values()]
    if (place := rate(composition)) is not None:
        lines.append(f"s[{place}] = r")
    return [*lines, f"s[{_last(composition)}] = f1"]


def _outer_forces(composition: Composition) -> list[tuple[Slot, Formula]]:
    return [(slot, slot.part.force) for slot in slots(composition) if slot.part.force and outside(slot.part)]


def _force(composition: Composition) -> tuple[str, list[str]]:
    places = {"x": "x", "v": "v", "a": "a"}
    terms = [f"s[{_last(composition)}]"]
    terms += [_called(formula, places | _values(slot)) for slot, formula in _outer_forces(composition)]
    return "force(s, x, v, a, p)", [f"return {' + '.join(terms)}"]


@dataclass(frozen=True)
class Direction:
    """Seeds of a derivative: expressions by what they are the tangent of."""

    motion: dict[str, str]
    states: str
    values: str

    def lines(self, composition: Composition, out: str) -> list[str]:
        """Lines that leave the tangents of the states in ``out0, ...`` and the one of Phi in ``out``."""
        lines, terms = [], []
        for slot in _inner(composition):
            seeds = (
                self.motion | _states(slot, self.states) | {n: self.values.format(k) for n, k in slot.values.items()}
            )
            if slot.part.advance:
                for k in slot.states.values():
                    lines.append(f"{out}{k} = {_sum(slot.part.advance, str(k), seeds)}")
            if slot.part.force:
                seeds |= _states(slot, out + "{}") | {"x": self.motion["x1"], "v": self.motion["v1"]}
                terms.append(_sum(slot.part.force, "", seeds))
        return [*lines, f"{out} = {' + '.join(terms)}"]


def _sum(formula: Formula, state: str, seeds: dict[str, str]) -> str:
    """The tangent of a formula from its partial derivatives, which stand under names of its own."""
    terms = [f"{formula.name}{state}_{a}*({seeds[a]})" for a in _active(formula) if seeds[a] != "0.0"]
    return " + ".join(terms) or "0.0"


ROUNDS = 5  # of Newton's method inside its bracket
ROUNDS_WITH_KINKS = 9  # enough for a law of straight pieces, in 20,000 random steps between guesses 30 N off


def _rounds(composition: Composition) -> int:
    parts = [slot.part for slot in _inner(composition)]
    slips = any("slip" in f.intrinsics() for p in parts for f in (p.advance, p.force) if f)
    branches = any(isinstance(node, ast.If) for p in parts if p.force for node in ast.walk(p.force.tree))
    return ROUNDS_WITH_KINKS if slips or branches else ROUNDS


def law(composition: Composition) -> list[str]:
    """Lines for the law without a loop that ends by itself: from the force ``g0`` at the start and a guess ``g1`` they make
    ``raw``, the force at the end, its slopes ``fx`` and ``fv``, and the states e0, ...

    The root lies between a guess and what the parts would give under it; Newton's method stays in that bracket, which
    shrinks. Where it would leave, or its step is more than half of the last one, the bracket is halved.
    """
    by_x = Direction({"x0": "0.0", "x1": "1.0", "v0": "0.0", "v1": "0.0"}, "0.0", "0.0")
    by_v = Direction({"x0": "0.0", "x1": "0.0", "v0": "0.0", "v1": "1.0"}, "0.0", "0.0")
    lines = ["q = 1.0/dt", f"z0 = {_stretch(composition, 'g0')}", "f1 = g1", *_under_guess(composition)]
    lines += ["low, high = min(f1, phi), max(f1, phi)", "step = (high - low) + (high - low)"]
    for _ in range(_rounds(composition)):
        lines += [
            "best = f1 + (phi - f1)/(1.0 - fg)",
            "best = best if low <= best and best <= high and abs(best - f1) <= 0.5*step else 0.5*(low + high)",
            "step = abs(best - f1)",
            "f1 = best",
            *_under_guess(composition),
            "low, high = max(low, min(f1, phi)), min(high, max(f1, phi))",
        ]
    states = [k for slot in _inner(composition) for k in slot.states.values()]
    place = rate(composition)
    lines += ["last = (phi - f1)/(1.0 - fg)", "raw = f1 + last"]
    if place is not None:
        states.append(place)
        lines += [f"fg{place} = dz*q", f"e{place} = r"]
    lines += [f"e{k} = e{k} + fg{k}*last" for k in states]
    for way, out in ((by_x, "fx"), (by_v, "fv")):
        lines += [*way.lines(composition, out), f"{out} = {out}/(1.0 - fg)"]
        own = [f"{out}{k} + " if k != place else "" for k in states]
        lines += [f"{out}{k} = {direct}fg{k}*{out}" for k, direct in zip(states, own, strict=True)]
    return lines


def _under_guess(composition: Composition) -> list[str]:
    """Lines for ``phi``, the force of the parts under the guess f1, ``fg``, its slope by the guess, and the states there."""
    by_g = Direction({"x0": "0.0", "x1": "-dz", "v0": "0.0", "v1": "-dz*q"}, "0.0", "0.0")
    forces = [slot.part.force.name for slot in _inner(composition) if slot.part.force]
    return [
        f"z1 = {_stretch(composition, 'f1')}",
        f"dz = {_stretched(composition, 'f1', '1.0', '0.0')}",
        *_shrunk(composition, f"s[{rate(composition)}]", "(z1 - z0)*q"),
        *_by_arguments(composition),
        "phi = " + " + ".join(f"{name}_value" for name in forces),
        *by_g.lines(composition, "fg"),
    ]


def _by_arguments(composition: Composition) -> list[str]:
    """Lines with the states at the end of a piece and all partial derivatives there, each computed once."""
    lines = []
    for slot in _inner(composition):
        places = INNER | _states(slot, "s[{}]") | _values(slot)
        if slot.part.advance:
            formula, own = slot.part.advance, list(slot.states.values())
            targets = [f"e{k}" for k in own] + [f"{formula.name}{k}_{a}" for a in _active(formula) for k in own]
            lines.append(f"{', '.join(targets)} = {_called(formula, places, _partials(formula))}")
        if slot.part.force:
            formula = slot.part.force
            targets = [f"{formula.name}_value", *(f"{formula.name}_{a}" for a in _active(formula))]
            lines.append(
                f"{', '.join(targets)} = {_called(formula, places | _states(slot, 'e{}'), _partials(formula))}"
            )
    return lines


def _towards(formula: Formula, places: dict[str, str], seeds: dict[str, str]) -> str:
    plain = [places[a] for a in formula.arguments]
    return f"{_along(formula)}({', '.join([*plain, *(seeds[a] for a in _active(formula))])})"


def _stretched(composition: Composition, f: str, df: str, values: str) -> str:
    """The tangent of the whole stretch."""
    terms = []
    for slot in slots(composition):
        if slot.part.stretch:
            places = {"f": f} | _values(slot)
            seeds = {"f": df} | {n: values.format(k) for n, k in slot.values.items()}
            terms.append(f"{_towards(slot.part.stretch, places, seeds)}[1]")
    return " + ".join(terms)


def _by_force(composition: Composition) -> list[str]:
    """Lines for ``b`` = dPhi/dF and the tangents b0, ... of the states by F."""
    at_start = _past(composition, "0.0", "-dz*q") if composition.keeps_rate else "0.0"
    unit = Direction({"x0": "0.0", "x1": "-dz", "v0": at_start, "v1": "-dz*q"}, "0.0", "0.0")
    return [
        "q = 1.0/dt if dt > 0.0 else 0.0",
        f"dz = {_stretched(composition, 'f1', '1.0', '0.0')}",
        *unit.lines(composition, "b"),
    ]


def _slopes(composition: Composition) -> tuple[str, list[str]]:
    by_x = Direction({"x0": "0.0", "x1": "1.0", "v0": "0.0", "v1": "0.0"}, "0.0", "0.0")
    by_v = Direction({"x0": "0.0", "x1": "0.0", "v0": "0.0", "v1": "1.0"}, "0.0", "0.0")
    lines = [
        *_solve_lines(composition),
        *_by_arguments(composition),
        *_by_force(composition),
        *by_x.lines(composition, "h"),
        "fx = h/(1.0 - b)",
    ]
    lines += [*by_v.lines(composition, "h"), "fv = h/(1.0 - b)"]
    for slot, formula in _outer_forces(composition):
        places = {"x": "x1", "v": "v1", "a": "0.0"} | _values(slot)
        zeros = dict.fromkeys([*slot.values, "x", "v", "a"], "0.0")
        lines += [f"f{axis} += {_towards(formula, places, zeros | {axis: '1.0'})}[1]" for axis in "xv"]
    return "slopes(s, x0, x1, v0, v1, dt, p)", [*lines, "return fx, fv"]


def _columns(composition: Composition) -> tuple[str, list[str]]:
    width = len(composition.parameters) + composition.n_states
    lines = [f"for m in range({width}):", f"    J[m] = D[{_last(composition)}, m]"]
    for slot, formula in _outer_forces(composition):
        places = {"x": "x", "v": "v", "a": "a"} | _values(slot)
        zeros = dict.fromkeys([*slot.values, "x", "v", "a"], "0.0")
        lines += [f"J[{k}] += {_towards(formula, places, zeros | {name: '1.0'})}[1]" for name, k in slot.values.items()]
    return "columns(s, D, x, v, a, p, J)", [*lines, "return"]


def _spread(composition: Composition) -> tuple[str, list[str]]:
    last = _last(composition)
    width = len(composition.parameters) + composition.n_states
    unit = "(1.0 if m == {} else 0.0)"
    place = rate(composition)
    at_start = _past(composition, "-D[{}, m]", "-c")
    any_way = Direction({"x0": "-c0", "x1": "-c1", "v0": at_start, "v1": "-c"}, "D[{}, m]", unit)
    loop = [
        f"c0 = {_stretched(composition, 'f0', f'D[{last}, m]', unit)}",
        f"c1 = {_stretched(composition, 'f1', '0.0', unit)}",
        "c = (c1 - c0)*q",
        *any_way.lines(composition, "h"),
        "df = h/(1.0 - b)",
    ]
    for slot in _inner(composition):
        loop += [f"D[{k}, m] = h{k} + b{k}*df" for k in slot.states.values()]
    loop += [f"D[{place}, m] = c + dz*q*df"] if place is not None else []
    loop.append(f"D[{last}, m] = df")
    lines = [
        *_solve_lines(composition),
        *_by_arguments(composition),
        *_by_force(composition),
        f"for m in range({width}):",
    ]
    lines += ["    " + line for line in loop]
    return "spread(s, D, x0, x1, v0, v1, dt, p)", [*lines, *_store_lines(composition), "return"]
