"""OpenSees: uniaxial materials in Python and in Tcl, for Dahl's and Bouc-Wen's models at constant inputs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from textwrap import wrap

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.errors import InputError
from dampyr.export.kinds.c import WIDTH, before_use, check_name
from dampyr.input_kinds import INPUTS
from dampyr.models import Damper, Interpolation
from dampyr.source_digest import full_version

HYSTERETIC = ("dahl", "bouc_wen")
ALLOWED = (*HYSTERETIC, "spring", "offset")
NODES = 5  # inputs of a law without nodes of its own
LETTERS = "ko N, n, gamma 1/m, beta 1/m, Ao 1/m, E N/m, eta N s/m"
DEFINED = """\
    ops.uniaxialMaterial("BoucWen", tag + 1, 0.0, m["ko"], m["n"], m["gamma"], m["beta"], m["Ao"], 0.0, 0.0, 0.0, 1e-10, 50)
    ops.uniaxialMaterial("Elastic", tag + 2, m["E"], m["eta"])
    ops.uniaxialMaterial("Parallel", tag, tag + 1, tag + 2)
"""
NUMBERS = ("ko", "n", "gamma", "beta", "Ao", "E", "eta")


def write(
    damper: Damper,
    folder: Path,
    name: str,
    allow_extrapolation: bool = False,
    *,
    inputs: Sequence[float] = (),
) -> list[Path]:
    r"""Write ``name.py`` and ``name.tcl``, which define one material for each input, numbered from 1.

    The material is a `Parallel` of a `BoucWen` with alpha = 0 and an `Elastic` with the stiffness and the damping beside it. In
    OpenSees' letters :math:`\dot z = (A_o - |z|^n (\gamma + \beta\,\mathrm{sgn}(\dot x z))) \dot x` and the force is
    :math:`k_o z`: ``Ao`` = rho, ``beta`` = rho sigma, ``gamma`` = rho (1 - sigma), ``ko`` = kw, with n = sigma = 1 of Dahl's.
    ``inputs`` are V or A; without them the nodes of the laws, or five inputs over the calibrated range. A damper without an
    input is one material. The static offset is left out. Raises :class:`InputError` for a damper of other parts: `dampyr serve`
    gives OpenSees these.
    """
    check_name(name)
    parts = [part.name for part in damper.composition.parts]
    others = [part for part in parts if part not in ALLOWED]
    if others or sum(part in HYSTERETIC for part in parts) != 1:
        why = (
            f"{', '.join(others)} {'has' if len(others) == 1 else 'have'} no material"
            if others
            else "it has no such part"
        )
        raise InputError(
            f"OpenSees has materials for one {' or '.join(HYSTERETIC)}, with or without spring and offset; {why}. "
            "dampyr serve CARD --opensees PORT runs any damper in OpenSees"
        )
    if len(inputs) and not damper.has_input:
        raise InputError("the damper has no input, and inputs are given; leave them out")
    at = np.atleast_1d(np.asarray(inputs, dtype=float)) if len(inputs) else _nodes(damper)
    damper.check_input(at, allow_extrapolation)
    rows = [_material(damper, float(u), allow_extrapolation) for u in at]
    folder.mkdir(parents=True, exist_ok=True)
    python, tcl = folder / f"{name}.py", folder / f"{name}.tcl"
    write_whole(python, _python(damper, name, at.tolist(), rows))
    write_whole(tcl, _tcl(damper, name, at.tolist(), rows))
    return [python, tcl]


def _nodes(damper: Damper) -> np.ndarray:
    """The inputs that the laws have nodes at; of laws without nodes, inputs over the range."""
    low, high = damper.range
    knots = {float(k) for law in damper.all_laws.values() if isinstance(law, Interpolation) for k in law.knots}
    return np.array(sorted(knots)) if knots else np.unique(np.linspace(low, high, NODES))


def _material(damper: Damper, u: float, allow_extrapolation: bool) -> dict[str, float]:
    """The numbers of a material in OpenSees' letters."""
    p = dict(zip(damper.all_laws, damper.values(u, allow_extrapolation=allow_extrapolation), strict=True))
    stiffness = float(p.get("spring.k0", 0.0))
    if "dahl.rho" in p:
        kx, kw, rho, n, sigma = p["dahl.kx"], p["dahl.kw"], p["dahl.rho"], 1.0, 1.0
    else:
        kx, kw, rho = p["bouc_wen.c0"], p["bouc_wen.kw"], p["bouc_wen.rho"]
        n, sigma = p["bouc_wen.n"], p["bouc_wen.sigma"]
        stiffness += p["bouc_wen.k0"]
    values = (kw, n, rho * (1.0 - sigma), rho * sigma, rho, stiffness, kx)
    return {key: float(value) for key, value in zip(NUMBERS, values, strict=True)}


