"""C99: a header and a source for controllers and simulations, double or single precision, with test vectors and a Makefile."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.export.c_law import law_files, libm_of
from dampyr.export.c_text import COMPOSED, DOUBLE, LIBM, SINGLE, Precision, extremes, function
from dampyr.findings import OF_DAMPER, handed_on
from dampyr.input_kinds import INPUTS, input_arguments
from dampyr.models import Constant, Damper, Interpolation, Polynomial
from dampyr.models import inverse as inverse_model
from dampyr.models.codegen.syntax_trees import statements_of
from dampyr.models.laws import Law
from dampyr.source_digest import full_version
from dampyr.structures.building import Building
from dampyr.structures.control_laws import describe_law, is_control_law, values_at
from dampyr.structures.controller import Controller, asks_force, design_controller
from dampyr.structures.raminelli_2020_building import two_storey
from dampyr.structures.supports import refuse_supports

Array = NDArray[np.float64]

HISTORY = 4096  # samples that a delay looks back over: 4 s at 1 kHz, in 64 kB of state
HISTORIES = (2, 1_000_000)
EXPORTED = ("phi", "solve", "advance", "force")
ARRAYS = ("s", "p")
WIDTH = 116  # characters of a line of a comment
VECTORS = 400  # samples of the path that the exported test replays
TOLERANCE = {DOUBLE: 1e-9, SINGLE: 1e-4}  # of the largest force: what the exported test allows
MET = {DOUBLE: inverse_model.TOLERANCE, SINGLE: 1e-5}  # of the largest force: what counts as the wanted one
# Arguments of the inverse's kernel; in C the laws are functions.
IN_PYTHON = {"knots", "coefficients", "work", "p", "kind"}


@dataclass(frozen=True)
class CSource:
    """A damper as C text: the header and the source, named ``name``; ``libm`` names the functions of math.h that are called."""

    name: str
    header: str
    source: str
    libm: tuple[str, ...]


def write(
    damper: Damper,
    folder: Path,
    name: str,
    allow_extrapolation: bool = False,
    *,
    single: bool = False,
    history: int = HISTORY,
    inverse: bool = False,
    control: Any = None,
    structure: Building | None = None,
    place: Any = 1,
) -> list[Path]:
    """Write ``name.h`` and ``name.c``, and what replays a path that dampyr computed: ``name_vectors.h``, ``name_test.c`` and a
    ``Makefile`` whose target ``test`` compiles and runs it.

    ``single`` writes ``float`` in the place of ``double``; ``history`` is the number of samples that a delay looks back over.
    ``inverse`` adds the functions that find the input of a wanted force (`dampyr.models.inverse`). ``control``, a control law
    for the damper at ``place`` of ``structure``, adds ``name_law.h`` and ``name_law.c``: its filter, states and decision; a
    law that asks for a force calls the inverse.
    """
    check_name(name)
    designed = design_exported(damper, control, structure, place)
    precision = SINGLE if single else DOUBLE
    follows = designed is not None and designed[0].formulas.asks_force
    c = c_source(damper, name, allow_extrapolation, precision, history, inverse or follows)
    texts = {
        f"{name}.h": c.header,
        f"{name}.c": c.source,
        f"{name}_vectors.h": _vectors(damper, name),
        f"{name}_test.c": _test_program(name, precision, damper.has_input, inverse or follows),
    }
    law_texts = {}
    if designed is not None:
        law_texts = law_files(*designed, damper, name, describe_law(control, damper.input), precision)
    libm = {name: bool(c.libm)} | ({f"{name}_law": libm_of(law_texts.values(), precision)} if law_texts else {})
    texts |= law_texts | {"Makefile": _makefile(libm, {f"{name}_law": name} if follows else {})}
    folder.mkdir(parents=True, exist_ok=True)
    for file, text in texts.items():
        (folder / file).write_text(text, encoding="utf-8")
    return [folder / file for file in texts]


def design_exported(
    damper: Damper, control: Any, structure: Building | None, place: Any
) -> tuple[Controller, Building] | None:
    """The controller that is written, with its building; None where there is no law."""
    if control is None:
        return None
    if not is_control_law(control):
        raise InputError(f"control is a {type(control).__name__}; give a law that dampyr.structures.control_law makes")
    building = two_storey() if structure is None else structure
    refuse_supports("the export of a law", building)
    values_at(control, damper.without("lag") if damper.composition.lag is not None else damper)
    static = [part.name for part in damper.composition.parts if part.static]
    if static and asks_force(control):
        raise InputError(
            f"{describe_law(control)} asks for a force without the static one, {static[0]}, which buildings leave out; export "
            f"damper.without({static[0]!r}), or with --without {static[0]}"
        )
    ideal = replace(control, sensors=())
    return design_controller(ideal, building, building.connection(place)[None], 0, summed=False), building


def check_name(name: str) -> None:
    """Raise :class:`InputError` for what cannot name a C function."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name):
        raise InputError(f"{name!r} cannot name a C function; use letters, digits and underscores, a letter first")


