"""AFAD of Türkiye, in its older form: 17 lines of header, then the columns N-S, E-W and U-D in gal.

``NUMBER OF DATA`` and ``SAMPLING INTERVAL (sec)`` are checked and taken, and the peak of each column must be that of ``RAW PGA
VALUES (gal)``. The text is Latin-1.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from dampyr.errors import FileError
from dampyr.ground_motions.channels import MotionChannel, StatedPeak

TITLE = "AFAD"
SUFFIXES: tuple[str, ...] = ()  # .txt is of plain columns
SIGNATURE = "'STRONG GROUND MOTION RECORDS OF TURKIYE' in line 1"
NAMES = re.compile(r"\s*(?:[NEUVLT]\w*-?\w*\s*){1,3}")
PEAK = re.compile(r"\(([^)]+)\)\s*([-+.\dEe]+)")


def recognises(lines: Sequence[str]) -> bool:
    """Whether the first lines of a file are those of AFAD."""
    return bool(lines) and lines[0].strip().upper().startswith("STRONG GROUND MOTION RECORDS OF TURK")


def channels(path: Path, lines: Sequence[str]) -> list[MotionChannel]:
    """The columns of the file, one for each component."""
    header = {key.strip(): value.strip() for key, mark, value in (line.partition(":") for line in lines[:30]) if mark}
    unit_line = next((key for key in header if key.startswith("RAW PGA VALUES")), "")
    if "(gal)" not in unit_line:
        raise FileError(
            path, "the header has no line 'RAW PGA VALUES (gal)', which names the unit; fetch the file again"
        )
    first = next((k for k in range(1, min(40, len(lines))) if "-" in lines[k] and NAMES.fullmatch(lines[k])), None)
    try:
        step, count = float(header["SAMPLING INTERVAL (sec)"]), int(header["NUMBER OF DATA"])
    except (KeyError, ValueError):
        raise FileError(
            path, "the header does not say NUMBER OF DATA and SAMPLING INTERVAL (sec) as numbers; fetch the file again"
        ) from None
    if first is None:
        raise FileError(path, "no line names the columns, such as 'N-S E-W U-D'; fetch the file again")
    components = lines[first].split()
    try:
        rows = np.array([[float(word) for word in line.split()] for line in lines[first + 1 :] if line.strip()])
    except ValueError as problem:
        raise FileError(path, f"its columns hold what is not a number, or differ in length ({problem})") from None
    if rows.shape != (count, len(components)):
        raise FileError(
            path,
            f"the header says {count} rows of {len(components)} columns but {' x '.join(map(str, rows.shape))} follow; the "
            "file was cut, so fetch it again",
        )
    peaks = dict(PEAK.findall(header[unit_line]))
    station, time = header.get("STATION ID", ""), header.get("RECORD TIME", "")
    return [
        MotionChannel(
            component, rows[:, k], step, "cm/s^2", f"AFAD, station {station}, {component}, {time}", str(path),
            StatedPeak.of(peaks[component]) if component in peaks else None,
        )
        for k, component in enumerate(components)
    ]  # fmt: skip
