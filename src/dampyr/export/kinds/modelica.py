"""Modelica: a package with the damper's equations, a model between two flanges, and an example to simulate."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill, wrap

from dampyr.atomic_write import write_whole
from dampyr.errors import InputError
from dampyr.export.fmi_exchange import NOMINAL
from dampyr.export.kinds.c import WIDTH, before_use, check_exportable, check_name
from dampyr.export.modelica_text import KEYWORDS, UNITS, Equations, number
from dampyr.input_kinds import INPUTS
from dampyr.models import Constant, Damper, Interpolation, Polynomial
from dampyr.models.codegen.layout import Slot
from dampyr.models.codegen.rates import check_has_rates
from dampyr.models.laws import Law
from dampyr.source_digest import full_version

MODELS = ("Equations", "Translational", "Example")

SINE = (0.005, 1.0)  # m and Hz of the example, where the damper's range allows it


def write(damper: Damper, folder: Path, name: str, allow_extrapolation: bool = False) -> list[Path]:
    """Write ``name.mo``, a package of three models.

    ``Equations`` is the force [N] from displacement [m], velocity [m/s] and the input at the coil, or its command where the
    damper has a `lag`; ``Translational`` the same between two flanges of the Modelica Standard Library; ``Example`` drives the
    equations by a sine. Raises :class:`~dampyr.errors.InputError` for a damper that is no differential equation, and for a name
    that Modelica has taken.
    """
    check_name(name)
    if name in KEYWORDS or name in MODELS:
        raise InputError(f"{name!r} has a meaning in Modelica; give the damper another name (--name)")
    check_exportable(damper)
    check_has_rates(damper.composition)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.mo"
    write_whole(path, modelica_package(damper, name, allow_extrapolation))
    return [path]


def modelica_package(damper: Damper, name: str, allow_extrapolation: bool = False) -> str:
    """The text of the package."""
    about = [
        f"Written by dampyr {full_version()}. {damper.composition}; the damper {damper.range_words}.",
        "A positive force opposes a positive velocity. SI units.",
        *([f"{notice}."] if (notice := damper.origin.notice) else []),
        *wrap(before_use(damper), WIDTH),
    ]
    comments = "\n".join(f"  // {line}" for line in about)
    return f"""\
package {name} "A damper: {damper.composition}"
{comments}

{_equations(damper, allow_extrapolation)}

{_translational(damper)}

{_example(damper)}
end {name};
"""


def _flat(name: str) -> str:
    return name.replace(".", "_")


def _places(slot: Slot) -> dict[str, str]:
    """The arguments of a part's formulas as variables of the model."""
    own = {key: f"{slot.part.name}_{key}" for key in (*slot.part.states, *slot.part.parameters)}
    shared = {argument: _flat(flat) for argument, flat in slot.part.shared.items()}
    return own | shared | {"x": "displacement", "v": "velocity"}


