"""The texts of an FMU: its model description, and the C that puts the functions of the FMI standard around a damper.

The declarations are those of the standards FMI 2.0.4 and FMI 3.0.1 (fmi-standard.org), of what co-simulation needs.

A step from t to t + h begins at the inputs as they are set at t, and ends at what they are set to at t + h. Until these are
set, the inputs of t hold, or go on with the derivatives that FMI 2 lets a master set. So a force that is read after the inputs
of its time are set is that of `Damper.force`; one that is read before lags by a step.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from xml.sax.saxutils import quoteattr

from dampyr.export.kinds.c import before_use
from dampyr.input_kinds import INPUTS
from dampyr.models import Damper
from dampyr.models.inverse import REASONS

UNITS = {
    "m": 'm="1"', "m/s": 'm="1" s="-1"', "m/s^2": 'm="1" s="-2"',
    "N": 'kg="1" m="1" s="-2"', "V": 'kg="1" m="2" s="-3" A="-1"', "A": 'A="1"',
    "V/s": 'kg="1" m="2" s="-4" A="-1"', "A/s": 'A="1" s="-1"',
    "s": 's="1"', "kg": 'kg="1"', "1/m": 'm="-1"', "1/s": 's="-1"', "N/m": 'kg="1" s="-2"', "N s/m": 'kg="1" s="-1"',
    "m/N": 'kg="-1" s="2"', "N s/m^3": 'kg="1" m="-2" s="-1"',
}  # fmt: skip


@dataclass(frozen=True)
class Variable:
    """A variable of the FMU, by its value ``reference``."""

    name: str
    unit: str
    causality: str
    description: str
    reference: int = 0


def variables(damper: Damper, drive: str, inverse: bool = False) -> list[Variable]:
    """The inputs (displacement, velocity, and voltage or current), then the force, then the parameters at the present input.

    Their references count from 0; of a damper without an input, that of the voltage or current, 2, is left out. With
    ``inverse`` that is the wanted force, and what was found for it comes after the force.
    """
    word = INPUTS.get(damper.input, "")
    derived = {
        "displacement": "integrated from the velocity, from 0",
        "velocity": "slope of the displacement over the step",
    }
    motion = [
        Variable(
            name,
            unit,
            "input" if drive in ("both", name) else "local",
            f"{what}{'' if drive in ('both', name) else ', ' + derived[name]}",
        )
        for name, unit, what in (
            ("displacement", "m", "of the damper, extension positive"),
            ("velocity", "m/s", "of the damper"),
        )
    ]
    units = {f"{p.name}.{key}": q.unit for p in damper.composition.parts for key, q in p.parameters.items()}
    where = "at the coil"
    if damper.input_lag:
        where = f"command, which the coil follows with a time constant of {damper.input_lag:g} s"
    at_coil = Variable(word, damper.input, "input", f"{where}; the damper {damper.range_words}")
    about = f"parameter at the present {word}" if word else "parameter"
    found: list[Variable] = []
    if inverse:
        at_coil = Variable("wanted_force", "N", "input", "wanted at this time, the end of a step")
        found = [
            Variable(word, damper.input, "output", f"at the coil, found; the damper {damper.range_words}"),
            Variable(
                "reason", "", "output", "; ".join(f"{k} {text.replace('_', ' ')}" for k, text in enumerate(REASONS))
            ),
            Variable("monotone", "", "output", f"0 where the force rises and falls over the {word}"),
        ]
    listed = [
        *motion,
        at_coil,
        Variable("force", "N", "output", "positive against a positive velocity"),
        *found,
        *(Variable(key, units.get(key, ""), "local", about) for key in damper.all_laws),
    ]
    numbered = [replace(variable, reference=k) for k, variable in enumerate(listed)]
    return [variable for variable in numbered if variable.name]


def model_description(
    damper: Damper, name: str, fmi: int, drive: str, token: str, version: str, inverse: bool = False
) -> str:
    """The text of modelDescription.xml."""
    head = f'modelName={quoteattr(name)} description={about_damper(damper)} generationTool="dampyr {version}"'
    return described(name, head, token, fmi, variables(damper, drive, inverse), 0.0 if inverse else damper.range[0])


def unit_definitions(listed: list[Variable]) -> str:
    """The units of the variables, in powers of those of SI."""
    used = sorted({variable.unit for variable in listed if variable.unit})
    return "\n".join(
        f"    <Unit name={quoteattr(unit)}>" + (f"<BaseUnit {UNITS[unit]}/>" if unit in UNITS else "") + "</Unit>"
        for unit in used
    )


def about_damper(damper: Damper) -> str:
    """Its model, its origin and what is to be known before it is used, as an attribute of XML."""
    origin = f". {notice}" if (notice := damper.origin.notice) else ""
    return quoteattr(f"Damper: {damper.composition}{origin}. {before_use(damper)}".removesuffix(". "))


def described(name: str, head: str, token: str, fmi: int, listed: list[Variable], start: float) -> str:
    """The text of modelDescription.xml for these variables; ``start`` is that of the variable of reference 2."""
    units = unit_definitions(listed)
    if fmi == 2:
        return _description_2(name, head, token, units, listed, start)
    return _description_3(name, head, token, units, listed, start)


def _unit_and_start(variable: Variable, start: float) -> str:
    value = "" if variable.causality != "input" else f' start="{start if variable.reference == 2 else 0.0!r}"'
    unit = f" unit={quoteattr(variable.unit)}" if variable.unit else ""
    return unit + value


def _attributes(variable: Variable) -> str:
    """What both versions of the standard write of a variable."""
    initial = "" if variable.causality == "input" else f" initial={quoteattr('calculated')}"
    return (
        f'name={quoteattr(variable.name)} valueReference="{variable.reference}" causality="{variable.causality}" '
        f'variability="continuous"{initial} description={quoteattr(variable.description)}'
    )


def _description_2(name: str, head: str, token: str, units: str, listed: list[Variable], start: float) -> str:
    rows = "\n".join(
        f"    <ScalarVariable {_attributes(variable)}><Real{_unit_and_start(variable, start)}/></ScalarVariable>"
        for variable in listed
    )
    outputs = [k for k, variable in enumerate(listed, 1) if variable.causality == "output"]
    unknowns = "".join(f'<Unknown index="{k}"/>' for k in outputs)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" {head} guid="{token}" variableNamingConvention="flat">
  <CoSimulation modelIdentifier="{name}" canHandleVariableCommunicationStepSize="true" canInterpolateInputs="true"
    canGetAndSetFMUstate="true" canSerializeFMUstate="true" canNotUseMemoryManagementFunctions="true">
    <SourceFiles><File name="{name}.c"/><File name="{name}_fmi.c"/></SourceFiles>
  </CoSimulation>
  <UnitDefinitions>
{units}
  </UnitDefinitions>
  <DefaultExperiment startTime="0.0" stopTime="1.0" stepSize="0.001"/>
  <ModelVariables>
{rows}
  </ModelVariables>
  <ModelStructure>
    <Outputs>{unknowns}</Outputs>
    <InitialUnknowns>
      {unknowns}
    </InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


def _description_3(name: str, head: str, token: str, units: str, listed: list[Variable], start: float) -> str:
    rows = "\n".join(f"    <Float64 {_attributes(variable)}{_unit_and_start(variable, start)}/>" for variable in listed)
    outputs = [variable.reference for variable in listed if variable.causality == "output"]
    unknowns = "\n".join(
        f'    <{kind} valueReference="{k}"/>' for kind in ("Output", "InitialUnknown") for k in outputs
    )
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" {head} instantiationToken="{token}">
  <CoSimulation modelIdentifier="{name}" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUState="true"
    canSerializeFMUState="true"/>
  <UnitDefinitions>
{units}
  </UnitDefinitions>
  <DefaultExperiment startTime="0.0" stopTime="1.0" stepSize="0.001"/>
  <ModelVariables>
    <Float64 name="time" valueReference="1000" causality="independent" variability="continuous" description="simulation time"/>
{rows}
  </ModelVariables>
  <ModelStructure>
{unknowns}
  </ModelStructure>
</fmiModelDescription>
"""


