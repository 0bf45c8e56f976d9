"""The C export of whole cards."""

import shutil
import subprocess

import numpy as np
import pytest
from tests.invariants.test_every_part import run_c

from dampyr.errors import InputError
from dampyr.export import export
from dampyr.models import Damper, Interpolation, Polynomial

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is missing: the C export cannot be compiled")


def everything() -> Damper:
    """A damper of many parts with every kind of law."""
    return Damper(
        "bouc_wen + hyperbolic_tangent + spring + delay + offset",
        {
            "bouc_wen.c0": Polynomial((500.0, 20.0), 0, 3),
            "bouc_wen.k0": 100.0,
            "bouc_wen.kw": Polynomial((300.0, 100.0, -10.0), 0, 3),
            "bouc_wen.rho": 2000.0,
            "bouc_wen.sigma": 1.3,
            "bouc_wen.n": Interpolation((0.0, 1.0, 3.0), (1.3, 1.5, 2.2)),
            "hyperbolic_tangent.c": 3.0,
            "hyperbolic_tangent.ft": Interpolation((0.0, 1.0, 2.0, 3.0), (100.0, 150.0, 190.0, 200.0)),
            "hyperbolic_tangent.v0": 0.01,
            "hyperbolic_tangent.s": -0.3,
            "spring.k0": -200.0,
            "delay.tau": Polynomial((0.005, 0.001), 0, 3),
            "offset.f0": 30.0,
        },
    )


@needs_gcc
def test_a_loaded_card_in_c_follows_a_varying_voltage(tmp_path) -> None:
    card = everything().save(tmp_path / "card.toml")
    damper = Damper.load(card)
    t = np.linspace(0.0, 3.0, 2001)
    x = 0.01 * np.sin(6.0 * t * t)
    v = np.gradient(x, t)
    u = 1.5 + 1.4 * np.sin(5.0 * t)
    force = damper.force(t, x, voltage=u, velocity=v)
    np.testing.assert_allclose(run_c(damper, tmp_path, t, x, v, u), force, atol=1e-9 * np.abs(force).max())


@needs_gcc
def test_outside_the_range_c_gives_no_number_unless_allowed(tmp_path) -> None:
    t, x, v = np.array([0.0, 0.1, 0.2]), np.array([0.0, 1e-3, 2e-3]), np.full(3, 0.01)
    assert np.all(np.isnan(run_c(everything(), tmp_path, t, x, v, 3.2)))
    assert np.all(np.isfinite(run_c(everything(), tmp_path, t, x, v, 3.2, allow_extrapolation=True)))


@needs_gcc
def test_a_delay_longer_than_the_history_gives_no_number(tmp_path) -> None:
    damper = Damper("dahl + delay", {"dahl.kx": 1.0, "dahl.kw": 9.0, "dahl.rho": 100.0, "delay.tau": 0.5})
    t = np.arange(6000) * 1e-4
    x = 1e-3 * np.sin(40 * t)
    force = run_c(damper, tmp_path, t, x, np.zeros_like(t))
    assert np.all(np.isfinite(force[:4000]))
    assert np.isnan(force[5500])


def test_names_that_c_cannot_use_are_refused(tmp_path) -> None:
    with pytest.raises(InputError, match="cannot name a C function"):
        export(everything(), "c", tmp_path, name="2nd damper")


def test_unknown_kinds_are_named(tmp_path) -> None:
    with pytest.raises(InputError, match=r"choose from .*\bc\b"):
        export(everything(), "cc", tmp_path)


@needs_gcc
def test_two_dampers_fit_in_one_c_program(tmp_path) -> None:
    export(everything(), "c", tmp_path, name="front")
    export(Damper("dahl", {"dahl.kx": 1.0, "dahl.kw": 9.0, "dahl.rho": 100.0}), "c", tmp_path, name="rear")
    (tmp_path / "both.c").write_text(
        '#include "front.h"\n#include "rear.h"\nint main(void) { return rear_in_range(9.0); }\n'
    )
    subprocess.run(
        ["gcc", "-std=c99", "-Werror", "front.c", "rear.c", "both.c", "-o", "both", "-lm"],
        cwd=tmp_path,
        check=True,
    )
    assert subprocess.run([tmp_path / "both"], check=False).returncode == 0
