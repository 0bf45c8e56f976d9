"""A control law in C99: its filter, states and decision as one function, with samples that dampyr decided on to test it by."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from textwrap import wrap

import numpy as np
from numpy.typing import NDArray

from dampyr.export.c_text import LIBM, Precision, extremes, function
from dampyr.input_kinds import input_arguments
from dampyr.models import Damper
from dampyr.models.codegen.formula import Formula, read
from dampyr.source_digest import full_version
from dampyr.structures.building import Building
from dampyr.structures.control_laws import lag_of
from dampyr.structures.controller import Controller, ControllerRun
from dampyr.structures.sensors import MEASURES, VECTORS
from dampyr.structures.wanted_force import inverse_of

Array = NDArray[np.float64]
VECTORS_OF_A_LAW = 300  # samples that the exported test replays
AGREE = {"double": 1e-10, "float": 1e-4}  # of the range of the input: what the exported test allows
AGREE_AT_A_TURN = {"double": 2e-5, "float": 1e-3}  # where a force is looked for: its turning points are found to 1e-5
WIDTH = 116  # characters of a line of a comment


def law_files(
    controller: Controller, building: Building, damper: Damper, name: str, described: str, precision: Precision
) -> dict[str, str]:
    """The texts of ``name_law.h`` and ``.c``, and of what tests them, by the names of the files.

    ``controller`` has its measures one by one (``summed=False`` of `dampyr.structures.controller.design_controller`); its
    sensors are the real ones of whoever calls the C, so that their noise and delay are left out. A law that asks for a force
    calls the inverse of the ``damper``, whose C is ``name.h``.
    """
    return {
        f"{name}_law.h": _header(controller, building, name, described, precision),
        f"{name}_law.c": _source(controller, damper, name, precision),
        f"{name}_law_vectors.h": _vectors(controller, damper, name),
        f"{name}_law_test.c": _test_program(controller, name, precision),
    }


def libm_of(texts: Iterable[str], precision: Precision) -> bool:
    """Whether one of the texts calls the mathematics library."""
    return any(re.search(rf"\b({'|'.join(LIBM)}){precision.suffix}\(", text) for text in texts)


def _header(controller: Controller, building: Building, name: str, described: str, precision: Precision) -> str:
    real, law, guard = precision.real, controller.law, f"{name.upper()}_LAW_H"
    inputs = "\n".join(f" *     y[{k}]  {what}" for k, what in enumerate(_inputs(controller, building)))
    asks = controller.formulas.asks_force
    include = f'\n#include "{name}.h"\n' if asks else ""
    model = MODEL_OF_A_LAW.format(name=name, real=real) if asks else ""
    reason = REASON_OF_A_LAW if asks else ""
    about = "\n".join(f" * {line}" for line in wrap(f"The control law {described} of {building.name}", WIDTH))
    return f"""\
/* A control law written by dampyr {full_version()}.
{about}.
 *
 *     {name}_law g;
 *     {name}_law_start(&g);
 *     {real} u = {name}_law_decide(&g, y);       every {law.period:g} s; the input is held between
 *
 * u is the command to the coil, {law.low:g} to {law.high:g};{reason} what is measured:
 *
{inputs}
 */
