"""C99: one header and one source without dependencies but libm, for controllers and other simulations."""

from __future__ import annotations

import re
from pathlib import Path

from dampyr.errors import InputError
from dampyr.export.c_text import function, number
from dampyr.models import Constant, Damper, Interpolation, Law, Polynomial
from dampyr.models.damper import INPUTS

HISTORY = 4096  # samples that a delay looks back over: 4 s at 1 kHz, in 64 kB of state
EXPORTED = ("phi", "solve", "advance", "force")
ARRAYS = ("s", "p")


def write(damper: Damper, folder: Path, name: str, allow_extrapolation: bool = False) -> list[Path]:
    """Write ``name.h`` and ``name.c``; see the header for how to call it."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name):
        raise InputError(f"{name!r} cannot name a C function; use letters, digits and underscores, a letter first")
    for p in damper.composition.parts:
        if p.needs_acceleration:
            raise InputError(
                f"{p.name} needs the acceleration, which the C code is not given; export damper.without({p.name!r})"
            )
    k = damper.composition.lag
    if k is not None:
        tau = float(list(damper.all_laws.values())[k](damper.range[0]))
        raise InputError(
            "the C code takes the input, not its command; export damper.without('lag'), or with --without lag, and filter the "
            f"command u_c before: u' = (u_c - u)/{tau:.6g} s"
        )
    folder.mkdir(parents=True, exist_ok=True)
    header, source = folder / f"{name}.h", folder / f"{name}.c"
    header.write_text(_header(damper, name), encoding="utf-8")
    source.write_text(_source(damper, name, allow_extrapolation), encoding="utf-8")
    return [header, source]


def _header(damper: Damper, name: str) -> str:
    low, high = damper.range
    word = INPUTS[damper.input]
    delay = (
        f"\n    double late_t[{HISTORY}], late_f[{HISTORY}];\n    long late_n;" if damper.composition.has_delay else ""
    )
    guard = f"{name.upper()}_H"
    return f"""\
/* A damper written by dampyr: {damper.composition}.
 *
 * Units: s, m, m/s, {damper.input} ({word} at the coil), N. A positive force opposes a positive velocity.
 * Calibrated from {low:g} to {high:g} {damper.input}.
 *
 *     {name}_state d;
 *     double f0 = {name}_start(&d, t0, x0, v0, u0);
 *     double f1 = {name}_step(&d, t1, x1, v1, u1);    for each sample in turn, t rising
 *
 * The motion between two samples counts as straight in x. Outside its range the force is NAN (see {name}_in_range).
 */
#ifndef {guard}
#define {guard}