def before_use(damper: Damper) -> str:
    """What is wrong or in doubt in a damper, and its origin, as text that can stand in a comment of any language."""
    sentences = [f"Before you use it: {finding}." for finding in handed_on([damper], OF_DAMPER)]
    sentences += [f"Where it comes from: {origin}."] if (origin := damper.origin.in_words()) else []
    text = " ".join(" ".join(sentences).split())
    for mark, instead in (("*/", "* /"), ("\\", "/"), ('"', "'")):
        text = text.replace(mark, instead)
    return text


def check_exportable(damper: Damper, takes_command: bool = True) -> None:
    """Raise :class:`InputError` for a damper that needs more than its path and its input: at the coil, or where the code takes
    that its command."""
    for p in damper.composition.parts:
        if p.needs_acceleration:
            raise InputError(
                f"{p.name} needs the acceleration, which the exported code is not given; export damper.without({p.name!r})"
            )
    if damper.input_lag and not takes_command:
        raise InputError(
            "the inverse in C gives the input at the coil, not its command; export damper.without('lag'), or with --without "
            f"lag, and let what acts follow the command u_c: u' = (u_c - u)/{damper.input_lag:.6g} s"
        )


def c_source(
    damper: Damper,
    name: str,
    allow_extrapolation: bool = False,
    precision: Precision = DOUBLE,
    history: int = HISTORY,
    inverse: bool = False,
) -> CSource:
    """The C text of a damper; :class:`InputError` for one that has no C form, or with ``inverse`` no inverse, and for a
    ``history`` out of range."""
    check_exportable(damper, takes_command=not inverse)
    if inverse:
        inverse_model.check_invertible(damper)
    if isinstance(history, bool) or not HISTORIES[0] <= history <= HISTORIES[1]:
        raise InputError(
            f"history = {history} is not a valid number of samples; choose {HISTORIES[0]} to {HISTORIES[1]}"
        )
    source = _source(damper, name, allow_extrapolation, precision, history, inverse)
    calls = re.findall(rf"\b({'|'.join(LIBM)}){precision.suffix}\(", source)
    libm = tuple(called for called in LIBM if called in calls)
    return CSource(name, _header(damper, name, precision, history, libm, inverse), source, libm)


