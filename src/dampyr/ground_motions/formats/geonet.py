"""GeoNet's V1A and V2A (GNS Science): three components a file, accelerations in mm/s2, 10 values of 8 columns a line.

Each component has 16 lines of text, 4 of 10 integers and 6 of 10 reals. Of V1A integer 31 is the number of samples, real 25 the
step and 31 the peak; of V2A integer 34, real 26 and 36, and velocity and displacement follow the acceleration.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

from dampyr.errors import FileError
from dampyr.ground_motions.channels import MotionChannel, StatedPeak
from dampyr.ground_motions.fixed_width import header_numbers, read_fields

TITLE = "GeoNet"
SUFFIXES = (".v1a", ".v2a")
SIGNATURE = "'Corrected accelerogram ... GNS Science' or 'Uncorrected accelerogram ... GNS Science' in line 1"
HEAD = re.compile(r"\s*(un)?corrected accelerogram\b.*\bGNS Science", re.IGNORECASE)
COMPONENT = re.compile(r"Component\s+(\S+)", re.IGNORECASE)
TEXTS, INTEGERS, REALS, WIDTH, PER_LINE = 16, 40, 60, 8, 10
PLACES = {"V1A": (30, 24, 30, 1), "V2A": (33, 25, 35, 3)}  # of count, step and peak, from 0; blocks of samples


def recognises(lines: Sequence[str]) -> bool:
    """Whether the first lines of a file are those of GeoNet."""
    return bool(lines) and HEAD.match(lines[0]) is not None


def channels(path: Path, lines: Sequence[str]) -> list[MotionChannel]:
    """The accelerations of the file, one for each component."""
    found: list[MotionChannel] = []
    start = 0
    while start < len(lines) and (head := HEAD.match(lines[start])):
        volume = "V1A" if head[1] else "V2A"
        count_at, step_at, peak_at, blocks = PLACES[volume]
        text = "\n".join(lines[start : start + TEXTS])
        if "mm/s/s" not in text:
            raise FileError(path, f"the header from line {start + 1} on does not name mm/s/s; fetch the file again")
        integers = header_numbers(path, lines, start + TEXTS, INTEGERS, WIDTH, PER_LINE)
        above = start + TEXTS + INTEGERS // PER_LINE
        reals = header_numbers(path, lines, above, REALS, WIDTH, PER_LINE)
        count = int(integers[count_at])
        first = above + REALS // PER_LINE
        rows = math.ceil(count / PER_LINE)
        values, *_ = (read_fields(path, lines, first + k * rows, count, WIDTH)[0] for k in range(blocks))
        row, column = divmod(peak_at, PER_LINE)
        match = COMPONENT.search(text)
        found.append(
            MotionChannel(
                match[1] if match else f"{len(found) + 1}", values, float(reals[step_at]), "mm/s^2",
                f"GeoNet {volume}: {' '.join(text.splitlines()[1].split())}", str(path),
                StatedPeak.of(lines[above + row][WIDTH * column : WIDTH * (column + 1)]),
            )
        )  # fmt: skip
        start = first + blocks * rows
        while start < len(lines) and not lines[start].strip():
            start += 1
    if start < len(lines):
        raise FileError(
            path, f"line {start + 1} is {lines[start].strip()[:40]!r}; the header of a component must stand there"
        )
    return found
