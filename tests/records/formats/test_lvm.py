"""LabVIEW's measurement files, in the layout of their header: separators, decimal marks, columns of time, several packets."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.errors import FileError
from dampyr.records import read

N, DT = 40, 0.005
X, F = np.round(8.0 * np.sin(0.3 * np.arange(N)), 4), np.round(300.0 * np.cos(0.3 * np.arange(N)), 3)


def packet(time, values, columns="No", separator="\t", units=("mm", "N"), samples=None, x0=0.0, step=DT):
    """A header, a line of names and the rows; an empty first column where the header has the time."""
    count = values.shape[1]
    names = {"No": ["X_Value", "displacement", "force"], "One": ["X_Value", "displacement", "force"],
             "Multi": ["X_Value", "displacement", "X_Value", "force"]}[columns]  # fmt: skip
    cells = {"Channels": [count], "Samples": [samples or len(values)] * count, "Y_Unit_Label": units,
             "X_Dimension": ["Time"] * count, "X0": [x0] * count, "Delta_X": [f"{step:.6E}"] * count}  # fmt: skip
    lines = [separator.join([key, *map(str, entries), ""]) for key, entries in cells.items()]
    lines += [f"***End_of_Header***{separator * 3}", separator.join([*names, "Comment"])]
    for t, row in zip(time, values, strict=True):
        first = {"No": ["", *row], "One": [f"{t:.6f}", *row], "Multi": [f"{t:.6f}", row[0], f"{t:.6f}", row[1]]}[
            columns
        ]
        lines.append(separator.join(map(str, first)))
    return [*lines, ""]


def lvm(path, *packets, separator="Tab", mark=".", columns="No", special=False):
    mid = {"Tab": "\t", "Comma": ",", "Semicolon": ";"}[separator]
    header = ["LabVIEW Measurement", f"Writer_Version{mid}2", f"Separator{mid}{separator}"]
    header += [f"Decimal_Separator{mid}{mark}", f"X_Columns{mid}{columns}", "***End_of_Header***", ""]
    block = ["***Start_Special***", "1 2 3", "***End_Special***", ""] if special else []
    text = "\n".join([*header, *block, *(line for lines in packets for line in lines)])
    path.write_text(text.replace(".", mark) if mark != "." else text, "utf-8")
    return path


def one(columns="No", separator="\t", first=0, count=N, **options):
    rows = slice(first, first + count)
    return packet(DT * np.arange(N)[rows], np.column_stack([X, F])[rows], columns, separator, **options)


def is_test(record, n=N):
    assert record.time == pytest.approx(DT * np.arange(n), abs=1e-12)
    assert record.displacement[:N] == pytest.approx(1e-3 * X, rel=1e-12)
    assert record.force[:N] == pytest.approx(F, rel=1e-12)
    return True


@pytest.mark.parametrize("columns", ["No", "One", "Multi"])
@pytest.mark.parametrize(("separator", "mark"), [("Tab", "."), ("Tab", ","), ("Semicolon", ","), ("Comma", ".")])
def test_every_dialect_without_an_option(tmp_path, columns, separator, mark):
    between = {"Tab": "\t", "Comma": ",", "Semicolon": ";"}[separator]
    lines = one(columns, between)
    record = read(lvm(tmp_path / "a.lvm", lines, separator=separator, mark=mark, columns=columns, special=True))
    assert is_test(record)
    assert record.provenance["header"] == "time [s], displacement [mm], force [N]"


@pytest.mark.parametrize("encoding", ["utf-8", "cp1252", "utf-16"])
def test_units_are_read_in_the_encoding_of_the_file(tmp_path, encoding):
    path = lvm(tmp_path / "a.lvm", one(units=("\u00b5m", "N")))
    path.write_text(path.read_text("utf-8").replace("\n", "\r\r\n"), encoding, newline="")
    record = read(path)
    assert record.displacement == pytest.approx(1e-6 * X, rel=1e-12)
    assert any("text" in entry for entry in record.history) == (encoding != "utf-8")


@pytest.mark.parametrize("starts", ["its own X0", "the same X0"])
def test_packets_are_put_together_where_one_follows_the_other(tmp_path, starts):
    packets = [one(first=k, count=20, x0=DT * k if starts == "its own X0" else 0.0) for k in (0, 20)]
    record = read(lvm(tmp_path / "a.lvm", *packets))
    assert is_test(record)
    assert "2 packets, one after the other" in record.history


def test_packets_under_one_heading(tmp_path):
    record = read(lvm(tmp_path / "a.lvm", one(samples=20)))
    assert is_test(record)
    assert "2 packets under one heading, taken as one after the other" in record.history


@pytest.mark.parametrize(
    ("packets", "words"),
    [
        ([one(count=20), one(first=20, count=20, x0=0.2)], r"packet 2 begins at 0\.2 s, not a step after 0\.095 s"),
        ([one(count=20, x0=0.5), one(first=20, count=20, x0=0.3)], r"packet 2 begins at 0\.3 s, before the last ends"),
        ([one(), one(units=("mm", "kN"))], "packet 2 has the channels displacement, force and packet 1"),
        ([one(samples=33)], "has 40 rows and says 33 samples"),
        ([one(step=0.0)], "differ in X0 or Delta_X, or have none"),
        ([], "has no packet of samples"),
    ],
)
def test_what_is_no_record_is_refused(tmp_path, packets, words):
    with pytest.raises(FileError, match=words):
        read(lvm(tmp_path / "a.lvm", *packets))


def test_a_file_of_something_else_and_options_that_it_answers_itself(tmp_path):
    path = tmp_path / "a.lvm"
    path.write_text("time,force\n0,1\n")
    with pytest.raises(FileError, match="does not begin with 'LabVIEW Measurement'"):
        read(path)
    with pytest.raises(FileError, match=r"dt = 0\.01 was given, but an \.lvm has a time"):
        read(lvm(path, one()), dt=0.01)
    path.write_text(path.read_text().replace("\tTab", "\tPipe"))
    with pytest.raises(FileError, match="its Separator is 'Pipe'; it must be Tab, Comma, Semicolon or Space"):
        read(path)


def test_a_strangers_folder_in_one_command_without_an_option(tmp_path):
    for k in (1, 2):
        lvm(tmp_path / f"test {k}.lvm", one(count=20), one(first=20, count=20, x0=DT * 20))
    result = CliRunner().invoke(cli, ["records", str(tmp_path), "--json"])
    assert result.exit_code == 0, result.stderr
    assert [record["name"] for record in json.loads(result.stdout)["records"]] == ["test 1", "test 2"]


def test_a_file_that_people_brought(first_day_cases):
    """Decimal commas; energy per cycle of 9.969 J by a closed form."""
    record = read(first_day_cases / "labview_decimal_comma.lvm")
    cycle = slice(400, 601)  # one of 1 Hz, at 5 ms
    assert np.trapezoid(record.force[cycle], record.displacement[cycle]) == pytest.approx(9.969, rel=5e-4)
