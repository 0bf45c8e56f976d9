"""A campaign is a folder: one with a ``campaign.csv``, one that dampyr recorded, or any folder of record files.

The table's columns are ``file, table, row, voltage_V, peak_to_peak_mm, frequency_Hz, kx_Ns_per_mm, kw_N,
rho_per_mm, sha256``, and where they are known ``measurement_session, specimen``. What it prints about a test becomes the
record's label, never its measurement.
"""

from __future__ import annotations

import csv
import hashlib
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import Any

from dampyr.errors import FileError, InputError, MissingData
from dampyr.options import takes
from dampyr.records.conditioning.cut_record import cut_all
from dampyr.records.files.folder import read_folder
from dampyr.records.files.folder_metadata import TABLE
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.files.record_files import read
from dampyr.records.formats.h5 import FewSamples
from dampyr.records.record import CHANNELS, GROUPS, Label, Record, Role, as_group, as_role
from dampyr.shown import Shown
from dampyr.units import round_trip, to_si

RecordsOrPaths = Record | Sequence[Record] | str | Path | Sequence[str | Path]
"""What a call takes that works on records: these, or the files and folders that hold them."""
COLUMNS = ("file", "table", "row", "voltage_V", "peak_to_peak_mm", "frequency_Hz")
PUBLISHED = {
    "kx_Ns_per_mm": ("kx", "N s/mm", "N s/m"),
    "kw_N": ("kw", "N", "N"),
    "rho_per_mm": ("rho", "1/mm", "1/m"),
}


@dataclass(frozen=True, repr=False)
class CampaignRow(Shown):
    """One row of a campaign's table, SI.

    ``file`` is None when the row has no file, or when the file is not in the folder (``file_name`` then still
    names it). ``published`` holds kx (N s/m), kw (N) and rho (1/m) where the table prints them.
    """

    file_name: str
    file: Path | None
    label: Label
    voltage: float
    role: Role
    sha256: str
    published: Mapping[str, float]
    measurement_session: str | None = None
    specimen: str | None = None

    @property
    def table(self) -> str:
        """The table it is printed in, such as "4.2"."""
        return self.label.table

    @property
    def row(self) -> int | None:
        """The row of that table, from 1; None for a test that is in no table."""
        return self.label.row


@takes(ReadOptions)
def read_campaign(
    folder: str | Path,
    role: Role | None = "fit",
    incomplete: bool = False,
    options: ReadOptions | None = None,
    **keywords: Any,
) -> list[Record]:
    """The records of a campaign, in the order of its table, or, without one, in the natural order of the files' names.

    Parameters
    ----------
    folder
        A folder with a ``campaign.csv``; or any folder with ``.csv``, ``.txt``, ``.mat`` or ``.h5`` files, each a record.
        What they do not state themselves is given here, or once for all in a ``reading.toml`` beside them
        (:mod:`dampyr.records.files.folder_metadata`).
    role
        "fit" (the rows of the tables), "validation" (the tests that no fit may use), or None for both.
    incomplete
        Of dampyr's own files the complete tests are returned, the latest try of each; True adds all the rest.
    options
        The further arguments, for every file, as one object; those that are given by name take their places. A ``campaign.csv``
        gives the voltages itself, and session and specimen where it has columns for them.

    Rows without a file are skipped here and reported by :func:`campaign_rows`. Text files without a line of numbers, such as
    a README, are left out with a warning.

    Raises
    ------
    MissingData
        There is no such folder, or there are no tests in it.
    FileError
        A file is wrong, is not the file whose sha256 the table gives, or the table is wrong.
    InputError
        An argument is wrong, an input is given beside a ``campaign.csv``, or two records or pieces of them have one name.

    Examples
    --------
    >>> from pathlib import Path
    >>> import numpy as np
    >>> import dampyr as dp
    >>> t = np.linspace(0.0, 1.0, 101)
    >>> Path("sines").mkdir()
    >>> for k in (1, 2):
    ...     record = dp.records.Record(t, 0.01 * np.sin(6 * k * t), 50.0 * np.cos(6 * k * t), voltage=1.0)
    ...     path = dp.records.write(record.replace(note="named", name=f"test{k}"), f"sines/test{k}.h5")
    >>> [record.name for record in dp.records.read_campaign("sines")]
    ['test1', 'test2']
    """
    options = ReadOptions.of("read_campaign", options, keywords)
    uncut = replace(options, cut=None)
    folder = _folder(folder)
    wanted = None if role is None else as_role(role)
    if (folder / TABLE).is_file():
        _check_no_input(folder, options)
        rows = [row for row in campaign_rows(folder) if wanted in (None, row.role)]
        records = [read_row(row, uncut) for row in rows if row.file is not None]
    else:
        records = [record for record in read_folder(folder, uncut, incomplete) if wanted in (None, record.role)]
    return records if options.cut is None else cut_all(records, options.cut)