def wrapper(damper: Damper, name: str, fmi: int, drive: str, inverse: bool = False) -> str:
    """The C of the interface, but for the line that defines INSTANTIATION_TOKEN."""
    low, high = damper.range
    count = len(damper.composition.parameters)
    core = CORE.replace("@STEPS\n", STEPS)
    for text, instead in INVERSE if inverse else ():
        assert text in core, f"the wrapper has no {text!r} any more, which the inverse's replaces"
        core = core.replace(text, instead)
    for text, instead in WITH_LAG if damper.input_lag else ():
        assert text in core, f"the wrapper has no {text!r} any more, which the lag's replaces"
        core = core.replace(text, instead)
    core = (
        core.replace("DAMPER", name)
        .replace("@COUNT", str(count))
        .replace("@LOW", repr(low))
        .replace("@DRIVE", str(("both", "displacement", "velocity").index(drive)))
    )
    interface = (FMI_2 if fmi == 2 else FMI_3).replace("DAMPER", name)
    if not damper.has_input:
        for text, instead in WITHOUT_INPUT:
            core, interface = core.replace(text, instead), interface.replace(text, instead)
    word = "wanted_force" if inverse else INPUTS.get(damper.input, "")
    core = core.replace("@RANGE", f"{low:g} to {high:g} {damper.input}").replace("@WORD", word)
    return core.replace("@UNIT", "N" if inverse else damper.input) + interface


