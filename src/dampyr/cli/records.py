"""Records: what was measured, how well, and where a label disagrees."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._options import OptionsCommand
from dampyr.cli._output import as_json_option, print_json, print_table, state_origin
from dampyr.cli._records import READING, gather, role_option

if TYPE_CHECKING:
    from dampyr.records import ReadOptions
    from dampyr.records.checks.overview import Overview

COLUMNS = ["record", "role", "input", "duration", "frequency", "peak to peak", "peak speed", "mean force"]
UNITS = ["", "", "", "s", "Hz", "mm", "mm/s", "N"]
BY_INPUT = ["input", "records", "frequency", "peak to peak", "peak speed"]


class RecordsCommand(OptionsCommand):
    """A command whose first word may be that of another one in `commands`; a folder of that name is ``./convert``."""

    @property
    def commands(self) -> dict[str, click.Command]:
        """The other commands, by what is typed after this one's name."""
        return {"convert": convert}

    def make_context(self, info_name: Any, args: list[str], parent: Any = None, **extra: Any) -> click.Context:
        """The context of the command that the first word chooses."""
        chosen = self.commands.get(args[0]) if args else None
        if chosen is None:
            return super().make_context(info_name, args, parent, **extra)
        return chosen.make_context(f"{info_name} {args[0]}", args[1:], parent, **extra)


@click.command(
    cls=OptionsCommand, options=READING, first=3, epilog=examples("dampyr records convert tests --to csv --out csv")
)
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--to",
    default="h5",
    show_default=True,
    metavar="FORMAT",
    help="Format of the new files: h5, csv, mat, nc (NetCDF) or parquet.",
)
@click.option("--out", required=True, type=click.Path(path_type=Path), help="The folder to write into.")
@role_option()
@as_json_option
def convert(paths: tuple[Path, ...], to: str, out: Path, role: str | None, reading: ReadOptions, as_json: bool) -> None:
    """Write records in another format.

    PATHS are files or folders of them. Each record becomes a file of its name in --out; a file that is there is never
    overwritten. Channels come out in SI, with their units in the header of a .csv.
    """
    from dampyr import records
    from dampyr.phrases import counted

    written = records.convert(gather(paths, role, reading, warn=False), out, to)
    if as_json:
        print_json({"written": written})
    else:
        click.echo(f"{counted(len(written), 'record')} in {out}")


@click.command(
    cls=RecordsCommand,
    options=READING,
    first=1,
    epilog=examples(
        "dampyr records tests",
        "dampyr records test.csv --column 'force=Load cell' --voltage 1.98",
    ),
)
@click.argument("paths", nargs=-1, type=click.Path(path_type=Path))
@role_option()
@as_json_option
def command(
    paths: tuple[Path, ...],
    role: str | None,
    reading: ReadOptions,
    as_json: bool,
) -> None:
    """List records, measured and checked.

    PATHS are files or folders of them; without any, the labcontrol campaign. One record alone is shown in
    full. Frequency and displacement are measured over whole cycles; where a label says something else, that
    is told. Of a motion that does not repeat itself, the overall stroke is told and its strongest frequency.
    `dampyr records convert` writes records in another format.
    """
    from dampyr import records
    from dampyr.origin import NOT_STATED, combined
    from dampyr.records.record import GROUPS

    places = paths or (records.locate("labcontrol"),)
    short: list[str] = []
    record_list = gather(places, role, reading, warn=False, short=short)
    absent = [row for path in places if path.is_dir() for row in _without_file(path)]
    descriptions = [records.describe(record) for record in record_list]
    state_origin(combined(record.origin for record in record_list))
    if as_json:
        print_json({"records": descriptions, "rows_without_file": absent, "too_short": short})
    elif len(descriptions) == 1 and not absent and not short:
        _print_in_full(descriptions[0])
    else:
        notes = [f"table {row['table']}, row {row['row']}: no file" for row in absent] + short
        groups = {name: word for name, word in GROUPS.items() if any(described[name] for described in descriptions)}
        if any(described["origin"]["kind"] != NOT_STATED.kind for described in descriptions):
            groups["origin"] = "origin"
        rows = [
            [
                *_row(described),
                *(described["origin"]["kind"] if name == "origin" else described[name] for name in groups),
                "; ".join(finding["words"] for finding in described["findings"]),
            ]
            for described in descriptions
        ]
        names, units = [*COLUMNS, *groups.values(), "to look at"], [*UNITS, *("" for _ in groups), ""]
        print_table(f"{len(descriptions)} records", names, rows, units, notes=notes)
        _print_by_input(descriptions)
        _print_smoothing(descriptions)


def _without_file(folder: Path) -> list[dict[str, Any]]:
    """The rows of a campaign's table that have no file."""
    from dampyr.records.files.campaign_folder import TABLE, campaign_rows

    rows = campaign_rows(folder) if (folder / TABLE).is_file() else []
    return [{"table": row.table, "row": row.row} for row in rows if row.file is None]


