"""Members of MATLAB structures by their names: ``test.time``, and of arrays of structures ``tests[1].x``, from 0.

What MATLAB writes as ``tests(2).x``, from 1, is the same member. Version 5 is unfolded by scipy's ``simplify_cells``, version
7.3 has groups of HDF5 and references. A ``table``, a ``timetable`` or another object is stored in a way that is not published.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.errors import FileError

OBJECTS = ("table", "timetable", "timeseries", "string", "datetime", "duration", "categorical", "containers.Map")


def canonical(name: str) -> str:
    """A member's name with its indices from 0: ``tests(2).x`` is ``tests[1].x``."""
    return re.sub(r"\((\d+)\)", lambda match: f"[{int(match[1]) - 1}]", name.strip())


def unfolded(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """The members of a variable as ``simplify_cells`` gives it, each with its full name; itself where it has none."""
    if isinstance(value, Mapping):
        for key, member in value.items():
            yield from unfolded(f"{name}.{key}", member)
    elif isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object):
        for k, member in enumerate(np.ravel(np.asarray(value, dtype=object))):
            yield from unfolded(f"{name}[{k}]", member)
    else:
        yield name, value


def unfolded_hdf5(name: str, item: Any) -> Iterator[tuple[str, Any]]:
    """The datasets of a variable of version 7.3, each with its full name."""
    import h5py

    if isinstance(item, h5py.Group):
        for key, member in item.items():
            if _holds_references(member) and _class_of(member) != "cell":  # the field of an array of structures
                stem, field = name, f".{key}"
            elif _holds_references(member):
                stem, field = f"{name}.{key}", ""
            else:
                yield from unfolded_hdf5(f"{name}.{key}", member)
                continue
            for k, reference in enumerate(np.ravel(member[()])):
                yield from unfolded_hdf5(f"{stem}[{k}]{field}", item.file[reference])
    elif _holds_references(item):
        for k, reference in enumerate(np.ravel(item[()])):
            yield from unfolded_hdf5(f"{name}[{k}]", item.file[reference])
    else:
        yield name, item


def object_class(value: Any) -> str:
    """The class of a variable of version 5 or 7.3 that is an object, such as "table"; "" of any other."""
    names = getattr(getattr(value, "dtype", None), "names", None) or ()
    field = next(
        (field for field in ("s2", "_Class") if field in names), ""
    )  # scipy's MatlabOpaque before 1.18, and since
    if field and ({"s0", "s1", "arr"} <= set(names) or "_TypeSystem" in names):
        return as_text(np.ravel(value)[0][field])
    kind = _class_of(value)
    return kind if kind in OBJECTS else ""


def as_text(text: Any) -> str:
    """A text of MATLAB's, which may come as bytes."""
    return text.decode("latin-1") if isinstance(text, bytes) else str(text)


def refuse_object(path: Path, name: str, kind: str) -> FileError:
    """The error for a variable that is an object of MATLAB, and how to export it."""
    repair = (
        f"S = table2struct({name}, 'ToScalar', true); save('{path.name}', 'S')"
        if kind == "table"
        else f"S = table2struct(timetable2table({name}), 'ToScalar', true); save('{path.name}', 'S')"
        if kind == "timetable"
        else f"t = {name}.Time; x = {name}.Data; save('{path.name}', 't', 'x')"
        if kind == "timeseries"
        else "save its numbers as matrices or as a struct"
    )
    return FileError(
        path, f"the variable {name} is a MATLAB {kind}, which only MATLAB reads; export it there: {repair}"
    )


def _class_of(item: Any) -> str:
    kind = getattr(item, "attrs", {}).get("MATLAB_class", b"")
    return kind.decode("latin-1") if isinstance(kind, bytes) else str(kind)


def _holds_references(item: Any) -> bool:
    import h5py

    return isinstance(item, h5py.Dataset) and h5py.check_ref_dtype(item.dtype) is not None