INVERSE = (
    ("V, U, FORCE, FIRST_PARAMETER,", "V, U, FORCE, FOUND, REASON, MONOTONE, FIRST_PARAMETER,"),
    ("    DAMPER_state past;\n",
     "    DAMPER_state past;\n    DAMPER_inverse g, found;          /* of `past`, and of m->now */\n"),
    ("x, v, u as they were set last", "x, v and the wanted force as they were set last"),
    ("/* The force at m->now;", """\
static double started(DAMPER_inverse *g, DAMPER_state *d, double t, double x, double v, double wanted)
{
    DAMPER_start(d, t, x, v, g->low);
    return DAMPER_start(d, t, x, v, DAMPER_inverse_find(g, d, 0.0, x, v, wanted));
}

static double stepped(DAMPER_inverse *g, DAMPER_state *d, double dt, double x, double v, double wanted)
{
    return DAMPER_step_by(d, dt, x, v, DAMPER_inverse_find(g, d, dt, x, v, wanted));
}

/* The force at m->now;"""),
    ("DAMPER_state d = m->past;\n", "DAMPER_state d = m->past;\n    DAMPER_inverse g = m->g;\n"),
    ("DAMPER_start(&d,", "started(&g, &d,"),
    ("DAMPER_step_by(&d,", "stepped(&g, &d,"),
    ("    if (commit && f == f) {\n", "    m->found = g;\n    if (commit && f == f) {\n        m->g = g;\n"),
    ("DAMPER_parameters(u, p);", "DAMPER_parameters(unit->m.found.u, p);"),
    ("r == U ? u : f;", "r == U ? u : r == FORCE ? f : r == FOUND ? unit->m.found.u\n                : "
     "r == REASON ? unit->m.found.reason : unit->m.found.monotone;"),
    ("unit->m.in[U] = @LOW;", "DAMPER_inverse_start(&unit->m.g);\n    unit->m.found = unit->m.g;"),
)  # fmt: skip
"""What of the core's text is another one where the input is found: U is the wanted force then."""


WITH_LAG = (
    (
        "    int running;  ",
        "    double acting;                    /* what the command u has become */\n    int running;  ",
    ),
    ("    if (commit && f == f) {\n", "    m->acting = d.acting;\n    if (commit && f == f) {\n"),
    ("DAMPER_parameters(u, p);", "DAMPER_parameters(unit->m.acting, p);"),
)
"""What of the core's text is another one where the input is a command, which a coil follows."""