def _input(description: dict[str, Any]) -> str | None:
    from dampyr.input_kinds import INPUTS

    if description["input"] not in INPUTS:
        return "none" if description["input"] else None
    low, high = description["input_range"]
    return f"{low:.5g} {description['input']}" if low == high else f"{low:.3g} to {high:.3g} {description['input']}"


def _row(description: dict[str, Any]) -> list[Any]:
    m, seen = description["measured"], description["overview"]
    stroke = 1e3 * (m.peak_to_peak_m if m else seen.stroke_m)
    speed = 1e3 * (m.peak_speed if m else seen.peak_speed)
    frequency, force = (m.frequency_hz, m.mean_force) if m else (None, None)
    return [
        description["name"],
        description["role"],
        _input(description),
        description["duration_s"],
        frequency,
        stroke,
        speed,
        force,
    ]


def _print_by_input(descriptions: list[dict[str, Any]]) -> None:
    """What was tested at each input, the inputs in rising order; those that vary, and those not known, last."""
    from dampyr.input_kinds import NO_INPUT

    groups: dict[tuple[bool, float], list[dict[str, Any]]] = {}
    for described in descriptions:
        low, high = described["input_range"] or (0.0, 1.0)
        groups.setdefault((low != high, low if low == high else 0.0), []).append(described)
    if len(groups) < 2 or all(described["input"] == NO_INPUT for described in descriptions):
        return
    rows = []
    for (varies, _), group in sorted(groups.items()):
        moves = [_row(described)[4:7] for described in group]
        spans = [_span([move[k] for move in moves if move[k] is not None]) for k in range(3)]
        rows.append(["varies or not known" if varies else _input(group[0]), len(group), *spans])
    click.echo()
    print_table("By input", BY_INPUT, rows, ["", "", "Hz", "mm", "mm/s"])


def _print_smoothing(descriptions: list[dict[str, Any]]) -> None:
    """How many records show which moving average, and how to declare it."""
    from dampyr.records.conditioning.smoothing_recognition import common_windows

    shown = common_windows({record["name"]: record["smoothing"][0] for record in descriptions if record["smoothing"]})
    if not shown:
        return
    rows = [
        [window, len(names), ", ".join(names[:3]) + (", …" if names[3:] else "")] for window, names in shown.items()
    ]
    notes = [
        "if a laboratory smoothed its files, declare it by pattern in reading.toml, such as "
        f"[smoothed] 'sine*' = '{next(iter(shown))}'"
    ]
    click.echo()
    print_table("Moving averages that show", ["window", "records", "which"], rows, ["", "", ""], notes=notes)


def _span(values: list[float]) -> str | None:
    if not values:
        return None
    low, high = f"{min(values):.3g}", f"{max(values):.3g}"
    return low if low == high else f"{low} to {high}"


def _print_in_full(description: dict[str, Any]) -> None:
    """A record in full, one line for each thing known of it."""
    from dampyr.records.checks.certificates import KEY, certificates_in_words
    from dampyr.records.record import CHANNELS, GROUPS

    m, q = description["measured"], description["quality"]
    lines: list[tuple[str, Any]] = [("role", description["role"]), ("input", _input(description))]
    lines.append(("origin", description["origin"]["kind"]))
    lines += [(word, description[name]) for name, word in GROUPS.items() if description[name]]
    lines += [("duration", f"{description['duration_s']:.6g} s"), ("samples", f"{q.samples}, every {q.dt:.6g} s")]
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
    else:
        lines += _moved(description["overview"])
        lines += [
            (
                f"level {level['number']}",
                f"{level['cycles']} x {1e3 * level['stroke_m']:.4g} mm at {level['frequency_hz']:.4g} Hz, "
                f"{level['energy_per_cycle']:.4g} J per cycle",
            )
            for level in description["levels"]
        ]
    lines += [(f"{channel} step", f"{step:.4g} {CHANNELS[channel]}") for channel, step in q.quantum.items()]
    lines += [
        (
            f"{channel} uncertainty",
            f"{uncertainty['standard']:.2g} {CHANNELS[channel]} (one sigma), by {uncertainty['largest']} before all",
        )
        for channel, uncertainty in description["uncertainty"].items()
    ]
    lines += [("to look at", finding["words"]) for finding in description["findings"]]
    lines += certificates_in_words(description["provenance"])
    lines += [(name, text) for name, text in description["provenance"].items() if name != KEY]
    lines += [("done", step) for step in description["history"]]
    print_table(description["name"], ["", ""], lines)


def _moved(seen: Overview) -> list[tuple[str, Any]]:
    """The lines on a motion that does not repeat itself."""
    lines: list[tuple[str, Any]] = [("whole stroke", f"{1e3 * seen.stroke_m:.5g} mm")]
    if seen.dominant_hz is None:
        return lines
    return [
        *lines,
        ("peak speed", f"{1e3 * seen.peak_speed:.4g} mm/s"),
        ("rms speed", f"{1e3 * seen.rms_speed:.4g} mm/s"),
        ("strongest at", f"{seen.dominant_hz:.3g} Hz"),
        ("total energy", f"{seen.work:.4g} J"),
    ]
