"""K-NET and KiK-net (NIED): 17 lines of header, then counts, 8 a line; one component a file.

``Scale Factor`` makes gal of counts, 2000(gal)/8388608. The counts have an offset that may be larger than the shaking: their
mean is taken off, as the header's ``Max. Acc.`` presumes, and the history says how much that was. ``Record Time`` is 15 s late.
``Dir.`` is N-S, E-W or U-D, and of KiK-net 1 to 3 (borehole) or 4 to 6 (surface) in that order.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from dampyr.errors import FileError
from dampyr.ground_motions.channels import MotionChannel, StatedPeak

TITLE = "K-NET"
SUFFIXES = (".ns", ".ew", ".ud", ".ns1", ".ew1", ".ud1", ".ns2", ".ew2", ".ud2")
SIGNATURE = "'Origin Time' at the head of line 1"
KEY_WIDTH = 18  # columns of a line of the header before its value
DELAY = 15  # s that Record Time is later than the first sample
DIRECTIONS = {
    **{str(1 + k): f"{name} borehole" for k, name in enumerate(("N-S", "E-W", "U-D"))},
    **{str(4 + k): f"{name} surface" for k, name in enumerate(("N-S", "E-W", "U-D"))},
}


def recognises(lines: Sequence[str]) -> bool:
    """Whether the first lines of a file are those of K-NET."""
    return bool(lines) and lines[0].startswith("Origin Time")


def channels(path: Path, lines: Sequence[str]) -> list[MotionChannel]:
    """The one component of the file."""
    header, first = _header(path, lines)
    try:
        counts = np.array([float(word) for line in lines[first:] for word in line.split()])
    except ValueError as problem:
        raise FileError(path, f"holds a count that is not a number ({problem}); fetch the file again") from None
    rate, scale = _number(path, header, "Sampling Freq(Hz)", r"([\d.]+)\s*Hz"), _scale(path, header)
    duration = _number(path, header, "Duration Time(s)", r"([\d.]+)")
    # Duration Time is in whole seconds
    if abs(len(counts) / rate - duration) >= 1.0:
        raise FileError(
            path,
            f"the header says {duration:g} s at {rate:g} Hz, {duration * rate:.0f} counts, but {len(counts)} follow; "
            "the file was cut, so fetch it again",
        )
    mean = float(counts.mean())
    direction = header.get("Dir.", "")
    station, start = header.get("Station Code", ""), header.get("Record Time", "")
    component = DIRECTIONS.get(direction, direction)
    source = f"K-NET, station {station}, {component}, from {start} JST less {DELAY} s"
    depth = component.partition(" ")[2]
    return [
        MotionChannel(
            component, scale * (counts - mean), 1.0 / rate, "cm/s^2", source, f"{station} {start} {depth}".strip(),
            StatedPeak.of(header["Max. Acc. (gal)"]) if header.get("Max. Acc. (gal)") else None,
            (f"mean of {mean:.6g} counts ({scale * mean:.4g} gal) taken off",),
        )
    ]  # fmt: skip


def _header(path: Path, lines: Sequence[str]) -> tuple[dict[str, str], int]:
    header = {}
    for number, line in enumerate(lines):
        key, value = line[:KEY_WIDTH].strip(), line[KEY_WIDTH:].strip()
        header[key] = value
        if key.startswith("Memo"):
            return header, number + 1
    raise FileError(path, "the header has no line 'Memo.', after which the counts begin; fetch the file again")


def _number(path: Path, header: dict[str, str], key: str, pattern: str) -> float:
    match = re.match(pattern, header.get(key, ""))
    if match is None or float(match[1]) <= 0:
        raise FileError(
            path, f"the header's {key} is {header.get(key, '')!r}; it must be a number greater than 0, such as 100"
        )
    return float(match[1])


def _scale(path: Path, header: dict[str, str]) -> float:
    """gal for each count."""
    match = re.fullmatch(r"([\d.]+)\(gal\)/([\d.]+)", header.get("Scale Factor", "").replace(" ", ""))
    if match is None or float(match[2]) == 0:
        raise FileError(
            path, f"the header's Scale Factor is {header.get('Scale Factor', '')!r}; it must be as in 3920(gal)/6182761"
        )
    return float(match[1]) / float(match[2])
