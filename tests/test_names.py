"""The check of names refuses what it is there to refuse."""

import subprocess
from pathlib import Path

import pytest

from tests.interpreters import run_file

TOOL = Path(__file__).parent.parent / "tools" / "check_names.py"


def check(root: Path) -> subprocess.CompletedProcess[str]:
    return run_file(TOOL, "--root", root)


@pytest.mark.parametrize(
    ("files", "sentence"),
    [
        (
            {
                "src/dampyr/models/a.py": "class Group: ...\n",
                "src/dampyr/records/b.py": "def f():\n    class Group: ...\n",
            },
            "2 classes are called 'Group': models/a.py:1, records/b.py:2",
        ),
        (
            {"src/dampyr/models/a.py": "", "src/dampyr/records/a.py": ""},
            "2 modules are called 'a': models/a.py, records/a.py",
        ),
        (
            {"src/dampyr/models/a.py": "", "src/dampyr/show/records/a.py": ""},
            "2 modules are called 'a': models/a.py, show/records/a.py",
        ),
        (
            {
                "src/dampyr/models/a.py": "from dampyr.models.b import y\nx = 1\n",
                "src/dampyr/models/b.py": "y = 1\ndef f():\n    from dampyr.models.a import x\n    return x\n",
            },
            "import circle: dampyr.models.a <-> dampyr.models.b",
        ),
        (
            {
                "src/dampyr/models/a.py": "from dampyr.models.b import y\nclass A: ...\n",
                "src/dampyr/models/b.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n"
                "    from dampyr.models.a import A\ny = 1\n",
            },
            "import circle: dampyr.models.a <-> dampyr.models.b",
        ),
        (
            {
                "src/dampyr/models/__init__.py": "from dampyr.models.cycles import cycles\n",
                "src/dampyr/models/cycles.py": "def cycles() -> None: ...\n",
            },
            "src/dampyr/models/__init__.py:1: 'cycles' hides the module dampyr.models.cycles",
        ),
        (
            {
                "src/dampyr/models/__init__.py": "from dampyr.records.b import score\n",
                "src/dampyr/models/score/__init__.py": "",
                "src/dampyr/records/b.py": "def score() -> None: ...\n",
            },
            "'score' hides the module dampyr.models.score",
        ),
    ],
)
def test_a_planted_offence_is_refused(tmp_path: Path, files: dict[str, str], sentence: str) -> None:
    for folder in ("src/dampyr/models", "src/dampyr/records", "tests", "benchmarks"):
        (tmp_path / folder).mkdir(parents=True)
    assert check(tmp_path).returncode == 0
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    run = check(tmp_path)
    assert run.returncode == 1
    assert sentence in run.stdout


def test_what_is_allowed_is_not_refused(tmp_path: Path) -> None:
    package = tmp_path / "src" / "dampyr"
    for folder in ("rig", "show/rig"):
        (package / folder).mkdir(parents=True)
        (package / folder / "drive.py").write_text("")
    for folder in ("cli", "console/pages"):
        (package / folder).mkdir(parents=True)
        (package / folder / "identify.py").write_text("")
    run = check(tmp_path)
    assert run.returncode == 0, run.stdout
