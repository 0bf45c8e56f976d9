"""The MATLAB export, run in GNU Octave beside `Damper.force`."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from tests.export.every_law import everything
from tests.invariants.test_every_part import SERIES, typical

from dampyr.export import export
from dampyr.models import Damper, available_parts
from dampyr.models.part import part

needs_octave = pytest.mark.skipif(
    shutil.which("octave-cli") is None, reason="GNU Octave is missing: the MATLAB export cannot be run"
)
N = 2000
T = np.linspace(0.0, 4.0, N)
X = 0.01 * np.sin(6.0 * T + 0.5 * T**2)
V = 0.01 * (6.0 + T) * np.cos(6.0 * T + 0.5 * T**2)
U = 1.5 + 1.4 * np.sin(5.0 * T)


def octave(folder: Path, lines: list[str]) -> str:
    """What Octave prints; the path lies in T, X, V and U."""
    np.savetxt(folder / "path.txt", np.column_stack([T, X, V, U]), fmt="%.17g")
    head = ["load('path.txt');", "T = path(:, 1); X = path(:, 2); V = path(:, 3); U = path(:, 4);"]
    (folder / "main_script.m").write_text("\n".join([*head, *lines]) + "\n")
    done = subprocess.run(
        ["octave-cli", "--quiet", "--no-init-file", "main_script.m"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def save(expression: str, file: str) -> str:
    return f"f = {expression}; id = fopen('{file}', 'w'); fprintf(id, '%.17g\\n', f); fclose(id);"


def exportable() -> list[Damper]:
    """The damper with every kind of law, and every part and series that needs no acceleration and no command."""
    forceful = [name for name in available_parts() if part(name).force is not None]
    names = [name for name in (*forceful, *SERIES) if "inertia" not in name]
    return [everything(), *(Damper(name, typical(name)) for name in names)]


@needs_octave
@pytest.mark.prove
def test_octave_gives_the_force_of_every_part(tmp_path: Path) -> None:
    """Equal to 1e-9 of the largest force."""
    dampers = exportable()
    lines = []
    for k, damper in enumerate(dampers):
        export(damper, "matlab", tmp_path, name=f"damper_{k}")
        lines.append(save(f"damper_{k}(T, X, V, {'U' if k == 0 else '0'})", f"{k}.txt"))
    octave(tmp_path, lines)
    for k, damper in enumerate(dampers):
        expected = damper.force(T, X, velocity=V, voltage=U if k == 0 else 0.0)
        np.testing.assert_allclose(
            np.loadtxt(tmp_path / f"{k}.txt"), expected, rtol=0, atol=1e-9 * np.abs(expected).max(),
            err_msg=str(damper.composition),
        )  # fmt: skip


@needs_octave
def test_it_goes_on_and_refuses_in_words(tmp_path: Path) -> None:
    export(everything(), "matlab", tmp_path, name="damper")
    halves = "i = 1:900; [a, s] = damper(T(i), X(i), V(i), U(i)); i = 901:2000; b = damper(T(i), X(i), V(i), U(i), s);"
    tries = {
        "range": "damper(T, X, V, 3.2)", "size": "damper(T, X, V(1:5), 1)", "time": "damper(T([1 3 2]), X(1:3), V(1:3), 1)",
    }  # fmt: skip
    lines = [halves, save("[a; b]", "both.txt")]
    lines += [f"try, {call}; catch e, disp([e.identifier, ' | ', e.message]); end" for call in tries.values()]
    printed = octave(tmp_path, [*lines, "help damper"])
    expected = everything().force(T, X, velocity=V, voltage=U)
    np.testing.assert_allclose(np.loadtxt(tmp_path / "both.txt"), expected, rtol=0, atol=1e-9 * np.abs(expected).max())
    assert "damper:range | voltage = 3.2 V at sample 1; calibrated from 0 to 3 V" in printed
    assert "damper:size | t, x, v and u have 2000, 2000, 5 and 2000 samples" in printed
    assert "damper:time" in printed
    assert "does not come after" in printed
    assert "Written by dampyr" in printed
