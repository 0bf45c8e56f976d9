"""The Modelica package: its equations, read and integrated by an own reader and by the compiler Rumoca, give dampyr's force."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.export.every_law import everything
from tests.export.modelica_reader import Model
from tests.export.test_fmi_exchange import LAGGED, check, constants

from dampyr.errors import InputError
from dampyr.export import export
from dampyr.input_kinds import input_arguments
from dampyr.models import Damper, available_parts
from dampyr.models.part import part
from dampyr.studies import raminelli_2020

REFUSED = {"bilinear", "choi_polynomial", "compliance", "delay", "free_play", "hysteretic_biviscous", "inertia",
           "maxwell_slip", "shutting_bleed", "sigmoid", "triple_pendulum"}  # fmt: skip
WRITTEN = sorted(set(available_parts()) - REFUSED)
OMEGA, AMPLITUDE = 2.0 * np.pi, 0.012
T = np.linspace(0.0, 0.75, 301)  # turns round at 0.25 and 0.75 s, samples both
TOLERANCE = 1e-10


def damper_with(name: str) -> Damper:
    """The part, beside a spring where it is a model and beside Dahl where it is an add-on."""
    if name == "lag":
        return LAGGED
    return constants(f"dahl + {name}" if part(name).add_on or name == "spring" else f"{name} + spring")


def motion(t: Any) -> tuple[Any, Any]:
    return AMPLITUDE * np.sin(OMEGA * t), AMPLITUDE * OMEGA * np.cos(OMEGA * t)


def command(damper: Damper, t: Any) -> Any:
    low, high = damper.range
    return 0.5 * (low + high) + 0.45 * (high - low) * np.sin(3.0 * t) if damper.has_input else 0.0 * t


def expected(damper: Damper, m: int = 64) -> np.ndarray:
    """Dampyr's force on refined paths, extrapolated: of second order in the motion, of first in an input that varies."""

    def refined(parts: int) -> np.ndarray:
        t = np.linspace(T[0], T[-1], (T.size - 1) * parts + 1)
        x, v = motion(t)
        return damper.force(t, x, velocity=v, **input_arguments(damper.input, command(damper, t)))[::parts]

    coarse, fine = refined(m), refined(2 * m)
    return fine + (fine - coarse) / (1.0 if damper.has_input else 3.0)


def text_of(damper: Damper, folder: Path, name: str = "damper", **options: Any) -> str:
    [path] = export(damper, "modelica", folder, name=name, **options)
    return path.read_text(encoding="utf-8")


def read(damper: Damper, folder: Path, tolerance: float = TOLERANCE) -> np.ndarray:
    """The force by the tests' own reader and SciPy."""
    word = {"V": "voltage", "A": "current"}.get(damper.input, "")

    def signals(t: float) -> dict[str, float]:
        x, v = motion(t)
        return {"displacement": x, "velocity": v} | ({word: command(damper, t)} if damper.has_input else {})

    return Model(text_of(damper, folder)).force(T, signals, tolerance)


@pytest.mark.parametrize("damper", [raminelli_2020.damper(), everything().without("delay")], ids=["dahl", "every law"])
def test_its_equations_give_the_force_of_dampyr(tmp_path: Path, damper: Damper) -> None:
    """With an input that varies, to 1e-6 of the largest force."""
    check(read(damper, tmp_path), expected(damper))


@pytest.mark.prove
@pytest.mark.parametrize("name", WRITTEN)
def test_the_equations_of_every_part(tmp_path: Path, name: str) -> None:
    """To 2e-7, most of which is left of dampyr's steps."""
    check(read(damper_with(name), tmp_path), expected(damper_with(name)), 2e-7)


DRIVEN = """
model Driven
  damper.Equations d;
equation
  d.displacement = {a!r}*sin({w!r}*time);
  d.velocity = {v!r}*cos({w!r}*time);{u}
end Driven;
"""


def compiled(folder: Path, text: str, model: str, dt: float, signal: str) -> tuple[np.ndarray, np.ndarray]:
    """The times and a signal of a model, by Rumoca."""
    rumoca = pytest.importorskip("rumoca", reason="Rumoca, a compiler of Modelica, is missing; make rumoca installs it")
    path = folder / "whole" / "whole.mo"  # it reads the package beside a file, too
    path.parent.mkdir()
    path.write_text(text, encoding="utf-8")
    result = rumoca.Session().load(str(path), model=model).simulate(
        t=(0.0, float(T[-1])), config=rumoca.SimConfig(dt=dt, rtol=1e-9, atol=1e-12)
    )  # fmt: skip
    return np.asarray(result.time), np.asarray(result[signal])


@pytest.mark.prove
@pytest.mark.parametrize("name", WRITTEN)
def test_a_compiler_of_modelica_simulates_it(tmp_path: Path, name: str) -> None:
    """Rumoca's own parser, sorting and solver."""
    damper = damper_with(name)
    low, high = damper.range
    mean, swing = 0.5 * (low + high), 0.45 * (high - low)
    u = f"\n  d.voltage = {float(mean)!r} + {float(swing)!r}*sin(3.0*time);" if damper.has_input else ""
    driven = DRIVEN.format(a=AMPLITUDE, w=float(OMEGA), v=float(AMPLITUDE * OMEGA), u=u)
    t, force = compiled(tmp_path, text_of(damper, tmp_path) + driven, "Driven", float(T[1]), "d.force")
    assert t.size == T.size
    check(force, expected(damper))