WITHOUT_INPUT = (
    (", *x, *v, u)", ", *x, *v)"),
    ("_parameters(u, p)", "_parameters(p)"),
    ("no force at @WORD = %g @UNIT: calibrated from @RANGE, or the delay is too long\", u)",
     "no force: the delay is too long\")"),
    ("@WORD = %g @UNIT at t = %g s: calibrated from @RANGE, or the delay is too long\", m->in[U], t)",
     "no force at t = %g s: the delay is too long\", t)"),
    ("        if (r < FIRST_PARAMETER) {", "        if (r < FIRST_PARAMETER && r != U) {"),
    ("} else if (r < FIRST_PARAMETER + COUNT) {", "} else if (r != U && r < FIRST_PARAMETER + COUNT) {"),
    ("if (r > U ||", "if (r >= U ||"),
    ("if (r[k] > U ||", "if (r[k] >= U ||"),
    ("/* x, v, u as they were set last", "/* x and v as they were set last, the third is free"),
)  # fmt: skip
"""What of the interface's text is another one where the damper has no input: nobody sets or reads the variable U."""


STEPS = r"""static void say(const Unit *unit, int status, const char *text);

/* The inputs from this time on, with the derivatives that a master has set. */
static void set_inputs(Moment *m, const unsigned *refs, size_t n, const double *values)
{
    for (size_t k = 0; k < n; k++) m->in[refs[k]] = values[k] - m->slope[refs[k]]*(m->now - m->begun);
}

enum { KIND = 1 }; /* co-simulation */

static void begin_at(Unit *unit, double start) { unit->m.begun = unit->m.now = unit->m.at = start; }

static int goes_forward(const Unit *unit, double t, double h)
{
    if (h > 0.0 && isfinite(t) && isfinite(h)) return 1;
    say(unit, 3, "a step has to go forward in time");
    return 0;
}
"""
"""What the FMUs of a damper and of a law share, after their `Moment` and `Unit`."""