def _header(damper: Damper, name: str, precision: Precision, history: int, libm: tuple[str, ...], inverse: bool) -> str:
    real, late = precision.real, damper.composition.has_delay
    at_coil, outside, in_range, and_u, u_first, u = "", "", "", "", "", ("", "")
    lag = ""
    if damper.has_input:
        at_coil = f", {damper.input} ({INPUTS[damper.input]} at the coil)"
        outside = f" Outside its range the force is NAN (see {name}_in_range)."
        in_range = f"int {name}_in_range({real} u);\n"
        and_u, u_first, u = f", {real} u", f"{real} u, ", (", u0", ", u1")
    if damper.input_lag:
        at_coil = f", {damper.input} (command of the {INPUTS[damper.input]})"
        lag = f"\n    {real} command, acting;"
        outside += f"""
 * u is the command, which counts as straight between two samples; what acts on the damper, `acting`, follows it with a time
 * constant of {damper.input_lag:g} s, and is the command at the start."""
    delay = (
        f"\n    {real} late_dt[{history}], late_f[{history}];\n    long late_at, late_count;\n    int late_lost;"
        if late
        else ""
    )
    link = (
        f"Link with -lm: it calls {', '.join(called + precision.suffix for called in libm)}."
        if libm
        else "It needs no mathematics library."
    )
    look_back = (
        f" *\n * The delay looks back over {history} samples; where more lie inside it the force is NAN.\n"
        if late
        else ""
    )
    if inverse:
        look_back += INVERSE_COMMENT.format(name=name, real=real, tolerance=MET[precision])
    to_invert = INVERSE_DECLARATIONS.format(name=name, real=real) if inverse else ""
    guard = f"{name.upper()}_H"
    warned = "".join(f"\n * {line}" for line in wrap(before_use(damper), WIDTH))
    origin = f"\n *\n * {notice}." if (notice := damper.origin.notice) else ""
    return f"""\
/* A damper written by dampyr {full_version()}: {damper.composition}.{origin}
 *
 * Units: s, m, m/s{at_coil}, N. A positive force opposes a positive velocity.
 * The damper {damper.range_words}. {"Single" if precision == SINGLE else "Double"} precision. {link}{warned}
 *
 *     {name}_state d;
 *     {real} f0 = {name}_start(&d, t0, x0, v0{u[0]});
 *     {real} f1 = {name}_step(&d, t1, x1, v1{u[1]});         for each sample in turn, t rising
 *     {real} f1 = {name}_step_by(&d, dt, x1, v1{u[1]});      the same with the time since the last sample, which stays
 *                                                        exact however long it runs
 *
 * The motion between two samples counts as straight in x.{outside}
{look_back} */
#ifndef {guard}
#define {guard}

#ifdef __cplusplus
extern "C" {{
#endif

typedef struct {{
    {real} s[{max(damper.composition.n_states, 1)}];
    {real} t, x, v;{lag}{delay}
}} {name}_state;

{in_range}{real} {name}_start({name}_state *d, {real} t, {real} x, {real} v{and_u});
{real} {name}_step({name}_state *d, {real} t, {real} x, {real} v{and_u});
{real} {name}_step_by({name}_state *d, {real} dt, {real} x, {real} v{and_u});
void {name}_parameters({u_first}{real} *p);
{to_invert}
#ifdef __cplusplus
}}
#endif
#endif
"""


INVERSE_COMMENT = """\
 *
 * The input that gives a wanted force at the end of a step, between g.low and g.high (at first the calibrated range):
 *
 *     {name}_inverse g; {name}_inverse_start(&g);
 *     {real} u = {name}_inverse_find(&g, &d, dt, x1, v1, wanted);     d stays; NAN for bounds outside the range
 *     {real} f = {name}_step_by(&d, dt, x1, v1, u);                   with the input that was applied
 *
 * g.f is its force; g.reason is 0 where that is the wanted one to {tolerance:g} of the largest, else the nearest: 1 the wanted
 * force has the wrong sign, 2 is above the largest, 3 below the smallest magnitude, 4 in a jump of the force.
 * g.monotone is 0 where the force rises and falls over the input; of several inputs the one nearest to the last g.u is taken.
"""

INVERSE_DECLARATIONS = """
typedef struct {{
    {real} low, high, u, f;
    int reason, monotone;
}} {name}_inverse;

void {name}_inverse_start({name}_inverse *g);
{real} {name}_inverse_find({name}_inverse *g, const {name}_state *d, {real} dt, {real} x, {real} v, {real} wanted);
"""


def function_trees(damper: Damper) -> tuple[list[ast.FunctionDef], list[ast.FunctionDef]]:
    """The formulas of a damper's parts, and the functions of the whole that call them, which any language exports."""
    composition = damper.composition
    return (
        [formula.tree for formula in composition.formulas()],
        [formula.tree() for formula in composition.functions() if formula.name in EXPORTED],
    )


