"""Measured and predicted forces side by side in a file."""

from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import FileError
from dampyr.records import Record
from dampyr.records.files.comparison import write_comparison


def chirp(sign: float = 1.0) -> Record:
    """0.2 to 2 Hz in 10 s, with most of its speed where it is fast."""
    t = 0.005 * np.arange(2001)
    x = 0.01 * np.sin(2 * np.pi * (0.2 * t + 0.09 * t**2))
    return Record(t, x, sign * 800.0 * np.gradient(x, t) + 70.0)


def test_forces_side_by_side(tmp_path: Path) -> None:
    record = chirp()
    path = write_comparison(record, 0.5 * record.force, tmp_path / "a.csv", offset=3.0)
    table = np.loadtxt(path, delimiter=",", skiprows=3)
    np.testing.assert_allclose(table.T[:3], [record.time, record.displacement, record.force], rtol=1e-8)
    np.testing.assert_allclose(table.T[3], 0.5 * record.force + 3.0, rtol=1e-8)
    assert path.read_text().splitlines()[2] == "time [s],displacement [m],measured force [N],predicted force [N]"
    write_comparison(record, record.force, path)
    np.testing.assert_allclose(np.loadtxt(path, delimiter=",", skiprows=3)[:, 3], record.force, rtol=1e-8)
    assert [each.name for each in tmp_path.iterdir()] == ["a.csv"]


def test_a_file_of_somebody_else_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("mine\n")
    with pytest.raises(FileError, match="was not written by dampyr"):
        write_comparison(chirp(), chirp().force, tmp_path / "a.csv")
    assert (tmp_path / "a.csv").read_text() == "mine\n"
    with pytest.raises(FileError, match="cannot be written"):
        write_comparison(chirp(), chirp().force, tmp_path / "no" / "a.csv")
