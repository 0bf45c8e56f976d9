"""Text of an MTS controller with several blocks, after its published layout: each is a record."""

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.errors import FileError
from dampyr.records import read, read_campaign

T = 0.01 * np.arange(50)
NAMED = {"time": "Running Time", "displacement": "Axial Displacement", "force": "Axial Load"}


def mts(path, counts=(3, 5)):
    """Blocks with 3 columns and more, of growing stroke, parted by empty lines."""
    lines = []
    for k, count in enumerate(counts, start=1):
        names = ["Running Time", "Axial Displacement", "Axial Load", "Axial Count", "Temperature"][:count]
        units = ["s", "mm", "kN", "segments", "degC"][:count]
        columns = [T, k * np.sin(6 * T), 0.1 * k * np.cos(6 * T), np.round(T), np.full_like(T, 20.0 + k)][:count]
        lines += [f"Data Header:\t\t\tTime:\t{k}\tSec", "Data Acquisition:\tTimed", "Station Name:\tmine.cfg"]
        lines += [f"Test File Name:\trun {k}.tst", "", "\t".join(names), "\t".join(units)]
        lines += ["\t".join(f"{value:.6f}" for value in row) for row in zip(*columns, strict=True)] + ["", ""]
    path.write_text("\n".join(lines))
    return path


def is_block(record, k):
    assert record.displacement == pytest.approx(1e-3 * k * np.sin(6 * T), abs=1e-9)
    assert record.force == pytest.approx(100.0 * k * np.cos(6 * T), abs=1e-3)
    return True


def test_a_block_by_its_number(tmp_path):
    path = mts(tmp_path / "run.dat")
    second = read(path, variable="2", columns=NAMED)
    assert is_block(second, 2)
    assert (second.name, second.temperature[0]) == ("run block 2", pytest.approx(22.0))
    assert "block 2 of 2" in second.history
    with pytest.raises(FileError, match="holds 2 blocks of an MTS controller, each a record; name one, --variable 1"):
        read(path, columns=NAMED)
    with pytest.raises(FileError, match="there is no block '3'; choose a number from 1 to 2"):
        read(path, variable="3", columns=NAMED)


def test_a_folder_takes_every_block_as_a_record(tmp_path):
    mts(tmp_path / "a.dat", (3, 5, 3))
    mts(tmp_path / "b.dat", (3,))
    records = read_campaign(tmp_path, columns=NAMED, no_input=True)
    assert [record.name for record in records] == ["a block 1", "a block 2", "a block 3", "b"]
    assert all(is_block(record, k) for record, k in zip(records, (1, 2, 3, 1), strict=True))


def test_an_error_names_the_line_of_the_file(tmp_path):
    path = mts(tmp_path / "run.dat")
    lines = path.read_text().splitlines()
    lines[80] = "broken"
    path.write_text("\n".join(lines))
    with pytest.raises(FileError, match="line 81 has 1 values and line 67 has 5"):
        read(path, variable="2", columns=NAMED)


def test_an_old_workbook_says_what_to_do(tmp_path):
    path = tmp_path / "test.xls"
    path.write_bytes(b"\xd0\xcf\x11\xe0")
    result = CliRunner().invoke(cli, ["records", str(path)])
    assert result.exit_code == 2
    assert (
        "is an Excel workbook of before 2007, which is not read; open it and save it as .xlsx or as .csv"
        in result.stderr
    )
