"""Each script of examples/ prints what its own text says that it prints."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

pytestmark = pytest.mark.prove

EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "examples").glob("*.py"))
INTRODUCTION = "It prints::\n"


def test_there_are_examples() -> None:
    assert len(EXAMPLES) >= 4


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_prints_what_it_says(script: Path, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    text = script.read_text(encoding="utf-8")
    environment = dict(os.environ)
    if "locate(" in text:
        environment["DAMPYR_DATA"] = str(request.getfixturevalue("campaign_folder").parent)
    done = subprocess.run(
        [sys.executable, str(script)], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    words = ast.get_docstring(ast.parse(text))
    assert words is not None
    assert INTRODUCTION in words
    assert done.stdout.strip() == textwrap.dedent(words.partition(INTRODUCTION)[2].strip("\n")).strip()
    assert done.stderr == ""
