"""Excel workbooks as openpyxl writes them, after ECMA-376."""

import zipfile
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from openpyxl import Workbook

from dampyr.errors import FileError, InputError
from dampyr.records import read

N = 200
TIME = 0.01 * np.arange(N)
STROKE = 8.0 * np.sin(6.0 * TIME)  # mm
FORCE = 300.0 * np.cos(6.0 * TIME) + 20.0  # N
ROWS = np.column_stack([TIME, STROKE, FORCE]).tolist()
HEADER = ["Time [s]", "Displacement [mm]", "Force [N]"]


def saved(path: Path, **sheets: list[list[Any]]) -> Path:
    book = Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save(path)
    return path


def test_a_sheet_with_a_header_is_read_to_its_last_digit(tmp_path: Path) -> None:
    record = read(saved(tmp_path / "run.xlsx", Data=[["Test of 3 March"], [], HEADER, *ROWS]), voltage=0.87)
    for ours, theirs in ((record.force, FORCE), (record.displacement, 1e-3 * STROKE), (record.time, TIME)):
        np.testing.assert_allclose(ours, theirs, rtol=2e-15)  # openpyxl writes 16 digits
    assert record.provenance["format"] == "Excel"
    assert "the sheet 'Data'" in record.history[-1]


def test_units_in_a_row_of_their_own_and_a_declared_header(tmp_path: Path) -> None:
    rows = [["Time", "Disp", "Load"], ["s", "mm", "kN"], *ROWS]
    record = read(saved(tmp_path / "run.xlsx", Data=rows), voltage=0.0, header=1)
    np.testing.assert_allclose(record.force, 1e3 * FORCE)


def test_a_sheet_is_chosen_by_name(tmp_path: Path) -> None:
    path = saved(tmp_path / "run.xlsx", first=[HEADER, *ROWS], second=[HEADER, *[[t, x, 2 * f] for t, x, f in ROWS]])
    with pytest.raises(FileError, match=r"has 2 sheets with rows \('first', 'second'\); name one, --variable NAME"):
        read(path, voltage=0.0)
    with pytest.raises(FileError, match="there is no sheet 'third' with rows; choose from 'first', 'second'"):
        read(path, voltage=0.0, variable="third")
    np.testing.assert_allclose(read(path, voltage=0.0, variable="second").force, 2 * FORCE)


def test_dates_with_times_count_from_the_first(tmp_path: Path) -> None:
    start = datetime(2026, 3, 1, 23, 59, 59)
    rows = [[start + timedelta(milliseconds=10 * k), *row[1:]] for k, row in enumerate(ROWS)]
    record = read(saved(tmp_path / "run.xlsx", Data=[["Time", *HEADER[1:]], *rows]), voltage=0.0)
    np.testing.assert_allclose(record.time, TIME, atol=1e-3)


def test_an_empty_cell_names_its_row(tmp_path: Path) -> None:
    rows = [list(row) for row in ROWS]
    rows[6][1] = None
    with pytest.raises(FileError, match="line 8"):
        read(saved(tmp_path / "run.xlsx", Data=[HEADER, *rows]), voltage=0.0)


def test_a_formula_without_a_saved_value_is_said(tmp_path: Path) -> None:
    rows = [list(row) for row in ROWS]
    rows[6][2] = "=C7*2"
    with pytest.raises(FileError, match=r"the formula in C8 has no saved value .* open the file in Excel and save it"):
        read(saved(tmp_path / "run.xlsx", Data=[HEADER, *rows]), voltage=0.0)


def test_broken_bytes_are_one_line(tmp_path: Path) -> None:
    path = saved(tmp_path / "run.xlsx", Data=[HEADER, *ROWS])
    whole = path.read_bytes()
    empty = tmp_path / "empty.zip"
    zipfile.ZipFile(empty, "w").close()
    for content in (b"", b"no workbook", whole[: len(whole) // 2], empty.read_bytes()):
        path.write_bytes(content)
        with pytest.raises(FileError, match=r"run\.xlsx: is not a readable \.xlsx file") as caught:
            read(path, voltage=0.0)
        assert "\n" not in str(caught.value)


def test_without_openpyxl_the_message_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = saved(tmp_path / "run.xlsx", Data=[HEADER, *ROWS])
    monkeypatch.setitem(__import__("sys").modules, "openpyxl", None)
    with pytest.raises(InputError, match=r'Excel files need openpyxl; install it: pip install "dampyr\[interop\]"'):
        read(path, voltage=0.0)


def test_a_workbook_that_unfolds_to_hundreds_of_megabytes_is_refused_by_its_directory(tmp_path: Path) -> None:
    """300 MB of spaces in one part fold to some 300 kB; nothing of them is unfolded, so that the answer takes no time."""
    path = saved(tmp_path / "large.xlsx", Data=[HEADER, *ROWS])
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive, archive.open("xl/media/blank.xml", "w") as part:
        for _ in range(300):
            part.write(b" " * 1_000_000)
    assert path.stat().st_size < 1e6
    with pytest.raises(FileError, match=r"large.xlsx: unfolds to 300 MB, and at most 200 MB .* save the sheet as .csv"):
        read(path, voltage=0.87)
