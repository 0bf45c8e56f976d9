"""Imports go one way through the packages, and a violation is seen."""

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.interpreters import run_text

ROOT = Path(__file__).resolve().parents[1]
LINT = "from importlinter.cli import lint_imports; import sys; sys.exit(lint_imports(no_cache=True))"


def lint(root: Path) -> subprocess.CompletedProcess[str]:
    """Check the contracts of ``root/pyproject.toml`` on the sources in ``root/src``."""
    code = f"import sys; sys.path.insert(0, {str(root / 'src')!r}); {LINT}"
    return run_text(code, folder=root)


@pytest.fixture
def source_copy(tmp_path: Path) -> Path:
    """A copy of the sources to do damage to."""
    ignore = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "src", tmp_path / "src", ignore=ignore)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def test_imports_go_one_way() -> None:
    run = lint(ROOT)
    assert run.returncode == 0, run.stdout + run.stderr


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("models/planted.py", "from dampyr import records"),  # an inner room enters an outer one
        (
            "models/planted.py",
            "def later() -> None:\n    from dampyr.structures import planted",
        ),  # however late
        ("structures/planted.py", "import dampyr.identification"),  # siblings
        ("errors.py", "import dampyr.units"),
        ("planted.py", ""),  # a room that stands in no layer
    ],
)
def test_a_planted_violation_is_found(source_copy: Path, file: str, line: str) -> None:
    (source_copy / "src/dampyr/structures/planted.py").write_text("")
    with (source_copy / "src/dampyr" / file).open("a") as source:
        source.write(f"\n{line}\n")
    run = lint(source_copy)
    assert run.returncode != 0, run.stdout
    assert "planted" in run.stdout or "dampyr.errors" in run.stdout
