"""Forces on the floors of a structure over time: wind, a shaker, an impact.

A table has a column of times and one of forces for each loaded floor, such as ``time [s], floor 1 [kN], roof [kN]``. The forces
are linear between the times, which need not be even: a blow is four rows. They act in the direction of the displacements,
are 0 before the first time and keep their last value after the last. In a TOML file they are lists, with units where they are
texts::

    time = [0, "10 ms", "20 ms", "1 s"]

    [forces]
    roof = [0, "0.5 kN", 0, 0]
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from dampyr.channel_columns import NAMES, ColumnTable, TextOptions, plain_name
from dampyr.config import fill, load_toml
from dampyr.errors import FileError, InputError
from dampyr.shown import Shown
from dampyr.structures.building import Building
from dampyr.text_table import read_table
from dampyr.units import Quantity, in_si, to_si

Array = NDArray[np.float64]
FLOOR = re.compile(r"(?:floor|storey|dof)[\s_-]*(\S+)", re.IGNORECASE)


@dataclass(frozen=True, eq=False, repr=False)
class FloorLoads(Shown):
    """Forces on floors: ``time`` (n,) in s from 0 on, rising, and ``forces``, floor -> (n,) in N, linear in between.

    A floor is its label or its count from 1. The first force of a floor acts at once where the time begins at 0, as a sudden
    load; a record that begins later must begin with 0. An :class:`~dampyr.errors.InputError` says what is wrong. Quantities are
    converted from their units.

    >>> import dampyr as dp
    >>> blow = dp.structures.FloorLoads([0.0, 0.01, 0.02, 1.0], {2: [0.0, 500.0, 0.0, 0.0]})
    >>> blow.peaks, blow.duration
    ({'2': 500.0}, 1.0)
    """

    time: Array
    forces: Mapping[Any, Array]
    name: str = "floor loads"
    source: str = ""
    history: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        time = np.array(in_si(self.time, "s", f"{self.name}: time"), dtype=float)
        if time.ndim != 1 or len(time) < 2 or not np.all(np.isfinite(time)):
            raise InputError(
                f"{self.name}: time has shape {time.shape}; it must be one row of at least 2 finite numbers"
            )
        if np.any(np.diff(time) <= 0.0) or time[0] < 0.0:
            k = int(np.argmax(np.diff(time) <= 0.0))
            what = f"is {time[0]:g} s at first" if time[0] < 0.0 else f"goes from {time[k]:g} to {time[k + 1]:g} s"
            raise InputError(f"{self.name}: time {what}; it must rise from 0 or later")
        if not isinstance(self.forces, Mapping) or not self.forces:
            raise InputError(
                f"{self.name}: forces must be a mapping from floor to its forces in N, with a floor at least"
            )
        forces = {str(floor): self._row(floor, row, len(time)) for floor, row in self.forces.items()}
        if len(forces) < len(self.forces):
            raise InputError(f"{self.name}: a floor is given twice; add its forces up")
        late = next((floor for floor, row in forces.items() if time[0] > 0.0 and row[0] != 0.0), None)
        if late is not None:
            raise InputError(
                f"{self.name}: the record begins at {time[0]:g} s with {forces[late][0]:g} N on floor {late}; begin with 0 N, "
                "or at 0 s"
            )
        time.flags.writeable = False
        for name, value in (("time", time), ("forces", forces), ("history", tuple(self.history))):
            object.__setattr__(self, name, value)

    def _row(self, floor: Any, values: Any, count: int) -> Array:
        row = np.array(in_si(values, "N", f"{self.name}: forces of floor {floor}"), dtype=float)
        if row.shape != (count,) or not np.all(np.isfinite(row)):
            raise InputError(
                f"{self.name}: the forces of floor {floor} have shape {row.shape}; they must be {count} finite numbers in N, "
                "as many as times"
            )
        row.flags.writeable = False
        return row

    @property
    def duration(self) -> float:
        """The last time [s]."""
        return float(self.time[-1])

    @property
    def peaks(self) -> dict[str, float]:
        """The largest magnitude of each floor's force [N]."""
        return {floor: float(np.max(np.abs(row))) for floor, row in self.forces.items()}

    def at(self, time: Array) -> Array:
        """The forces (k, floors) [N] at the times (k,) [s]: linear in between, 0 before the first and the last one after it."""
        return np.column_stack([np.interp(time, self.time, row, left=0.0) for row in self.forces.values()])

    def scaled(self, factor: float) -> FloorLoads:
        """The same loads, ``factor`` times as strong."""
        factor = float(in_si(factor, "dimensionless", "the scale"))
        if not np.isfinite(factor):
            raise InputError(f"the scale {factor!r} is not a finite number")
        forces = {floor: factor * row for floor, row in self.forces.items()}
        return replace(
            self,
            forces=forces,
            name=f"{self.name} x {factor:g}",
            history=(*self.history, f"scaled by {factor:.12g}"),
        )

    def floors_of(self, building: Building) -> tuple[int, ...]:
        """The loaded floors by count from 1; InputError for one that the building does not have, or has under two names."""
        counts = tuple(_floor_of(building, floor) for floor in self.forces)
        if len(set(counts)) < len(counts):
            raise InputError(
                f"{self.name}: {', '.join(self.forces)} name one floor of {building.name} twice; add its forces up"
            )
        return counts