def _head(damper: Damper, name: str) -> list[str]:
    left_out = "; its static offset is left out" if "offset.f0" in damper.all_laws else ""
    return [
        f"{name}: a damper written by dampyr {full_version()}, {damper.composition}{left_out}.",
        *([f"{notice}."] if (notice := damper.origin.notice) else []),
        "Units: m, N, s." + " One material for each input at the coil, which stays constant." * damper.has_input,
        "OpenSees integrates BoucWen by backward Euler: its error is proportional to the step. Halve it until the peaks stay.",
        *wrap(before_use(damper), WIDTH),
    ]


def _python(damper: Damper, name: str, at: list[float], rows: list[dict[str, float]]) -> str:
    first, *rest = _head(damper, name)
    text = "\n".join([first, "", *rest])
    if not damper.has_input:
        return f'''"""{text}

    import {name}
    {name}.define(ops, 100)  # material 100
    ops.element("zeroLength", 5, 1, 2, "-mat", 100, "-dir", 1)
"""

# {LETTERS}
MATERIAL = {rows[0]!r}


def define(ops, tag):
    """Define the material `tag`, and with it tag + 1 and tag + 2, of the damper."""
    m = MATERIAL
{DEFINED}'''
    word, unit = INPUTS[damper.input], damper.input
    table = "\n".join(f"    {u!r}: {row!r}," for u, row in zip(at, rows, strict=True))
    return f'''"""{text}

    import {name}
    {name}.define(ops, 100, {word}={at[0]!r})  # material 100
    ops.element("zeroLength", 5, 1, 2, "-mat", 100, "-dir", 1)
"""

MATERIALS = {{  # {word} in {unit}: {LETTERS}
{table}
}}


def define(ops, tag, {word}):
    """Define the material `tag`, and with it tag + 1 and tag + 2, of the damper at this {word} [{unit}]."""
    if {word} not in MATERIALS:
        raise ValueError(f"{word} = {{{word}}} {unit} has no material; choose from {{', '.join(map(str, MATERIALS))}} {unit}")
    m = MATERIALS[{word}]
{DEFINED}'''


def _tcl(damper: Damper, name: str, at: list[float], rows: list[dict[str, float]]) -> str:
    lines = [f"# {line}" for line in _head(damper, name)]
    which = "at the k-th input is material [expr 3*$k + $" if damper.has_input else "is material $"
    end = "]" * damper.has_input
    lines.append(f"# The damper {which}{name}_first{end}; set {name}_first before, or it is 1.")
    lines.append(f"if {{![info exists {name}_first]}} {{ set {name}_first 1 }}")
    for k, (u, m) in enumerate(zip(at, rows, strict=True)):
        tag = [f"[expr ${name}_first + {3 * k + j}]" for j in range(3)]
        letters = " ".join(repr(m[key]) for key in ("ko", "n", "gamma", "beta", "Ao"))
        lines += [
            *([f"# {u!r} {damper.input}"] if damper.has_input else []),
            f"uniaxialMaterial BoucWen {tag[1]} 0.0 {letters} 0.0 0.0 0.0 1e-10 50",
            f"uniaxialMaterial Elastic {tag[2]} {m['E']!r} {m['eta']!r}",
            f"uniaxialMaterial Parallel {tag[0]} {tag[1]} {tag[2]}",
        ]
    return "\n".join(lines) + "\n"
