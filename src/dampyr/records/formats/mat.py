"""MATLAB files, version 5 and 7.3: those of the Labcontrol campaign, and any matrices by their variables' names.

The campaign's variables: ``Ts`` (s), ``dist`` (table displacement, mm), ``forc`` (load-cell force, N) and ``x_F`` (n x 3:
displacement mm, velocity mm/s, force N). Displacement and force are taken from ``dist`` and ``forc``, since
some files have the offsets of ``x_F`` removed; the velocity is the second column of ``x_F``, as it was
recorded. ``f`` is 1.5 in every file and is not the test's frequency, so it is not read.

Of any other file ``columns`` gives each channel its variable, ``{"force": "F"}``; or, with ``variable``, its column of that
one matrix by number, from 0, ``{"force": 2}``. A member of a structure has a dotted name, ``test.force`` or
``tests[1].force`` (:mod:`dampyr.records.files.mat_members`); a ``variable`` that is a structure has its members of one length
as named columns, and the only such structure of a file needs no ``variable``. Samples are rows; units are declared; ``dt``
where no column is the time. Version 5 is written.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.atomic_write import whole_file
from dampyr.channel_columns import MAX_NAMED, OF_TEXTS, ColumnTable
from dampyr.errors import FileError, InputError, one_line
from dampyr.input_kinds import NO_INPUT
from dampyr.phrases import listing
from dampyr.records.files.column_table import record_of
from dampyr.records.files.mat_members import as_text, canonical, object_class, refuse_object, unfolded, unfolded_hdf5
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.files.self_contained import check_contained
from dampyr.records.record import CHANNELS, COMMENTS, PUBLISHED, Array, Record, as_stated, stated
from dampyr.units import to_si

TITLE = "MATLAB"
NEEDS_VELOCITY = True
UNITS = {"displacement": "mm", "velocity": "mm/s", "force": "N"}
VARIABLES = {"displacement": "dist", "force": "forc"}
NEEDED = ("Ts", "dist", "forc", "x_F")


@dataclass(frozen=True)
class _Stored:
    """What is needed of a file, by name; the names of all of its variables and members; and its version in words.

    ``objects`` are the variables that only MATLAB reads, and of which class each is.
    """

    variables: dict[str, Any]
    names: tuple[str, ...]
    version: str
    objects: dict[str, str]

    @property
    def listed(self) -> str:
        """The variables that a person can choose from."""
        return listing(self.names, MAX_NAMED) if self.names else "none"

    def members(self, structure: str) -> dict[str, Array]:
        """The vectors in a structure by their names, those of the length that most of them have; none where it is not one."""
        inside = {
            name.removeprefix(f"{structure}."): value
            for name, value in self.variables.items()
            if name.startswith(f"{structure}.")
        }
        vectors = {name: np.asarray(value, dtype=float).ravel() for name, value in inside.items() if _is_vector(value)}
        lengths = Counter(vector.size for vector in vectors.values())
        return {name: vector for name, vector in vectors.items() if vector.size == lengths.most_common(1)[0][0]}

    def structures(self) -> list[str]:
        """The structures that hold two vectors or more of one length."""
        stems = dict.fromkeys(name.rpartition(".")[0] for name in self.names if "." in name)
        return [stem for stem in stems if len(self.members(stem)) > 1]

    def groups(self) -> dict[str, str]:
        """Session, specimen, origin, that there is no input, and the published data set, where the file has them as text."""
        return as_stated({name: text for name in COMMENTS if isinstance(text := self.variables.get(name), str)})


def read(path: Path, request: ReadOptions) -> Record:
    """The record in a MATLAB file: that of the campaign, whose header is checked against the data, or as declared."""
    request.refuse(path, **dict.fromkeys(OF_TEXTS, "a MATLAB file has none"))
    import h5py

    columns = {
        channel: canonical(column) if isinstance(column, str) else column for channel, column in request.columns.items()
    }
    variable = None if request.variable is None else canonical(request.variable)
    request = replace(request, columns=columns, variable=variable)
    named = {column for column in columns.values() if isinstance(column, str)} - {"", "-"}
    declared = any(column not in (None, "", "-") for column in columns.values())
    wanted = {*NEEDED, "Tout", *COMMENTS, *named, *([variable] if variable else [])}

    def is_wanted(name: str) -> bool:
        undeclared = not named and variable is None and "." in name
        return name in wanted or undeclared or (variable is not None and name.startswith(f"{variable}."))

    stored = _version_7_3(path, is_wanted) if h5py.is_hdf5(path) else _version_5(path)
    if not set(NEEDED) <= set(stored.names) and not named and variable is None:
        structures = stored.structures()
        if len(structures) > 1:
            raise FileError(
                path,
                f"holds the structures {listing(structures, MAX_NAMED)}; name one, --variable {structures[0]} or "
                f"variable={structures[0]!r}",
            )
        if structures:
            request = replace(request, variable=structures[0])
        elif stored.objects and not stored.names:
            raise refuse_object(path, *next(iter(stored.objects.items())))
    if request.variable is not None or (declared and not set(NEEDED) <= set(stored.names)):
        return record_of(path, _table(path, stored, request), request, stored.version)
    fixed = "its channels are those of the campaign; declare their variables, --column force=NAME"
    request.refuse(path, dt="its Ts is the sampling interval", factors=fixed, offsets=fixed)
    return _of_the_campaign(path, stored, request)


def _table(path: Path, stored: _Stored, request: ReadOptions) -> ColumnTable:
    """One matrix, or one column for each variable that is declared."""
    if request.variable is not None and (members := stored.members(request.variable)):
        note = f"members of {request.variable}"
        return ColumnTable(
            tuple(members), ("",) * len(members), np.column_stack(list(members.values())), groups=stored.groups(),
            notes=(note,),
        )  # fmt: skip
    if request.variable is not None:
        matrix = _real(path, stored, request.variable)
        matrix = matrix.reshape(matrix.shape[0], -1) if matrix.ndim < 2 else matrix
        if matrix.ndim != 2 or matrix.shape[0] < matrix.shape[1]:
            raise FileError(
                path,
                f"the variable {request.variable} has the shape {matrix.shape}; its rows must be the samples, so "
                "save its transpose",
            )
        return ColumnTable((), (), matrix, groups=stored.groups())
    numbers = [f"{channel} = {column}" for channel, column in request.columns.items() if isinstance(column, int)]
    if numbers:
        raise FileError(
            path,
            f"columns by number ({numbers[0]}) are those of a matrix; declare which, --variable NAME or variable=NAME "
            f"(there: {stored.listed})",
        )
    names = [column for column in request.columns.values() if isinstance(column, str) and column not in ("", "-")]
    vectors = {name: _real(path, stored, name) for name in dict.fromkeys(names)}
    first, n = next(((name, vector.size) for name, vector in vectors.items()), ("", 0))
    for name, vector in vectors.items():
        if vector.size != max(vector.shape, default=0):
            raise FileError(
                path,
                f"the variable {name} has the shape {vector.shape} and is not a single column; declare it with variable, "
                "and its columns by number",
            )
        if vector.size != n:
            raise FileError(path, f"{name} has {vector.size} samples and {first} has {n}; export the test again")
    values = np.column_stack([vector.ravel() for vector in vectors.values()]) if vectors else np.empty((0, 0))
    return ColumnTable(tuple(vectors), ("",) * len(vectors), values, groups=stored.groups())


def _of_the_campaign(path: Path, stored: _Stored, request: ReadOptions) -> Record:
    variables = _campaign_variables(path, stored)
    step = variables["Ts"]
    if step.size != 1 or not np.isfinite(step).all() or step.item() <= 0:
        shown = step.ravel()[:3].tolist()
        raise FileError(path, f"Ts = {shown} s is not a sampling interval; it must be one number greater than 0")
    dt = float(step.item())
    n = variables["dist"].size
    for name in ("forc", "x_F"):
        rows = len(variables[name]) if name == "x_F" else variables[name].size
        if rows != n:
            raise FileError(path, f"{name} has {rows} samples and dist has {n}; export the test again")
    if variables["x_F"].shape != (n, 3):
        shape = variables["x_F"].shape
        raise FileError(path, f"x_F has the shape {shape}; it must be ({n}, 3): displacement, velocity, force")
    _check_clock(path, variables, dt, n)
    raw = {name: variables[variable].ravel() for name, variable in VARIABLES.items()}
    raw["velocity"] = variables["x_F"][:, 1]
    groups = stored.groups()
    published = {name: groups.pop(name) for name in PUBLISHED if name in groups}
    return Record(
        time=dt * np.arange(n, dtype=np.float64),
        **{name: to_si(raw[name], request.units.get(name, unit), CHANNELS[name]) for name, unit in UNITS.items()},
        **request.input_channels(no_input=groups.pop("input", None) == NO_INPUT),
        name=path.stem,
        provenance={"file": path.name, "format": stored.version, "velocity": "as recorded (x_F, column 2)"} | published,
        history=("read from dist, forc and x_F: displacement mm to m, velocity mm/s to m/s",),
        **groups,  # type: ignore[arg-type]
    )


def write(record: Record, path: Path) -> Path:
    """Write a record with the variables that :func:`read` takes, in mm and N; the input as ``voltage_V`` or ``current_A``,
    and as the text ``input`` where it has none.

    Raises FileError for a record without a velocity or with uneven steps, which this format cannot hold.
    """
    from scipy.io import savemat

    if record.velocity is None:
        raise FileError(
            path, "the campaign's format needs a velocity; derive it with with_velocity, or write .h5 or .csv"
        )
    if not record.evenly_sampled:
        raise FileError(
            path, "the campaign's format has one sampling interval and the record has several; write .h5 or .csv"
        )
    displacement, force = 1e3 * record.displacement, record.force  # the campaign's units, mm and N
    variables = {"Ts": record.dt, "Tout": record.time, "dist": displacement, "forc": force}
    variables["x_F"] = np.column_stack([displacement, 1e3 * record.velocity, force])
    inputs = {"voltage_V": record.voltage, "current_A": record.current}
    variables |= {name: value for name, value in inputs.items() if value is not None}
    variables |= stated(record)
    with whole_file(path) as temporary:
        savemat(temporary, variables, appendmat=False, oned_as="column")
    return path


def _campaign_variables(path: Path, stored: _Stored) -> dict[str, Array]:
    for name in NEEDED:
        if name not in stored.names:
            raise FileError(
                path,
                f"the variable {name} is missing (there: {stored.listed}); export the test again, or declare the channels' "
                "variables, --column force=NAME, or --variable and --column force=NUMBER",
            )
    return {name: _real(path, stored, name) for name in (*NEEDED, "Tout") if name in stored.names}


def _real(path: Path, stored: _Stored, name: str) -> Array:
    """A variable as real numbers."""
    if name in stored.objects:
        raise refuse_object(path, name, stored.objects[name])
    if name not in stored.names:
        raise FileError(path, f"there is no variable {name!r}; choose from {stored.listed}")
    value = np.asarray(stored.variables[name])
    if value.dtype.kind not in "fiub":
        raise FileError(path, f"the variable {name} is not real numbers; export the test again")
    return np.asarray(value, dtype=float)


def _version_5(path: Path) -> _Stored:
    from scipy.io import loadmat

    try:
        variables: dict[str, Any] = loadmat(path, appendmat=False)
    except Exception as problem:  # scipy raises whatever the broken bytes lead it to
        raise FileError(
            path, f"is not a readable MATLAB v5 file ({one_line(problem)}); fetch or export it again"
        ) from problem
    objects = {}
    for name, value in [*variables.items()]:
        if kind := object_class(value):
            del variables[name]
            # scipy before 1.18 calls it otherwise, and has its own name in it
            objects[as_text(np.ravel(value)[0]["s0"]) if "s0" in value.dtype.names else name] = kind
    variables = {name: _text(value) for name, value in variables.items() if not name.startswith("__")}
    if any(getattr(value, "dtype", None) is not None and value.dtype.hasobject for value in variables.values()):
        simple = loadmat(path, appendmat=False, simplify_cells=True, variable_names=list(variables))
        for name, value in [*variables.items()]:
            if getattr(value, "dtype", None) is not None and value.dtype.hasobject:
                variables |= dict(unfolded(name, simple[name]))
                del variables[name]
    return _Stored(variables, tuple(sorted(variables)), "MATLAB v5", objects)


def _text(value: Any) -> Any:
    """A row of characters as a text; anything else as it is."""
    return (
        str(value.ravel()[0])
        if isinstance(value, np.ndarray) and value.dtype.kind == "U" and value.size == 1
        else value
    )


def _is_vector(value: Any) -> bool:
    """Whether a member is a column or a row of real numbers."""
    array = np.asarray(value)
    return array.dtype.kind in "fiub" and array.ndim > 0 and array.size == max(array.shape) > 1


def _version_7_3(path: Path, wanted: Callable[[str], bool]) -> _Stored:
    """Version 7.3 is HDF5; MATLAB keeps a matrix there with its dimensions in the opposite order."""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            check_contained(path, file)
            objects = {name: kind for name, item in file.items() if (kind := object_class(item))}
            tops = [name for name in file if not name.startswith("#") and name not in objects]
            items = {full: item for name in tops for full, item in unfolded_hdf5(name, file[name])}
            values = {name: _dataset(item) for name, item in items.items() if wanted(name)}
            return _Stored(values, tuple(sorted(items)), "MATLAB v7.3", objects)
    except InputError:
        raise
    except MemoryError as problem:
        raise FileError(
            path, f"tells of more data than the memory holds ({problem}); export the test again"
        ) from problem
    except (OSError, KeyError, RuntimeError, TypeError, AttributeError, ValueError) as problem:
        raise FileError(
            path, f"is a truncated or broken MATLAB v7.3 file ({one_line(problem)}); export it again"
        ) from problem


def _dataset(data: Any) -> Any:
    """The values of a variable of version 7.3; a row of characters as a text, and what is no matrix as None."""
    import h5py

    if not isinstance(data, h5py.Dataset):
        return None
    if data.attrs.get("MATLAB_class", b"") == b"char":
        return "".join(map(chr, np.asarray(data[()]).ravel())) if data.dtype.kind == "u" else None
    if data.dtype.kind not in "fiub" or data.attrs.get("MATLAB_empty", 0):
        return None
    return np.asarray(data[()]).T


def _check_clock(path: Path, variables: dict[str, Array], dt: float, n: int) -> None:
    """``Tout`` is the recorder's own clock where it is stored: it must tell the same time as ``Ts``."""
    clock = variables.get("Tout")
    if clock is None or clock.size == 0:
        return
    clock = clock.ravel()
    if clock.size != n:
        raise FileError(path, f"Tout has {clock.size} samples and dist has {n}; export the test again")
    if not np.isfinite(clock).all():
        i = int(np.flatnonzero(~np.isfinite(clock))[0])
        raise FileError(path, f"Tout[{i}] = {clock[i]} s is not finite; export the test again")
    steps = np.diff(clock)
    if np.any(steps <= 0):
        i = int(np.flatnonzero(steps <= 0)[0]) + 1
        raise FileError(
            path,
            f"Tout[{i}] = {clock[i]:.9g} s does not come after {clock[i - 1]:.9g} s; "
            "time must strictly increase, so export the test again",
        )
    if np.max(np.abs(steps - dt)) > 0.01 * dt:
        i = int(np.argmax(np.abs(steps - dt)))
        raise FileError(
            path,
            f"Ts = {dt:g} s but Tout steps by {steps[i]:g} s at sample {i}; export the test again",
        )