CORE = r"""#include "DAMPER.h"
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define API __declspec(dllexport)
#else
#define API __attribute__((visibility("default")))
#endif

enum { X, V, U, FORCE, FIRST_PARAMETER, COUNT = @COUNT, BOTH = 0, DISPLACEMENT = 1, VELOCITY = 2, DRIVE = @DRIVE };

/* Everything that a step changes; `past` is the damper at the last time whose inputs are final. */
typedef struct {
    DAMPER_state past;
    double begun, now, at, v_at;      /* s: the last doStep's times; time and velocity of `past` */
    double in[3], slope[3];           /* x, v, u as they were set last, and their derivatives */
    int running;                      /* 0 before the first step */
} Moment;

typedef struct {
    Moment m;
    void *environment;
    void *logger;
    char name[128];
} Unit;

/* The inputs at the time m->now: as set, or with the derivatives where none was set since the step began. */
static void inputs_now(const Moment *m, double dt, double *x, double *v, double *u)
{
    double h = m->now - m->begun;
    *u = m->in[U] + m->slope[U]*h;
    *v = m->in[V] + m->slope[V]*h;
    *x = m->in[X] + m->slope[X]*h;
    if (DRIVE == DISPLACEMENT) *v = dt > 0.0 ? (*x - m->past.x)/dt : m->v_at;
    if (DRIVE == VELOCITY) *x = m->past.x + 0.5*dt*(m->v_at + *v);
}

/* The force at m->now; `past` goes on to there where `commit`. */
static double force_now(Moment *m, int commit, double *x, double *v)
{
    DAMPER_state d = m->past;
    double dt = m->now - m->at, u, f;
    if (!m->running) {
        u = m->in[U];
        *x = DRIVE == VELOCITY ? 0.0 : m->in[X];
        *v = DRIVE == DISPLACEMENT ? 0.0 : m->in[V];
        f = DAMPER_start(&d, 0.0, *x, *v, u);
    } else {
        inputs_now(m, dt, x, v, &u);
        if (dt > 0.0) {
            f = DAMPER_step_by(&d, dt, *x, *v, u);
        } else {
            f = m->running == 1 ? DAMPER_start(&d, 0.0, *x, *v, u) : DAMPER_step_by(&d, 1e-12, *x, *v, u);
        }
    }
    if (commit && f == f) {
        m->past = d;
        m->at = m->now;
        m->v_at = *v;
    }
    return f;
}

@STEPS
static int read_values(Unit *unit, const unsigned *refs, size_t n, double *values)
{
    double p[COUNT ? COUNT : 1], x, v, f = force_now(&unit->m, 0, &x, &v), u = unit->m.in[U];
    DAMPER_parameters(u, p);
    for (size_t k = 0; k < n; k++) {
        unsigned r = refs[k];
        if (r == FORCE && !(f == f)) {
            char text[200];
            snprintf(text, sizeof text, "no force at @WORD = %g @UNIT: calibrated from @RANGE, or the delay is too long", u);
            say(unit, 3, text);
            return 3;
        }
        if (r < FIRST_PARAMETER) {
            values[k] = r == X ? x : r == V ? v : r == U ? u : f;
        } else if (r < FIRST_PARAMETER + COUNT) {
            values[k] = p[r - FIRST_PARAMETER];
        } else {
            say(unit, 3, "there is no variable of that value reference");
            return 3;
        }
    }
    return 0;
}

static int write_values(Unit *unit, const unsigned *refs, size_t n, const double *values)
{
    for (size_t k = 0; k < n; k++) {
        unsigned r = refs[k];
        if (r > U || (DRIVE == DISPLACEMENT && r == V) || (DRIVE == VELOCITY && r == X)) {
            say(unit, 3, "only inputs can be set");
            return 3;
        }
        if (!isfinite(values[k])) {
            say(unit, 3, "an input is not finite");
            return 3;
        }
    }
    set_inputs(&unit->m, refs, n, values);
    return 0;
}

static int step(Unit *unit, double t, double h)
{
    Moment *m = &unit->m;
    double x, v, f;
    if (!goes_forward(unit, t, h)) return 3;
    if (!m->running) {
        m->begun = m->now = m->at = t;
        m->running = 1;
    }
    f = force_now(m, 1, &x, &v);
    if (!(f == f)) {
        char text[200];
        snprintf(text, sizeof text,
            "@WORD = %g @UNIT at t = %g s: calibrated from @RANGE, or the delay is too long", m->in[U], t);
        say(unit, 3, text);
        return 3;
    }
    for (int k = 0; k < 3; k++) m->in[k] += m->slope[k]*(m->now - m->begun);
    if (m->running == 1) m->running = 2;
    m->begun = t;
    m->now = t + h;
    return 0;
}

static void begin(Unit *unit)
{
    memset(&unit->m, 0, sizeof unit->m);
    unit->m.in[U] = @LOW;
}

static Unit *made(const char *name, const char *token, void *environment, void *logger)
{
    Unit *unit;
    if (!token || strcmp(token, INSTANTIATION_TOKEN)) return NULL;
    unit = calloc(1, sizeof *unit);
    if (!unit) return NULL;
    unit->environment = environment;
    unit->logger = logger;
    if (name) snprintf(unit->name, sizeof unit->name, "%s", name);
    begin(unit);
    return unit;
}

static Moment *copied(const Moment *from, void *into)
{
    Moment *copy = into ? into : malloc(sizeof *copy);
    if (copy) memcpy(copy, from, sizeof *copy);
    return copy;
}
"""