#ifdef __cplusplus
extern "C" {{
#endif

typedef struct {{
    double s[{max(damper.composition.n_states, 1)}];
    double t, x, v;{delay}
}} {name}_state;

int {name}_in_range(double u);
double {name}_start({name}_state *d, double t, double x, double v, double u);
double {name}_step({name}_state *d, double t, double x, double v, double u);

#ifdef __cplusplus
}}
#endif
#endif
"""


def _source(damper: Damper, name: str, allow_extrapolation: bool) -> str:
    prefix = f"{name}_"
    formulas = [f.tree for f in damper.composition.formulas()]
    whole = [f.tree() for f in damper.composition.functions() if f.name in EXPORTED]
    own = {tree.name for tree in (*formulas, *whole)}
    laws = [_law(law, f"{prefix}law_{k}", key) for k, (key, law) in enumerate(damper.all_laws.items())]
    functions = [function(tree, prefix, own) for tree in formulas]
    functions += [function(tree, prefix, own, ARRAYS) for tree in whole]
    return (
        "\n\n".join(
            [
                f'#include "{name}.h"\n#include <math.h>',
                *laws,
                _values(damper, prefix),
                *functions,
                _in_range(damper, prefix, allow_extrapolation),
                *([_late(damper, prefix)] if damper.composition.has_delay else []),
                _calls(damper, prefix),
            ]
        )
        + "\n"
    )


def _law(law: Law, function_name: str, key: str) -> str:
    if isinstance(law, Constant):
        body = ["    (void)u;", f"    return {number(law.value)};"]
    elif isinstance(law, Polynomial):
        text = number(law.coefficients[-1])
        for c in reversed(law.coefficients[:-1]):
            text = f"({number(c)} + u*{text})"
        body = [f"    return {text};"]
    elif isinstance(law, Interpolation):
        body = _interpolation(law)
    else:
        raise InputError(f"the law of {key}, {law!r}, has no C form; choose constant, polynomial or interpolation")
    return "\n".join([f"/* {key} */", f"static double {function_name}(double u)", "{", *body, "}"])


def _interpolation(law: Interpolation) -> list[str]:
    pieces = law.pieces.T
    rows = ", ".join("{" + ", ".join(number(c) for c in row) + "}" for row in pieces)
    knots = ", ".join(number(k) for k in law.knots[:-1])
    return [
        f"    static const double knot[] = {{{knots}}};",
        f"    static const double c[][4] = {{{rows}}};",
        f"    int k = {len(pieces) - 1};",
        "    while (k > 0 && u < knot[k]) k--;",
        "    u -= knot[k];",
        "    return c[k][0] + u*(c[k][1] + u*(c[k][2] + u*c[k][3]));",
    ]


def _values(damper: Damper, prefix: str) -> str:
    count = len(damper.composition.parameters)
    lines = [f"    p[{k}] = {prefix}law_{k}(u);" for k in range(count)]
    return "\n".join([f"static void {prefix}values(double u, double *p)", "{", *lines, "}"])


def _in_range(damper: Damper, prefix: str, allow_extrapolation: bool) -> str:
    low, high = damper.range
    slack = 1e-9 * max(abs(low), abs(high), 1.0)
    test = "isfinite(u)" if allow_extrapolation else f"u >= {number(low - slack)} && u <= {number(high + slack)}"
    return f"int {prefix}in_range(double u)\n{{\n    return {test};\n}}"


def _late(damper: Damper, prefix: str) -> str:
    """The delayed force, from the stored samples; NAN where the delay is longer than they reach back."""
    return f"""\
static double {prefix}late({prefix}state *d, double f, double tau)
{{
    long n = d->late_n++, k = n, oldest = n < {HISTORY} ? 0 : n - {HISTORY} + 1;
    double at = d->t - tau;
    d->late_t[n % {HISTORY}] = d->t;
    d->late_f[n % {HISTORY}] = f;
    while (k > oldest && d->late_t[k % {HISTORY}] > at) k--;
    if (d->late_t[k % {HISTORY}] > at) return oldest == 0 ? d->late_f[0] : NAN;
    if (k == n) return f;
    double t0 = d->late_t[k % {HISTORY}], t1 = d->late_t[(k + 1) % {HISTORY}];
    double part = (at - t0)/(t1 - t0);
    return d->late_f[k % {HISTORY}]*(1.0 - part) + d->late_f[(k + 1) % {HISTORY}]*part;
}}"""


def _calls(damper: Damper, prefix: str) -> str:
    composition = damper.composition
    result = "f" if composition.delay is None else f"{prefix}late(d, f, p[{composition.delay}])"
    empty = "" if composition.delay is None else "    d->late_n = 0;\n"
    count = len(composition.parameters)
    past = "".join(f"    d->s[{k}] = {number(value)};\n" for k, value in enumerate(composition.path0) if value)
    return f"""\
double {prefix}start({prefix}state *d, double t, double x, double v, double u)
{{
    double p[{count}], f;
    for (int k = 0; k < {max(composition.n_states, 1)}; k++) d->s[k] = 0.0;
{past}    d->t = t; d->x = x; d->v = v;
{empty}    if (!{prefix}in_range(u)) return NAN;
    {prefix}values(u, p);
    f = {prefix}force(d->s, x, v, 0.0, p);
    return {result};
}}

double {prefix}step({prefix}state *d, double t, double x, double v, double u)
{{
    double p[{count}], f;
    if (!{prefix}in_range(u) || !(t > d->t)) return NAN;
    {prefix}values(u, p);
    {prefix}advance(d->s, d->x, x, d->v, v, t - d->t, p);
    d->t = t; d->x = x; d->v = v;
    f = {prefix}force(d->s, x, v, 0.0, p);
    return {result};
}}"""