def _equations(damper: Damper, allow_extrapolation: bool) -> str:
    composition, equations = damper.composition, Equations()
    word = INPUTS.get(damper.input, "") if damper.has_input else ""
    acting = f"acting_{word}" if damper.input_lag else word
    units = {f"{p.name}.{key}": q.unit for p in composition.parts for key, q in p.parameters.items()}
    constants, followed, laws = [], [], []
    for key, law in damper.all_laws.items():
        unit = UNITS[units[key]]
        if isinstance(law, Constant):
            constants.append(f'    parameter Real {_flat(key)}(unit="{unit}") = {number(law.value)};')
        else:
            followed.append(f'    Real {_flat(key)}(unit="{unit}") "at the present {word}";')
            laws.append(f"{_flat(key)} = {_law(law, acting, key)};")
    states = []
    for key, (low, high) in composition.states.items():
        kind = 'unit="1", ' if high - low < float("inf") else f'unit="m", nominal={NOMINAL["m"]!r}, '
        states.append(f'    Real {_flat(key)}({kind}start=0.0, fixed=true) "memory, 0 at rest";')
    slopes, forces = [], []
    for slot in composition.layout.slots:
        if slot.part.rates is not None:
            values = equations.value_of(slot.part.rates, _places(slot))
            names = [f"{slot.part.name}_{state}" for state in slot.part.states]
            slopes += [f"der({state}) = {value};" for state, value in zip(names, values, strict=True)]
        if slot.part.force is not None:
            forces += equations.value_of(slot.part.force, _places(slot))
    inputs = [
        '    input Real displacement(unit="m") "extension positive";',
        '    input Real velocity(unit="m/s");',
    ]
    initial, checks = [], []
    if word:
        where = "command of the coil" if damper.input_lag else "at the coil"
        inputs.append(f'    input Real {word}(unit="{damper.input}") "{where}";')
        if not allow_extrapolation:
            low, high = damper.range
            slack = 1e-9 * max(abs(low), abs(high), 1.0)
            checks = [
                f"assert({word} >= {number(low - slack)} and {word} <= {number(high + slack)},",
                f'  "the {word} is outside the calibrated {low:g} to {high:g} {damper.input}");',
            ]
    if damper.input_lag:
        states.append(f'    Real {acting}(unit="{damper.input}") "at the coil, follows the command";')
        slopes.append(f"der({acting}) = ({word} - {acting})/{number(damper.input_lag)};")
        initial = ["  initial equation", f"    {acting} = {word};"]
    lines = [*laws, *equations.lines, *slopes, f"force = {' + '.join(forces)};"]
    helpers = [f'    Real {variable} "{words}";' for variable, words in equations.variables.items()]
    return "\n".join(
        [
            *(f"{text}\n" for text in equations.functions.values()),
            '  model Equations "The force from the motion"',
            *constants,
            *inputs,
            '    output Real force(unit="N");',
            *followed,
            *states,
            *(["  protected", *helpers] if helpers else []),
            *initial,
            "  equation",
            *(f"    {line}" for line in checks),
            *(
                fill(line, WIDTH, initial_indent="    ", subsequent_indent="      ", break_long_words=False)
                for line in lines
            ),
            "  end Equations;",
        ]
    )


def _law(law: Law, u: str, key: str) -> str:
    """A law over the input as an expression."""
    if isinstance(law, Polynomial):
        text = number(law.coefficients[-1])
        for c in reversed(law.coefficients[:-1]):
            text = f"{number(c)} + {u}*({text})"
        return text
    if isinstance(law, Interpolation):
        pieces = []
        for knot, row in zip(law.knots[:-1], law.pieces.T, strict=True):
            d = f"({u} - {number(knot)})"
            a0, a1, a2, a3 = map(number, row)
            pieces.append(f"{a0} + {d}*({a1} + {d}*({a2} + {d}*{a3}))")
        text = pieces[-1]
        for knot, piece in zip(reversed(law.knots[1:-1]), reversed(pieces[:-1]), strict=True):
            text = f"if {u} < {number(knot)} then {piece} else {text}"
        return f"noEvent({text})" if len(pieces) > 1 else text
    raise InputError(f"the law of {key}, {law!r}, has no Modelica form; choose constant, polynomial or interpolation")


def _translational(damper: Damper) -> str:
    word = INPUTS.get(damper.input, "") if damper.has_input else ""
    declared = f'    input Real {word}(unit="{damper.input}");\n' if word else ""
    joined = f"    damper.{word} = {word};\n" if word else ""
    return f"""\
  model Translational "The damper between two flanges of the Modelica Standard Library"
    extends Modelica.Mechanics.Translational.Interfaces.PartialCompliant;
{declared}    Equations damper;
  equation
    damper.displacement = s_rel;
    damper.velocity = der(s_rel);
{joined}    f = damper.force;
  end Translational;"""


def _example(damper: Damper) -> str:
    word = INPUTS.get(damper.input, "") if damper.has_input else ""
    amplitude = min(SINE[0], 0.9 * damper.ranges.get("displacement", (0.0, SINE[0]))[1])
    speed = 0.9 * damper.ranges.get("velocity", (0.0, float("inf")))[1]
    omega = min(6.283185307179586 * SINE[1], speed / amplitude)
    held = f"    damper.{word} = {number(damper.range[1])};\n" if word else ""
    return f"""\
  model Example "A sine of {1e3 * amplitude:g} mm"
    Equations damper;
  equation
    damper.displacement = {number(amplitude)}*sin({number(omega)}*time);
    damper.velocity = {number(amplitude * omega)}*cos({number(omega)}*time);
{held}    annotation(experiment(StartTime=0.0, StopTime=2.0, Tolerance=1e-8));
  end Example;"""
