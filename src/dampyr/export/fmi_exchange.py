"""An FMU for model exchange: the damper as a differential equation that the master's own solver integrates.

The master sets time, continuous states and inputs, and asks for the derivatives, the force and the event indicators, which
change their sign where the derivatives have a kink: where the motion turns round. Nothing is stepped here, so that the force
has no delay and a mechanical loop through it is closed within the master's solver. The declarations are those of FMI 2.0.4 and
FMI 3.0.1 (fmi-standard.org).
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

from dampyr.export.c_text import DOUBLE, extremes, function
from dampyr.export.fmi_text import (
    CORE,
    FMI_2_COMMON,
    FMI_3_COMMON,
    STEPS_3,
    Variable,
    about_damper,
    refused,
    refused_kind,
    unit_definitions,
    variables,
)
from dampyr.export.kinds.c import before_use, check_exportable, parameter_functions, range_function
from dampyr.input_kinds import INPUTS
from dampyr.models import Damper
from dampyr.models.codegen.rates import check_has_rates, formulas, functions, switch_texts
from dampyr.source_digest import full_version

# The size of a state, which a solver takes its absolute tolerance from. States in m are some mm in a damper; with a tenth of
# that CVODE keeps to 1e-6 of the force at a tolerance of 1e-8 in the narrow pinch of `bouc_wen_baber_noori` too.
NOMINAL = {"": 1.0, "m": 1e-4}
ARRAYS = ("s", "p", "rate", "sign")


@dataclass(frozen=True)
class ContinuousState:
    """A continuous state: its name, its unit, and what it begins at."""

    name: str
    unit: str
    about: str
    start: float = 0.0
    nominal: float = 1.0


def continuous_states(damper: Damper, drive: str) -> list[ContinuousState]:
    """The states of the parts, then the displacement where the velocity drives, then the input at the coil behind a lag."""
    states = []
    for name, (low, high) in damper.composition.states.items():
        unit = "" if high - low < float("inf") else "m"
        states.append(ContinuousState(name, unit, "state of the damper, 0 at rest", 0.0, NOMINAL[unit]))
    if drive == "velocity":
        states.append(ContinuousState("displacement", "m", "integral of the velocity", 0.0, NOMINAL["m"]))
    if damper.input_lag:
        low, high = damper.range
        about = f"at the coil, follows the command with a time constant of {damper.input_lag:g} s"
        states.append(
            ContinuousState(f"acting_{INPUTS[damper.input]}", damper.input, about, low, max(abs(low), abs(high)))
        )
    return states


def exchange_source(damper: Damper, name: str, allow_extrapolation: bool = False) -> dict[str, str]:
    """``name.h`` and ``name.c``: parameters, force, derivatives and indicators as functions of state, motion and parameters.

    Raises :class:`~dampyr.errors.InputError` for a damper that is no differential equation.
    """
    check_exportable(damper)
    check_has_rates(damper.composition)
    prefix = f"{name}_"
    parts = [formula.tree for formula in formulas(damper.composition)]
    whole = [each.tree() for each in functions(damper.composition)]
    names = {tree.name for tree in (*parts, *whole)}
    called = [function(tree, prefix, names) for tree in parts]
    public = [function(tree, prefix, names, ARRAYS).removeprefix("static ") for tree in whole]
    text = "\n\n".join([*called, *public])
    declared = "\n".join(f"{each.splitlines()[0]};" for each in public)
    u = "double u, " if damper.has_input else ""
    notice = f" {damper.origin.notice}." if damper.origin.notice else ""
    header = f"""\
/* The differential equation of a damper, written by dampyr {full_version()}: {damper.composition}.{notice}
 * {before_use(damper) or "m, N, s."} */