def _floor_of(building: Building, floor: str) -> int:
    labels = [str(label) for label in building.floors]
    match = FLOOR.fullmatch(floor.strip())
    for text in (floor.strip(), *([match[1]] if match else [])):
        if text in labels:
            return labels.index(text) + 1
        if text.isdigit() and 1 <= int(text) <= len(labels):
            return int(text)
    raise InputError(
        f"there is no floor {floor!r} in {building.name} to load; write a label, {', '.join(labels)}, or a count from 1 to "
        f"{len(labels)}"
    )


def refuse_loads(call: str, keywords: Mapping[str, Any]) -> None:
    """:class:`~dampyr.errors.InputError` where a call that runs motions of the ground alone is given loads."""
    if "loads" in keywords:
        raise InputError(
            f"{call} runs motions of the ground alone, without loads on floors; take respond(..., loads=), one case "
            "after another"
        )


def read_loads(path: str | Path, units: str | None = None, name: str | None = None) -> FloorLoads:
    """Loads on floors from a table in a text: a column of times, and one of forces for each loaded floor.

    The header names the columns, with their units in brackets: ``time [s], floor 1 [kN], roof [kN]``. A floor is a label of the
    building, a count from 1, or ``floor`` and a count. Delimiter, decimal mark and encoding are found as those of records.
    A TOML file has the list ``time``, the lists of the table ``forces`` by their floors, and a ``name``.

    Parameters
    ----------
    path
        The file.
    units
        Of the forces, such as "kN", where the header does not say them; the time is in s then, unless it says another.
    name
        What the loads are called; by default after the file.

    Raises
    ------
    InputError
        The file has no header, no time or a force without a unit, or its numbers are wrong.

    Examples
    --------
    >>> import dampyr as dp
    >>> from pathlib import Path
    >>> _ = Path("blow.csv").write_text("time [s],floor 2 [kN]\\n0,0\\n0.01,0.5\\n0.02,0\\n1,0\\n")
    >>> dp.structures.read_loads("blow.csv").peaks
    {'floor 2': 500.0}
    """
    file = Path(path)
    if file.suffix.lower() == ".toml":
        return _of_toml(file, units, name)
    table = read_table(file, TextOptions())
    if not table.names:
        raise FileError(file, "names no columns; the first line must be such as: time [s],floor 1 [kN],floor 2 [kN]")
    if table.empty or table.short:
        raise FileError(file, "has an empty cell; every row needs a time and a force of each floor")
    times = [k for k, header in enumerate(table.names) if plain_name(header) in NAMES["time"]]
    if len(times) != 1 or len(table.names) < 2:
        raise FileError(
            file,
            f"has {len(times)} columns of times and {len(table.names) - len(times)} others; it must have one, and forces",
        )
    twice = sorted({header for header in table.names if list(table.names).count(header) > 1})
    if twice:
        raise FileError(file, f"has two columns called {twice[0]!r}; add the forces of one floor up")
    time = _in_si(file, table, times[0], "s", "s")
    forces = {header: _in_si(file, table, k, "N", units) for k, header in enumerate(table.names) if k != times[0]}
    try:
        return FloorLoads(time, forces, name or file.stem, file.name, table.notes)
    except InputError as problem:
        raise FileError(file, str(problem)) from None


@dataclass(frozen=True)
class LoadLists:
    """What the TOML file of loads holds."""

    time: Annotated[tuple[float, ...], Quantity("s"), "from 0 on, rising"]
    forces: Annotated[Mapping[str, tuple[float, ...]], Quantity("N"), "of each loaded floor, as many as times"]
    name: Annotated[str, "what the loads are called"] = ""


def _of_toml(file: Path, units: str | None, name: str | None) -> FloorLoads:
    document = load_toml(file)
    try:
        if units is not None:
            raise InputError(f"units = {units!r} is of a table of text; here each force has its own, such as '0.5 kN'")
        lists = fill(LoadLists, document)
        return FloorLoads(np.array(lists.time), lists.forces, name or lists.name or file.stem, file.name)  # type: ignore[arg-type]
    except InputError as problem:
        raise FileError(file, str(problem)) from None


def _in_si(path: Path, table: ColumnTable, column: int, si: str, declared: str | None) -> Array:
    stated = table.unit(column)
    if not stated and declared is None:
        raise FileError(
            path,
            f"the column {table.label(column)} has no unit; write it in the header, such as {table.names[column]} [kN], or "
            "declare it, such as units='kN'",
        )
    if table.kind(column) != "number":
        raise FileError(
            path, f"the column {table.label(column)} holds {table.kind(column)}s; it must be numbers in {si}"
        )
    try:
        return np.asarray(to_si(table.values[:, column], stated or declared or si, si), dtype=np.float64)
    except InputError as problem:
        raise FileError(path, f"column {table.label(column)}: {problem}") from None
