"""Corrected accelerograms (volume 2) of CSMIP, CDMG and USC, and CSMIP's uncorrected ones of equal steps: V2, V1.

Before the samples a line says all of them: ``15050 points of accel data equally spaced at .020 sec, in cm/sec2. (8f10.6)``, of
volume 1 ``13200 Accelerogram points at 200 pts/sec in units of g . Format: (8f9.6)``. Velocity and displacement follow, and
further components. The step is printed to three decimals there: the header above the line, 7 lines of 16 integers and 13 of 8
reals, has more digits (real 61).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from dampyr.errors import FileError, InputError
from dampyr.ground_motions.channels import MotionChannel, StatedPeak, unit_of
from dampyr.ground_motions.fixed_width import header_numbers, read_fields, width_of

TITLE = "CSMIP"
SUFFIXES = (".v2", ".v1")
SIGNATURE = (
    "'Corrected accelerogram' in line 1 and a line such as ' 15050 points of accel data equally spaced at .020 sec'"
)
CORRECTED = re.compile(
    r"\s*(\d+)\s+points of (acc|vel|dis)\w*\.? data equally spaced at\s+(?P<step>[\d.]+)\s*sec\W*"
    r"(?:in units|in|units:?)\s*(?P<unit>[\w/^]+)",
    re.IGNORECASE,
)
UNCORRECTED = re.compile(
    r"\s*(\d+)\s+(acc)elerogram points at\s+(?P<rate>[\d.]+)\s*pts/sec\s+in units of\s+(?P<unit>[\w/^]+)", re.IGNORECASE
)
PEAK = re.compile(r"peak acceleration\s*=\s*([-+.\d]+)", re.IGNORECASE)
LARGEST = re.compile(r"\bmax\s*=\s*([-+.\d]+)\s*g\b", re.IGNORECASE)
CHANNEL = re.compile(r"\bchan\s+(\d+)\s*:\s*(.*?)\s*(?:from|$)|\bcomp\s+(\w+)", re.IGNORECASE)
HEAD = "corrected accelerogram"
REAL_LINES = 13


def recognises(lines: Sequence[str]) -> bool:
    """Whether the first lines of a file are those of a volume 2, or of a volume 1 of equal steps."""
    return bool(lines) and HEAD in "".join(lines[:2]).lower() and any(_block(line) for line in lines[:80])


def channels(path: Path, lines: Sequence[str]) -> list[MotionChannel]:
    """The accelerations of the file, one for each component."""
    found: list[MotionChannel] = []
    after = end = 0  # the line after the accelerations of the component before, and after the samples so far
    for number, line in enumerate(lines):
        block = _block(line)
        if block is None:
            continue
        values, end = read_fields(path, lines, number + 1, int(block[1]), width_of(line, 10))
        if block[2].lower() != "acc":  # read so that a file which was cut is not taken for whole
            continue
        header = lines[next((k for k in range(after, number) if HEAD in lines[k].lower()), after) : number]
        corrected = "step" in block.groupdict()
        step = _step(path, lines, number, float(block["step"])) if corrected else 1.0 / float(block["rate"])
        after = end
        text = "\n".join(header)
        match = (PEAK if corrected else LARGEST).search(text)
        channel = next(filter(None, map(CHANNEL.search, header)), None)
        component = "" if channel is None else channel[3] or f"{channel[1]}: {channel[2]}"
        title = " ".join(line.strip() for line in header[: 2 if corrected else 6] if line.strip())[:120]
        found.append(
            MotionChannel(
                component or f"{len(found) + 1}", values, step, unit_of(path, block["unit"]),
                f"{'corrected' if corrected else 'uncorrected'} accelerogram: {title}", str(path),
                StatedPeak.of(match[1]) if match else None,
            )
        )  # fmt: skip
    if any(HEAD in line.lower() for line in lines[end:]):
        raise FileError(path, "no line of samples follows the last header; the file was cut, so fetch it again")
    return found


def _block(line: str) -> re.Match[str] | None:
    return CORRECTED.match(line) or UNCORRECTED.match(line)


def _step(path: Path, lines: Sequence[str], number: int, printed: float) -> float:
    """The step of the header's reals where it is that of the line, to more digits: a 300th of a second is .003 there."""
    try:
        exact = float(header_numbers(path, lines, number - REAL_LINES, 61, 10, 8)[60])
    except InputError:
        return printed
    return exact if abs(exact - printed) <= 0.51e-3 and exact > 0 else printed
