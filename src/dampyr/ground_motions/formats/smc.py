"""SMC of the USGS: 11 lines of text, 6 of integers, 10 of reals, comments, then 8 values of 10 columns a line, in cm/s2.

The values have no blanks between them, ``1.5057E+0-2.2223E+0``. Integer 16 is the number of comments (``|``), 17 that of the
samples, real 2 the samples a second, 30 and 32 the largest and the smallest one; -32768 and 1.7E38 stand where nothing is
known. One component a file; velocities and displacements (``3`` and ``4`` in line 1) are refused.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from dampyr.errors import FileError
from dampyr.ground_motions.channels import MotionChannel, StatedPeak
from dampyr.ground_motions.fixed_width import header_numbers, read_fields

TITLE = "SMC"
SUFFIXES = (".smc",)
SIGNATURE = "'1 UNCORRECTED ACCELEROGRAM' or '2 CORRECTED ACCELEROGRAM' in line 1 and '*' in line 2"
KIND = re.compile(r"\s*([1-6])\s+(UN)?CORRECTED ACCELEROGRAM|\s*([3-6])\s+(VELOCITY|DISPLACEMENT|RESPONSE)")
TEXTS, INTEGERS, REALS = 11, 48, 50  # lines, numbers, numbers
UNKNOWN = 1e38  # of reals: 1.7E38


def recognises(lines: Sequence[str]) -> bool:
    """Whether the first lines of a file are those of SMC."""
    return len(lines) > 1 and KIND.match(lines[0]) is not None and lines[1].strip() == "*"


def channels(path: Path, lines: Sequence[str]) -> list[MotionChannel]:
    """The one component of the file."""
    if not lines[0].strip().startswith(("1", "2")):
        raise FileError(path, f"holds {lines[0].strip().lower()}; fetch the file of the acceleration")
    integers = header_numbers(path, lines, TEXTS, INTEGERS, 10, 8)
    reals = header_numbers(path, lines, TEXTS + 6, REALS, 15, 5)
    comments, count, rate = int(integers[15]), int(integers[16]), float(reals[1])
    if count < 2 or not 0 < rate < UNKNOWN:
        raise FileError(path, f"the header says {count} samples at {rate:g} Hz; fetch the file again")
    first = TEXTS + 6 + 10 + max(comments, 0)
    values, _ = read_fields(path, lines, first, count, 10)
    extremes = [(abs(reals[k]), _text_of_real(lines, k)) for k in (29, 31) if abs(reals[k]) < UNKNOWN]
    station = re.search(r"station\s*=\s*(.*?)\s+component\s*=\s*(.*)", " ".join(lines[3:8]), re.IGNORECASE)
    name, component = (station[1].strip(), station[2].split()[0]) if station else ("", path.stem)
    when = " ".join(lines[3].split())
    return [
        MotionChannel(
            component, values, 1.0 / rate, "cm/s^2", f"SMC, station {name}, component {component}, {when}",
            f"{name} {when}".strip(), StatedPeak.of(max(extremes)[1]) if extremes else None,
        )
    ]  # fmt: skip


def _text_of_real(lines: Sequence[str], number: int) -> str:
    row, column = divmod(number, 5)
    return lines[TEXTS + 6 + row][15 * column : 15 * column + 15]