FMI_2_COMMON = r"""
typedef const char *Text;
typedef void (*Logger)(void *, Text, int, Text, Text, ...);
typedef struct { Logger logger; void *allocate, *release, *finished, *environment; } Callbacks;

static void say(const Unit *unit, int status, const char *text)
{
    const Callbacks *callbacks = unit->logger;
    if (callbacks && callbacks->logger)
        callbacks->logger(callbacks->environment, unit->name, status, "logStatusError", "%s", text);
}

API const char *fmi2GetTypesPlatform(void) { return "default"; }
API const char *fmi2GetVersion(void) { return "2.0"; }
API int fmi2SetDebugLogging(void *c, int on, size_t n, const Text *s) { (void)c; (void)on; (void)n; (void)s; return 0; }
API void *fmi2Instantiate(Text name, int kind, Text guid, Text place, const Callbacks *callbacks, int visible, int logging)
{
    (void)place; (void)visible; (void)logging;
    return kind == KIND ? made(name, guid, NULL, (void *)(size_t)callbacks) : NULL;
}
API void fmi2FreeInstance(void *c) { free(c); }
API int fmi2SetupExperiment(void *c, int has_tolerance, double tolerance, double start, int has_end, double end)
{
    (void)has_tolerance; (void)tolerance; (void)has_end; (void)end;
    begin_at(c, start);
    return 0;
}
API int fmi2EnterInitializationMode(void *c) { (void)c; return 0; }
API int fmi2ExitInitializationMode(void *c) { (void)c; return 0; }
API int fmi2Terminate(void *c) { (void)c; return 0; }
API int fmi2Reset(void *c) { begin(c); return 0; }
API int fmi2GetReal(void *c, const unsigned *r, size_t n, double *v) { return read_values(c, r, n, v); }
API int fmi2SetReal(void *c, const unsigned *r, size_t n, const double *v) { return write_values(c, r, n, v); }
API int fmi2GetInteger(void *c, const unsigned *r, size_t n, int *v) { (void)c; (void)r; (void)v; return n ? 3 : 0; }
API int fmi2SetInteger(void *c, const unsigned *r, size_t n, const int *v) { (void)c; (void)r; (void)v; return n ? 3 : 0; }
API int fmi2GetBoolean(void *c, const unsigned *r, size_t n, int *v) { (void)c; (void)r; (void)v; return n ? 3 : 0; }
API int fmi2SetBoolean(void *c, const unsigned *r, size_t n, const int *v) { (void)c; (void)r; (void)v; return n ? 3 : 0; }
API int fmi2GetString(void *c, const unsigned *r, size_t n, Text *v) { (void)c; (void)r; (void)v; return n ? 3 : 0; }
API int fmi2SetString(void *c, const unsigned *r, size_t n, const Text *v) { (void)c; (void)r; (void)v; return n ? 3 : 0; }
API int fmi2GetFMUstate(void *c, void **state)
{
    *state = copied(&((Unit *)c)->m, *state);
    return *state ? 0 : 3;
}
API int fmi2SetFMUstate(void *c, void *state) { copied(state, &((Unit *)c)->m); return 0; }
API int fmi2FreeFMUstate(void *c, void **state) { (void)c; free(*state); *state = NULL; return 0; }
API int fmi2SerializedFMUstateSize(void *c, void *state, size_t *size)
{
    (void)c; (void)state;
    *size = sizeof(Moment);
    return 0;
}
API int fmi2SerializeFMUstate(void *c, void *state, char *bytes, size_t size)
{
    (void)c;
    if (size < sizeof(Moment)) return 3;
    memcpy(bytes, state, sizeof(Moment));
    return 0;
}
API int fmi2DeSerializeFMUstate(void *c, const char *bytes, size_t size, void **state)
{
    (void)c;
    if (size < sizeof(Moment)) return 3;
    *state = malloc(sizeof(Moment));
    if (!*state) return 3;
    memcpy(*state, bytes, sizeof(Moment));
    return 0;
}
API int fmi2GetDirectionalDerivative(void *c, const unsigned *z, size_t nz, const unsigned *r, size_t nr,
    const double *dv, double *dz)
{
    (void)z; (void)nz; (void)r; (void)nr; (void)dv; (void)dz;
    say(c, 3, "directional derivatives are not given");
    return 3;
}
"""

