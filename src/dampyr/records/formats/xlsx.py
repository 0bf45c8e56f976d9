"""Excel workbooks: a sheet is read as columns of text are, ``variable`` names the sheet.

What stands above the numbers is the header, as in `dampyr.text_table`; ``header`` is its row. A cell with a
formula gives the value that was saved with it. Read with openpyxl, the extra ``interop``.
"""

from __future__ import annotations

import zipfile
from datetime import date, datetime, time
from pathlib import Path
from typing import Any

from dampyr.errors import FileError, InputError, install_line, one_line
from dampyr.records.files.column_table import read_text
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import Record

TITLE = "Excel"
MAX_UNFOLDED = 200_000_000  # bytes of the archive's parts: a million rows of four channels, and some 20 s of reading


def read(path: Path, request: ReadOptions) -> Record:
    """The record in one sheet of an ``.xlsx`` file."""
    reason = "a workbook has cells"
    request.refuse(path, encoding=reason, delimiter=reason)
    name, text, formula = _sheet(path, request.variable)
    try:
        record = read_text(path, request, "Excel", text)
    except FileError as problem:
        if formula:
            raise FileError(
                path,
                f"the formula in {formula} has no saved value and reads as an empty cell; open the file in Excel and save it",
            ) from problem
        raise
    return record.replace(note=f"the sheet {name!r}")


def _sheet(path: Path, wanted: str | None) -> tuple[str, str, str]:
    """The name of the sheet, its rows as lines with tabs, and the first cell with a formula and no value, or nothing."""
    try:
        from openpyxl import load_workbook
    except ImportError as problem:
        raise InputError(f"Excel files need openpyxl; install it: {install_line('interop')}") from problem
    _check_size(path)
    try:
        book = load_workbook(path, read_only=True, data_only=True)
        formulas = load_workbook(path, read_only=True)
        try:
            name = _name(path, book, wanted)
            lines, formula = [], ""
            for row, original in zip(book[name].iter_rows(), formulas[name].iter_rows(), strict=False):
                lines.append("\t".join(_text(cell.value) for cell in row).rstrip("\t"))
                for cell, source in () if formula else zip(row, original):
                    if cell.value is None and isinstance(source.value, str) and source.value.startswith("="):
                        formula = str(source.coordinate)
                        break
        finally:
            book.close()
            formulas.close()
    except InputError:
        raise
    except Exception as problem:  # openpyxl raises whatever the broken archive leads it to
        raise FileError(
            path, f"is not a readable .xlsx file ({one_line(problem)}); save it again as an Excel workbook"
        ) from problem
    return name, "\n".join(lines) + "\n", formula


def _check_size(path: Path) -> None:
    """Refuse a workbook by what its archive's directory says, before anything of it is unfolded: zeros fold to a thousandth."""
    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(part.file_size for part in archive.infolist())
    except (OSError, zipfile.BadZipFile):
        return  # openpyxl says what is wrong with it
    if size > MAX_UNFOLDED:
        raise FileError(
            path,
            f"unfolds to {size / 1e6:.0f} MB, and at most {MAX_UNFOLDED / 1e6:.0f} MB of a workbook are read; "
            "save the sheet as .csv, or split it",
        )


def _name(path: Path, book: Any, wanted: str | None) -> str:
    sheets = [sheet.title for sheet in book.worksheets if sheet.max_row is None or sheet.max_row > 1]
    available = ", ".join(map(repr, sheets)) or "none"
    if wanted is not None:
        if wanted not in sheets:
            raise FileError(path, f"there is no sheet {wanted!r} with rows; choose from {available}")
        return wanted
    if len(sheets) != 1:
        raise FileError(
            path, f"has {len(sheets)} sheets with rows ({available}); name one, --variable NAME or variable=NAME"
        )
    return str(sheets[0])


def _text(value: Any) -> str:
    """A cell as a text of columns has it."""
    if value is None:
        return ""
    if isinstance(value, datetime):
        return value.isoformat(sep="T")
    if isinstance(value, date | time):
        return value.isoformat()
    return repr(value) if isinstance(value, float) else " ".join(str(value).split())
