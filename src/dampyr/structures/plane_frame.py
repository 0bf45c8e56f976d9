r"""A plane frame of nodes and elements, from two tables: its mass and stiffness matrices.

An element of length L is a beam of Euler and Bernoulli, or a truss whose ends are pinned. In its own axes, with the axial
displacements u, the transverse w and the rotations r of its ends i and j,

.. math:: N = \frac{EA}{L}(u_j - u_i), \qquad
          k_w = \frac{EI}{L^3} \begin{pmatrix} 12 & 6L & -12 & 6L \\ 6L & 4L^2 & -6L & 2L^2 \\ -12 & -6L & 12 & -6L \\
          6L & 2L^2 & -6L & 4L^2 \end{pmatrix} \text{ over } (w_i, r_i, w_j, r_j)

Masses stand at the nodes. A node may be held in x, in y or against rotation, and may follow another one in x, as a floor that
is rigid in its plane lets it.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import FileError, InputError
from dampyr.units import to_si

Array = NDArray[np.float64]

NODE = {
    "node": "", "x": "m", "y": "m", "mass horizontal": "kg", "mass vertical": "kg", "mass rotational": "kg m^2",
    "fixed x": "", "fixed y": "", "fixed rotation": "", "x follows node": "",
}  # fmt: skip
ELEMENT = {"element": "", "node i": "", "node j": "", "EI": "N m^2", "EA": "N", "kind": ""}
DIRECTIONS = ("x", "y", "rotation")
KINDS = ("frame", "truss")
HELD = -1


@dataclass(frozen=True, eq=False)
class PlaneFrame:
    """``M`` and ``K`` (n, n) [kg and N/m; kg m2 and N m for rotations]; ``labels`` (n,) such as "9 x".

    ``influence`` (n,) is 1 for x and 0 for what is not horizontal.
    """

    M: Array
    K: Array
    labels: tuple[str, ...]
    influence: Array


def read_frame(nodes: Path, elements: Path) -> PlaneFrame:
    """The frame of two .csv files.

    ``nodes`` has the columns node, x, y, mass horizontal, mass vertical, mass rotational, fixed x, fixed y, fixed rotation
    (1 or 0) and x follows node (empty where it does not); ``elements`` element, node i, node j, EI, EA and kind (frame or
    truss). A unit stands in brackets behind a column's name, ``x [mm]``. A table is refused with its line
    (:class:`~dampyr.errors.FileError`).
    """
    node_rows, element_rows = _table(nodes, NODE), _table(elements, ELEMENT)
    places: dict[str, tuple[float, float]] = {}
    for row in node_rows:
        if row["node"] in places:
            raise FileError(nodes, f"line {row['line']}: node {row['node']} is given twice")
        places[row["node"]] = _number(nodes, row, "x"), _number(nodes, row, "y")
    counts, labels = _degrees(nodes, node_rows)
    size = len(labels)
    mass, stiffness = np.zeros(size), np.zeros((size, size))
    for row in node_rows:
        for count, column in zip(
            counts[row["node"]], ("mass horizontal", "mass vertical", "mass rotational"), strict=True
        ):
            value = _number(nodes, row, column)
            if value < 0.0:
                raise FileError(nodes, f"line {row['line']}: {column} = {value:g} is negative; give 0 or more")
            if count != HELD:
                mass[count] += value
    for row in element_rows:
        for end in ("node i", "node j"):
            if row[end] not in places:
                raise FileError(elements, f"line {row['line']}: node {row[end]} is not in {nodes.name}")
        at = np.array([*counts[row["node i"]], *counts[row["node j"]]])
        span = np.subtract(places[row["node j"]], places[row["node i"]])
        free = at != HELD
        np.add.at(stiffness, np.ix_(at[free], at[free]), _element(elements, row, span)[np.ix_(free, free)])
    influence = np.array([1.0 if label.endswith(" x") else 0.0 for label in labels])
    return PlaneFrame(np.diag(mass), 0.5 * (stiffness + stiffness.T), labels, influence)


def _degrees(path: Path, rows: list[dict[str, str]]) -> tuple[dict[str, list[int]], tuple[str, ...]]:
    """The number of every degree of freedom of each node, `HELD` where it has none, and their labels."""
    labels: list[str] = []
    counts: dict[str, list[int]] = {}
    followers: dict[str, dict[str, str]] = {}
    for row in rows:
        counts[row["node"]] = []
        for direction in DIRECTIONS:
            fixed = row[f"fixed {direction}"]
            if fixed not in ("0", "1"):
                raise FileError(path, f"line {row['line']}: fixed {direction} = {fixed!r} must be 1 or 0")
            follows = direction == "x" and row["x follows node"] != ""
            if follows:
                followers[row["node"]] = row
            if fixed == "1" or follows:
                counts[row["node"]].append(HELD)
            else:
                counts[row["node"]].append(len(labels))
                labels.append(f"{row['node']} {direction}")
    for name, row in followers.items():
        leader = row["x follows node"]
        if leader not in counts or leader in followers or row["fixed x"] == "1":
            raise FileError(
                path,
                f"line {row['line']}: node {name} follows {leader}; it must be another node that follows none, and not fixed",
            )
        counts[name][0] = counts[leader][0]
    return counts, tuple(labels)


def _element(path: Path, row: dict[str, str], span: Array) -> Array:
    """The stiffness (6, 6) of an element in the frame's axes."""
    length = float(np.hypot(*span))
    kind = row["kind"].split(" ")[0]
    if kind not in KINDS:
        raise FileError(path, f"line {row['line']}: kind {row['kind']!r} is not known; write {' or '.join(KINDS)}")
    axial, bending = _number(path, row, "EA"), _number(path, row, "EI") if kind == "frame" else 0.0
    if length == 0.0 or axial < 0.0 or bending < 0.0:
        raise FileError(path, f"line {row['line']}: its length must be more than 0, and EI and EA at least 0")
    a, b, c, d = axial / length, 12 * bending / length**3, 6 * bending / length**2, 2 * bending / length
    local = np.array(
        [
            [a, 0, 0, -a, 0, 0],
            [0, b, c, 0, -b, c],
            [0, c, 2 * d, 0, -c, d],
            [-a, 0, 0, a, 0, 0],
            [0, -b, -c, 0, b, -c],
            [0, c, d, 0, -c, 2 * d],
        ]
    )
    cosine, sine = span / length
    rotation = np.kron(np.eye(2), [[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1]])
    return np.asarray(rotation.T @ local @ rotation, dtype=np.float64)


