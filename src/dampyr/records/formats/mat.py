"""MATLAB v5 files of the Labcontrol campaign.

Variables: ``Ts`` (s), ``dist`` (table displacement, mm), ``forc`` (load-cell force, N) and ``x_F`` (n x 3:
displacement mm, velocity mm/s, force N). Displacement and force are taken from ``dist`` and ``forc``, since
some files have the offsets of ``x_F`` removed; the velocity is the second column of ``x_F``, as it was
recorded. ``f`` is 1.5 in every file and is not the test's frequency, so it is not read.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from dampyr.atomic_write import whole_file
from dampyr.errors import FileError
from dampyr.records.record import Array, Record
from dampyr.records.record_files import Request
from dampyr.units import to_si

TITLE = "MAT (version 5)"
NEEDS_VELOCITY = True
UNITS = {"displacement": "mm", "velocity": "mm/s", "force": "N"}
VARIABLES = {"displacement": "dist", "force": "forc"}
NEEDED = ("Ts", "dist", "forc", "x_F")


def read(path: Path, request: Request) -> Record:
    """The record in a MATLAB file of the campaign; the header is checked against the data."""
    variables = _variables(path)
    dt = _interval(path, variables["Ts"])
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
    return Record(
        time=dt * np.arange(n, dtype=np.float64),
        **{name: to_si(raw[name], request.units.get(name, UNITS[name]), si) for name, si in _SI.items()},
        **request.input_channels(),
        name=path.stem,
        provenance={"file": path.name, "format": "MATLAB v5", "velocity": "as recorded (x_F, column 2)"},
        history=("read from dist, forc and x_F: displacement mm to m, velocity mm/s to m/s",),
    )


def write(record: Record, path: Path) -> Path:
    """Write a record with the variables that :func:`read` takes, in mm and N; the input as ``voltage_V`` or ``current_A``.

    Raises FileError for a record without a velocity or with uneven steps, which this format cannot hold.
    """
    from scipy.io import savemat

    if record.velocity is None:
        raise FileError(
            path, "the campaign's format needs a velocity; derive it with with_velocity, or write .h5 or .csv"
        )
    if np.max(np.abs(np.diff(record.time) - record.dt)) > 0.01 * record.dt:
        raise FileError(
            path, "the campaign's format has one sampling interval and the record has several; write .h5 or .csv"
        )
    mm = {"displacement": 1e3 * record.displacement, "velocity": 1e3 * record.velocity, "force": record.force}
    held = {"Ts": record.dt, "Tout": record.time, "dist": mm["displacement"], "forc": mm["force"]}
    held |= {"x_F": np.column_stack([mm[name] for name in ("displacement", "velocity", "force")])}
    inputs = {"voltage_V": record.voltage, "current_A": record.current}
    held |= {name: value for name, value in inputs.items() if value is not None}
    with whole_file(path) as temporary:
        savemat(temporary, held, appendmat=False, oned_as="column")
    return path


_SI = {"displacement": "m", "force": "N", "velocity": "m/s"}


def _variables(path: Path) -> dict[str, Array]:
    from scipy.io import loadmat

    try:
        variables: dict[str, Any] = loadmat(path, appendmat=False)
    except NotImplementedError:
        raise FileError(path, "is a MATLAB v7.3 file; save it again with save(..., '-v7')") from None
    except Exception as problem:  # scipy raises whatever the broken bytes lead it to
        reason = " ".join(str(problem).split()) or type(problem).__name__
        raise FileError(path, f"is no readable MATLAB v5 file ({reason}); fetch or export it again") from problem
    for name in NEEDED:
        if name not in variables:
            there = ", ".join(sorted(k for k in variables if not k.startswith("__"))) or "none"
            raise FileError(path, f"the variable {name} is missing (there: {there}); export the test again")
        if not np.issubdtype(np.asarray(variables[name]).dtype, np.number) or np.iscomplexobj(variables[name]):
            raise FileError(path, f"the variable {name} is not real numbers; export the test again")
    return {k: np.asarray(v, dtype=float) for k, v in variables.items() if k in (*NEEDED, "Tout")}


def _interval(path: Path, value: Array) -> float:
    if value.size != 1 or not np.isfinite(value).all() or value.item() <= 0:
        shown = value.ravel()[:3].tolist()
        raise FileError(path, f"Ts = {shown} s is no sampling interval; it must be one number greater than 0")
    return float(value.item())


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
