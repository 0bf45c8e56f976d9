"""The C export of whole cards."""

import shutil
import subprocess

import numpy as np
import pytest
from tests.export.every_law import everything
from tests.invariants.test_every_part import MAIN, SERIES, run_c, typical

from dampyr.errors import InputError
from dampyr.export import export
from dampyr.models import Constant, Damper, available_parts
from dampyr.models.inverse import REASONS
from dampyr.models.part import part
from dampyr.studies import raminelli_2020

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is missing: the C export cannot be compiled")
needs_make = pytest.mark.skipif(
    shutil.which("make") is None, reason="make is missing: the exported vectors cannot be replayed"
)


@needs_gcc
@pytest.mark.prove
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
    laws = {"dahl.kx": Constant(1.0, 0.0, 3.0), "dahl.kw": 9.0, "dahl.rho": 100.0}
    export(Damper("dahl", laws), "c", tmp_path, name="rear")
    (tmp_path / "both.c").write_text(
        '#include "front.h"\n#include "rear.h"\nint main(void) { return rear_in_range(9.0); }\n'
    )
    subprocess.run(
        ["gcc", "-std=c99", "-Werror", "front.c", "rear.c", "both.c", "-o", "both", "-lm"],
        cwd=tmp_path,
        check=True,
    )
    assert subprocess.run([tmp_path / "both"], check=False).returncode == 0


@needs_gcc
@pytest.mark.prove
def test_a_sigmoid_behind_a_compliance_at_10_khz_is_the_same_in_c(tmp_path) -> None:
    """It turns within vh of zero, where its own law has several roots in series: rounding chose among them."""
    laws = {"sigmoid.ft": 150.0, "sigmoid.c": 3000.0, "sigmoid.vk": 0.03, "sigmoid.vh": 0.008, "compliance.s": 5e-7}
    t = np.arange(10_000) * 1e-4
    v = 0.005 * np.minimum(t / 0.01, 1.0) + 0.007 * np.sin(2 * np.pi * 10.0 * t)
    x = np.concatenate([[0.0], np.cumsum(0.5e-4 * (v[1:] + v[:-1]))])
    damper = Damper("sigmoid + compliance", laws)
    force = damper.force(t, x, voltage=0.0, velocity=v)
    np.testing.assert_allclose(run_c(damper, tmp_path, t, x, v, 0.0), force, rtol=0.0, atol=1e-9 * np.abs(force).max())


STRICT = "-std=c99 -O2 -Wall -Wextra -Wconversion -Wdouble-promotion -pedantic -Werror"
# Their kernels take long to compile; a new part is looked at by `make test`.
LONG = {
    "asymmetric", "asymmetric_bouc_wen", "bilinear", "bingham", "biviscous", "bouc_wen", "bouc_wen_baber_noori",
    "choi_polynomial", "force_table", "gamota_filisko", "gas_spring", "generalised_maxwell", "hardening_bouc_wen",
    "hysteretic_biviscous", "lugre", "maxwell_slip", "modified_bouc_wen", "offset", "power_law", "sigmoid",
    "spring", "triple_pendulum", *SERIES,
}  # fmt: skip
LIBRARY = [name for name in available_parts() if part(name).force is not None and "inertia" not in name]