FMI_2_STEPS = r"""
API int fmi2SetRealInputDerivatives(void *c, const unsigned *r, size_t n, const int *order, const double *v)
{
    for (size_t k = 0; k < n; k++) {
        if (r[k] > U || order[k] != 1) {
            say(c, 3, "only the first derivatives of the inputs can be set");
            return 3;
        }
    }
    for (size_t k = 0; k < n; k++) {
        Moment *m = &((Unit *)c)->m;
        m->in[r[k]] += (m->slope[r[k]] - v[k])*(m->now - m->begun);
        m->slope[r[k]] = v[k];
    }
    return 0;
}
API int fmi2GetRealOutputDerivatives(void *c, const unsigned *r, size_t n, const int *order, double *v)
{
    (void)r; (void)n; (void)order; (void)v;
    say(c, 3, "derivatives of the force are not given");
    return 3;
}
API int fmi2DoStep(void *c, double t, double h, int final) { (void)final; return step(c, t, h); }
API int fmi2CancelStep(void *c) { (void)c; return 3; }
API int fmi2GetStatus(void *c, int kind, int *v) { (void)c; (void)kind; (void)v; return 2; }
API int fmi2GetRealStatus(void *c, int kind, double *v) { *v = ((Unit *)c)->m.now; return kind == 2 ? 0 : 2; }
API int fmi2GetIntegerStatus(void *c, int kind, int *v) { (void)c; (void)kind; (void)v; return 2; }
API int fmi2GetBooleanStatus(void *c, int kind, int *v) { (void)c; (void)kind; *v = 0; return 2; }
API int fmi2GetStringStatus(void *c, int kind, Text *v) { (void)c; (void)kind; *v = ""; return 2; }
"""

FMI_2 = FMI_2_COMMON + FMI_2_STEPS

_UNUSED_3 = "".join(
    f"API int fmi3Get{kind}(void *c, const unsigned *r, size_t n, {type_} *v, size_t m)"
    " { (void)c; (void)r; (void)v; (void)m; return n ? 3 : 0; }\n"
    f"API int fmi3Set{kind}(void *c, const unsigned *r, size_t n, const {type_} *v, size_t m)"
    " { (void)c; (void)r; (void)v; (void)m; return n ? 3 : 0; }\n"
    for kind, type_ in (
        ("Float32", "float"), ("Int8", "signed char"), ("UInt8", "unsigned char"), ("Int16", "short"),
        ("UInt16", "unsigned short"), ("Int32", "int"), ("UInt32", "unsigned"), ("Int64", "long long"),
        ("UInt64", "unsigned long long"), ("Boolean", "bool"), ("String", "Text"),
    )
)  # fmt: skip

_EXCHANGE_3 = (
    "CompletedIntegratorStep", "EnterContinuousTimeMode", "GetContinuousStateDerivatives", "GetContinuousStates",
    "GetEventIndicators", "GetNominalsOfContinuousStates", "GetNumberOfContinuousStates", "GetNumberOfEventIndicators",
    "SetContinuousStates", "SetTime", "UpdateDiscreteStates",
)  # fmt: skip
"""What model exchange has beside co-simulation."""

STEPS_3 = ("EnterStepMode", "GetOutputDerivatives", "DoStep")
"""What co-simulation has beside model exchange."""


def refused(names: tuple[str, ...]) -> str:
    """What the standard has a library export, and this description does not offer: each answers with an error."""
    return "".join(f"API int fmi3{name}(void *c, ...) {{ (void)c; return 3; }}\n" for name in names)


def refused_kind(*names: str) -> str:
    """An instance of another kind than the FMU is."""
    return "".join(
        f"API void *fmi3Instantiate{name}(Text name, ...) {{ (void)name; return NULL; }}\n" for name in names
    )


_REFUSED_3 = (
    "ActivateModelPartition", "EnterConfigurationMode", "EvaluateDiscreteStates", "ExitConfigurationMode",
    "GetAdjointDerivative", "GetClock", "GetDirectionalDerivative", "GetIntervalDecimal", "GetIntervalFraction",
    "GetNumberOfVariableDependencies", "GetShiftDecimal", "GetShiftFraction", "GetVariableDependencies",
    "SetClock", "SetIntervalDecimal", "SetIntervalFraction", "SetShiftDecimal", "SetShiftFraction",
)  # fmt: skip