def _table(path: Path, columns: dict[str, str]) -> list[dict[str, str]]:
    """The rows by the columns' names, with ``line``; ``NAME unit`` is that of a column with one."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.reader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as problem:
        raise FileError(path, f"cannot be read as a table ({problem}); give a .csv file of UTF-8") from None
    heads = [cell.partition("[") for cell in rows[0]] if rows else []
    names = [name.strip() for name, _, _ in heads]
    if sorted(names) != sorted(columns):
        missing = [name for name in columns if name not in names]
        detail = f"lacks {', '.join(missing)}" if missing else f"has {len(names)} columns"
        raise FileError(path, f"{detail} in its first line; it must name {', '.join(columns)}, each once")
    units = {f"{name} unit": unit.rstrip("] ") for name, (_, _, unit) in zip(names, heads, strict=True)}
    tables = []
    for line, row in enumerate(rows[1:], start=2):
        if len(row) != len(names):
            raise FileError(path, f"line {line} has {len(row)} cells; it must have {len(names)}")
        tables.append(dict(zip(names, (cell.strip() for cell in row), strict=True)) | units | {"line": str(line)})
    if not tables:
        raise FileError(path, "has no rows below its names")
    return tables


def _number(path: Path, row: dict[str, str], column: str) -> float:
    si = (NODE | ELEMENT)[column]
    unit = row[f"{column} unit"]
    try:
        value = float(to_si(float(row[column]), unit or si, si))
    except ValueError as problem:  # an InputError is one
        detail = f" ({problem})" if isinstance(problem, InputError) else ""
        raise FileError(
            path, f"line {row['line']}: {column} = {row[column]!r} must be a number in {unit or si}{detail}"
        ) from None
    if not np.isfinite(value):
        raise FileError(path, f"line {row['line']}: {column} = {row[column]!r} must be finite")
    return value
