"""Folders of record files without a table, and the reading.toml beside them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.records.text_files import UNITS, four_files, put, say

from dampyr.errors import DampyrWarning, FileError, InputError, MissingData
from dampyr.records import Record, read, read_campaign, write


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return four_files(tmp_path)


def test_every_file_is_a_record_named_by_its_stem_in_natural_order(folder: Path) -> None:
    records = read_campaign(folder, units=UNITS, current=0.5)
    assert [r.name for r in records] == ["quake_1,5A", "run2_0.25A", "run2_0.5A", "run10_0.5A"]
    assert {r.current for r in records} == {0.5}
    np.testing.assert_allclose(np.max(records[0].displacement), 5e-3, rtol=1e-3)


def test_texts_without_numbers_are_left_out_and_named(folder: Path) -> None:
    (folder / "README.txt").write_text("Two lines.\n2 operators in May, 1 damper\n", encoding="utf-8")
    with pytest.warns(DampyrWarning, match=r"left out, no line of numbers: README\.txt"):
        assert len(read_campaign(folder, units=UNITS)) == 4


def test_a_file_that_cannot_be_read_is_named_and_can_be_ignored(folder: Path) -> None:
    (folder / "zero.txt").write_text("Time\tForce\n0.0\t1.0\n0.1\t2.0\n", encoding="utf-8")
    with pytest.raises(FileError, match=r"zero\.txt: no column is the displacement .*ignore it in reading\.toml"):
        read_campaign(folder, units=UNITS)
    say(folder, 'ignore = ["zero*"]')
    assert len(read_campaign(folder)) == 4


def test_two_records_of_one_name(folder: Path) -> None:
    put(folder / "run2_0.25A.csv")
    with pytest.raises(InputError, match=r"2 records are called 'run2_0.25A' \(from .*csv, .*txt\)"):
        read_campaign(folder, units=UNITS)


def test_own_files_stand_beside_text(folder: Path) -> None:
    record = read(folder / "run2_0.5A.csv", units=UNITS)
    write(record.replace(note="renamed", name="own"), folder / "run3.h5")
    assert [r.name for r in read_campaign(folder, units=UNITS)][2:] == ["run2_0.5A", "own", "run10_0.5A"]


def test_nothing_but_prose(tmp_path: Path) -> None:
    (tmp_path / "notes.md").write_text("1 2\n", encoding="utf-8")
    with pytest.raises(MissingData, match="the folder has no records"):
        read_campaign(tmp_path)


def test_an_input_beside_a_campaign_table_is_refused(tmp_path: Path) -> None:
    head = "file,table,row,voltage_V,peak_to_peak_mm,frequency_Hz\n"
    (tmp_path / "campaign.csv").write_text(head, encoding="utf-8")
    with pytest.raises(InputError, match=r"current = 1 A was given, but .*campaign\.csv says it of each file"):
        read_campaign(tmp_path, current=1.0)


def test_a_measured_column_gives_way_to_what_is_stated_where_it_agrees(tmp_path: Path) -> None:
    header = "time [s]\tdisplacement [mm]\tforce [N]\tcurrent [A]"
    path = put(tmp_path / "a.txt", header, extra=0.497)
    assert read(path).current == pytest.approx(0.497)
    stated = read(path, current=0.5)
    assert stated.current == 0.5
    assert "current 0.5 A as stated; 0.497 A as measured" in stated.history
    with pytest.raises(FileError, match=r"current = 1 A was given, but the file's column has 0\.497 to 0\.497 A"):
        read(path, current=1.0)


def test_one_of_two_inputs_can_be_left_out(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    rows = "\n".join(f"{k} {k} {k} 2.2 0.5" for k in range(9))
    path.write_text(f"t[s] x[mm] f[N] u[V] i[A]\n{rows}\n", encoding="utf-8")
    with pytest.raises(FileError, match=r"voltage and current are both given.*--column voltage=-"):
        read(path)
    for none in (None, "-"):
        assert read(path, columns={"voltage": none}).current == 0.5


@pytest.mark.parametrize(
    ("name", "pattern", "value"),
    [
        ("sine_0p25A", "*_{}A", 0.25),
        ("sine_0x25A", "*_{}A", 0.25),
        ("sine_1X5A", "*_{}A", 1.5),
        ("sine_2P5A", "sine_{}A", 2.5),
        ("0,25A", "{}A", 0.25),
        ("sine0x25A", "*{}A", 0.25),
        ("sine0p125A", "sine*{}A", 0.125),
        ("run_10A", "*_{}A", 10.0),
        ("5mmx2A", "*{}A", 2.0),
        ("run5x2A", "run*x{}A", 2.0),
        ("step12p25A", "step*p{}A", 25.0),
    ],
)
def test_an_input_in_a_name_may_have_a_letter_for_its_point(
    tmp_path: Path, name: str, pattern: str, value: float
) -> None:
    put(tmp_path / f"{name}.txt")
    say(tmp_path, f'current = "{pattern}"')
    assert read(tmp_path / f"{name}.txt").current == value


def test_names_with_inputs_are_listed_in_the_order_of_the_inputs(tmp_path: Path) -> None:
    for text in ("10A", "1A", "0,5A", "0p25A", "0x125A", "0.75A"):
        put(tmp_path / f"sine_{text}.txt")
    say(tmp_path, 'current = "*_{}A"')
    assert [r.current for r in read_campaign(tmp_path)] == [0.125, 0.25, 0.5, 0.75, 1.0, 10.0]


def test_a_campaign_table_may_name_sessions_and_specimens(folder: Path) -> None:
    head = "file,table,row,voltage_V,peak_to_peak_mm,frequency_Hz,measurement_session,specimen\n"
    rows = "run2_0.25A.txt,4.1,1,0.5,10,1, day 1 ,no. 7\nrun2_0.5A.csv,4.1,2,1.0,10,1,,\n"
    (folder / "campaign.csv").write_text(head + rows, encoding="utf-8")
    first, second = read_campaign(folder, units=UNITS)
    assert (first.measurement_session, first.specimen) == ("day 1", "no. 7")
    assert (second.measurement_session, second.specimen) == (None, None)
    assert read_campaign(folder, units=UNITS, specimen="no. 8")[1].specimen == "no. 8"


def test_files_of_one_name_are_no_tries_of_one_test(tmp_path):
    t = 0.01 * np.arange(100)
    for k in range(2):
        write(Record(t, np.sin(t), np.cos(t), voltage=0.0, name="sine"), tmp_path / f"{k}.h5")
    with pytest.raises(
        InputError, match=r"2 records are called 'sine' \(from .*\); ignore or rename all but one .* inside"
    ):
        read_campaign(tmp_path)
