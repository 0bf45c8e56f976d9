"""Parquet: as dampyr, pandas and pyarrow write it; units in names or in the metadata of the fields."""

import numpy as np
import pandas
import pyarrow
import pytest
from pyarrow import parquet

from dampyr.errors import FileError
from dampyr.records import read, write

N = 60
T = 0.01 * np.arange(N)
X, F = 8.0 * np.sin(6 * T), 0.3 * np.cos(6 * T)


def test_pandas_reads_what_is_written_and_every_bit_comes_back(tmp_path, make_sine):
    record = make_sine(voltage=1 / 3, specimen="no. 7 µ", origin="simulated")
    path = write(record, tmp_path / "a.parquet")
    frame = pandas.read_parquet(path)
    assert list(frame) == ["time [s]", "displacement [m]", "force [N]", "voltage [V]"]
    assert np.array_equal(frame["force [N]"], record.force)
    back = read(path)
    assert np.array_equal(back.force, record.force)
    assert np.array_equal(back.time, record.time)
    assert (back.voltage, back.specimen, back.origin.kind) == (1 / 3, "no. 7 µ", "simulated")


def test_units_stand_in_the_names_or_in_the_metadata_of_the_fields(tmp_path):
    columns = {"test": ["a"] * N, "time": T, "Weg": X.astype("f4"), "Kraft [kN]": F}
    table = pyarrow.table(columns)
    units = {"time": "s", "Weg": "mm"}
    fields = [
        field.with_metadata({"units": units[field.name]} if field.name in units else {}) for field in table.schema
    ]
    parquet.write_table(table.cast(pyarrow.schema(fields)), tmp_path / "a.parquet")
    record = read(tmp_path / "a.parquet", voltage=0.0)
    np.testing.assert_allclose(record.displacement, 1e-3 * X, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(record.force, 1e3 * F, rtol=1e-12)
    assert record.provenance["header"] == "time [s], Weg [mm], Kraft [kN]"


@pytest.mark.parametrize("unit", ["ns", "us", "ms"])
def test_time_stamps_of_a_frame_are_seconds_from_the_first(tmp_path, unit):
    stamps = (pandas.Timestamp("2026-03-01 23:59:59.8") + pandas.to_timedelta(T, unit="s")).as_unit(unit)
    frame = pandas.DataFrame({"time": stamps, "x": X, "f": F}).set_index("time")
    frame.to_parquet(tmp_path / "a.parquet")
    record = read(tmp_path / "a.parquet", units={"displacement": "mm", "force": "kN"})
    np.testing.assert_allclose(record.time, T, atol=1e-9)
    assert record.provenance["date"] == "2026-03-01"
    frame.reset_index().assign(time=pandas.to_timedelta(T, unit="s")).to_parquet(tmp_path / "b.parquet")
    assert np.allclose(read(tmp_path / "b.parquet", units={"displacement": "mm", "force": "kN"}).time, T, atol=1e-9)


def test_what_is_wrong_is_said(tmp_path):
    path = tmp_path / "a.parquet"
    with pytest.raises(FileError, match="is not a readable Parquet file"):
        path.write_bytes(b"PAR1 and no more") and read(path)
    gap = np.where(T[7] == T, np.nan, F)
    pandas.DataFrame({"time [s]": T, "x [mm]": X, "f [N]": pandas.array(gap, dtype="Float64")}).to_parquet(path)
    with pytest.raises(FileError, match=r"force\[7\] = nan N is not finite"):
        read(path)
    pandas.DataFrame({"time": T, "x": X, "f": F}).to_parquet(path)
    with pytest.raises(FileError, match="declare it: --unit time=s"):
        read(path)
    with pytest.raises(FileError, match="header = 1 was given, but a Parquet file names its columns; leave it out"):
        read(path, header=1)
    pandas.DataFrame({"name": ["a", "b"]}).to_parquet(path)
    with pytest.raises(FileError, match="has no column of numbers with a row"):
        read(path)
