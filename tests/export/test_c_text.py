"""C text of functions, compiled by gcc, gives the numbers that Python gives."""

import ast
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from tests.export.formulas import FORMULAS, POINTS, trees

from dampyr.export.c_text import COARSEST, SINGLE, function, read_names

MAIN = """
#include <math.h>
#include <stdio.h>
static double f_min(double a, double b) { return a < b ? a : b; }
static double f_max(double a, double b) { return a > b ? a : b; }
"""


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is missing: C text cannot be compiled")
def test_every_form_gives_the_numbers_of_python(tmp_path: Path) -> None:
    defined = {tree.name for tree in trees()}
    calls = [f'printf("%.17g\\n", f_{f.__name__}({x!r}, {y!r}));' for f in FORMULAS for x, y in POINTS]
    text = [MAIN, *(function(tree, "f_", defined) for tree in trees()), "int main(void) {", *calls, "return 0; }"]
    (tmp_path / "main.c").write_text("\n".join(text))
    subprocess.run(["gcc", "-std=c99", "-Wall", "-Werror", "main.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    done = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True)
    expected = [f(x, y) for f in FORMULAS for x, y in POINTS]
    np.testing.assert_allclose([float(line) for line in done.stdout.split()], expected, rtol=1e-14)


def tree_of(text: str) -> ast.FunctionDef:
    [tree] = ast.parse(text).body
    assert isinstance(tree, ast.FunctionDef)
    return tree


def test_what_is_not_read_is_left_out() -> None:
    tree = tree_of("def f(x, y):\n    a = x + 1.0\n    b = a + y\n    return x")
    assert read_names(tree) == {"x"}
    text = function(tree, "d_", set())
    assert "a" not in text.partition("{")[2].replace("return", "")
    assert "(void)y;" in text


def test_in_single_precision_numbers_have_their_suffix_and_tolerances_can_be_met() -> None:
    text = function(tree_of("def f(x):\n    return exp(x) if abs(x) < 1e-12 else 1e-12"), "d_", set(), precision=SINGLE)
    assert "double" not in text
    assert "expf(x)" in text
    assert f"(fabsf(x) < {COARSEST!r}f)" in text
    assert "1e-12f" in text


@pytest.mark.parametrize(
    "body", ["while x > 0.0: x = x - 1.0", "return x if 0.0 < x < 1.0 else 0.0", "a, b = x, a + 1.0\n    return b"]
)
def test_what_c_has_no_form_for_is_refused(body: str) -> None:
    with pytest.raises(TypeError, match="no C form for: "):
        function(tree_of(f"def f(x, a):\n    {body}"), "d_", set())
