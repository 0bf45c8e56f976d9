"""Records: what was measured, how well, and where a label disagrees."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._output import as_json_option, print_json, print_table
from dampyr.cli._records import Reading, gather, reading_options
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.records import Measured, Record

COLUMNS = ["record", "role", "input", "duration", "frequency", "peak to peak", "mean force", "to look at"]
UNITS = ["", "", "", "s", "Hz", "mm", "N", ""]


@click.command()
@click.argument("paths", nargs=-1, type=click.Path(path_type=Path))
@click.option("--role", type=click.Choice(["fit", "validation", "all"]), default="all", help="Of a campaign.")
@reading_options
@as_json_option
def command(
    paths: tuple[Path, ...],
    role: str,
    reading: Reading,
    as_json: bool,
) -> None:
    """List records, measured and checked.

    PATHS are files or campaign folders; without them, the labcontrol campaign. One record alone is shown in
    full. Frequency and displacement are measured over whole cycles; where a label says something else, that
    is told.
    """
    from dampyr import records

    places = paths or (records.locate("labcontrol"),)
    found = gather(places, None if role == "all" else role, reading)
    absent = [row for path in places if path.is_dir() for row in _without_file(path)]
    told = [_told(record) for record in found]
    if as_json:
        print_json({"records": told, "rows_without_file": absent})
    elif len(told) == 1 and not absent:
        _print_one(told[0])
    else:
        notes = [f"table {row['table']}, row {row['row']}: no file" for row in absent]
        print_table(f"{len(told)} records", COLUMNS, [_row(each) for each in told], UNITS, notes=notes)


def _without_file(folder: Path) -> list[dict[str, Any]]:
    """The rows of a campaign's table that have no file."""
    from dampyr import records
    from dampyr.records.campaign import TABLE

    rows = records.campaign_rows(folder) if (folder / TABLE).is_file() else []
    return [{"table": row.table, "row": row.row} for row in rows if row.file is None]


def _told(record: Record) -> dict[str, Any]:
    """All that is known of a record, without its samples."""
    from dampyr import records

    measured: Measured | None = None
    try:
        measured, notes = records.measure(record), records.disagreements(record)
    except InputError as problem:  # no whole cycle: there is a record, but nothing to measure in it
        notes = [str(problem)]
    quality = records.quality(record)
    return {
        "name": record.name,
        "role": record.role,
        "input": record.input,
        "input_value": record.input_value,
        "duration_s": record.duration,
        "label": record.label,
        "measured": measured,
        "quality": quality,
        "notes": [*(note.removeprefix(f"{record.name}: ") for note in notes), *quality.notes],
        "history": record.history,
        "provenance": record.provenance,
    }


def _input(told: dict[str, Any]) -> str | None:
    return None if told["input"] is None else f"{told['input_value']:.5g} {told['input']}"


def _row(told: dict[str, Any]) -> list[Any]:
    m = told["measured"]
    motion = [m.frequency_hz, 1e3 * m.peak_to_peak_m, m.mean_force] if m else [None, None, None]
    notes = "; ".join(told["notes"])
    return [told["name"], told["role"], _input(told), told["duration_s"], *motion, notes]


def _print_one(told: dict[str, Any]) -> None:
    """A record in full, one line for each thing known of it."""
    from dampyr.records.record import CHANNELS

    m, q = told["measured"], told["quality"]
    lines: list[tuple[str, Any]] = [("role", told["role"]), ("input", _input(told))]
    lines += [("duration", f"{told['duration_s']:.6g} s"), ("samples", f"{q.samples}, every {q.dt:.6g} s")]
    if m:
        lines += [
            ("motion starts at", f"{m.motion_start:.4g} s"),
            ("whole cycles", str(m.cycles)),
            ("frequency", f"{m.frequency_hz:.5g} Hz"),
            ("peak to peak", f"{1e3 * m.peak_to_peak_m:.5g} mm"),
            ("peak speed", f"{1e3 * m.peak_speed:.4g} mm/s"),
            ("drift", f"{1e3 * m.drift_m_per_s:.3g} mm/s"),
            ("mean force", f"{m.mean_force:.4g} N"),
            ("energy per cycle", f"{m.energy_per_cycle:.4g} J"),
            ("third harmonic", f"{100 * m.harmonics[3]:.2g} %"),
        ]
    lines += [(f"{channel} step", f"{step:.4g} {CHANNELS[channel]}") for channel, step in q.quantum.items()]
    lines += [("to look at", note) for note in told["notes"]]
    lines += list(told["provenance"].items()) + [("done", step) for step in told["history"]]
    print_table(told["name"], ["", ""], lines)
