"""What the ground motions in a folder show."""

from __future__ import annotations

from typing import Any

from dampyr.ground_motions.intensity_measures import pgv
from dampyr.ground_motions.motion_folder import MotionEntry, MotionTable
from dampyr.phrases import counted, sentence
from dampyr.show.descriptions import Description, describe
from dampyr.show.table import Cell, Table
from dampyr.units import STANDARD_GRAVITY


@describe.register
def describe_table(table: MotionTable) -> Description:
    """How many could be read, and a row for each."""
    refused = [entry for entry in table.entries if entry.motion is None]
    rows = [("read", counted(len(table.motions), "component")), ("refused", str(len(refused)) if refused else "")]
    return Description(
        f"MotionTable of {table.path!r}",
        [row for row in rows if row[1]],
        tables=[lambda: motions_table(table)],
        data=lambda: {"path": table.path, "motions": [_as_dict(entry) for entry in table.entries]},
    )


@describe.register
def describe_entry(entry: MotionEntry) -> Description:
    """The file, the component, and the motion's peak or why the file is refused."""
    motion = entry.motion
    peak = "" if motion is None else f"{motion.pga:.4g} m/s² ({motion.pga / STANDARD_GRAVITY:.3g} g)"
    rows = [("format", entry.format), ("component", entry.component), ("peak", peak), ("refused", entry.problem)]
    return Description(
        f"MotionEntry {entry.file!r}", [row for row in rows if row[1]], data=lambda: _as_dict(entry),
        tables=[lambda: motions_table(MotionTable("", (entry,)))],
    )  # fmt: skip


def motions_table(table: MotionTable) -> Table:
    """A row for each component, and a sentence below for each file that is refused."""
    rows: list[list[Cell]] = []
    notes = []
    for entry in table.entries:
        start: list[Cell] = [entry.file, entry.format or None, entry.component or None]
        motion = entry.motion
        if motion is None:
            rows.append([*start, None, None, None, None, None, None])
            named = entry.problem.startswith(f"{entry.component}: ")
            about = entry.file if named else f"{entry.file} {entry.component}".strip()
            notes.append(f"{about}: {sentence(entry.problem)}")
            continue
        peaks = (motion.pga, motion.pga / STANDARD_GRAVITY, 1e3 * pgv(motion))
        rows.append([*start, 1e3 * motion.dt, motion.n, motion.duration, *peaks])
    return Table(
        ("file", "format", "component", "step", "samples", "duration", "PGA", "PGA", "PGV"),
        rows,
        ("", "", "", "ms", "", "s", "m/s²", "g", "mm/s"),
        caption=f"Ground motions in {table.path}." if table.path else "Ground motion.",
        notes=notes,
        digits=4,
    )


def _as_dict(entry: MotionEntry) -> dict[str, Any]:
    motion = entry.motion
    numbers = {} if motion is None else {
        "name": motion.name, "source": motion.source, "history": motion.history, "dt_s": motion.dt, "samples": motion.n,
        "duration_s": motion.duration, "pga_m_s2": motion.pga, "pgv_m_s": pgv(motion),
    }  # fmt: skip
    refused = {"problem": entry.problem} if entry.problem else {}
    return {"file": entry.file, "format": entry.format, "component": entry.component, **numbers, **refused}