def _source(
    damper: Damper, name: str, allow_extrapolation: bool, precision: Precision, history: int, inverse: bool
) -> str:
    prefix = f"{name}_"
    formulas, whole = function_trees(damper)
    names = {tree.name for tree in (*formulas, *whole)}
    functions = [function(tree, prefix, names, precision=precision) for tree in formulas]
    functions += [function(tree, prefix, names, ARRAYS, precision) for tree in whole]
    search = _search(prefix, precision) if inverse else ""
    text = "\n".join([*functions, search])
    helpers = extremes(text, prefix, precision)
    helpers += [COMPOSITION[name].replace("PREFIX", prefix) for name in COMPOSED if f"{prefix}{name}(" in text]
    return (
        "\n\n".join(
            [
                *([f"/* {notice}. */"] if (notice := damper.origin.notice) else []),
                f'#include "{name}.h"\n#include <math.h>',
                *parameter_functions(damper, prefix, precision),
                *helpers,
                *functions,
                *([range_function(damper, prefix, allow_extrapolation, precision)] if damper.has_input else []),
                *([_late(prefix, precision, history)] if damper.composition.has_delay else []),
                _calls(damper, prefix, precision),
                *([_inverse(damper, prefix, precision, search)] if inverse else []),
            ]
        )
        + "\n"
    )


COMPOSITION = {
    "expm1": """\
static float PREFIXexpm1(float x)
{
    float y = expf(x);
    if (y == 1.0f) return x;
    return y - 1.0f == -1.0f ? -1.0f : (y - 1.0f)*x/logf(y);
}""",
    "log1p": """\
static float PREFIXlog1p(float x)
{
    float y = 1.0f + x;
    return y == 1.0f ? x : logf(y)*x/(y - 1.0f);
}""",
}  # W. Kahan's, to a few units of the last digit


def parameter_functions(damper: Damper, prefix: str, precision: Precision = DOUBLE) -> list[str]:
    """The laws, one function each where there is an input, and the function that fills all parameters."""
    laws = list(damper.all_laws.items()) if damper.has_input else []
    functions = [_law(law, f"{prefix}law_{k}", key, precision) for k, (key, law) in enumerate(laws)]
    return [*functions, _values(damper, prefix, precision)]


def _law(law: Law, function_name: str, key: str, precision: Precision) -> str:
    number, real = precision.number, precision.real
    if isinstance(law, Constant):
        body = ["    (void)u;", f"    return {number(law.value)};"]
    elif isinstance(law, Polynomial):
        text = number(law.coefficients[-1])
        for c in reversed(law.coefficients[:-1]):
            text = f"({number(c)} + u*{text})"
        body = [*(["    (void)u;"] if "u" not in text else []), f"    return {text};"]
    elif isinstance(law, Interpolation):
        body = _interpolation(law, precision)
    else:
        raise InputError(f"the law of {key}, {law!r}, has no C form; choose constant, polynomial or interpolation")
    return "\n".join([f"/* {key} */", f"static {real} {function_name}({real} u)", "{", *body, "}"])


def _interpolation(law: Interpolation, precision: Precision) -> list[str]:
    pieces, number, real = law.pieces.T, precision.number, precision.real
    rows = ", ".join("{" + ", ".join(number(c) for c in row) + "}" for row in pieces)
    knots = ", ".join(number(k) for k in law.knots[:-1])
    return [
        f"    static const {real} knot[] = {{{knots}}};",
        f"    static const {real} c[][4] = {{{rows}}};",
        f"    int k = {len(pieces) - 1};",
        "    while (k > 0 && u < knot[k]) k--;",
        "    u -= knot[k];",
        "    return c[k][0] + u*(c[k][1] + u*(c[k][2] + u*c[k][3]));",
    ]


def _values(damper: Damper, prefix: str, precision: Precision) -> str:
    real, laws = precision.real, damper.all_laws
    head = f"/* {', '.join(laws)} */"
    if not damper.has_input:
        lines = [f"    p[{k}] = {precision.number(float(value))};" for k, value in enumerate(damper.values(0.0))]
        return "\n".join([head, f"void {prefix}parameters({real} *p)", "{", *lines, "}"])
    lines = [f"    p[{k}] = {prefix}law_{k}(u);" for k in range(len(laws))]
    return "\n".join([head, f"void {prefix}parameters({real} u, {real} *p)", "{", *lines, "}"])


