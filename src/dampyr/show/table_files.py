"""Tables of a result as files: an Excel workbook with a sheet for each, or a folder with a CSV file for each."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from dampyr.atomic_write import whole_file, write_whole
from dampyr.errors import InputError, install_line
from dampyr.findings import Finding
from dampyr.show.table import Cell, Table, Verdict

MAX_SHEET_NAME = 31  # of Excel
FIRST_SHEET = "origin"


def write_tables(
    tables: Mapping[str, Table], path: str | Path, origin: Any = None, findings: Sequence[Finding] = ()
) -> list[Path]:
    """Write ``tables``, name -> table, and return the paths of the files.

    A path that ends in ``.xlsx`` becomes a workbook (extra ``interop``), whose first sheet says what the ``origin`` and the
    ``findings`` say; another is a folder of ``NAME.csv``, with the names of columns and their units in the first line, and what
    the origin says in comments above it where it is not measured. Numbers have all their digits. Raises
    :class:`~dampyr.errors.InputError` for another suffix and without openpyxl.
    """
    path = Path(path)
    notice = getattr(origin, "notice", "") or ""
    if path.suffix.lower() == ".xlsx":
        _write_workbook(tables, path, notice, findings)
        return [path]
    if path.suffix:
        raise InputError(
            f"{path}: tables are written to a workbook, such as {path.stem}.xlsx, or to a folder of .csv files"
        )
    path.mkdir(parents=True, exist_ok=True)
    written = []
    for name, table in tables.items():
        text = io.StringIO()
        if notice:
            text.write(f"# {notice}\n")
        rows = csv.writer(text, lineterminator="\n")
        rows.writerow(table.heads)
        rows.writerows([[_plain(cell) for cell in row] for row in table.rows])
        write_whole(path / f"{name}.csv", text.getvalue())
        written.append(path / f"{name}.csv")
    return written


def _plain(cell: Cell) -> str | float | int | None:
    return cell.text or cell.kind if isinstance(cell, Verdict) else cell


def _write_workbook(tables: Mapping[str, Table], path: Path, notice: str, findings: Sequence[Finding]) -> None:
    try:
        from openpyxl import Workbook
        from openpyxl.styles import Font
        from openpyxl.utils import get_column_letter
    except ImportError as problem:
        raise InputError(f"Excel files need openpyxl; install it: {install_line('interop')}") from problem
    from dampyr.source_digest import full_version

    book = Workbook()
    first = book.worksheets[0]
    first.title = FIRST_SHEET
    lines = [f"dampyr {full_version()}", notice, *(finding.sentence for finding in findings)]
    for line in filter(None, lines):
        first.append([line])
    for name, table in tables.items():
        sheet = book.create_sheet(name[:MAX_SHEET_NAME])
        sheet.append(table.heads)
        for row in table.rows:
            sheet.append([_plain(cell) for cell in row])
        for k, head in enumerate(table.heads, 1):
            sheet.cell(1, k).font = Font(bold=True)
            sheet.column_dimensions[get_column_letter(k)].width = max(len(head) + 2, 10)
        sheet.freeze_panes = "A2"
        for note in table.notes:
            sheet.append([])
            sheet.append([note])
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as temporary:
        book.save(temporary)