#ifndef {guard}
#define {guard}
{include}
#ifdef __cplusplus
extern "C" {{
#endif

#define {name.upper()}_LAW_PERIOD {precision.number(law.period)} /* s */
#define {name.upper()}_LAW_INPUTS {max(len(controller.rows), 1)}

typedef struct {{
    {real} x[{max(len(controller.F), 1)}]; /* memory of its filter */
    {real} q[{max(len(controller.formulas.states), 1)}]; /* states */{model}
}} {name}_law;

void {name}_law_start({name}_law *g);
{real} {name}_law_decide({name}_law *g, const {real} *y);

#ifdef __cplusplus
}}
#endif
#endif
"""


REASON_OF_A_LAW = """ its damper's own model finds it for the force that
 * the law wants. g.found.reason is 0 where that force is met, else what keeps it from being so (see the inverse there);"""
MODEL_OF_A_LAW = """
    {name}_state model; /* of the damper, which follows the measured stroke and rate */
    {name}_inverse found; /* the input of the wanted force, and why it is not met */
    {real} level, command; /* at the coil, and its latest command */
    int begun;"""


def _inputs(controller: Controller, building: Building) -> list[str]:
    """What each number of y is, in words."""
    lines = []
    for name, size in controller.sizes:
        measure = MEASURES[name]
        places = [f", floor {label}" for label in building.floors] if name in VECTORS else [""]
        if name == "state":
            places = [f", {what} {k + 1}" for what in ("displacement", "velocity") for k in range(size // 2)]
        lines += [f"{measure.about}{place} [{measure.unit}]" for place in places[:size]]
    return lines


def _source(controller: Controller, damper: Damper, name: str, precision: Precision) -> str:
    prefix = f"{name}_law_"
    formulas = [formula for formula in (controller.formulas.update, controller.formulas.decide) if formula is not None]
    trees = []
    for formula in formulas:
        trees += [read(called, inner).tree for inner, called in formula.intrinsics().items()]
        trees.append(read(getattr(controller.module, formula.name), f"{formula.name}_by").tree)
    names = {tree.name for tree in trees}
    functions = list(dict.fromkeys(function(tree, prefix, names, precision=precision) for tree in trees))
    helpers = extremes("\n".join(functions), prefix, precision)
    head = f'#include "{name}_law.h"\n#include <math.h>'
    return (
        "\n\n".join(
            [
                head,
                *helpers,
                *functions,
                _start(controller, name, precision),
                _decide(controller, damper, name, precision),
            ]
        )
        + "\n"
    )


def _start(controller: Controller, name: str, precision: Precision) -> str:
    lines = [f"    g->x[{k}] = {precision.number(0.0)};" for k in range(max(len(controller.F), 1))]
    states = controller.formulas.states or (0.0,)
    lines += [f"    g->q[{k}] = {precision.number(value)};" for k, value in enumerate(states)]
    if controller.formulas.asks_force:
        lines += [f"    {name}_inverse_start(&g->found);", "    g->begun = 0;"]
    return "\n".join([f"void {name}_law_start({name}_law *g)", "{", *lines, "}"])


def _find(controller: Controller, damper: Damper, name: str, precision: Precision) -> list[str]:
    """The lines that turn the wanted force u into an input, as `dampyr.structures.wanted_force.FollowedInverse` does."""
    number, law = precision.number, controller.law
    x, v = (f"s{k}" for k in controller.formulas.stroke_and_rate)
    lag = lag_of(law, damper)
    left, low, high, period = (
        number(value) for value in (float(np.exp(-law.period / lag)) if lag else 0.0, law.low, law.high, law.period)
    )
    return [
        "    if (g->begun) {",
        f"        g->level = g->command + (g->level - g->command)*{left};",
        f"        if (g->level < {low}) g->level = {low};",
        f"        if (g->level > {high}) g->level = {high};",
        f"        (void){name}_step_by(&g->model, {period}, {x}, {v}, g->level);",
        "    } else {",
        f"        g->level = {low};",
        f"        (void){name}_start(&g->model, {number(0.0)}, {x}, {v}, {low});",
        "        g->begun = 1;",
        "    }",
        f"    g->found.low = {low} + (g->level - {low})*{left};",
        f"    g->found.high = {high} + (g->level - {high})*{left};",
        "    g->found.u = g->level;",
        f"    u = {name}_inverse_find(&g->found, &g->model, {period}, {x} + {period}*{v}, {v}, u);",
        f"    u = (u - g->level*{left})/({number(1.0)} - {left});",
        f"    if (u < {low}) u = {low};",
        f"    if (u > {high}) u = {high};",
        "    g->command = u;",
    ]


def _decide(controller: Controller, damper: Damper, name: str, precision: Precision) -> str:
    real, prefix = precision.real, f"{name}_law_"
    signals = controller.formulas.signals
    terms = [*(f"g->x[{k}]" for k in range(len(controller.F))), *(f"y[{c}]" for c in range(len(controller.rows)))]
    lines = []
    if "y[" not in "".join(terms):
        lines.append("    (void)y;")
    for k, row in enumerate(np.hstack([controller.of_memory, controller.of_measured])):
        lines.append(f"    const {real} s{k} = {_sum(row, terms, precision)}; /* {signals[k]} */")
    lines.append(f"    {real} u;")
    if controller.formulas.update is not None:
        call = f"{prefix}update_by({_arguments(controller, controller.formulas.update, precision)}, q)"
        copied = " ".join(f"g->q[{k}] = q[{k}];" for k in range(len(controller.formulas.states)))
        lines.append(f"    {{ {real} q[{len(controller.formulas.states)}]; {call}; {copied} }}")
    lines.append(f"    u = {prefix}decide_by({_arguments(controller, controller.formulas.decide, precision)});")
    if controller.formulas.asks_force:
        lines += _find(controller, damper, name, precision)
    memory = [f"            {_sum(row, terms, precision)}" for row in np.hstack([controller.F, controller.G])]
    if memory:
        count = len(memory)
        lines += ["    {", f"        const {real} x[{count}] = {{", ",\n".join(memory), "        };"]
        lines += [f"        for (int k = 0; k < {count}; k++) g->x[k] = x[k];", "    }"]
    used = "\n".join(lines)
    if "g->" not in used:
        lines.insert(0, "    (void)g;")
    if not re.search(r"\by\[", used) and "    (void)y;" not in lines:
        lines.insert(0, "    (void)y;")
    return "\n".join([f"{real} {name}_law_decide({name}_law *g, const {real} *y)", "{", *lines, "    return u;", "}"])


def _sum(row: Array, terms: list[str], precision: Precision) -> str:
    pairs = [(value, term) for value, term in zip(row, terms, strict=True) if value != 0.0]
    return " + ".join(term if v == 1.0 else f"{precision.number(float(v))}*{term}" for v, term in pairs) or "0"


def _arguments(controller: Controller, formula: Formula, precision: Precision) -> str:
    signals, texts = controller.formulas.signals, []
    for argument in formula.arguments:
        if argument in controller.formulas.arguments:
            k = controller.formulas.arguments.index(argument)
            texts.append(f"s{k}" if k < len(signals) else f"g->q[{k - len(signals)}]")
        else:
            texts.append(precision.number(float(getattr(controller.law, argument))))
    return ", ".join(texts)


def _samples(controller: Controller, damper: Damper) -> tuple[Array, Array]:
    """Random measures, as large beside one another as the law weighs them, and what the controller decides on them.

    Of a law that asks for a force the stroke is a sine within what the damper was calibrated on, and the wanted forces are as
    large as the damper's.
    """
    rng = np.random.default_rng(1)
    weights = np.abs(controller.of_measured).max(axis=0, initial=0.0)
    scale = np.where(weights > 0.0, 1.0 / np.where(weights > 0.0, weights, 1.0), 1.0)
    y = scale * rng.standard_normal((VECTORS_OF_A_LAW, len(controller.rows)))
    if controller.formulas.asks_force:
        _with_a_stroke(y, controller, damper)
    run = ControllerRun(controller, inverse=inverse_of(controller.law, damper))
    return y, np.array([run.decide_on(each) for each in y])


def _with_a_stroke(y: Array, controller: Controller, damper: Damper) -> None:
    limits = [damper.ranges.get(name, (0.0, math.inf))[1] for name in ("displacement", "velocity")]
    amplitude, omega = min(0.008, 0.9 * limits[0]), 2.0 * math.pi
    omega = min(omega, 0.9 * limits[1] / amplitude)
    t = controller.law.period * np.arange(VECTORS_OF_A_LAW)
    x, v = amplitude * np.sin(omega * t), amplitude * omega * np.cos(omega * t)
    y *= np.max(np.abs(damper.force(t, x, velocity=v, **input_arguments(damper.input, controller.law.high))))
    at = dict(zip(dict(controller.sizes), np.cumsum([0, *dict(controller.sizes).values()]).tolist(), strict=False))
    y[:, at["stroke"]], y[:, at["rate"]] = x, v


def _vectors(controller: Controller, damper: Damper, name: str) -> str:
    y, u = _samples(controller, damper)
    if not y.shape[1]:
        y = np.zeros((len(y), 1))
    rows = ",\n".join("    {" + ", ".join(repr(float(v)) for v in row) + "}" for row in y)
    decided = ",\n".join("    " + ", ".join(repr(float(v)) for v in row) for row in u.reshape(-1, 6))
    return f"""\