FLANGES = """
package Modelica "What the model between two flanges takes from the standard library, in the words of these tests"
  package Mechanics
    package Translational
      package Interfaces
        connector Flange
          Real s;
          flow Real f;
        end Flange;
        partial model PartialCompliant
          Flange flange_a;
          Flange flange_b;
          Real s_rel(start=0);
          Real f;
        equation
          s_rel = flange_b.s - flange_a.s;
          flange_b.f = f;
          flange_a.f = -f;
        end PartialCompliant;
      end Interfaces;
    end Translational;
  end Mechanics;
end Modelica;
model Mass
  parameter Real m = 2.0;
  Modelica.Mechanics.Translational.Interfaces.Flange flange;
  Real s(start=0.01, fixed=true);
  Real v(start=0.0, fixed=true);
equation
  flange.s = s;
  der(s) = v;
  m*der(v) = flange.f - 4000.0*s;
end Mass;
model Ground
  Modelica.Mechanics.Translational.Interfaces.Flange flange;
equation
  flange.s = 0.0;
end Ground;
model Free
  damper.Translational d;
  Mass mass;
  Ground ground;
equation
  connect(ground.flange, d.flange_a);
  connect(d.flange_b, mass.flange);
end Free;
"""


@pytest.mark.prove
def test_between_flanges_it_damps_a_mass(tmp_path: Path) -> None:
    """A mass on a spring, let go from 10 mm: by Rumoca with a stand-in for the library's interface, and by SciPy here."""
    from scipy.integrate import solve_ivp

    damper = Damper("dahl", {"dahl.kx": 10.0, "dahl.kw": 8.0, "dahl.rho": 500.0}, input="none")
    t, s = compiled(tmp_path, text_of(damper, tmp_path) + FLANGES, "Free", float(T[1]), "mass.s")

    def slope(_: float, y: np.ndarray) -> list[float]:
        place, v, w = y
        return [v, -(4000.0 * place + 10.0 * v + 8.0 * w) / 2.0, 500.0 * (v - abs(v) * w)]

    own = solve_ivp(slope, (0.0, float(T[-1])), [0.01, 0.0, 0.0], t_eval=t, rtol=1e-10, atol=1e-13).y[0]
    assert np.min(own) < -0.005  # it swings through
    np.testing.assert_allclose(s, own, rtol=0.0, atol=1e-7)


def test_the_package_says_units_range_and_origin(tmp_path: Path) -> None:
    text = text_of(raminelli_2020.damper(), tmp_path)
    for line in (
        'package damper "A damper: dahl"',
        'input Real voltage(unit="V") "at the coil";',
        'Real dahl_kx(unit="N.s/m") "at the present voltage";',
        'Real dahl_w(unit="1", start=0.0, fixed=true) "memory, 0 at rest";',
        "der(dahl_w) = dahl_rho*(velocity - abs(velocity)*dahl_w);",
        "force = dahl_kx*velocity + dahl_kw*dahl_w;",
        '"the voltage is outside the calibrated 0 to 3.212 V"',
        "extends Modelica.Mechanics.Translational.Interfaces.PartialCompliant;",
    ):
        assert line in text
    assert re.search(r"Written by dampyr \S+\. dahl; the damper is calibrated from 0 to 3.212 V\.", text)
    assert max(map(len, text.splitlines())) <= 128
    assert "assert(" not in text_of(raminelli_2020.damper(), tmp_path, "wide", allow_extrapolation=True)
    model = Model(text)
    with pytest.raises(AssertionError, match="an assertion of the model fails"):
        model.values(np.zeros(1), {"displacement": 0.0, "velocity": 0.0, "voltage": 3.3})
    assert 'parameter Real dahl_kw(unit="N") = 300.0;' in text_of(constants("dahl"), tmp_path, "constants")


def test_what_has_no_modelica_form_is_said(tmp_path: Path) -> None:
    for damper, name, words in (
        (constants("dahl"), "model", "'model' has a meaning in Modelica; give the damper another name"),
        (constants("dahl"), "Equations", "'Equations' has a meaning in Modelica"),
        (constants("dahl"), "two words", "'two words' cannot name"),
        (constants("maxwell_slip"), "damper", "maxwell_slip is no differential equation for a solver"),
        (constants("dahl + inertia"), "damper", "inertia needs the acceleration"),
    ):
        with pytest.raises(InputError, match=words):
            export(damper, "modelica", tmp_path / "new", name=name)
    with pytest.raises(InputError, match="fmi is not an option of the export modelica; it has no options"):
        export(constants("dahl"), "modelica", tmp_path / "new", fmi=2)
    assert not (tmp_path / "new").exists()