@needs_gcc
@needs_make
@pytest.mark.parametrize("single", [False, True], ids=["double", "float"])
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.prove] * (name in LONG))
        for name in (*LIBRARY, *(name for name in SERIES if "inertia" not in name))
    ],
)
def test_the_exported_vectors_replay_without_a_warning(tmp_path, name: str, single: bool) -> None:
    """In double precision to 1e-9 of the largest force, in single precision to 1e-4."""
    export(Damper(name, typical(name)), "c", tmp_path, single=single)
    done = subprocess.run(
        ["make", "test", f"CFLAGS={STRICT}"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "largest difference" in done.stdout
    source = (tmp_path / "damper.c").read_text()
    assert "malloc" not in source
    if single:
        assert "double" not in source


@needs_gcc
@needs_make
def test_a_planted_error_fails_the_replay(tmp_path) -> None:
    export(everything(), "c", tmp_path)
    source = tmp_path / "damper.c"
    source.write_text(source.read_text().replace("-200.0", "-200.1"))
    done = subprocess.run(["make", "test"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "largest difference" in done.stdout


@needs_gcc
@pytest.mark.parametrize(
    "name",
    [
        "dahl",
        "bouc_wen",
        *(
            pytest.param(name, marks=pytest.mark.prove)
            for name in ("hyperbolic_tangent + compliance + spring + delay", "modified_bouc_wen")
        ),
    ],
)
def test_single_precision_is_within_1e_4_of_double(tmp_path, name: str) -> None:
    """10,000 samples; the time between samples is given, so that it keeps its digits."""
    t = np.linspace(0.0, 10.0, 10_000)
    x = 0.01 * np.sin(6.0 * t + 0.5 * t**2)
    v = 0.01 * (6.0 + t) * np.cos(6.0 * t + 0.5 * t**2)
    damper = Damper(name, typical(name))
    expected = damper.force(t, x, velocity=v, voltage=0.0)
    export(damper, "c", tmp_path, single=True)
    (tmp_path / "main.c").write_text(MAIN_SINGLE)
    subprocess.run(["gcc", *STRICT.split(), "damper.c", "main.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    rows = np.column_stack((np.append(0.0, np.diff(t)), x, v))
    text = "\n".join(" ".join(repr(float(c)) for c in row) for row in rows)
    done = subprocess.run([str(tmp_path / "main")], input=text, capture_output=True, text=True, check=True)
    force = np.array(done.stdout.split(), dtype=float)
    off = np.abs(force - expected).max() / np.abs(expected).max()
    print(f"{name}: {off:.2g} of the largest force")
    assert off < 1e-4


MAIN_SINGLE = r"""
#include "damper.h"
#include <stdio.h>
int main(void)
{
    damper_state d; float dt, x, v; int n = 0;
    while (scanf("%f %f %f", &dt, &x, &v) == 3)
        printf("%.9g\n", (double)(n++ ? damper_step_by(&d, dt, x, v, 0.0f) : damper_start(&d, 0.0f, x, v, 0.0f)));
    return 0;
}
"""


@needs_gcc
def test_bouc_wen_with_a_large_sigma_walks_the_same_path(tmp_path) -> None:
    """sigma above 1.5 takes a series of its own, whose loop does not begin at 0."""
    values = typical("bouc_wen") | {"bouc_wen.sigma": 4.0, "bouc_wen.n": 1.7}
    damper = Damper("bouc_wen", values)
    t = np.linspace(0.0, 3.0, 2001)
    x, v = 0.01 * np.sin(6.0 * t * t), 0.12 * t * np.cos(6.0 * t * t)
    force = damper.force(t, x, voltage=0.0, velocity=v)
    np.testing.assert_allclose(run_c(damper, tmp_path, t, x, v), force, atol=1e-9 * np.abs(force).max())


@needs_gcc
@pytest.mark.parametrize("name", ["spring", pytest.param("maxwell_slip + spring", marks=pytest.mark.prove)])
def test_what_needs_no_library_is_linked_with_none(tmp_path, name: str) -> None:
    damper = Damper(name, typical(name))
    export(damper, "c", tmp_path)
    assert "It needs no mathematics library." in (tmp_path / "damper.h").read_text()
    (tmp_path / "main.c").write_text(MAIN)
    subprocess.run(["gcc", "-std=c99", "damper.c", "main.c", "-o", "main"], cwd=tmp_path, check=True)
    export(Damper("dahl", typical("dahl")), "c", tmp_path, name="other")
    assert "Link with -lm: it calls exp." in (tmp_path / "other.h").read_text()


@needs_gcc
def test_the_history_of_a_delay_is_chosen(tmp_path) -> None:
    export(everything(), "c", tmp_path, history=50, name="small")
    assert "late_f[50]" in (tmp_path / "small.h").read_text()
    for wrong in (1, 2_000_000, True):
        with pytest.raises(InputError, match="is not a valid number of samples; choose 2 to 1000000"):
            export(everything(), "c", tmp_path / "none", history=wrong)
    assert not (tmp_path / "none").exists()


MAIN_INVERSE = r"""
#include "damper.h"
#include <stdio.h>
int main(void)
{
    damper_state d; damper_inverse g; double dt, x, v, wanted, u, f; int n = 0;
    damper_inverse_start(&g);
    while (scanf("%lf %lf %lf %lf", &dt, &x, &v, &wanted) == 4) {
        if (!n) damper_start(&d, 0.0, x, v, g.low);
        u = damper_inverse_find(&g, &d, dt, x, v, wanted);
        f = n++ ? damper_step_by(&d, dt, x, v, u) : damper_start(&d, 0.0, x, v, u);
        printf("%.17g %.17g %.17g %d %d\n", u, g.f, f, g.reason, g.monotone);
    }
    return 0;
}
"""


@needs_gcc
@pytest.mark.parametrize(
    "name",
    ["published", *(pytest.param(name, marks=pytest.mark.prove) for name in ("every law", "dahl + compliance"))],
)
def test_the_inverse_in_c_is_that_of_python(tmp_path, name: str) -> None:
    """The input to 1e-10 of its range and the force to 1e-10 of the largest, over 2,000 samples of which many cannot be met."""
    damper = raminelli_2020.damper() if name == "published" else everything().without("delay")
    if "compliance" in name:
        damper = Damper(name, {**raminelli_2020.damper().laws, "compliance.s": 2e-6})
    t = np.linspace(0.0, 4.0, 2001)
    x = 0.006 * np.sin(6.0 * t) + 0.003 * np.sin(17.0 * t)
    v = np.gradient(x, t)
    wanted = 5000.0 * v + 30.0 * np.sin(11.0 * t)
    found = damper.inverse().along(t, x, wanted, velocity=v)
    export(damper, "c", tmp_path, inverse=True)
    (tmp_path / "main.c").write_text(MAIN_INVERSE)
    subprocess.run(["gcc", *STRICT.split(), "damper.c", "main.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    rows = np.column_stack((np.append(0.0, np.diff(t)), x, v, wanted))
    text = "\n".join(" ".join(repr(float(c)) for c in row) for row in rows)
    done = subprocess.run([str(tmp_path / "main")], input=text, capture_output=True, text=True, check=True)
    u, f, stepped, reason, monotone = np.array(done.stdout.split(), dtype=float).reshape(-1, 5).T
    largest = np.abs(found.force).max()
    print(
        f"{name}: input to {np.abs(u - found.input).max():.1g}, force to {np.abs(f - found.force).max() / largest:.1g}"
    )
    np.testing.assert_allclose(u, found.input, rtol=0, atol=1e-10 * np.ptp(damper.range))
    np.testing.assert_allclose(f, found.force, rtol=0, atol=1e-10 * largest)
    np.testing.assert_allclose(stepped, f, rtol=0, atol=1e-12 * largest)
    assert [REASONS[int(k)] for k in reason] == found.reason.tolist()
    assert monotone.tolist() == found.monotone.tolist()
    assert {"met", "wrong_sign", "below_smallest"} <= set(found.reason)


@needs_gcc
@needs_make
@pytest.mark.parametrize("single", [False, True], ids=["double", "float"])
@pytest.mark.parametrize(
    "name", ["published", *(pytest.param(name, marks=pytest.mark.prove) for name in ("every law", "dahl + compliance"))]
)
def test_the_exported_inverse_finds_the_force_of_each_vector(tmp_path, name: str, single: bool) -> None:
    """In double precision to 1e-9 of the largest force, in single precision to 1e-4; a planted error fails."""
    damper = raminelli_2020.damper() if name == "published" else everything().without("delay")
    if "compliance" in name:
        damper = Damper(name, {**raminelli_2020.damper().laws, "compliance.s": 2e-6})
    export(damper, "c", tmp_path, single=single, inverse=True)
    command = ["make", "test", f"CFLAGS={STRICT}"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    source = (tmp_path / "damper.c").read_text()
    assert not single or "double" not in source
    (tmp_path / "damper.c").write_text(source.replace("g->u = out[0];", "g->u = out[0]/2;"))
    assert subprocess.run(["make", "test"], cwd=tmp_path, capture_output=True, check=False).returncode != 0


@needs_gcc
def test_the_inverse_in_c_stays_in_its_bounds(tmp_path) -> None:
    export(raminelli_2020.damper(), "c", tmp_path, inverse=True)
    (tmp_path / "main.c").write_text(r"""
#include "damper.h"
#include <stdio.h>
int main(void)
{
    damper_state d; damper_inverse g;
    damper_start(&d, 0.0, 0.0, 0.0, 0.0);
    damper_inverse_start(&g);
    g.high = 1.0;
    printf("%g ", damper_inverse_find(&g, &d, 0.01, 0.001, 0.05, 5000.0));
    printf("%d ", g.reason);
    g.high = 9.0;
    printf("%g ", damper_inverse_find(&g, &d, 0.01, 0.001, 0.05, 100.0));
    g.high = 1.0;
    printf("%g ", damper_inverse_find(&g, &d, -0.01, 0.001, 0.05, 100.0));
    g.low = 2.0;
    printf("%g\n", damper_inverse_find(&g, &d, 0.01, 0.001, 0.05, 100.0));
    return 0;
}
""")
    subprocess.run(["gcc", "damper.c", "main.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    done = subprocess.run([str(tmp_path / "main")], capture_output=True, text=True, check=True)
    assert [word.lstrip("-") for word in done.stdout.split()] == ["1", "2", "nan", "nan", "nan"]


def test_an_inverse_that_does_not_exist_is_not_written(tmp_path) -> None:
    with pytest.raises(InputError, match="is delayed"):
        export(everything(), "c", tmp_path / "none", inverse=True)
    with pytest.raises(InputError, match="are the same at every input"):
        export(Damper("dahl", typical("dahl")), "c", tmp_path / "none", inverse=True)
    assert not (tmp_path / "none").exists()
