"""PEER's .AT2: four lines of header, then accelerations in rows.

The fourth line says how many samples there are and their step, in one of two styles: ``NPTS=   5372, DT=
.0100 SEC`` or ``5372    0.0100    NPTS, DT``. The third says the unit. A header that does not fit its data
is refused.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from dampyr.errors import FileError
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.samples import motion_of

SUFFIXES = (".at2",)
_NUMBER = r"([-+]?\d*\.?\d+(?:[eE][-+]?\d+)?)"
_STYLES = (
    re.compile(rf"NPTS\s*=\s*(\d+)\s*,?\s*DT\s*=\s*{_NUMBER}", re.IGNORECASE),
    re.compile(rf"^\s*(\d+)\s+{_NUMBER}\s+NPTS\s*,?\s*DT", re.IGNORECASE),
)


def read(path: Path, units: str | None = None, dt: float | None = None) -> GroundMotion:
    """The ground motion of an .AT2 file; ``units`` and ``dt`` may be given again but must not
    contradict the header."""
    lines = path.read_text(encoding="latin-1").splitlines()
    count, step = _header(path, lines)
    values = _values(path, lines[4:])
    if len(values) != count:
        raise FileError(
            path,
            f"the header says NPTS = {count} but {len(values)} values follow; fetch the file again or correct NPTS",
        )
    if dt is not None and abs(dt - step) > 1e-6 * step:
        raise FileError(path, f"dt = {dt:g} s contradicts the header's DT = {step:g} s; leave dt out")
    named = _unit(lines[2])
    if units is not None and named is not None and units.lower() != named.lower():
        raise FileError(path, f"units = {units!r} contradict the header's {named!r}; leave units out")
    unit = named or units
    if unit is None:
        raise FileError(path, "the header names no unit; declare it, such as units='g'")
    return motion_of(path, values, step, unit, source=" / ".join(line.strip() for line in lines[:2]))


def _header(path: Path, lines: list[str]) -> tuple[int, float]:
    if len(lines) < 5:
        raise FileError(path, f"has {len(lines)} lines; an .AT2 file has 4 lines of header and then its values")
    for style in _STYLES:
        match = style.search(lines[3])
        if match and float(match[2]) > 0:
            return int(match[1]), float(match[2])
    raise FileError(
        path,
        f"line 4 is {lines[3].strip()!r}; it must give NPTS and DT > 0, such as 'NPTS= 5372, DT= .0100 SEC'",
    )


def _values(path: Path, lines: list[str]) -> np.ndarray:
    values: list[float] = []
    for number, line in enumerate(lines, start=5):
        try:
            values.extend(map(float, line.split()))
        except ValueError:
            raise FileError(path, f"line {number} is {line.strip()!r}; it must hold numbers only") from None
    return np.array(values)


def _unit(line: str) -> str | None:
    match = re.search(r"UNITS? OF\s+(\S+)", line, re.IGNORECASE)
    if not match:
        return None
    unit = match[1].rstrip(".,;")
    return {"g": "g", "g's": "g", "gs": "g"}.get(unit.lower(), unit.lower())