def range_function(damper: Damper, prefix: str, allow_extrapolation: bool, precision: Precision = DOUBLE) -> str:
    """The function that says whether an input is in the calibrated range."""
    low, high = damper.range
    slack = (1e-9 if precision == DOUBLE else 1e-6) * max(abs(low), abs(high), 1.0)
    limits = f"u >= {precision.number(low - slack)} && u <= {precision.number(high + slack)}"
    test = "isfinite(u)" if allow_extrapolation else limits
    return f"int {prefix}in_range({precision.real} u)\n{{\n    return {test};\n}}"


def _late(prefix: str, precision: Precision, history: int) -> str:
    """The delayed force, from the stored samples; NAN where the delay is longer than they reach back.

    It adds up the times between the samples, backwards from the newest, so that a long run loses no digits.
    """
    real, one, zero = precision.real, precision.number(1.0), precision.number(0.0)
    return f"""\
static {real} {prefix}late({prefix}state *d, {real} f, {real} dt, {real} tau)
{{
    long at = d->late_count ? (d->late_at + 1) % {history} : 0, k = at;
    {real} age = {zero};
    d->late_at = at;
    d->late_dt[at] = dt;
    d->late_f[at] = f;
    if (d->late_count < {history}) d->late_count++; else d->late_lost = 1;
    if (!(tau > {zero})) return f;
    for (long n = 1; n < d->late_count; n++) {{
        long before = (k + {history} - 1) % {history};
        age += d->late_dt[k];
        if (age >= tau) {{
            {real} part = (age - tau)/d->late_dt[k];
            return d->late_f[before]*({one} - part) + d->late_f[k]*part;
        }}
        k = before;
    }}
    if (d->late_lost) return ({real})NAN;
    return d->late_f[k];
}}"""


def _calls(damper: Damper, prefix: str, precision: Precision) -> str:
    composition, real, zero = damper.composition, precision.real, precision.number(0.0)
    late = composition.delay is not None
    first, later = (f"{prefix}late(d, f, {dt}, p[{composition.delay}])" if late else "f" for dt in (zero, "dt"))
    empty = "    d->late_at = 0; d->late_count = 0; d->late_lost = 0;\n" if late else ""
    count = len(composition.parameters)
    past = "".join(f"    d->s[{k}] = {precision.number(v)};\n" for k, v in enumerate(composition.path0) if v)
    declared, passed, first_u, refused, outside, begun, followed = "", "", "", "", "", "", ""
    if damper.has_input:
        declared, passed, first_u = f", {real} u", ", u", "u, "
        refused = f"    if (!{prefix}in_range(u)) return ({real})NAN;\n"
        outside = f"!{prefix}in_range(u) || "
    if damper.input_lag:
        first_u = "d->acting, "
        begun = "    d->command = u; d->acting = u;\n"
        followed = _follow(damper.input_lag, precision)
    return f"""\
{real} {prefix}start({prefix}state *d, {real} t, {real} x, {real} v{declared})
{{
    {real} p[{count}], f;
    for (int k = 0; k < {max(composition.n_states, 1)}; k++) d->s[k] = {zero};
{past}    d->t = t; d->x = x; d->v = v;
{empty}{refused}{begun}    {prefix}parameters({first_u}p);
    f = {prefix}force(d->s, x, v, {zero}, p);
    return {first};
}}

{real} {prefix}step_by({prefix}state *d, {real} dt, {real} x, {real} v{declared})
{{
    {real} p[{count}], f;
    if ({outside}!(dt > {zero})) return ({real})NAN;
{followed}    {prefix}parameters({first_u}p);
    {prefix}advance(d->s, d->x, x, d->v, v, dt, p);
    d->t += dt; d->x = x; d->v = v;
    f = {prefix}force(d->s, x, v, {zero}, p);
    return {later};
}}

{real} {prefix}step({prefix}state *d, {real} t, {real} x, {real} v{declared})
{{
    {real} f = {prefix}step_by(d, t - d->t, x, v{passed});
    if (f == f) d->t = t;
    return f;
}}"""


def _follow(tau: float, precision: Precision) -> str:
    """The lines that let the acting input follow the command u, straight over the step: `dampyr.models.input_lag`'s step."""
    real, number = precision.real, precision.number(tau)
    return f"""\
    {{
        {real} rise = (u - d->command)/dt*{number};
        d->acting = u - rise + (d->acting - d->command + rise)*exp{precision.suffix}(-dt/{number});
        d->command = u;
    }}
"""


