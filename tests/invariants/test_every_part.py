"""True of every part of the catalogue."""

import shutil
import subprocess
from collections.abc import Iterable, Set

import numpy as np
import pytest
from _pytest.mark import ParameterSet

from dampyr.errors import InputError
from dampyr.export import export
from dampyr.models import Damper, available_parts, compose
from dampyr.models.codegen.series import UNKNOWN
from dampyr.models.part import Scale, part
from dampyr.models.path_integration import along, along_with_columns

FORCEFUL = [name for name in available_parts() if part(name).force is not None]
SERIES = [f"dahl + {name}" for name in available_parts() if part(name).stretch]
SERIES += ["modified_bouc_wen + inertia + spring + compliance + free_play", "bouc_wen + offset + compliance"]
FOLLOWING = [name for name in FORCEFUL if part(name).follows_velocity]  # behind a stretch they need its rate
SERIES += [f"{name} + spring + compliance" for name in FOLLOWING] + ["hysteretic_biviscous + inertia + free_play"]
TYPICAL = {
    "N": 100.0,
    "N s/m": 700.0,
    "N/m": 900.0,
    "1/m": 1500.0,
    "m": 0.05,
    "m/s": 0.01,
    "1/s": 0.4,
    "s": 0.006,
    "kg": 3.0,
    "m/N": 5e-7,
    "": 1.4,
}
# where the usual numbers have no finite force
INSTEAD = {"hardening_bouc_wen.rho": 20.0} | {f"asymmetric_bouc_wen.b{k}": 0.2 - 0.06 * k for k in range(2, 7)}
# its stops beyond the states of the tests, and no two sliders that begin to move together
INSTEAD |= {f"triple_pendulum.d{k}": 0.5 for k in (1, 2, 3)} | {
    f"triple_pendulum.l{k}": 2e-3 + 2e-3 * k for k in (1, 2, 3)
}
INSTEAD |= {"triple_pendulum.r3": 2.2, "triple_pendulum.uy": 0.01}


def typical(names: str) -> dict[str, float]:
    """A value inside the limits for each parameter, by flat name."""
    parameters = {f"{name}.{key}": q for name in names.split(" + ") for key, q in part(name).parameters.items()}
    return {key: INSTEAD.get(key, min(TYPICAL[q.unit], 0.5 * q.high)) for key, q in parameters.items()}


def path(n: int = 400) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    t = np.linspace(0.0, 1.0, n)
    x = 0.008 * np.sin(9.0 * t) + 0.002 * np.sin(31.0 * t)
    return t, x, 0.072 * np.cos(9.0 * t) + 0.062 * np.cos(31.0 * t)


STEPS = (1e-6, 1e-3)  # of a state: the force of a series is found to 1e-13 of it, so its states need the longer one
KINKED = {"maxwell_slip", "triple_pendulum"}  # a slip may fall inside the step of a numeric difference


def agree(name: str, ours: np.ndarray, *numeric: np.ndarray) -> None:
    """Equal to one of the numeric differences; of a part with kinks one sample in a hundred may not be."""
    off = [np.abs(ours - n) > 1e-6 * max(np.abs(n).max(), 1e-2) + 1e-7 * np.abs(n) for n in numeric]
    assert min(o.mean() for o in off) <= (0.01 if name in KINKED else 0.0)


# Kernels that take long to compile are proofs; a part that is new is not among them, so that `make test` looks at it.
LONG = {"bouc_wen_baber_noori", "modified_bouc_wen", *SERIES}
LONG_GRADIENTS = {
    "asymmetric", "asymmetric_bouc_wen", "bilinear", "bingham", "biviscous", "bouc_wen", "choi_polynomial", "force_table",
    "gamota_filisko", "gas_spring", "generalised_maxwell", "hardening_bouc_wen", "hysteretic_biviscous", "inertia", "lugre",
    "maxwell_slip", "power_law", "sigmoid", "triple_pendulum", *LONG,
}  # fmt: skip


def proved(names: Iterable[str], long: Set[str] = LONG) -> list[ParameterSet]:
    """The cases of these names, the long ones as proofs."""
    return [pytest.param(name, marks=[pytest.mark.prove] * (name in long)) for name in names]


@pytest.mark.parametrize("name", proved((*FORCEFUL, *SERIES), LONG_GRADIENTS))
def test_the_derived_gradient_is_the_gradient(name: str) -> None:
    p = np.array(list(typical(name).values()))
    s = np.full(compose(name).n_states, 0.2)
    agree_with_differences(name, p, s)


@pytest.mark.prove
@pytest.mark.parametrize("name", [one for one in SERIES if compose(one).layout.has_rate])
def test_so_is_that_of_a_stretch_with_an_unknown_past(name: str) -> None:
    agree_with_differences(name, np.array(list(typical(name).values())), np.array(compose(name).path0))


