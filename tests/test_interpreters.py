"""A text that runs in a copy of a process ends, prints and fails as in an interpreter of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.interpreters import run_text

TEXTS = {
    "prints": "print('a'); import sys; print('b', file=sys.stderr)",
    "exit with a number": "import sys; sys.exit(3)",
    "exit with a sentence": "import sys; sys.exit('no')",
    "exit without a word": "import sys; sys.exit()",
    "an error": "1 / 0",
    "arguments, folder and environment": "import os, sys; print(sys.argv[1:], os.getcwd(), os.environ['WHAT'])",
    "a module on the path": "import planted; print(planted.VALUE)",
    "what was loaded": "import sys; print('dampyr' in sys.modules)",
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_it_is_what_an_interpreter_of_its_own_does(tmp_path: Path, text: str) -> None:
    (tmp_path / "planted.py").write_text("VALUE = 4\n", "utf-8")
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": str(tmp_path), "WHAT": "this"}
    copy = run_text(text, ("-c", "x", "--y"), tmp_path, environment)
    command = [sys.executable, "-c", text, "x", "--y"]
    fresh = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (copy.returncode, copy.stdout) == (fresh.returncode, fresh.stdout)
    assert copy.stderr.splitlines()[-1:] == fresh.stderr.splitlines()[-1:]


def test_a_text_changes_nothing_for_the_next() -> None:
    run_text("import sys, os; sys.modules['click'] = None; os.environ['LEFT'] = '1'")
    after = run_text("import click, os; print('LEFT' in os.environ)")
    assert (after.returncode, after.stdout) == (0, "False\n"), after.stderr


def test_what_a_copy_starts_with_is_not_dampyr() -> None:
    loaded = run_text("import sys; print(sorted(name for name in sys.modules if name.startswith('dampyr')))")
    assert loaded.stdout == "[]\n"