class _Less(ast.NodeTransformer):
    """Leaves out the arguments that the kernel of the inverse needs in Python only, where it takes and where it hands them."""

    def visit_arguments(self, node: ast.arguments) -> ast.arguments:
        node.args = [each for each in node.args if each.arg not in IN_PYTHON]
        return node

    def visit_Call(self, node: ast.Call) -> ast.Call:
        self.generic_visit(node)
        node.args = [each for each in node.args if not (isinstance(each, ast.Name) and each.id in IN_PYTHON)]
        return node


def _search(prefix: str, precision: Precision) -> str:
    """The search of the inverse, which dampyr runs itself."""
    names = {"force_under_input", *(each.__name__ for each in inverse_model.SEARCH)}
    texts = []
    for each in inverse_model.SEARCH:
        tree = statements_of(inspect.getsource(each)).body[0]
        assert isinstance(tree, ast.FunctionDef)
        tree.body = tree.body[1:]  # without the docstring
        texts.append(function(_Less().visit(tree), prefix, names, ("s", "nodes", "out"), precision))
    return "\n\n".join(texts)


def _inverse(damper: Damper, prefix: str, precision: Precision, search: str) -> str:
    """The search over the input, whose nodes lie in the calibrated range."""
    composition, real, number = damper.composition, precision.real, precision.number
    zero, states, (low, high) = number(0.0), max(composition.n_states, 1), damper.range
    nodes = ", ".join(number(u) for u in inverse_model.nodes(damper, low, high))
    return f"""\
static {real} {prefix}force_under_input({real} u, const {real} *s, {real} x0, {real} x1, {real} v0, {real} v1, {real} dt)
{{
    {real} p[{len(composition.parameters)}], w[{states}];
    for (int k = 0; k < {states}; k++) w[k] = s[k];
    {prefix}parameters(u, p);
    if (dt > {zero}) {prefix}advance(w, x0, x1, v0, v1, dt, p);
    return {prefix}force(w, x1, v1, {zero}, p);
}}

{search}

void {prefix}inverse_start({prefix}inverse *g)
{{
    g->low = {number(low)}; g->high = {number(high)}; g->u = g->low;
    g->f = {zero}; g->reason = 0; g->monotone = 1;
}}

{real} {prefix}inverse_find({prefix}inverse *g, const {prefix}state *d, {real} dt, {real} x, {real} v, {real} wanted)
{{
    static const {real} nodes[] = {{{nodes}}};
    {real} out[4];
    if (!{prefix}in_range(g->low) || !{prefix}in_range(g->high) || !(g->low <= g->high)) return ({real})NAN;
    if (!(dt >= {zero}) || !isfinite(wanted)) return ({real})NAN;
    {prefix}find_input(wanted, g->u, g->low, g->high, {number(MET[precision])}, nodes, d->s, d->x, x, d->v, v, dt, out);
    g->u = out[0]; g->f = out[1];
    g->reason = (int)out[2]; g->monotone = (int)out[3];
    return g->u;
}}"""


def replayed_path(damper: Damper, samples: int = VECTORS) -> tuple[Array, Array, Array, Array, Array]:
    """A path ``(t, x, v, u, f)`` in s, m, m/s, V or A, and N, with an input that varies over the calibrated range, 0 without.

    Its displacement and its velocity stay within those that the damper was calibrated on.
    """
    t = np.linspace(0.0, 2.0, samples)
    phase = 2.0 * np.pi * (0.5 * t + 0.6 * t**2)
    amplitude = min(0.008, 0.9 * damper.ranges.get("displacement", (0.0, np.inf))[1])
    v = amplitude * 2.0 * np.pi * (0.5 + 1.2 * t) * np.cos(phase)
    slower = max(1.0, float(np.max(np.abs(v))) / (0.9 * damper.ranges.get("velocity", (0.0, np.inf))[1]))
    t, x, v = slower * t, amplitude * np.sin(phase), v / slower
    low, high = damper.range
    u = 0.5 * (low + high) + 0.5 * (high - low) * np.sin(2.0 * np.pi * 0.7 * t / slower)
    return t, x, v, u, damper.force(t, x, velocity=v, **input_arguments(damper.input, u))


