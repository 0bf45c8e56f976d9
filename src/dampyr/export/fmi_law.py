"""A control law as an FMU of its own: what it measures goes in, the input for the damper's coil comes out.

It decides at its samples, a period apart from the start on, on what is set at that time, and holds its decision between. So an
input that is read after the measures of its time are set is that of `dampyr.structures.controller.ControllerRun`. Steps have to
end at the samples: one that passes over a sample is refused.
"""

from __future__ import annotations

from xml.sax.saxutils import quoteattr

from dampyr.export.fmi_text import CORE, FMI_2, FMI_3, STEPS, Variable, described
from dampyr.input_kinds import INPUTS
from dampyr.models import Damper
from dampyr.models.inverse import REASONS
from dampyr.structures.building import Building
from dampyr.structures.controller import Controller
from dampyr.structures.sensors import MEASURES, VECTORS


def law_variables(controller: Controller, damper: Damper) -> list[Variable]:
    """What it measures, in the order of the C; then the input that it decides on, and why a wanted force is not met."""
    listed = []
    for name, size in controller.sizes:
        measure = MEASURES[name]
        for k in range(size):
            unit = measure.unit if name != "state" else ("m" if k < size // 2 else "m/s")
            listed.append((f"{name}[{k + 1}]" if name in VECTORS else name, unit, "input", measure.about))
    law, word = controller.law, INPUTS[damper.input]
    listed.append((word, damper.input, "output", f"command to the coil, {law.low:g} to {law.high:g} {damper.input}"))
    if controller.formulas.asks_force:
        listed.append(
            ("reason", "", "output", "; ".join(f"{k} {text.replace('_', ' ')}" for k, text in enumerate(REASONS)))
        )
    return [Variable(*each, reference=k) for k, each in enumerate(listed)]


def law_description(
    controller: Controller, building: Building, damper: Damper, name: str, fmi: int, token: str, version: str
) -> str:
    """The text of modelDescription.xml; ``name`` is that of the FMU."""
    about = f"{type(controller.law).__name__} for a damper of {building.name}, every {controller.law.period:g} s"
    head = f'modelName={quoteattr(name)} description={quoteattr(about)} generationTool="dampyr {version}"'
    return described(name, head, token, fmi, law_variables(controller, damper), 0.0)


def law_wrapper(controller: Controller, name: str, fmi: int) -> str:
    """The C of the interface around ``name``.h, but for the line that defines INSTANTIATION_TOKEN."""
    asks = controller.formulas.asks_force
    core = (
        LAW_CORE.replace("@STEPS\n", STEPS)
        .replace("@REASON", "law.found.reason" if asks else "0")
        .replace("@VALUES", "2" if asks else "1")
    )
    core = core.replace("@COUNT", str(len(controller.rows))) + CORE[CORE.index("static Unit *made(") :]
    core = core.replace("@GUARD", name.upper()).replace("LAW_NAME", name)
    return core + (FMI_2 if fmi == 2 else FMI_3).replace("derivatives of the force", "derivatives of the input")


LAW_CORE = (
    '#include "LAW_NAME.h"\n'
    + CORE[CORE.index("#include <math.h>") : CORE.index("enum {")]
    + r"""
enum { COUNT = @COUNT, U = COUNT - 1, VALUES = @VALUES };
#define PERIOD @GUARD_PERIOD
#define HIT (1e-9*PERIOD) /* so near to a sample counts as there */

/* Everything that a step changes. */
typedef struct {
    LAW_NAME law;                          /* after the latest sample whose measures are final */
    double begun, now, at;                 /* s: the last doStep's times, and the first sample */
    double in[COUNT], slope[COUNT];        /* measures as they were set last, and their derivatives */
    double value[2];                       /* the decision, and its reason */
    long samples;
} Moment;

typedef struct {
    Moment m;
    void *environment;
    void *logger;
    char name[128];
} Unit;

static double next_sample(const Moment *m) { return m->at + (double)m->samples*PERIOD; }

/* Decide on what is set now, where it is time. */
static void decide_now(Moment *m)
{
    double y[COUNT];
    LAW_NAME law = m->law;
    if (m->samples && m->now < next_sample(m) - HIT) return;
    for (int k = 0; k < COUNT; k++) y[k] = m->in[k] + m->slope[k]*(m->now - m->begun);
    m->value[0] = LAW_NAME_decide(&law, y);
    m->value[1] = @REASON;
    m->law = law;
    if (!m->samples) m->at = m->now;
    m->samples++;
}

@STEPS
static int read_values(Unit *unit, const unsigned *refs, size_t n, double *values)
{
    Moment trial = unit->m;
    decide_now(&trial);
    for (size_t k = 0; k < n; k++) {
        unsigned r = refs[k];
        if (r >= COUNT + VALUES) {
            say(unit, 3, "there is no variable of that value reference");
            return 3;
        }
        values[k] = r < COUNT ? trial.in[r] + trial.slope[r]*(trial.now - trial.begun) : trial.value[r - COUNT];
    }
    return 0;
}

static int write_values(Unit *unit, const unsigned *refs, size_t n, const double *values)
{
    for (size_t k = 0; k < n; k++) {
        if (refs[k] >= COUNT || !isfinite(values[k])) {
            say(unit, 3, refs[k] >= COUNT ? "only inputs can be set" : "an input is not finite");
            return 3;
        }
    }
    set_inputs(&unit->m, refs, n, values);
    return 0;
}

static int step(Unit *unit, double t, double h)
{
    Moment *m = &unit->m;
    if (!goes_forward(unit, t, h)) return 3;
    if (!m->samples) m->begun = m->now = t;
    decide_now(m);
    if (t + h > next_sample(m) + HIT) {
        char text[200];
        snprintf(text, sizeof text, "a step from %g s to %g s passes over the law's sample at %g s; end a step there",
            t, t + h, next_sample(m));
        say(unit, 3, text);
        return 3;
    }
    for (int k = 0; k < COUNT; k++) m->in[k] += m->slope[k]*(m->now - m->begun);
    m->begun = t;
    m->now = t + h;
    return 0;
}

static void begin(Unit *unit)
{
    memset(&unit->m, 0, sizeof unit->m);
    LAW_NAME_start(&unit->m.law);
}

"""
)