/* What is measured at each sample, and what dampyr decided on it. */
#define {name.upper()}_LAW_VECTORS {len(u)}

static const double {name}_law_y[{len(u)}][{y.shape[1]}] = {{
{rows}
}};

static const double {name}_law_u[{len(u)}] = {{
{decided}
}};
"""


def _test_program(controller: Controller, name: str, precision: Precision) -> str:
    real = precision.real
    allowed = (AGREE_AT_A_TURN if controller.formulas.asks_force else AGREE)[real]
    span = max(controller.law.high - controller.law.low, 1e-300)
    return f"""\
/* Replays {name}_law_vectors.h: exit status 1 where a decision is off by more than {allowed:g} of the range. */
#include "{name}_law.h"
#include "{name}_law_vectors.h"
#include <stdio.h>

int main(void)
{{
    {name}_law g;
    double off = 0.0;
    {name}_law_start(&g);
    for (int k = 0; k < {name.upper()}_LAW_VECTORS; k++) {{
        {real} y[{name.upper()}_LAW_INPUTS];
        double u, gap;
        for (int c = 0; c < {name.upper()}_LAW_INPUTS; c++) y[c] = ({real}){name}_law_y[k][c];
        u = (double){name}_law_decide(&g, y);
        gap = u > {name}_law_u[k] ? u - {name}_law_u[k] : {name}_law_u[k] - u;
        if (!(gap <= off)) off = gap;
    }}
    printf("{name}_law: largest difference %.3g of the range, allowed {allowed:g}\\n", off/{span!r});
    return !(off <= {allowed * span!r});
}}
"""
