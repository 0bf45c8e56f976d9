"""Uncorrected accelerograms (volume 1) of CSMIP, USC and RENADIC as they were digitised: pairs of time and g/10.

13 lines of text, 7 of 16 integers, 7 of 8 reals, then pairs in fields of 7 columns, five a line (of USC after one blank);
several components may follow one another. Times that are not even, as those of USC, are not forced on a mean step: the
samples are set on the grid of the times' last digit, a thousandth of a second, which holds each of them, with straight lines
between. The history says so.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from dampyr.errors import FileError
from dampyr.ground_motions.channels import MotionChannel, StatedPeak
from dampyr.ground_motions.fixed_width import Array, read_fields

TITLE = "volume 1"
SUFFIXES = (".raw",)
SIGNATURE = "'UNCORRECTED ACCELEROGRAM DATA' in line 1 and 'G/10' in its 13 lines of text"
HEAD = re.compile(r"uncorrected accelerogram data", re.IGNORECASE)
UNIT = re.compile(r"units\b.*\bare\b.*\bsec\b.*\bg/10\b", re.IGNORECASE)
COUNT = re.compile(r"no\.? of points\s*=\s*(\d+)", re.IGNORECASE)
PEAK = re.compile(r"\bmax\s*=\s*([-+.\d]+)\s*g\b", re.IGNORECASE)
CHANNEL = re.compile(r"\bchan\s+(\d+)\s*:\s*(.*)|\bcomp\s+(\w+)", re.IGNORECASE)
INTEGERS = re.compile(r"[\s\d-]{70,80}")
HEADER_LINES = 14  # of numbers
WIDTH, PAIRS = 7, 5
TICK = 1e-3  # s: the last digit of the times
EVEN = 0.6e-3  # s: what even times are off a line by, for their last digit


def recognises(lines: Sequence[str]) -> bool:
    """Whether the first lines of a file are those of a volume 1 of pairs."""
    return bool(lines) and HEAD.search(lines[0]) is not None and UNIT.search("\n".join(lines[:14])) is not None


def channels(path: Path, lines: Sequence[str]) -> list[MotionChannel]:
    """The components of the file, one for each header."""
    starts = [number for number, line in enumerate(lines) if HEAD.search(line)]
    return [_channel(path, lines, start, k + 1) for k, start in enumerate(starts)]


def _channel(path: Path, lines: Sequence[str], start: int, number: int) -> MotionChannel:
    integers = next((k for k in range(start + 5, min(start + 20, len(lines))) if INTEGERS.fullmatch(lines[k])), None)
    header = lines[start:integers]
    text = "\n".join(header)
    count, unit = COUNT.search(text), UNIT.search(text)
    if integers is None or count is None or unit is None:
        raise FileError(
            path,
            f"the header from line {start + 1} on says no number of points or no unit of G/10, or no integers follow it; "
            "fetch the file again",
        )
    first = integers + HEADER_LINES
    line = lines[first].rstrip() if first < len(lines) else ""
    pairs, _ = read_fields(path, lines, first, 2 * int(count[1]), WIDTH, offset=len(line) % WIDTH)
    values, step, notes = _even(path, pairs[0::2], pairs[1::2])
    peak = PEAK.search(text)
    channel = next(filter(None, map(CHANNEL.search, header)), None)
    component = f"{number}" if channel is None else channel[3] or f"{channel[1]}: {channel[2].strip()}"
    title = " ".join(" ".join(header[1:6]).split())[:120]
    return MotionChannel(
        component, 0.1 * values, step, "g", f"uncorrected accelerogram: {title}", str(path),
        StatedPeak.of(peak[1]) if peak else None, notes,
    )  # fmt: skip


def _even(path: Path, time: Array, values: Array) -> tuple[Array, float, tuple[str, ...]]:
    """The samples at an even step, the step, and what the history says of it."""
    steps = np.diff(time)
    if len(time) < 2 or np.any(steps <= 0):
        k = int(np.argmax(steps <= 0)) if len(time) > 1 else 0
        raise FileError(path, f"its times do not increase after pair {k + 1} ({time[k]:g} s); fetch the file again")
    order = np.arange(len(time))
    slope, start = np.polyfit(order, time, 1)
    if np.max(np.abs(time - start - slope * order)) <= EVEN:
        return values, float(f"{slope:.9g}"), ()
    ticks = np.rint((time - time[0]) / TICK).astype(int)
    note = (
        f"uneven times ({steps.min():.3g} to {steps.max():.3g} s): set on every {TICK:g} s, which holds each sample, with "
        "straight lines between"
    )
    return np.interp(np.arange(ticks[-1] + 1), ticks, values), TICK, (note,)