#ifndef {name.upper()}_H
#define {name.upper()}_H
{f"int {prefix}in_range(double u);" if damper.has_input else ""}
void {prefix}parameters({u}double *p);
{declared}
#endif
"""
    source = [
        f'#include "{name}.h"\n#include <math.h>',
        *parameter_functions(damper, prefix),
        *([range_function(damper, prefix, allow_extrapolation)] if damper.has_input else []),
        *extremes(text, prefix, DOUBLE),
        text,
    ]
    return {f"{name}.h": header, f"{name}.c": "\n\n".join(source) + "\n"}


@dataclass(frozen=True)
class Row:
    """A variable of the description with its attributes beside those that each has."""

    variable: Variable
    initial: str = "calculated"
    start: float | None = None
    nominal: float | None = None
    derivative: int | None = None


def exchange_rows(damper: Damper, drive: str) -> list[Row]:
    """All variables by their references: motion, input, force, parameters; states, their derivatives, event indicators."""
    motion = variables(damper, drive)
    states = continuous_states(damper, drive)
    own = {state.name: k for k, state in enumerate(states)}
    rows = []
    for each in motion:
        if each.name in own:  # the displacement: among the states below
            continue
        value = (damper.range[0] if each.reference == 2 else 0.0) if each.causality == "input" else None
        rows.append(Row(each, "" if value is not None else "calculated", value))
    first = max(each.reference for each in motion) + 1
    for k, state in enumerate(states):
        variable = Variable(state.name, state.unit, "local", state.about, first + k)
        rows.append(Row(variable, "exact", state.start, state.nominal))
    rate = {"": "1/s", "m": "m/s", "V": "V/s", "A": "A/s"}
    for k, state in enumerate(states):
        variable = Variable(
            f"der({state.name})", rate[state.unit], "local", f"derivative of {state.name}", first + len(states) + k
        )
        rows.append(Row(variable, derivative=first + k))
    for k, text in enumerate(switch_texts(damper.composition)):
        about = f"changes its sign at a kink of the derivatives: {text}"
        rows.append(Row(Variable(f"switch[{k + 1}]", "", "local", about, first + 2 * len(states) + k)))
    return rows


def exchange_description(damper: Damper, name: str, fmi: int, drive: str, token: str, version: str) -> str:
    """The text of modelDescription.xml."""
    rows = exchange_rows(damper, drive)
    n_signs = len(switch_texts(damper.composition))
    head = f'modelName={quoteattr(name)} description={about_damper(damper)} generationTool="dampyr {version}"'
    units = unit_definitions([row.variable for row in rows])
    write = _structure_2 if fmi == 2 else _structure_3
    listed, structure = write(rows)
    if fmi == 2:
        opening = f'fmiVersion="2.0" {head} guid="{token}" variableNamingConvention="flat" numberOfEventIndicators="{n_signs}"'
        kind = f"""\
  <ModelExchange modelIdentifier="{name}" canGetAndSetFMUstate="true" canSerializeFMUstate="true"
    canNotUseMemoryManagementFunctions="true">
    <SourceFiles><File name="{name}.c"/><File name="{name}_fmi.c"/></SourceFiles>
  </ModelExchange>"""
        clock = ""
    else:
        opening = f'fmiVersion="3.0" {head} instantiationToken="{token}"'
        kind = f"""\
  <ModelExchange modelIdentifier="{name}" canGetAndSetFMUState="true" canSerializeFMUState="true"/>"""
        clock = (
            '    <Float64 name="time" valueReference="100000" causality="independent" variability="continuous" '
            'description="simulation time"/>\n'
        )
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription {opening}>
{kind}
  <UnitDefinitions>
{units}
  </UnitDefinitions>
  <DefaultExperiment startTime="0.0" stopTime="1.0" tolerance="1e-6"/>
  <ModelVariables>
{clock}{listed}
  </ModelVariables>
  <ModelStructure>
{structure}
  </ModelStructure>
</fmiModelDescription>
"""


def _common(row: Row) -> str:
    """What both versions write of a variable."""
    each = row.variable
    initial = f' initial="{row.initial}"' if row.initial else ""
    return (
        f'name={quoteattr(each.name)} valueReference="{each.reference}" causality="{each.causality}" '
        f'variability="continuous"{initial} description={quoteattr(each.description)}'
    )


def _numbers(row: Row, derivative: int | None) -> str:
    unit = f" unit={quoteattr(row.variable.unit)}" if row.variable.unit else ""
    nominal = f' nominal="{row.nominal!r}"' if row.nominal is not None else ""
    start = f' start="{row.start!r}"' if row.start is not None else ""
    slope = f' derivative="{derivative}"' if derivative is not None else ""
    return f"{unit}{nominal}{start}{slope}"


