"""What benches print, and where they ran."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Line:
    """One contender: how long it took (median, s, and the fastest), its error in words, and how many rounds."""

    name: str
    median: float
    fastest: float
    rounds: int
    error: str = ""


def show(lines: Sequence[Line]) -> str:
    """The lines as a table, the time of each also as a multiple of the first line's."""
    rows = [("", "median", "fastest", "times", "rounds", "")]
    first = lines[0].median
    rows += [
        (
            each.name,
            spoken(each.median),
            spoken(each.fastest),
            "" if math.isnan(each.median) else f"{each.median / first:.3g}",
            str(each.rounds or ""),
            each.error,
        )
        for each in lines
    ]
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return "\n".join(_aligned(row, widths) for row in rows)


def _aligned(row: Sequence[str], widths: Sequence[int]) -> str:
    cells = [
        row[0].ljust(widths[0]),
        *(cell.rjust(w) for cell, w in zip(row[1:-1], widths[1:-1], strict=True)),
        row[-1],
    ]
    return "  " + "  ".join(cells).rstrip()


def spoken(seconds: float) -> str:
    """A time in the unit that suits it; nothing for a contender that did not run."""
    if math.isnan(seconds):
        return ""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def machine() -> str:
    """The processor, its cores, and the versions that matter."""
    import numba
    import numpy
    import scipy

    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    versions = f"Python {platform.python_version()}, numpy {numpy.__version__}, scipy {scipy.__version__}"
    return f"{_processor()}, {cores} cores, {platform.system()}; {versions}, numba {numba.__version__}"


def _processor() -> str:
    listing = Path("/proc/cpuinfo")
    if listing.is_file():
        for line in listing.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def data_folder() -> Path | None:
    """The folder of measured data, or None where it is absent."""
    default = Path(__file__).resolve().parents[2] / "shared" / "data"
    folder = Path(os.environ.get("DAMPYR_DATA") or default)
    return folder if folder.is_dir() else None