FMI_3_COMMON = (
    r"""
#include <stdbool.h>
typedef const char *Text;
typedef void (*Logger)(void *, int, Text, Text);

static void say(const Unit *unit, int status, const char *text)
{
    Logger logger;
    memcpy(&logger, &unit->logger, sizeof logger);
    if (logger) logger(unit->environment, status, "logStatusError", text);
}

API const char *fmi3GetVersion(void) { return "3.0"; }
API int fmi3SetDebugLogging(void *c, bool on, size_t n, const Text *s) { (void)c; (void)on; (void)n; (void)s; return 0; }
API void fmi3FreeInstance(void *c) { free(c); }
API int fmi3EnterInitializationMode(void *c, bool has_tolerance, double tolerance, double start, bool has_end, double end)
{
    (void)has_tolerance; (void)tolerance; (void)has_end; (void)end;
    begin_at(c, start);
    return 0;
}
API int fmi3ExitInitializationMode(void *c) { (void)c; return 0; }
API int fmi3Terminate(void *c) { (void)c; return 0; }
API int fmi3Reset(void *c) { begin(c); return 0; }
API int fmi3GetFloat64(void *c, const unsigned *r, size_t n, double *v, size_t m)
{
    return m == n ? read_values(c, r, n, v) : 3;
}
API int fmi3SetFloat64(void *c, const unsigned *r, size_t n, const double *v, size_t m)
{
    return m == n ? write_values(c, r, n, v) : 3;
}
"""
    + _UNUSED_3
    + refused(_REFUSED_3)
    + r"""
API int fmi3GetBinary(void *c, const unsigned *r, size_t n, size_t *s, const unsigned char **v, size_t m)
{
    (void)c; (void)r; (void)s; (void)v; (void)m;
    return n ? 3 : 0;
}
API int fmi3SetBinary(void *c, const unsigned *r, size_t n, const size_t *s, const unsigned char *const *v, size_t m)
{
    (void)c; (void)r; (void)s; (void)v; (void)m;
    return n ? 3 : 0;
}
API int fmi3GetFMUState(void *c, void **state)
{
    *state = copied(&((Unit *)c)->m, *state);
    return *state ? 0 : 3;
}
API int fmi3SetFMUState(void *c, void *state) { copied(state, &((Unit *)c)->m); return 0; }
API int fmi3FreeFMUState(void *c, void **state) { (void)c; free(*state); *state = NULL; return 0; }
API int fmi3SerializedFMUStateSize(void *c, void *state, size_t *size)
{
    (void)c; (void)state;
    *size = sizeof(Moment);
    return 0;
}
API int fmi3SerializeFMUState(void *c, void *state, unsigned char *bytes, size_t size)
{
    (void)c;
    if (size < sizeof(Moment)) return 3;
    memcpy(bytes, state, sizeof(Moment));
    return 0;
}
API int fmi3DeserializeFMUState(void *c, const unsigned char *bytes, size_t size, void **state)
{
    (void)c;
    if (size < sizeof(Moment)) return 3;
    *state = malloc(sizeof(Moment));
    if (!*state) return 3;
    memcpy(*state, bytes, sizeof(Moment));
    return 0;
}
"""
)

FMI_3 = (
    FMI_3_COMMON
    + refused_kind("ModelExchange", "ScheduledExecution")
    + refused(("EnterEventMode", *_EXCHANGE_3))
    + r"""
API void *fmi3InstantiateCoSimulation(Text name, Text token, Text place, bool visible, bool logging, bool events, bool early,
    const unsigned *required, size_t n, void *environment, Logger logger, void *intermediate)
{
    void *stored;
    (void)place; (void)visible; (void)logging; (void)events; (void)early; (void)required; (void)n; (void)intermediate;
    memcpy(&stored, &logger, sizeof stored);
    return made(name, token, environment, stored);
}
API int fmi3EnterStepMode(void *c) { (void)c; return 0; }
API int fmi3GetOutputDerivatives(void *c, const unsigned *r, size_t n, const int *order, double *v, size_t m)
{
    (void)r; (void)n; (void)order; (void)v; (void)m;
    say(c, 3, "derivatives of the force are not given");
    return 3;
}
API int fmi3DoStep(void *c, double t, double h, bool final, bool *event, bool *terminate, bool *early, double *last)
{
    int status = step(c, t, h);
    (void)final;
    *event = *terminate = *early = false;
    *last = status ? t : t + h;
    return status;
}
"""
)