@takes(ReadOptions)
def read_records(
    paths: str | Path | Sequence[str | Path],
    role: Role | None = None,
    options: ReadOptions | None = None,
    too_short: list[str] | None = None,
    **keywords: Any,
) -> list[Record]:
    """Every record of these files and folders, in their order.

    Parameters
    ----------
    paths
        a file is read as by `read`, a folder as by `read_campaign`.
    role
        "fit" or "validation" chooses among the records of a folder; None takes all.
    options
        the further arguments, for every file, as one object; those that are given by name take their places. ``cut`` cuts the
        records of files, too.
    too_short
        takes the sentence of each file that has too few samples for a record; without it such a file is an error.

    Raises
    ------
    MissingData
        there is no such file or folder.
    FileError
        a file is wrong.
    InputError
        an argument is wrong, or there are no records of this role.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> t = np.linspace(0.0, 1.0, 101)
    >>> for k in (1, 2):
    ...     record = dp.records.Record(t, 0.01 * np.sin(6 * k * t), 50.0 * np.cos(6 * k * t))
    ...     path = dp.records.write(record, f"test{k}.csv")
    >>> [record.name for record in dp.records.read_records(["test1.csv", "test2.csv"], voltage=1.98)]
    ['test1', 'test2']
    """
    options = ReadOptions.of("read_records", options, keywords)
    named = [Path(paths)] if isinstance(paths, str | Path) else [Path(path) for path in paths]
    uncut, found = replace(options, cut=None), list[Record]()
    for path in named:
        if path.is_dir():
            found += read_campaign(path, role, options=uncut)
            continue
        try:
            found.append(read(path, uncut))
        except FewSamples as problem:
            if too_short is None:
                raise
            too_short.append(str(problem))
    if not found and not too_short:
        where, which = ", ".join(map(str, named)), f" whose role is {role}" if role else ""
        raise InputError(f"no records{which} in {where or 'an empty list'}; name files, or a folder with records")
    return found if options.cut is None else cut_all(found, options.cut)


def as_records(given: RecordsOrPaths, role: Role | None = None) -> list[Record]:
    """The records that a call was given, those of files read; what is neither is left as it is, for `check_kinds`.

    ``role`` chooses among those of a folder.
    """
    if isinstance(given, Record):
        return [given]
    if isinstance(given, str | Path):
        return read_records(given, role)
    if isinstance(given, Sequence) and given and all(isinstance(item, str | Path) for item in given):
        return read_records(given, role)  # type: ignore[arg-type]
    return given  # type: ignore[return-value]


def _check_no_input(folder: Path, options: ReadOptions) -> None:
    if options.no_input:
        raise InputError(f"no_input was given, but {folder / TABLE} gives each file a voltage; leave no_input out")
    for name in ("voltage", "current"):
        value = getattr(options, name)
        if value is not None:
            raise InputError(
                f"{name} = {value:g} {CHANNELS[name]} was given, but {folder / TABLE} says it of each file; leave {name} out"
            )


