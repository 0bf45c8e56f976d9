"""NetCDF: the classic form as xarray writes it by scipy, version 4 in its layout of HDF5, with packed numbers."""

import h5py
import numpy as np
import pytest
import xarray
from scipy.io import netcdf_file

from dampyr.errors import FileError
from dampyr.records import read, write

N = 60
T = 0.01 * np.arange(N)
X, F = 8.0 * np.sin(6 * T), 0.3 * np.cos(6 * T)


def classic(path):
    data = {"displacement": ("time", X, {"units": "mm"}), "force": ("time", F, {"units": "kN"}), "rate": 100.0}
    time = ("time", T, {"units": "s"})
    xarray.Dataset(data, {"time": time}, {"specimen": "SN1"}).to_netcdf(path, engine="scipy")
    return path


def version_4(path, prefix=""):
    """Dimension scales of HDF5, as the netCDF library writes them."""
    with h5py.File(path, "w") as file:
        scale = file.create_dataset("time", data=T)
        scale.make_scale("time")
        scale.attrs["units"] = "seconds since 2026-01-01 00:00:00"
        for name, values, unit in (("displacement", X, "mm"), ("force", F, "kN")):
            data = file.create_dataset(prefix + name, data=values)
            data.dims[0].attach_scale(scale)
            data.attrs["units"] = np.bytes_(unit)
        bare = file.create_dataset("sensor", data=np.zeros(3))
        bare.make_scale("This is a netCDF dimension but not a netCDF variable.         3")
        file.attrs["specimen"] = "SN1"
    return path


@pytest.mark.parametrize("write", [classic, version_4])
def test_variables_with_units_need_no_option(tmp_path, write):
    record = read(write(tmp_path / "a.nc"))
    np.testing.assert_allclose(record.time, T, atol=1e-12)
    np.testing.assert_allclose(record.displacement, 1e-3 * X, rtol=1e-12)
    np.testing.assert_allclose(record.force, 1e3 * F, rtol=1e-12)
    assert (record.specimen, record.provenance["format"]) == ("SN1", "NetCDF")


def test_packed_numbers_and_a_choice_of_dimensions(tmp_path):
    path = tmp_path / "a.nc"
    with netcdf_file(str(path), "w") as file:
        for dimension, factor in (("fast", 1.0), ("slow", 2.0)):
            file.createDimension(dimension, N)
            for name, values, unit in (("t", T, "s"), ("x", factor * X, "mm"), ("f", F, "kN")):
                variable = file.createVariable(f"{name}_{dimension}", "i4", (dimension,))
                variable.units, variable.scale_factor, variable.add_offset = unit, 1e-7, 0.5
                variable[:] = np.rint((values - 0.5) / 1e-7).astype("i4")
    with pytest.raises(FileError, match="has 2 dimensions with two variables of numbers or more \\('fast', 'slow'\\)"):
        read(path)
    columns = {"time": "t_slow", "displacement": "x_slow", "force": "f_slow"}
    record = read(path, variable="slow", columns=columns)
    np.testing.assert_allclose(record.displacement, 2e-3 * X, atol=1e-10)
    with pytest.raises(FileError, match="there is no dimension 'depth' with two variables; choose from 'fast', 'slow'"):
        read(path, variable="depth")


def test_a_missing_value_is_refused_and_so_is_a_broken_file(tmp_path):
    path = version_4(tmp_path / "a.nc")
    with h5py.File(path, "r+") as file:
        file["force"].attrs["_FillValue"] = F[7]
    with pytest.raises(FileError, match=r"force\[7\] = nan N is not finite"):
        read(path)
    path.write_bytes(b"CDF\x01 and no more")
    with pytest.raises(FileError, match="is not a readable NetCDF file"):
        read(path)


def test_xarray_and_scipy_read_what_is_written(tmp_path, make_sine):
    record = make_sine(current=0.3, name="ação", specimen="no. 7 µ", origin="simulated", history=("read", "turned"))
    path = write(record, tmp_path / "a.nc")
    with xarray.open_dataset(path, engine="scipy") as data:
        assert (data["force"].dims, data["force"].units, data.title, data.specimen) == (
            ("time",),
            "N",
            "ação",
            "no. 7 µ",
        )
        assert (data.Conventions, data.origin, data.history) == ("CF-1.11", "simulated", "read\nturned")
        assert np.array_equal(data["force"], record.force)
        assert np.array_equal(data["time"], record.time)
        assert np.array_equal(data["current"], np.full(record.n, 0.3))
    with netcdf_file(str(path), "r", mmap=False) as file:
        assert file.variables["displacement"].units == b"m"
        assert np.array_equal(file.variables["displacement"].data, record.displacement)
    back = read(path)
    assert np.array_equal(back.force, record.force)
    assert (back.current, back.specimen, back.origin.kind) == (0.3, "no. 7 µ", "simulated")


def test_a_record_as_an_xarray_has_its_input_as_a_number(make_sine):
    record = make_sine(voltage=1.98, temperature=None)
    data = record.to_xarray()
    assert (float(data["voltage"]), data["voltage"].dims, data["voltage"].units) == (1.98, (), "V")
    assert float(data["force"].sel(time=1.0, method="nearest")) == record.force[100]
    assert "temperature" not in data
    assert "origin" not in data.attrs
