"""docs/how-to/from-matlab.md: what MATLAB's lines give in GNU Octave is what those of dampyr give, and what a script loses."""

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

PAGE = Path(__file__).resolve().parents[2] / "docs" / "how-to" / "from-matlab.md"
needs_octave = pytest.mark.skipif(shutil.which("octave-cli") is None, reason="GNU Octave is missing")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)


def octave(folder: Path, lines: str) -> dict[str, list[float]]:
    """The numbers of what Octave shows, by name."""
    (folder / "evaluate.m").write_text(f"format long\n{lines}")
    command = ["octave-cli", "--quiet", "--no-init-file", "evaluate.m"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    shown = re.findall(r"^(\w+) =\s*([-\d.e+\s]+)", done.stdout, re.MULTILINE)
    return {name: [float(number) for number in numbers.split()] for name, numbers in shown}


@needs_octave
@pytest.mark.prove
def test_both_columns_of_the_page_give_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for block in blocks("python"):
        exec(block, names)
    script = [block for block in blocks("matlab") if not block.startswith("function")]
    [function] = [block for block in blocks("matlab") if block.startswith("function")]
    (tmp_path / "dahl.m").write_text(function)
    shown = octave(tmp_path, "\n".join(script))
    last, fit = names["last"], names["fit"]
    assert shown["energy"][0] == pytest.approx(last.energy, rel=2e-3)
    assert shown["stiffness"][0] == pytest.approx(last.effective_stiffness, rel=2e-2)  # of two samples, each with noise
    assert shown["p"][:2] == pytest.approx([fit.parameters["dahl.kx"], fit.parameters["dahl.kw"]], rel=3e-2)
    assert shown["L1"][0] == pytest.approx(fit.scores["run"].l1, abs=3e-3)
    assert list(fit.parameters.values()) == pytest.approx([1200.0, 300.0, 1000.0], rel=5e-3)
    assert shown["p"][2] == pytest.approx(1000.0, rel=3e-2)
    assert shown["top"][0] == pytest.approx(names["response"].peak_displacement[-1], rel=2e-3)
    assert names["damped"].peak_displacement[-1] < names["response"].peak_displacement[-1]