def campaign_rows(folder: str | Path | None = None) -> list[CampaignRow]:
    """Every row of a campaign's table, those without a file too (``row.file is None``).

    Without a folder: the table of the Labcontrol campaign that comes with dampyr, all files None.
    """
    if folder is None:
        text = resources.files("dampyr.records").joinpath("labcontrol_campaign.csv").read_text("utf-8")
        return _rows(Path("labcontrol_campaign.csv"), text, None)
    path = _folder(folder) / TABLE
    if not path.is_file():
        raise MissingData(f"{path}: there is no such table; a campaign's folder holds one")
    return _rows(path, path.read_text("utf-8"), path.parent)


def read_row(row: CampaignRow, options: ReadOptions | None = None) -> Record:
    """The record of one row: its file checked by sha256, with the row's voltage, label, role, session and specimen."""
    if row.file is None:
        where = f"row {row.row} of table {row.table}" if row.row else f"the test of {row.table}"
        raise MissingData(f"{where} has no file{f' {row.file_name}' if row.file_name else ''}; choose another row")
    check_sha256(row.file, row.sha256)
    options = options or ReadOptions()
    groups = {name: getattr(row, name) for name in GROUPS if getattr(options, name) is None}
    record = read(row.file, options, voltage=row.voltage, **groups)
    provenance = dict(record.provenance) | {"campaign": TABLE, "sha256": row.sha256}
    note = f"voltage, label and role from {TABLE}"
    return record.replace(note=note, label=row.label, role=row.role, provenance=provenance)


def check_sha256(path: Path, expected: str) -> None:
    """Raise :class:`FileError` unless the file has this sha256; an empty one is not checked."""
    actual = hashlib.sha256(path.read_bytes()).hexdigest()
    if expected and actual != expected.lower():
        raise FileError(path, f"its sha256 is {actual}, the table says {expected.lower()}; fetch the file again")


def _folder(folder: str | Path) -> Path:
    folder = Path(folder)
    if not folder.is_dir():
        raise MissingData(
            f"{folder}: there is no such folder; check the path, or fetch the published campaign with "
            "`dampyr datasets fetch labcontrol`"
        )
    return folder


def _rows(path: Path, text: str, folder: Path | None) -> list[CampaignRow]:
    reader = csv.DictReader(io.StringIO(text, newline=""))
    missing = [name for name in COLUMNS if name not in (reader.fieldnames or ())]
    if missing:
        raise FileError(path, f"the column {missing[0]} is missing; a campaign's table has {', '.join(COLUMNS)}")
    return [_row(path, line, cells, folder) for line, cells in enumerate(reader, start=2)]


def _row(path: Path, line: int, cells: dict[str, str], folder: Path | None) -> CampaignRow:
    def number(column: str) -> float:
        try:
            return float(cells[column])
        except (TypeError, ValueError):
            raise FileError(
                path, f"line {line}: {column} = {cells[column]!r} is not a number; repair the table"
            ) from None

    try:
        label = Label(
            round_trip(to_si(number("peak_to_peak_mm"), "mm", "m")),
            number("frequency_Hz"),
            (cells["table"] or "").strip(),
            int(number("row")) if (cells["row"] or "").strip() else None,
        )
    except FileError:
        raise
    except InputError as problem:
        raise FileError(path, f"line {line}: {problem}") from problem
    groups = {name: as_group(name, text) for name in GROUPS if (text := (cells.get(name) or "").strip())}
    printed = {c: parts for c, parts in PUBLISHED.items() if (cells.get(c) or "").strip()}
    name = (cells["file"] or "").strip()
    file = folder / name if folder is not None and name else None
    return CampaignRow(
        file_name=name,
        file=file if file is not None and file.is_file() else None,
        label=label,
        voltage=number("voltage_V"),
        role="validation" if label.row is None else "fit",
        sha256=(cells.get("sha256") or "").strip(),
        published={key: round_trip(to_si(number(c), unit, si)) for c, (key, unit, si) in printed.items()},
        **groups,
    )