def _vectors(damper: Damper, name: str) -> str:
    columns = dict(zip(("t", "x", "v", "u", "f"), replayed_path(damper), strict=True))
    if not damper.has_input:
        del columns["u"]
    units = {"t": "s", "x": "m", "v": "m/s", "u": damper.input, "f": "N, by dampyr"}
    arrays = [
        f"static const double {name}_{key}[{VECTORS}] = {{ /* {units[key]} */\n"
        + ",\n".join("    " + ", ".join(repr(float(v)) for v in row) for row in values.reshape(-1, 8))
        + "\n};"
        for key, values in columns.items()
    ]
    return "\n\n".join(
        [f"/* A path, and the force of the damper on it. */\n#define {name.upper()}_VECTORS {VECTORS}", *arrays, ""]
    )


def _test_program(name: str, precision: Precision, has_input: bool, inverse: bool) -> str:
    """With the inverse it also asks, before each step, for the input of the force that the step gives."""
    real, tolerance = precision.real, TOLERANCE[precision]
    arguments = ", ".join(f"({real}){name}_{key}[k]" for key in ("x", "v", "u")[: 2 + has_input])
    begun, searched = "", ""
    if inverse:
        begun = f"\n    {name}_inverse g;\n    {name}_inverse_start(&g);"
        searched = f"""\
        if (k) {{
            {name}_state e = d;
            double lack, wanted = {name}_f[k];
            {real} u = {name}_inverse_find(&g, &d, dt, ({real}){name}_x[k], ({real}){name}_v[k], ({real})wanted);
            lack = (double){name}_step_by(&e, dt, ({real}){name}_x[k], ({real}){name}_v[k], u) - wanted;
            if (lack < 0.0) lack = -lack;
            if (!(lack <= off)) off = lack;
        }}
"""
    return f"""\
/* Replays {name}_vectors.h: exit status 1 where the force is off by more than {tolerance:g} of its largest. */
#include "{name}.h"
#include "{name}_vectors.h"
#include <stdio.h>

int main(void)
{{
    {name}_state d;
    double largest = 0.0, off = 0.0;{begun}
    for (int k = 0; k < {name.upper()}_VECTORS; k++) {{
        {real} dt = k ? ({real})({name}_t[k] - {name}_t[k - 1]) : ({real})0;
{searched}        double f = (double)(k ? {name}_step_by(&d, dt, {arguments})
                              : {name}_start(&d, ({real}){name}_t[0], {arguments}));
        double expected = {name}_f[k], gap = f > expected ? f - expected : expected - f;
        double size = expected > 0.0 ? expected : -expected;
        if (!(gap <= off)) off = gap;
        if (size > largest) largest = size;
    }}
    printf("{name}: largest difference %.3g of the largest force, allowed {tolerance:g}\\n", off/largest);
    return !(off <= {tolerance:g}*largest);
}}
"""


def _makefile(libm: Mapping[str, bool], calls: Mapping[str, str]) -> str:
    """``libm``: what has a test, such as ``damper``, and whether it needs the mathematics library; ``calls``: which of them
    calls which other."""
    tests = [f"{name}_test" for name in libm]
    rules = []
    for name, needed in libm.items():
        called = calls.get(name)
        headers, sources = f"{name}.h {name}_vectors.h", f"{name}_test.c {name}.c"
        if called:
            headers, sources = f"{headers} {called}.h", f"{sources} {called}.c"
        link = " -lm" if needed or (called and libm[called]) else ""
        rules.append(f"{name}_test: {sources} {headers}\n\t$(CC) $(CFLAGS) {sources} -o $@{link}\n\n")
    runs = "".join(f"\t./{test}\n" for test in tests)
    return f"""\
CC ?= cc
CFLAGS ?= -std=c99 -O2 -Wall -Wextra -Wconversion -Wdouble-promotion -pedantic

.PHONY: test clean
test: {" ".join(tests)}
{runs}
{"".join(rules)}clean:
\trm -f {" ".join(tests)}
"""