def _structure_2(rows: list[Row]) -> tuple[str, str]:
    """Variables and structure, whose indices count from 1."""
    index = {row.variable.reference: k for k, row in enumerate(rows, 1)}
    listed = "\n".join(
        f"    <ScalarVariable {_common(row)}>"
        f"<Real{_numbers(row, None if row.derivative is None else index[row.derivative])}/></ScalarVariable>"
        for row in rows
    )
    outputs = [index[row.variable.reference] for row in rows if row.variable.causality == "output"]
    slopes = [index[row.variable.reference] for row in rows if row.derivative is not None]
    blocks = (("Outputs", outputs), ("Derivatives", slopes), ("InitialUnknowns", [*outputs, *slopes]))
    lines = []
    for name, which in blocks:
        unknowns = "".join(f'<Unknown index="{k}"/>' for k in sorted(which))
        lines += [f"    <{name}>{unknowns}</{name}>"] if which else []
    return listed, "\n".join(lines)


def _structure_3(rows: list[Row]) -> tuple[str, str]:
    """Variables and structure, by references."""
    listed = "\n".join(f"    <Float64 {_common(row)}{_numbers(row, row.derivative)}/>" for row in rows)
    outputs = [row.variable.reference for row in rows if row.variable.causality == "output"]
    slopes = [row.variable.reference for row in rows if row.derivative is not None]
    signs = [row.variable.reference for row in rows if row.variable.name.startswith("switch[")]
    lines = [
        *(("Output", k) for k in outputs),
        *(("ContinuousStateDerivative", k) for k in slopes),
        *(("InitialUnknown", k) for k in (*outputs, *slopes)),
        *(("EventIndicator", k) for k in signs),
    ]
    return listed, "\n".join(f'    <{kind} valueReference="{k}"/>' for kind, k in lines)


def exchange_wrapper(damper: Damper, name: str, fmi: int, drive: str) -> str:
    """The C of the interface, but for the line that defines INSTANTIATION_TOKEN."""
    states = continuous_states(damper, drive)
    own = len(damper.composition.states)
    place = own if drive == "velocity" else -1
    acting = len(states) - 1 if damper.input_lag else -1
    low, high = damper.range
    numbers = {
        "@COUNT": len(damper.composition.parameters),
        "@OWN": own,
        "@STATES": len(states),
        "@SIGNS": len(switch_texts(damper.composition)),
        "@PLACE": place,
        "@ACTING": acting,
        "@INPUT": int(damper.has_input),
        "@STARTS": ", ".join(repr(state.start) for state in states) or "0.0",
        "@NOMINALS": ", ".join(repr(state.nominal) for state in states) or "1.0",
        "@TAU": repr(float(damper.input_lag or 1.0)),
        "@LOW": repr(low) if damper.has_input else "0.0",
        "@WORD": INPUTS.get(damper.input, ""),
        "@SAID": f"{low:g} to {high:g} {damper.input}",
    }
    text = (
        '#include "DAMPER.h"\n'
        + CORE[CORE.index("#include <math.h>") : CORE.index("enum {")]
        + EXCHANGE_CORE
        + CORE[CORE.index("static Unit *made(") :]
        + (EXCHANGE_2 if fmi == 2 else EXCHANGE_3)
    )
    if not damper.has_input:
        text = text.replace("DAMPER_in_range(u)", "1").replace("DAMPER_parameters(u, p)", "DAMPER_parameters(p)")
    for key in sorted(numbers, key=len, reverse=True):
        text = text.replace(key, str(numbers[key]))
    return text.replace("DAMPER", name)


