"""What a person waits for: importing the package, and one command, each in a fresh process with warm caches."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks._lines import Line
from benchmarks._timing import race

TITLE = "A fresh process, its start included (compiled kernels from the disk)"


def run(data: Path | None) -> list[Line]:
    """An empty Python, the import, help, and the building with one damper."""
    commands = {
        "python -c pass": ["-c", "pass"],
        "import dampyr": ["-c", "import dampyr"],
        "dampyr --help": ["-m", "dampyr", "--help"],
        "dampyr simulate --voltage 0": ["-m", "dampyr", "simulate", "--voltage", "0"],
    }
    return race({name: _started(arguments) for name, arguments in commands.items()}, {}, rounds=3)


def _started(arguments: list[str]) -> Callable[[], Any]:
    return lambda: subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
