"""The C export in single precision on an ATmega328P at 16 MHz, in simavr: its force, its time and its stack.

``pytest -s tests/export/kinds/test_c_on_the_uno.py`` prints the figures of docs/how-to/export.md.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from tests.invariants.test_every_part import typical

from dampyr.export import export
from dampyr.models import Damper
from dampyr.studies import raminelli_2020

MISSING = [name for name in ("avr-gcc", "gcc") if shutil.which(name) is None]
MISSING += ["libsimavr-dev"] * (not Path("/usr/include/simavr/sim_avr.h").exists())
pytestmark = pytest.mark.skipif(
    bool(MISSING), reason=f"missing: {', '.join(MISSING)}; `make firmware-tools` installs them"
)
N = 300
DAMPERS = {
    "Dahl, published cubics": raminelli_2020.damper(),
    "Bouc-Wen, n = 1": Damper("bouc_wen", typical("bouc_wen") | {"bouc_wen.n": 1.0}),
    "Bouc-Wen, n = 2": Damper("bouc_wen", typical("bouc_wen") | {"bouc_wen.n": 2.0}),
    "Bouc-Wen, n = 1.4": Damper("bouc_wen", typical("bouc_wen")),
    "hyperbolic tangent": Damper("hyperbolic_tangent", typical("hyperbolic_tangent")),
}
MAIN = r"""
#include "damper.h"
#include "path.h"
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>

static damper_state d;

int main(void)
{
    for (unsigned k = 0; k < SAMPLES; k++) {
        float x = pgm_read_float(&path[3*k]), v = pgm_read_float(&path[3*k + 1]), u = pgm_read_float(&path[3*k + 2]);
        union { float f; unsigned char b[4]; } force;
        GPIOR0 = 1;
        force.f = k ? damper_step_by(&d, STEP, x, v, u) : damper_start(&d, 0.0f, x, v, u);
        GPIOR0 = 2;
        for (unsigned char i = 0; i < 4; i++) GPIOR1 = force.b[i];
        GPIOR0 = 3;
    }
    cli();
    sleep_enable();
    sleep_cpu();
    return 0;
}
"""


@pytest.fixture(scope="module")
def runner(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program that runs another one in simavr."""
    program = tmp_path_factory.mktemp("runner") / "run"
    source = Path(__file__).with_name("damper_in_simavr.c")
    subprocess.run(
        ["gcc", "-O2", "-std=gnu99", "-Wall", str(source), "-o", str(program), "-lsimavr", "-lm"], check=True
    )
    return program


@pytest.mark.parametrize(
    "name",
    [
        name if name in ("Dahl, published cubics", "Bouc-Wen, n = 2") else pytest.param(name, marks=pytest.mark.prove)
        for name in DAMPERS
    ],
)
def test_its_force_time_and_stack(name: str, runner: Path, tmp_path: Path) -> None:
    """Forces within 1e-4 of the largest; a step of Dahl within a millisecond, in less than 256 bytes of stack."""
    damper = DAMPERS[name]
    t = 0.004 * np.arange(N)
    x, v = 0.008 * np.sin(9.0 * t), 0.072 * np.cos(9.0 * t)
    low, high = damper.range
    u = 0.5 * (low + high) + 0.5 * (high - low) * np.sin(4.0 * t)
    expected = damper.force(t, x, velocity=v, voltage=u)
    export(damper, "c", tmp_path, single=True)
    rows = ", ".join(f"{float(value)!r}f" for value in np.column_stack([x, v, u]).ravel())
    head = f"#include <avr/pgmspace.h>\n#define SAMPLES {N}\n#define STEP 0.004f\n"
    (tmp_path / "path.h").write_text(f"{head}static const float path[] PROGMEM = {{{rows}}};\n")
    (tmp_path / "main.c").write_text(MAIN)
    command = "avr-gcc -mmcu=atmega328p -std=c99 -Os -Wall -Wextra damper.c main.c -o damper.elf -lm"
    subprocess.run(command.split(), cwd=tmp_path, check=True)
    done = subprocess.run(
        [str(runner), "damper.elf"], cwd=tmp_path, capture_output=True, text=True, check=True, timeout=300
    )
    lines = [line.split() for line in done.stdout.splitlines() if line[:1].isdigit()]
    assert len(lines) == N
    force = np.array([bytes(map(int, line[2:])) for line in lines]).view("<f4").astype(float)
    cycles, stack = np.array([[int(word) for word in line[:2]] for line in lines]).T
    size = subprocess.run(["avr-size", "damper.elf"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    off = np.abs(force - expected).max() / np.abs(expected).max()
    print(
        f"{name}: {cycles.mean() / 16:.0f} us a step, {cycles.max() / 16:.0f} at most, {stack.max()} bytes of stack, "
        f"flash {size.split()[6]} bytes with the path's {12 * N}; {off:.1e} of the largest force"
    )
    assert off < 1e-4
    assert stack.max() < 1024
    if "Dahl" in name:
        assert cycles.max() < 16_000
        assert stack.max() < 256