EXCHANGE_CORE = r"""
enum { X, V, U, FORCE, FIRST_PARAMETER, COUNT = @COUNT, OWN = @OWN, STATES = @STATES, SIGNS = @SIGNS, PLACE = @PLACE,
    ACTING = @ACTING, INPUT = @INPUT, FIRST_STATE = FIRST_PARAMETER + COUNT, FIRST_RATE = FIRST_STATE + STATES,
    FIRST_SIGN = FIRST_RATE + STATES, LAST = FIRST_SIGN + SIGNS, KIND = 0 /* model exchange */ };

static const double starts[] = {@STARTS}, nominals[] = {@NOMINALS};

/* What a master sets: x, v and u, and the states. */
typedef struct {
    double time, in[3], s[STATES + 1];
} Moment;

typedef struct {
    Moment m;
    void *environment;
    void *logger;
    char name[128];
} Unit;

/* What follows from it. */
typedef struct {
    double p[COUNT + 1], rate[STATES + 1], sign[SIGNS + 1], x, force;
} Result;

static void say(const Unit *unit, int status, const char *text);

static void begin_at(Unit *unit, double start) { unit->m.time = start; }

static int evaluate(const Unit *unit, Result *r)
{
    const Moment *m = &unit->m;
    double u = m->in[U], *p = r->p;
    if (!DAMPER_in_range(u)) {
        char text[200];
        snprintf(text, sizeof text, "no force at @WORD = %g: calibrated from @SAID", u);
        say(unit, 3, text);
        return 3;
    }
    r->x = PLACE >= 0 ? m->s[PLACE < 0 ? 0 : PLACE] : m->in[X];
    if (ACTING >= 0) {
        u = m->s[ACTING < 0 ? 0 : ACTING];
        r->rate[ACTING < 0 ? 0 : ACTING] = (m->in[U] - u)/@TAU;
    }
    if (PLACE >= 0) r->rate[PLACE < 0 ? 0 : PLACE] = m->in[V];
    DAMPER_parameters(u, p);
    r->force = DAMPER_force(m->s, r->x, m->in[V], 0.0, p);
    DAMPER_rates(m->s, r->x, m->in[V], p, r->rate);
    DAMPER_switches(m->s, r->x, m->in[V], p, r->sign);
    return 0;
}

/* The state that a reference means, -1 where it is none. */
static int state_of(unsigned r)
{
    if (r >= FIRST_STATE && r < FIRST_RATE) return (int)r - FIRST_STATE;
    return r == X ? PLACE : -1;
}

static int read_values(Unit *unit, const unsigned *refs, size_t n, double *values)
{
    Result now;
    if (evaluate(unit, &now)) return 3;
    for (size_t k = 0; k < n; k++) {
        unsigned r = refs[k];
        if (r >= LAST || (r == U && !INPUT)) {
            say(unit, 3, "there is no variable of that value reference");
            return 3;
        }
        if (r == X) values[k] = now.x;
        else if (r == V || r == U) values[k] = unit->m.in[r];
        else if (r == FORCE) values[k] = now.force;
        else if (r < FIRST_STATE) values[k] = now.p[r - FIRST_PARAMETER];
        else if (r < FIRST_RATE) values[k] = unit->m.s[r - FIRST_STATE];
        else if (r < FIRST_SIGN) values[k] = now.rate[r - FIRST_RATE];
        else values[k] = now.sign[r - FIRST_SIGN];
    }
    return 0;
}

static int write_values(Unit *unit, const unsigned *refs, size_t n, const double *values)
{
    for (size_t k = 0; k < n; k++) {
        int state = state_of(refs[k]);
        if (state < 0 && (refs[k] > U || (refs[k] == U && !INPUT))) {
            say(unit, 3, "only inputs and states can be set");
            return 3;
        }
        if (!isfinite(values[k])) {
            say(unit, 3, "an input or a state is not finite");
            return 3;
        }
        *(state < 0 ? &unit->m.in[refs[k]] : &unit->m.s[state]) = values[k];
    }
    return 0;
}

static int get_states(const Unit *unit, double *x, size_t n)
{
    if (n != STATES) return 3;
    for (size_t k = 0; k < n; k++) x[k] = unit->m.s[k];
    return 0;
}

static int set_states(Unit *unit, const double *x, size_t n)
{
    if (n != STATES) return 3;
    for (size_t k = 0; k < n; k++) unit->m.s[k] = x[k];
    return 0;
}

static int get_rates(const Unit *unit, double *rates, size_t n)
{
    Result now;
    if (n != STATES || evaluate(unit, &now)) return 3;
    for (size_t k = 0; k < n; k++) rates[k] = now.rate[k];
    return 0;
}

static int get_signs(const Unit *unit, double *signs, size_t n)
{
    Result now;
    if (n != SIGNS || evaluate(unit, &now)) return 3;
    for (size_t k = 0; k < n; k++) signs[k] = now.sign[k];
    return 0;
}

static int get_nominals(double *values, size_t n)
{
    if (n != STATES) return 3;
    for (size_t k = 0; k < n; k++) values[k] = nominals[k];
    return 0;
}

static void begin(Unit *unit)
{
    memset(&unit->m, 0, sizeof unit->m);
    unit->m.in[U] = @LOW;
    for (int k = 0; k < STATES; k++) unit->m.s[k] = starts[k];
}

"""

