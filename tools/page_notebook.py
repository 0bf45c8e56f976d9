"""A page of the documentation as a notebook: its words, its Python, and its commands behind ``!``.

Commands that are not dampyr's, such as those of the installation, stay words.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

FENCED = re.compile(r"^```(\w+)[^\n]*\n(.*?)^```\n?", re.MULTILINE | re.DOTALL)
# A kernel's environment need not be the active one.
FIRST = """import os
import sys
from pathlib import Path

os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"  # where this kernel's dampyr is"""


def notebook(page: Path) -> str:
    """The text of the notebook, without outputs."""
    cells, words, end = [], "", 0
    text = page.read_text(encoding="utf-8")
    text = re.sub(r"^This page is also .*\n\n", "", text, flags=re.MULTILINE)
    for block in FENCED.finditer(text):
        words += text[end : block.start()]
        end = block.end()
        code = code_of(block[1], block[2].rstrip())
        if code is None:
            words += block[0]
            continue
        cells += [("markdown", words.strip()), ("code", code)]
        words = ""
    cells.append(("markdown", (words + text[end:]).strip()))
    first = next(k for k, (kind, _) in enumerate(cells) if kind == "code")
    cells.insert(first, ("code", FIRST))
    about = {
        "cells": [cell(number, kind, source) for number, (kind, source) in enumerate(cells) if source],
        "metadata": {
            "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
            "language_info": {"name": "python"},
        },
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(about, indent=1, ensure_ascii=False) + "\n"


def code_of(language: str, text: str) -> str | None:
    """The code of a cell; None where the block is for reading."""
    if language == "python":
        return text
    if language == "sh" and all(line.startswith("dampyr ") for line in text.splitlines()):
        return "\n".join(f"!{line}" for line in text.splitlines())
    return None


def cell(number: int, kind: str, source: str) -> dict[str, Any]:
    """One cell as a file has it."""
    own: dict[str, Any] = {"execution_count": None, "outputs": []} if kind == "code" else {}
    return {"cell_type": kind, "id": f"cell-{number:02}", "metadata": {}, "source": source.splitlines(True), **own}
