"""The C of parts that stand in series with something that stretches: the equation of `dampyr.models.codegen.series`."""

from __future__ import annotations

from collections.abc import Callable

from dampyr.models import Composition
from dampyr.models.codegen.formula import Formula
from dampyr.models.codegen.series import INNER, UNKNOWN, rate, slots

Call = Callable[[Formula, dict[str, str]], str]


def functions(composition: Composition, prefix: str) -> list[str]:
    """``advance`` and ``force`` of the whole, and what they need."""

    def call(formula: Formula, places: dict[str, str]) -> str:
        return f"{prefix}{formula.name}({', '.join(places[a] for a in formula.arguments)})"

    return [_stretch(composition, prefix, call), _phi(composition, prefix, call), _advance(composition, prefix)]


def _stretch(composition: Composition, prefix: str, call: Call) -> str:
    terms = []
    for slot in slots(composition):
        if slot.part.stretch:
            terms.append(call(slot.part.stretch, {"f": "f"} | {n: f"p[{k}]" for n, k in slot.values.items()}))
    return f"static double {prefix}stretch(double f, const double *p)\n{{\n    return {' + '.join(terms)};\n}}"


def _phi(composition: Composition, prefix: str, call: Call) -> str:
    """What the parts push with under the force f, their states at the end of the piece left in e."""
    lines, terms = [], []
    for slot in slots(composition):
        places = INNER | {n: f"p[{k}]" for n, k in slot.values.items()}
        if slot.part.advance:
            begin = places | {n: f"s[{k}]" for n, k in slot.states.items()}
            first = next(iter(slot.states.values()))
            if len(slot.states) == 1:
                lines.append(f"    e[{first}] = {call(slot.part.advance, begin)};")
            else:
                lines.append(f"    {call(slot.part.advance, begin)[:-1]}, e + {first});")
        if slot.part.force:
            terms.append(call(slot.part.force, places | {n: f"e[{k}]" for n, k in slot.states.items()}))
    motion = "double x0, double x1, double v0, double v1, double dt"
    place = rate(composition)
    before, rate_lines = "", []
    if place is not None:
        before = f"u0 = v0 - (s[{place}] >= {UNKNOWN} ? r : s[{place}]), "
        rate_lines = [f"    e[{place}] = r;"]
    return "\n".join(
        [
            f"static double {prefix}phi(const double *s, double f, {motion}, const double *p, double *e)",
            "{",
            f"    double z0 = {prefix}stretch(s[{composition.n_states - 1}], p), z1 = {prefix}stretch(f, p);",
            f"    double a0 = x0 - z0, a1 = x1 - z1, r = (z1 - z0)/dt, {before}u1 = v1 - r;",
            "    (void)e; (void)a0; (void)v0; (void)u1;",
            *rate_lines,
            *lines,
            f"    return {' + '.join(terms)};",
            "}",
        ]
    )


def _advance(composition: Composition, prefix: str) -> str:
    last = composition.n_states - 1
    motion = "double x0, double x1, double v0, double v1, double dt"
    phi = f"{prefix}phi(s, {{}}, x0, x1, v0, v1, dt, p, e)"
    return f"""\
static void {prefix}advance(double *s, {motion}, const double *p)
{{
    double e[{last + 1}], f0 = s[{last}], g0 = f0 - {phi.format("f0")}, reach = g0, f = f0;
    double f1 = f0 - reach, g1 = f1 - {phi.format("f1")};
    for (int k = 0; g0 != 0.0 && g0*g1 > 0.0 && k < 60; k++) {{
        reach *= 2.0;
        f1 = f0 - reach;
        g1 = f1 - {phi.format("f1")};
    }}
    for (int k = 0; g0 != 0.0 && k < 200; k++) {{
        f = g1 != g0 ? f1 - g1*(f1 - f0)/(g1 - g0) : f1;
        double g = f - {phi.format("f")};
        if (fabs(g) <= 1e-13*fabs(f) + 1e-12) break;
        if (g*g1 < 0.0) {{ f0 = f1; g0 = g1; }} else g0 *= 0.5;
        f1 = f; g1 = g;
    }}
    {phi.format("f")};
    for (int k = 0; k < {last}; k++) s[k] = e[k];
    s[{last}] = f;
}}

static double {prefix}force(const double *s, double x, double v, const double *p)
{{
    (void)x; (void)v; (void)p;
    return s[{last}];
}}"""