EXCHANGE_2 = (
    FMI_2_COMMON
    + r"""
typedef struct { int again, terminate, nominals, states, time_defined; double time; } Events;

API int fmi2EnterEventMode(void *c) { (void)c; return 0; }
API int fmi2NewDiscreteStates(void *c, Events *events)
{
    Events none = {0, 0, 0, 0, 0, 0.0};
    (void)c;
    *events = none;
    return 0;
}
API int fmi2EnterContinuousTimeMode(void *c) { (void)c; return 0; }
API int fmi2CompletedIntegratorStep(void *c, int final, int *event, int *terminate)
{
    (void)c; (void)final;
    *event = *terminate = 0;
    return 0;
}
API int fmi2SetTime(void *c, double t) { ((Unit *)c)->m.time = t; return 0; }
API int fmi2SetContinuousStates(void *c, const double *x, size_t n) { return set_states(c, x, n); }
API int fmi2GetDerivatives(void *c, double *rates, size_t n) { return get_rates(c, rates, n); }
API int fmi2GetEventIndicators(void *c, double *signs, size_t n) { return get_signs(c, signs, n); }
API int fmi2GetContinuousStates(void *c, double *x, size_t n) { return get_states(c, x, n); }
API int fmi2GetNominalsOfContinuousStates(void *c, double *values, size_t n) { (void)c; return get_nominals(values, n); }
"""
)

EXCHANGE_3 = (
    FMI_3_COMMON
    + refused_kind("CoSimulation", "ScheduledExecution")
    + refused(STEPS_3)
    + r"""
API void *fmi3InstantiateModelExchange(Text name, Text token, Text place, bool visible, bool logging, void *environment,
    Logger logger)
{
    void *stored;
    (void)place; (void)visible; (void)logging;
    memcpy(&stored, &logger, sizeof stored);
    return made(name, token, environment, stored);
}
API int fmi3EnterEventMode(void *c) { (void)c; return 0; }
API int fmi3UpdateDiscreteStates(void *c, bool *again, bool *terminate, bool *nominals, bool *states, bool *defined,
    double *time)
{
    (void)c;
    *again = *terminate = *nominals = *states = *defined = false;
    *time = 0.0;
    return 0;
}
API int fmi3EnterContinuousTimeMode(void *c) { (void)c; return 0; }
API int fmi3CompletedIntegratorStep(void *c, bool final, bool *event, bool *terminate)
{
    (void)c; (void)final;
    *event = *terminate = false;
    return 0;
}
API int fmi3SetTime(void *c, double t) { ((Unit *)c)->m.time = t; return 0; }
API int fmi3SetContinuousStates(void *c, const double *x, size_t n) { return set_states(c, x, n); }
API int fmi3GetContinuousStateDerivatives(void *c, double *rates, size_t n) { return get_rates(c, rates, n); }
API int fmi3GetEventIndicators(void *c, double *signs, size_t n) { return get_signs(c, signs, n); }
API int fmi3GetContinuousStates(void *c, double *x, size_t n) { return get_states(c, x, n); }
API int fmi3GetNominalsOfContinuousStates(void *c, double *values, size_t n) { (void)c; return get_nominals(values, n); }
API int fmi3GetNumberOfEventIndicators(void *c, size_t *n) { (void)c; *n = SIGNS; return 0; }
API int fmi3GetNumberOfContinuousStates(void *c, size_t *n) { (void)c; *n = STATES; return 0; }
"""
)