def agree_with_differences(name: str, p: np.ndarray, s: np.ndarray) -> None:
    composition, (t, x, v) = compose(name), path()
    _, J = along_with_columns(composition, t, x, v, p, s)
    for k, value in enumerate(p):
        h = 1e-5 * (value if name in SERIES else max(abs(value), 1e-3))
        up, down = p.copy(), p.copy()
        up[k] += h
        down[k] -= h
        numeric = (along(composition, t, x, v, up, s) - along(composition, t, x, v, down, s)) / (2 * h)
        agree(name, J[:, k], numeric)
    for j in composition.free_at_start if s.max(initial=0.0) == UNKNOWN else range(composition.n_states):
        unit = np.eye(composition.n_states)[j]
        sides = [
            (along(composition, t, x, v, p, s + h * unit), along(composition, t, x, v, p, s - h * unit), h)
            for h in STEPS
        ]
        agree(name, J[:, len(p) + j], *((up - down) / (2 * h) for up, down, h in sides))


@pytest.mark.parametrize("name", proved(FORCEFUL))
def test_the_force_is_proportional_to_what_a_part_says(name: str) -> None:
    composition = compose(name)
    t, x, v = path()
    values = typical(name)
    force = along(composition, t, x, v, np.array(list(values.values())))
    twice = [value * (1 + (key.partition(".")[2] in part(name).scaling)) for key, value in values.items()]
    np.testing.assert_allclose(along(composition, t, x, v, np.array(twice)), 2.0 * force, atol=1e-9)
    assert {composition.parameters[k].partition(".")[2] for k in composition.linear} <= set(part(name).scaling)


@pytest.mark.parametrize("name", available_parts())
def test_limits_hold_when_a_part_is_made(name: str) -> None:
    values = {key.partition(".")[2]: value for key, value in typical(name).items()}
    part(name).cls(**values)
    for key, quantity in part(name).parameters.items():
        for bad in (np.nan, *([quantity.low - 1.0] if np.isfinite(quantity.low) else [])):
            with pytest.raises(InputError, match=key):
                part(name).cls(**(values | {key: bad}))


@pytest.mark.parametrize("name", available_parts())
def test_a_part_says_where_it_comes_from(name: str) -> None:
    text = part(name).module.__doc__ or ""
    assert ".. math::" in text
    assert part(name).cls.__doc__


@pytest.mark.parametrize("name", available_parts())
def test_proposals_cover_what_is_not_linear(name: str) -> None:
    needed = {key for key, q in part(name).parameters.items() if not q.linear}
    for proposal in part(name).starts(Scale(stroke=0.02, speed=0.06, dt=0.01, force=500.0)):
        assert set(proposal) == needed
        for key, value in proposal.items():
            part(name).parameters[key].check(key, value)


@pytest.mark.parametrize("name", proved([*available_parts(), *(f"{name} + spring + compliance" for name in FOLLOWING)]))
def test_the_c_export_walks_the_same_path(name: str, tmp_path: pytest.TempPathFactory) -> None:
    if shutil.which("gcc") is None:
        pytest.skip("gcc is missing: the C export cannot be compiled")
    first = part(name.partition(" ")[0])
    parts = name if first.force else f"{name} + dahl"
    damper = Damper(parts, typical(parts))
    t, x, v = path()
    if first.lag:
        with pytest.raises(InputError, match="not its command"):
            export(damper, "c", tmp_path, inverse=True)
    if first.force and "a" in first.force.arguments:
        with pytest.raises(InputError, match="acceleration"):
            export(damper, "c", tmp_path)
        return
    np.testing.assert_allclose(run_c(damper, tmp_path, t, x, v), damper.force(t, x, voltage=0.0, velocity=v), rtol=1e-9)


MAIN = r"""
#include "damper.h"
#include <stdio.h>
int main(void)
{
    damper_state d; double t, x, v, u; int n = 0;
    while (scanf("%lf %lf %lf %lf", &t, &x, &v, &u) == 4)
        printf("%.17g\n", n++ ? damper_step(&d, t, x, v, u) : damper_start(&d, t, x, v, u));
    return 0;
}
"""


def run_c(damper: Damper, folder, t, x, v, u=0.0, **options):
    """The force that the exported C gives, compiled without a warning."""
    export(damper, "c", folder, **options)
    (folder / "main.c").write_text(MAIN)
    command = [
        "gcc",
        "-std=c99",
        "-Wall",
        "-Wextra",
        "-Wpedantic",
        "-Werror",
        "-O2",
        "damper.c",
        "main.c",
        "-o",
        "main",
        "-lm",
    ]
    subprocess.run(command, cwd=folder, check=True)
    rows = np.column_stack((t, x, v, np.broadcast_to(u, t.shape)))
    text = "\n".join(" ".join(repr(float(c)) for c in row) for row in rows)
    done = subprocess.run([str(folder / "main")], input=text, capture_output=True, text=True, check=True)
    return np.array(done.stdout.split(), dtype=float)
