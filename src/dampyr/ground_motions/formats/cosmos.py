"""COSMOS v1.20: headers that say how long they are, then the samples in the unit and the format that their line names.

The lines ``100 Integer-header values follow on 10 lines, Format= (10I8)``, ``100 Real-header values ...``, ``2 Comment line(s)
follow`` and ``7000 acceleration pts, ..., units=cm/sec2(04),Format=(8F10.5)`` lead through a component; several may follow one
another, velocities and displacements between them. Real 34 is the step and 64 the peak; -999 stands where nothing is known.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from dampyr.errors import FileError
from dampyr.ground_motions.channels import MotionChannel, StatedPeak, unit_of
from dampyr.ground_motions.fixed_width import read_fields, width_of

TITLE = "COSMOS"
SUFFIXES = (".v1c", ".v2c")
SIGNATURE = "'(Format v01.20 with 13 text lines)' in line 1"
HEAD = re.compile(r"\(Format\s+v0*1\.20\s+with\s+(\d+)\s+text lines\)", re.IGNORECASE)
BLOCK = re.compile(r"\s*(\d+)\s+(Integer|Real)-header values follow", re.IGNORECASE)
COMMENTS = re.compile(r"\s*(\d+)\s+Comment line", re.IGNORECASE)
SAMPLES = re.compile(r"\s*(\d+)\s+(\w+)\s+pts,.*units=\s*([^,(]+)", re.IGNORECASE)
STATION = re.compile(r"Stat\w*\s+No\s*:\s*(\S+)", re.IGNORECASE)
CHANNEL = re.compile(r"Sta Cha\w*\s*:?\s*(\S+?)\s*:\s*(.*?)\s*(?:\(|Location|$)", re.IGNORECASE)
SCNL = re.compile(r"<SCNL>\s*(\S+)")
UNKNOWN = -999.0


def recognises(lines: Sequence[str]) -> bool:
    """Whether the first lines of a file are those of COSMOS v1.20."""
    return bool(lines) and HEAD.search(lines[0]) is not None


def channels(path: Path, lines: Sequence[str]) -> list[MotionChannel]:
    """The components of the file whose samples are accelerations."""
    found: list[MotionChannel] = []
    kinds: list[str] = []
    for start in (number for number, line in enumerate(lines) if HEAD.search(line)):
        channel, kind = _channel(path, lines, start)
        kinds.append(kind)
        if channel:
            found.append(channel if channel.component else replace(channel, component=f"{len(found) + 1}"))
    if not found:
        raise FileError(path, f"holds {', '.join(dict.fromkeys(kinds))}; fetch the file of the acceleration")
    return found


def _channel(path: Path, lines: Sequence[str], start: int) -> tuple[MotionChannel | None, str]:
    """The component whose header begins at ``start``, None where it is not an acceleration, and what it is."""
    head = HEAD.search(lines[start])
    texts = lines[start : start + int(head[1] if head else 13)]
    number, comments, reals, places = start + len(texts), "", np.empty(0), list[str]()
    while number < len(lines) and not (samples := SAMPLES.match(lines[number])):
        if block := BLOCK.match(lines[number]):
            width = width_of(lines[number], 8 if block[2].lower() == "integer" else 13)
            values, after = read_fields(path, lines, number + 1, int(block[1]), width)
            if block[2].lower() == "real":
                reals, places = values, _fields(lines[number + 1 : after], width)
            number = after
        elif several := COMMENTS.match(lines[number]):
            comments = "\n".join(lines[number + 1 : number + 1 + int(several[1])])
            number += 1 + int(several[1])
        else:
            number += 1
    if number >= len(lines) or samples is None:
        raise FileError(path, f"no line of samples (such as '7000 acceleration pts, ...') follows line {start + 1}")
    values, _ = read_fields(path, lines, number + 1, int(samples[1]), width_of(lines[number], 10))
    if not samples[2].lower().startswith("acc"):
        return None, samples[2].lower()
    if len(reals) < 64 or reals[33] <= 0:
        step = f"{reals[33]:g} s" if len(reals) >= 34 else "missing"
        raise FileError(path, f"the step in the header (real 34) is {step}; fetch the file again")
    text = "\n".join(texts)
    station, place, code = STATION.search(text), CHANNEL.search(text), SCNL.search(comments)
    component = (code[1].split(".")[1] if code and code[1].count(".") else "") or (
        f"{place[1]}: {place[2]}" if place else ""
    )
    name = station[1] if station else ""
    return MotionChannel(
        component, values, float(reals[33]), unit_of(path, samples[3]),
        f"COSMOS, station {name}, {component}, {' '.join(texts[1].split())}", f"{name} {' '.join(texts[3].split())}".strip(),
        StatedPeak.of(places[63]) if reals[63] != UNKNOWN else None,
    ), "acceleration"  # fmt: skip


def _fields(lines: Sequence[str], width: int) -> list[str]:
    return [line[k : k + width] for line in lines for k in range(0, len(line.rstrip()), width)]
