"""NetCDF, classic and of version 4: each variable over one dimension is a column, its attribute ``units`` the unit.

``variable`` names the dimension where a file has several with variables that share it. Numbers that are packed are unpacked
(``scale_factor``, ``add_offset``, ``_FillValue``), and ``seconds since ...`` is s. The classic form is read by scipy, version 4
as the HDF5 that it is; groups in it are left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.atomic_write import whole_file
from dampyr.channel_columns import MAX_NAMED, OF_TEXTS, Array, ColumnTable
from dampyr.errors import FileError, InputError, one_line
from dampyr.phrases import listing
from dampyr.records.files.column_table import record_of
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.files.self_contained import check_contained
from dampyr.records.record import COMMENTS, Record, as_stated

TITLE, MEDIA_TYPE = "NetCDF", "application/x-netcdf"
CONVENTIONS = "CF-1.11"
SINCE = " since "  # of CF's units of time, "seconds since 2026-01-01"
Columns = dict[str, tuple[str, Array, Mapping[str, Any]]]  # dimension, values and attributes of each variable


def read(path: Path, request: ReadOptions) -> Record:
    """The record in the variables of one dimension of a ``.nc`` file."""
    import h5py

    request.refuse(path, **dict.fromkeys(OF_TEXTS, "a NetCDF file names its variables"))
    try:
        columns, attributes = _version_4(path) if h5py.is_hdf5(path) else _classic(path)
    except InputError:
        raise
    except Exception as problem:  # scipy and h5py raise whatever the broken bytes lead them to
        raise FileError(
            path, f"is not a readable NetCDF file ({one_line(problem)}); copy or export it again"
        ) from problem
    dimension = _dimension(path, columns, request.variable)
    chosen = {name: column for name, column in columns.items() if column[0] == dimension}
    table = ColumnTable(
        names=tuple(chosen),
        units=tuple(_text(of_variable.get("units", "")).partition(SINCE)[0] for _, _, of_variable in chosen.values()),
        values=np.column_stack([values for _, values, _ in chosen.values()]),
        groups=as_stated({name: _text(attributes[name]) for name in COMMENTS if name in attributes}),
        notes=(f"the dimension {dimension!r}",),
    )
    return record_of(path, table, request, "NetCDF")


def write(record: Record, path: Path) -> Path:
    """Write `Record.to_xarray` as classic NetCDF with offsets of 64 bits, a constant input at each time; by scipy."""
    data = record.to_xarray()
    data = data.assign({name: values.broadcast_like(data["time"]) for name, values in data.items()})
    with whole_file(path) as temporary:
        data.assign_attrs(Conventions=CONVENTIONS).to_netcdf(temporary, engine="scipy", format="NETCDF3_64BIT")
    return path


def _dimension(path: Path, columns: Columns, wanted: str | None) -> str:
    """The dimension that is asked for, or the only one that two variables or more share."""
    sharing = [dimension for dimension, _, _ in columns.values()]
    available = [dimension for dimension in dict.fromkeys(sharing) if sharing.count(dimension) > 1]
    listed = listing(list(map(repr, available)), MAX_NAMED) or "none"
    if wanted is not None:
        if wanted not in available:
            raise FileError(path, f"there is no dimension {wanted!r} with two variables; choose from {listed}")
        return wanted
    if len(available) != 1:
        raise FileError(
            path,
            f"has {len(available)} dimensions with two variables of numbers or more ({listed}); a record needs one, named by "
            "--variable NAME or variable=NAME",
        )
    return available[0]


def _classic(path: Path) -> tuple[Columns, Mapping[str, Any]]:
    from scipy.io import netcdf_file

    with netcdf_file(str(path), "r", mmap=False) as file:
        columns: Columns = {
            name: (variable.dimensions[0], _unpacked(variable.data, variable._attributes), dict(variable._attributes))
            for name, variable in file.variables.items()
            if len(variable.dimensions) == 1 and variable.data.dtype.kind in "fiu"
        }
        return columns, dict(file._attributes)


def _version_4(path: Path) -> tuple[Columns, Mapping[str, Any]]:
    """A variable is a dataset whose list of dimensions refers to that of its dimension, or is that of its own."""
    import h5py

    with h5py.File(path, "r") as file:
        check_contained(path, file)
        columns: Columns = {}
        for name, item in file.items():
            if not isinstance(item, h5py.Dataset) or item.ndim != 1 or item.dtype.kind not in "fiu":
                continue
            attributes = dict(item.attrs)
            if _text(attributes.get("NAME", "")).startswith("This is a netCDF dimension but not a netCDF variable"):
                continue
            own = attributes.get("CLASS") is not None  # a dimension's own variable
            references = attributes.get("DIMENSION_LIST")
            dimension = name if own else file[references[0][0]].name.lstrip("/") if references is not None else ""
            columns[name] = (dimension, _unpacked(item[()], attributes), attributes)
        return columns, dict(file.attrs)


def _unpacked(data: Any, attributes: Mapping[str, Any]) -> Array:
    """The numbers of a variable by the conventions of CF; NaN where the file says that there is none."""
    values = np.array(data, dtype=np.float64)
    for name in ("_FillValue", "missing_value"):
        if name in attributes:
            values[np.asarray(data) == np.ravel(attributes[name])[0]] = np.nan
    scale, offset = (
        float(np.ravel(attributes.get(name, usual))[0]) for name, usual in (("scale_factor", 1.0), ("add_offset", 0.0))
    )
    return values * scale + offset


def _text(value: Any) -> str:
    value = np.ravel(value)[0] if isinstance(value, np.ndarray) and value.size else value
    return (value.decode("utf-8", errors="replace") if isinstance(value, bytes) else str(value)).strip()
