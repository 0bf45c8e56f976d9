"""MATLAB text of functions, run in GNU Octave, gives the numbers that Python gives."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from tests.export.formulas import FORMULAS, POINTS, trees

from dampyr.export.matlab_text import SUPPORT, MatlabWriter, function, number


@pytest.mark.skipif(shutil.which("octave-cli") is None, reason="GNU Octave is missing: MATLAB text cannot be run")
def test_every_form_gives_the_numbers_of_python(tmp_path: Path) -> None:
    defined = {tree.name for tree in trees()}
    calls = [f"printf('%.17g\\n', f_{f.__name__}({x!r}, {y!r}));" for f in FORMULAS for x, y in POINTS]
    functions = [SUPPORT.replace("{prefix}", "f_"), *(function(tree, "f_", defined) for tree in trees())]
    (tmp_path / "main.m").write_text("\n".join(["1;", *functions, *calls]) + "\n")
    done = subprocess.run(
        ["octave-cli", "--quiet", "--no-init-file", "main.m"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    expected = [f(x, y) for f in FORMULAS for x, y in POINTS]
    np.testing.assert_allclose([float(line) for line in done.stdout.split()], expected, rtol=1e-14)


def test_numbers_have_all_their_digits_and_names_are_matlabs() -> None:
    assert (number(0.1), number(-2.5)) == ("0.1", "(-2.5)")
    writer = MatlabWriter("d_", set(), set(), [])
    assert [writer.variable(name) for name in ("x", "end", "_hidden")] == ["x", "end_", "n_hidden"]
