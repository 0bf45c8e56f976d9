"""PEER's .AT2: four lines of header, then accelerations in rows.

The last line of the header says how many samples there are and their step, in one of two styles: ``NPTS=   5372, DT=
.0100 SEC`` or ``5372    0.0100    NPTS, DT``. One above it says the unit. A header that does not fit its data is refused.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from dampyr import text_table
from dampyr.errors import FileError
from dampyr.ground_motions.formats.columns import motion_of_table, stated_in
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.motion_options import ACCELERATION, MotionReadOptions

SUFFIXES = (".at2",)
TAKES_OPTIONS = True
HEADER = 4  # lines, blank ones not counted
VERTICAL = {"UP", "DWN", "DOWN", "DN", "V", "VER", "VERT", "VERTICAL", "Z"}
NAMED = 3  # parts of the second line at least, the last of which is the component


def read(
    path: Path, units: str | None = None, dt: float | None = None, options: MotionReadOptions | None = None
) -> GroundMotion:
    """The ground motion of an .AT2 file; ``units`` and ``dt`` may be given again but must not
    contradict the header."""
    request = options or MotionReadOptions()
    request.refuse(path, columns="an .AT2 file holds accelerations alone", header="its line of NPTS and DT is found")
    text, note = text_table.decoded(path, request.encoding)
    lines = text.split("\n")
    written = [k for k, line in enumerate(lines) if line.strip()][: HEADER + 1]
    if len(written) <= HEADER:
        raise FileError(
            path, f"has {len(written)} lines; an .AT2 file has {HEADER} lines of header and then its values"
        )
    last = written[HEADER - 1]
    header = tuple(line.strip() for line in lines[: last + 1] if line.strip())
    stated = stated_in(header)
    if stated.count is None or stated_in(header[-1:]).count is None:
        raise FileError(
            path,
            f"line {last + 1} is {header[-1]!r}; it must give NPTS and DT > 0, such as 'NPTS= 5372, DT= .0100 SEC'",
        )
    if units is not None:
        if stated.unit is not None and units.lower() != stated.unit.lower():
            raise FileError(path, f"units = {units!r} contradict the header's {stated.unit!r}; leave units out")
        request = replace(request, units={**request.units, ACCELERATION: units})
    table = text_table.table_of_rows(path, "\n".join(lines[last + 1 :]), last + 1, request, series=True)
    table = replace(table, notes=(*((note,) if note else ()), *table.notes))
    return motion_of_table(path, table, stated, request, dt, source=" / ".join(header[:2]))


def component_of(path: Path) -> tuple[str, str, bool]:
    """The component, the recording that it belongs to, and whether it is vertical, by the second line of the header.

    That is event, date, station and component, such as ``Imperial Valley-02, 5/19/1940, El Centro Array #9, 180``: the three
    files of a recording differ in the last of them. Empty where the line has fewer parts.
    """
    lines = [line.strip() for line in text_table.decoded(path, None)[0].split("\n") if line.strip()]
    parts = [part.strip() for part in lines[1].split(",")] if len(lines) > 1 else []
    if len(parts) < NAMED or not parts[-1]:
        return "", "", False
    return parts[-1], ", ".join(parts[:-1]), parts[-1].upper() in VERTICAL
