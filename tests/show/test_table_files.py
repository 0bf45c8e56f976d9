"""Tables as files: every cell with all its digits, the units in the heads, and what the origin says."""

import csv
import sys
from pathlib import Path

import pytest
from openpyxl import load_workbook

from dampyr.errors import InputError
from dampyr.findings import Finding
from dampyr.origin import Origin
from dampyr.show.table import Table, Verdict
from dampyr.show.table_files import write_tables

TABLES = {
    "cycles": Table(("cycle", "energy"), [[1, 1.0 / 3.0], [2, None]], ("", "J"), notes=["By trapezoids, or better."]),
    "verdicts": Table(("specimen", "verdict"), [["SN 1, new", Verdict("passed")]]),
}
SIMULATED = Origin("simulated")


def test_a_folder_has_a_file_for_each_table(tmp_path: Path) -> None:
    paths = write_tables(TABLES, tmp_path / "out", SIMULATED)
    assert [path.name for path in paths] == ["cycles.csv", "verdicts.csv"]
    first, *lines = paths[0].read_text("utf-8").splitlines()
    assert first == f"# {SIMULATED.notice}"
    assert list(csv.reader(lines)) == [["cycle", "energy [J]"], ["1", repr(1.0 / 3.0)], ["2", ""]]
    write_tables(TABLES, tmp_path / "out")
    assert paths[1].read_text("utf-8") == 'specimen,verdict\n"SN 1, new",passed\n'


def test_a_workbook_has_a_sheet_for_each_table_and_what_is_known_of_all(tmp_path: Path) -> None:
    finding = Finding("doubt", "the force may be saturated", ("test 1",))
    assert write_tables(TABLES, tmp_path / "out.xlsx", SIMULATED, [finding]) == [tmp_path / "out.xlsx"]
    book = load_workbook(tmp_path / "out.xlsx")
    assert book.sheetnames == ["origin", "cycles", "verdicts"]
    texts = [row[0] for row in book["origin"].iter_rows(values_only=True)]
    assert texts[0].startswith("dampyr ")
    assert texts[1:] == [SIMULATED.notice, finding.sentence]
    rows = list(book["cycles"].iter_rows(values_only=True))
    assert rows[:3] == [("cycle", "energy [J]"), (1, 1.0 / 3.0), (2, None)]
    assert rows[-1][0] == "By trapezoids, or better."


def test_another_suffix_and_a_missing_package_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match=r"such as out\.xlsx, or to a folder"):
        write_tables(TABLES, tmp_path / "out.pdf")
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(InputError, match="Excel files need openpyxl; install it"):
        write_tables(TABLES, tmp_path / "out.xlsx")
    assert not list(tmp_path.iterdir())
