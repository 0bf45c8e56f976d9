"""The check of copyright notices refuses those of others, wherever they stand."""

import subprocess
from pathlib import Path

import pytest

from tests.interpreters import run_file

CHECKOUT = Path(__file__).parent.parent
TOOL = CHECKOUT / "tools" / "check_copyright.py"
WORD, SIGN, YEAR = "Copy" + "right", "\N{COPYRIGHT SIGN}", "20" + "24"  # in parts, so that this file is none


def check(root: Path) -> subprocess.CompletedProcess[str]:
    return run_file(TOOL, "--root", root)


@pytest.mark.prove
def test_this_checkout_has_no_notice_of_others() -> None:
    run = check(CHECKOUT)
    assert run.returncode == 0, run.stdout + run.stderr


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("src/a.js", f"/*! {WORD} (c) {YEAR} Somebody Else */\n", "src/a.js:1: a copyright notice of others"),
        ("src/a.js", f"x();\n * {WORD} (c) Another, Inc., and Contributors\n", "src/a.js:2: a copyright notice"),
        ("docs/a.md", f"{SIGN} {YEAR} A Publisher\n", "docs/a.md:1: a copyright notice of others"),
        ("src/a.py", f"# {WORD.upper()} {YEAR} X.\n", "src/a.py:1: a copyright notice of others"),
        ("src/a.c", f"// ({'c'}) {YEAR} Y\n", "src/a.c:1: a copyright notice of others"),
        ("src/LICENSE", "Permission is " + "hereby granted, free of charge\n", "src/LICENSE:1: terms of a licence"),
        ("src/a.py", "# SPDX-License-" + "Identifier: BSD-3-Clause\n", "src/a.py:1: terms of a licence"),
        ("src/vendor/a.js", "x();\n", "src/vendor/a.js: a copy of others' code by its name"),
        ("src/a.min.css", "b{}\n", "src/a.min.css: a copy of others' code by its name"),
    ],
)
def test_a_planted_notice_is_refused(tmp_path: Path, name: str, text: str, sentence: str) -> None:
    (tmp_path / "LICENSE").write_text((CHECKOUT / "LICENSE").read_text("utf-8"), "utf-8")
    assert check(tmp_path).returncode == 0
    (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / name).write_text(text, "utf-8")
    run = check(tmp_path)
    assert run.returncode == 1
    assert run.stdout.startswith(sentence)


def test_a_checkout_is_read_as_git_lists_it(tmp_path: Path) -> None:
    """What git ignores, such as an environment, is not part of the repository; what it would add is."""
    subprocess.run(["git", "init", "-q", str(tmp_path)], check=True)
    (tmp_path / ".gitignore").write_text(".venv/\n")
    for name in (".venv/a.js", "new.js"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(f"// {WORD} {YEAR} Z\n")
    run = check(tmp_path)
    assert (run.returncode, run.stdout.count("\n")) == (1, 1)
    assert run.stdout.startswith("new.js:1:")
