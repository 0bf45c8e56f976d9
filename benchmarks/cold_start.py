"""What a person waits for on a fresh machine: commands in a process with an empty folder of kernels.

A checkout has no archive of kernels; a wheel has the one that ``tools/make_kernels.py`` writes, which is made here first. Times
are of the processor, user and system, as the compiler's own threads and a busy machine change the others.
"""

from __future__ import annotations

import os
import resource
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from benchmarks._lines import Line

OPT_IN = True  # the archive alone takes three minutes
ROUNDS = 3
TITLE = "The first command on a fresh machine, processor time (no kernels on the disk; then with those of a wheel; then all)"
WITH_ARCHIVE = """
import sys
from pathlib import Path
from dampyr.models.codegen import shipped_kernels
shipped_kernels.FOLDER = Path(sys.argv.pop(1))
"""
MAKE = WITH_ARCHIVE + "sys.path.insert(0, 'tools')\nfrom make_kernels import main\nmain()"
RUN = WITH_ARCHIVE + "from dampyr.cli import main\nmain()"


def run(data: Path | None) -> list[Line]:
    """An empty Python first, as the measure of the machine."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        started([MAKE, str(folder / "archive")], folder / "made")
        spent = [started(["pass"], folder) for _ in range(ROUNDS)]
        lines = [_line("python -c pass", spent)]
        for name, words in commands(folder, data):
            for kind in ("none", "archive"):
                caches = [folder / f"{name} {kind} {k}" for k in range(ROUNDS)]
                spent = [started([RUN, str(folder / kind), *words], cache) for cache in caches]
                lines.append(_line(f"{name}, {'the kernels of a wheel' if kind == 'archive' else 'no kernels'}", spent))
            spent = [started([RUN, str(folder / "none"), *words], caches[0]) for _ in range(ROUNDS)]
            lines.append(_line(f"{name}, again", spent))
    return lines


def commands(folder: Path, data: Path | None) -> Iterator[tuple[str, list[str]]]:
    """The commands by name; an identification only where the laboratory's campaign is at hand."""
    yield "simulate", ["simulate", "raminelli_2020", "--voltage", "1.98"]
    yield "ensemble", ["ensemble", "raminelli_2020", "--voltage", "1.98"]
    if data is not None:
        campaign = data / "labcontrol-mr-damper"
        yield "identify", ["identify", str(campaign), "--model", "dahl", "--save", str(folder / "damper.toml")]


def started(words: list[str], cache: Path) -> float:
    """Seconds of the processor that ``python -c`` takes with a folder of kernels."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, "-c", *words], env=os.environ | {"DAMPYR_CACHE": str(cache)}, check=True, capture_output=True
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def _line(name: str, spent: list[float]) -> Line:
    return Line(name, statistics.median(spent), min(spent), len(spent))
