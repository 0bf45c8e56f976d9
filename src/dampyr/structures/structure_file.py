"""A structure's TOML file: storeys, floors that turn, the matrices M, C and K, or a plane frame of nodes and elements.

::

    name = "three storeys"                        name = "frame"
    masses = ["1 t", "1 t", "0.8 t"]              M = ["1 t", "1 t"]
    stiffnesses = ["2 kN/mm", "2 kN/mm", 1.5e6]   K = { unit = "kN/m", values = [[3000, -1000], [-1000, 1000]] }
    damping_ratio = 0.02                          damping_ratio = [0.03, 0.05]

    name = "plane frame"                          M = { file = "mass.txt", unit = "t" }
    nodes = "nodes.csv"                           K = { file = "model.npz", variable = "K", unit = "kN/m" }
    elements = "elements.csv"                     damping_ratio = 0.02
    floors = ["21", "27"]                         keep = [2, 4]
    damping_ratio = 0.02

    name = "floors that turn"                     name = "bridge"
    masses = ["20 t", "16 t"]                     M = ["20 t", "20 t"]
    inertias = ["400 t m^2", 2.6e5]               K = { unit = "MN/m", values = [[9, -4, -5, 0], ...] }
    frames = [                                    damping_ratio = 0.02
      { position = "-5 m", stiffnesses = 6e6 },   supports = ["west", "east"]
      { position = "6 m", stiffnesses = 9e6 },
    ]
    damping_ratio = 0.03

A number without a unit is SI: kg, N/m, N s/m. A list in the place of a matrix is its diagonal. Files lie beside this one.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from dampyr.atomic_write import write_whole
from dampyr.config import Choices, fill, load_toml, unknown
from dampyr.errors import FileError, InputError
from dampyr.structures.building import Building
from dampyr.structures.damping import modal, rayleigh
from dampyr.structures.plane_frame import read_frame
from dampyr.structures.shear import shear_building
from dampyr.structures.supports import SupportedBuilding, with_supports
from dampyr.structures.time_history.modal_coordinates import modal_condensation
from dampyr.structures.torsion import TorsionalBuilding, torsional_building
from dampyr.units import Quantity, parse, to_si

Array = NDArray[np.float64]

Mass, Stiffness, Dashpot = Quantity("kg"), Quantity("N/m"), Quantity("N s/m")
Ratio = Annotated[tuple[float, ...], "ratio to critical damping: one for all modes of the method, or one for each"]
Method = Annotated[str, Choices(("rayleigh", "modal")), "how the damping matrix follows from the ratios"]


@dataclass(frozen=True)
class Storeys:
    """A structure of storeys, from the ground up: see `dampyr.structures.shear_building`."""

    masses: Annotated[tuple[float, ...], Mass, "mass of each floor"]
    stiffnesses: Annotated[tuple[float, ...], Stiffness, "stiffness of each storey"]
    dashpots: Annotated[tuple[float, ...], Dashpot, "dashpot of each storey"] = ()
    damping_ratio: Ratio = ()
    method: Method = "rayleigh"
    modes: Annotated[tuple[int, ...], 'the two modes of "rayleigh"'] = (1, 2)
    name: str = "shear building"


@dataclass(frozen=True)
class Matrices:
    """What stands in the file of a structure of matrices besides ``M``, ``C`` and ``K``."""

    damping_ratio: Ratio = ()
    method: Method = "modal"
    modes: Annotated[tuple[int, ...], 'the two modes of "rayleigh"'] = (1, 2)
    floors: Annotated[tuple[str, ...], "labels from the ground up"] = ()
    influence: Annotated[tuple[float, ...], "how each degree of freedom follows the ground"] = ()
    keep: Annotated[tuple[int, ...], "degrees of freedom, from 1, that are floors; the others go by modes"] = ()
    supports: Annotated[tuple[str, ...], "the last degrees of freedom of K, which move as told"] = ()
    support_influence: Annotated[
        tuple[tuple[float, ...], ...], "how each floor follows the supports, a row each, where K is of the floors alone"
    ] = ()
    below: Annotated[tuple[int, ...], "of a structure on supports the floor below each storey, 0 for a support"] = ()
    lines: Annotated[tuple[float, ...], Quantity("m"), "of floors that turn, the two lines of their displacements"] = ()
    centres: Annotated[tuple[float, ...], Quantity("m"), "of floors that turn, where their centres of mass lie"] = ()
    name: str = "structure"


@dataclass(frozen=True)
class Frame:
    """A plane frame: see `dampyr.structures.plane_frame.read_frame`."""

    nodes: Annotated[str, "the .csv file of the nodes"]
    elements: Annotated[str, "the .csv file of the elements"]
    floors: Annotated[tuple[str, ...], "the nodes whose horizontal displacement is that of a floor, from the ground up"]
    damping_ratio: Ratio
    method: Method = "rayleigh"
    modes: Annotated[tuple[int, ...], 'the two modes of "rayleigh"'] = (1, 2)
    frames: Annotated[int, "equal frames that move together"] = 1
    name: str = "plane frame"


@dataclass(frozen=True)
class PlanFrame:
    """A frame of a building whose floors turn."""

    position: Annotated[float, Quantity("m"), "where it stands along y"]
    stiffnesses: Annotated[tuple[float, ...], Stiffness, "of each storey, or one for all"]


@dataclass(frozen=True)
class Turning:
    """A building whose floors turn: see `dampyr.structures.torsional_building`."""

    masses: Annotated[tuple[float, ...], Mass, "mass of each floor"]
    inertias: Annotated[tuple[float, ...], Quantity("kg m^2"), "of each floor, in plan about its centre of mass"]
    frames: Annotated[tuple[PlanFrame, ...], "frames along x, at their positions"]
    centres: Annotated[
        tuple[float, ...], Quantity("m"), "y of the centres of mass, one for all floors or one for each"
    ] = (0.0,)
    lines: Annotated[
        tuple[float, ...], Quantity("m"), "y of the two lines of displacements; empty: the outermost frames"
    ] = ()
    torsional_stiffness: Annotated[
        tuple[float, ...], Quantity("N m/rad"), "what frames across x add in each storey, or one for all"
    ] = (0.0,)
    damping_ratio: Ratio = ()
    method: Method = "modal"
    modes: Annotated[tuple[int, ...], 'the two modes of "rayleigh"'] = (1, 2)
    names: Annotated[tuple[str, ...], "what the lines are called"] = ("left", "right")
    name: str = "torsional building"


UNITS = {"M": Mass.unit, "C": Dashpot.unit, "K": Stiffness.unit}


def load(path: str | Path) -> Building:
    """The structure in a TOML file.

    Storeys have ``masses`` and ``stiffnesses``, one for each from the ground up; other structures have the matrices ``M`` and
    ``K``. Damping is ``dashpots`` of the storeys, or the matrix ``C``, or a ``damping_ratio``, one number or one for each mode,
    with ``method`` "rayleigh" (that of storeys where none is given; of two ``modes``) or "modal" (that of matrices). ``name``;
    with matrices also ``floors`` and ``influence``. Each number may be a text with its unit, ``"26 kN/mm"``, a matrix also a
    table of its ``unit`` and ``values``, or of a ``file`` (text, .npz, .mat); a number without a unit is SI. Files that it
    names lie in its own folder or below it: no other is read.

    Floors that turn have ``inertias`` and ``frames`` beside ``masses``, as `dampyr.structures.torsional_building` takes them.
    Matrices with ``supports`` are a structure on several supports, the last degrees of freedom of K
    (`dampyr.structures.with_supports`). What `save` has written is read to the same bits.

    A plane frame has two tables, ``nodes`` and ``elements`` (`dampyr.structures.plane_frame.read_frame`). It is taken to the
    displacements of its ``floors`` by modes, and so are matrices to the degrees of freedom ``keep``
    (`dampyr.structures.time_history.modal_coordinates`).

    Raises
    ------
    FileError
        It starts with the path: what is not known, with the nearest name; a unit that does not fit; a matrix that is not
        square, not symmetric or not definite.
    MissingData
        There is no such file.
    """
    document = load_toml(path)
    try:
        return structure_of(document, Path(path).parent)
    except FileError:
        raise
    except InputError as problem:
        raise FileError(path, str(problem)) from None


def structure_of(document: Mapping[str, Any], folder: Path | None = None) -> Building:
    """The structure in a table as TOML gives it; its files lie in ``folder`` or below it. :class:`~dampyr.errors.InputError`
    says what is wrong.
    """
    if {"nodes", "elements"} & set(document):
        return _of_frame(fill(Frame, document), folder or Path())
    if "inertias" in document:
        return _of_turning(fill(Turning, document))
    storeys = {field.name for field in fields(Storeys)}
    matrices = {field.name for field in fields(Matrices)} | set(UNITS)
    available = sorted(storeys | matrices | {"nodes", "elements", "frames", "inertias"})
    for key in document:
        if key not in available:
            raise InputError(unknown(key, key, available))
    has_storeys, has_matrices = set(document) & (storeys - matrices), set(document) & (matrices - storeys)
    if has_storeys and has_matrices:
        raise InputError(
            f"{', '.join(sorted(has_storeys))} belong to storeys and {', '.join(sorted(has_matrices))} to matrices; "
            "give masses and stiffnesses, or M and K"
        )
    if not has_storeys and not has_matrices:
        raise InputError(
            "there is no structure; give masses and stiffnesses, the matrices M and K, or nodes and elements"
        )
    if "frames" in document:
        raise InputError(
            "frames belongs to nodes and elements, or to the masses and inertias of floors that turn; leave it out"
        )
    return _of_storeys(fill(Storeys, document)) if has_storeys else _of_matrices(document, folder or Path())


def save(building: Building, path: str | Path) -> Path:
    """Write a structure as a TOML file, which `load` reads to the same numbers, bit by bit.

    Written are its matrices with its labels; of floors that turn their lines, of several supports how the floors follow them.

    Parameters
    ----------
    building
        A `Building`, of `shear_building`, `torsional_building`, `with_supports` or matrices of one's own.
    path
        The file; one that is there is replaced.

    Raises
    ------
    InputError
        The structure was reduced to some of its degrees of freedom, is a half car, or can move without a spring.
    FileError
        The file cannot be written.

    Examples
    --------
    >>> import dampyr as dp
    >>> house = dp.structures.torsional_building([2e4], [4e5], {-5.0: 3e6, 5.0: 5e6}, damping_ratio=0.03)
    >>> same = dp.structures.load(dp.structures.save(house, "house.toml"))
    >>> bool((same.K == house.K).all()), same.lines
    (True, (-5.0, 5.0))
    """
    import tomli_w

    if type(building) not in (Building, TorsionalBuilding, SupportedBuilding):
        raise InputError(
            f"{building.name} is a {type(building).__name__}, of which a file would not keep everything; save the structure "
            "that it was made of"
        )
    document: dict[str, Any] = {"name": building.name, "floors": list(map(str, building.floors))}
    document |= {letter: getattr(building, letter).tolist() for letter in UNITS}
    if isinstance(building, SupportedBuilding):
        document |= {"supports": list(building.supports), "support_influence": building.support_influence.tolist()}
        document |= {"below": list(building.below)}
    elif isinstance(building, TorsionalBuilding):
        document |= {"lines": list(building.lines), "centres": np.asarray(building.centres).tolist()}
    if not isinstance(building, SupportedBuilding):
        document |= {"influence": building.influence.tolist()}
    structure_of(document)  # what cannot be read is not written
    file = Path(path)
    try:
        write_whole(file, tomli_w.dumps(document))
    except OSError as problem:
        raise FileError(file, f"cannot be written ({problem.strerror or problem})") from None
    return file


def _of_turning(table: Turning) -> Building:
    frames = {frame.position: frame.stiffnesses for frame in table.frames}
    if len(frames) < len(table.frames):
        raise InputError("two frames stand at one position; add their stiffnesses up")
    if len(table.names) != 2:
        raise InputError(f"names = {list(table.names)} must be two names, of the two lines")
    return torsional_building(
        table.masses,
        table.inertias,
        frames,
        table.centres,
        table.lines or None,
        table.torsional_stiffness,
        table.damping_ratio or 0.0,
        table.method,
        _pair(table.modes),
        (table.names[0], table.names[1]),
        table.name,
    )


def _of_frame(table: Frame, folder: Path) -> Building:
    if table.frames < 1 or not table.floors or not table.damping_ratio:
        raise InputError("a frame needs frames of at least 1, floors, and a damping_ratio; give all of them")
    frame = read_frame(own_file(folder, table.nodes, "nodes"), own_file(folder, table.elements, "elements"))
    M, K, labels, influence = table.frames * frame.M, table.frames * frame.K, frame.labels, frame.influence
    massive = np.diag(M) > 0.0
    if not np.all(massive):  # what has no mass follows by its springs alone, exactly
        held = K[np.ix_(~massive, ~massive)]
        if np.linalg.eigvalsh(held)[0] <= 1e-12 * np.max(np.abs(K)):
            loose = [label for label, has in zip(labels, massive, strict=True) if not has]
            raise InputError(
                f"what has no mass ({', '.join(loose[:8])}) is not held by springs; give it a mass or an element"
            )
        K = K[np.ix_(massive, massive)] - K[np.ix_(massive, ~massive)] @ np.linalg.solve(
            held, K[np.ix_(~massive, massive)]
        )
        K, M, influence = 0.5 * (K + K.T), M[np.ix_(massive, massive)], influence[massive]
        labels = tuple(label for label, has in zip(labels, massive, strict=True) if has)
    for floor in table.floors:
        if f"{floor} x" not in labels:
            raise InputError(f"floor {floor!r} is not a node with a mass that is free in x; name others in floors")
    ratio = table.damping_ratio
    C = modal(M, K, ratio) if table.method == "modal" else rayleigh(M, K, ratio, _pair(table.modes))
    keep = [labels.index(f"{floor} x") for floor in table.floors]
    return modal_condensation(M, C, K, keep, table.name, labels, influence, table.floors)


def _of_storeys(table: Storeys) -> Building:
    return shear_building(
        table.masses,
        table.stiffnesses,
        table.damping_ratio or None,
        table.dashpots or None,
        table.method,
        table.name,
        _pair(table.modes),
    )


def _of_matrices(document: Mapping[str, Any], folder: Path) -> Building:
    table = fill(Matrices, {key: value for key, value in document.items() if key not in UNITS})
    for key in ("M", "K"):
        if key not in document:
            raise InputError(f"{key} is missing; give it in {UNITS[key]}, a row for each degree of freedom")
    if ("C" in document) == bool(table.damping_ratio):
        raise InputError("matrices take either C or damping_ratio; give one of the two")
    matrices = {key: _matrix(key, document[key], UNITS[key], folder) for key in UNITS if key in document}
    M, C, K = matrices["M"], matrices.get("C"), matrices["K"]
    if table.supports:
        return _on_supports(table, M, C, K)
    for name in ("support_influence", "below"):
        if getattr(table, name):
            raise InputError(
                f"{name} belongs to a structure on several supports; give their names in supports, or leave it out"
            )
    bare = Building(M, np.zeros_like(K), K, table.name)  # checks M and K before a mode is sought
    squared = bare.modes()[0]
    if squared[0] <= 1e-12 * squared[-1]:
        raise InputError(
            "K is not positive definite: the structure can move without a spring; hold every degree of freedom"
        )
    C = _damped(table, bare.M, bare.K) if C is None else C
    if table.lines or table.centres:
        return _on_lines(table, M, C, K)
    whole = Building(M, C, K, table.name, table.floors, table.influence or None)  # type: ignore[arg-type]
    if not table.keep:
        return whole
    if len(set(table.keep)) != len(table.keep) or not all(1 <= count <= whole.n for count in table.keep):
        raise InputError(f"keep = {list(table.keep)} must be different degrees of freedom from 1 to {whole.n}")
    at = [count - 1 for count in table.keep]
    return modal_condensation(whole.M, whole.C, whole.K, at, table.name, tuple(whole.floors), whole.influence)


def _damped(table: Matrices, M: Array, K: Array) -> Array:
    """The damping matrix of the ratios."""
    if table.method == "modal":
        return modal(M, K, table.damping_ratio)
    return rayleigh(M, K, table.damping_ratio, _pair(table.modes))


def _on_supports(table: Matrices, M: Array, C: Array | None, K: Array) -> Building:
    """A structure on several supports: those of K, or with the influence that is stated."""
    for name in ("influence", "keep", "lines", "centres"):
        if getattr(table, name):
            raise InputError(f"{name} is not of a structure on several supports; leave it out")
    n = len(K) if table.support_influence else len(K) - len(table.supports)
    if n < 1:
        raise InputError(
            f"K has {len(K)} rows for {len(table.supports)} supports; it must have those of the floors first, then those "
            "of the supports"
        )
    if C is None:
        C = _damped(table, M[:n, :n], K[:n, :n])
    if not table.support_influence:
        made = with_supports(M, C, K, table.supports, table.floors, table.name)
        return replace(made, below=table.below) if table.below else made
    lengths = sorted({len(row) for row in table.support_influence})
    if len(table.support_influence) != n or lengths != [len(table.supports)]:
        raise InputError(
            f"support_influence has {len(table.support_influence)} rows of {', '.join(map(str, lengths))} numbers; give one of "
            f"{len(table.supports)}, the supports, for each of {n} floors"
        )
    return SupportedBuilding(
        M, C, K, table.name, table.floors, supports=table.supports, support_influence=np.array(table.support_influence),
        below=table.below,
    )  # fmt: skip


def _on_lines(table: Matrices, M: Array, C: Array, K: Array) -> Building:
    """Floors that turn, by their matrices on two lines."""
    if table.keep:
        raise InputError("keep is not of floors that turn; leave it out")
    if len(table.lines) != 2 or table.lines[0] == table.lines[1]:
        raise InputError(f"lines = {list(table.lines)} must be two different positions in m")
    if len(M) % 2 or len(table.centres) != len(M) // 2:
        raise InputError(
            f"floors that turn have two degrees of freedom each and a centre in m; there are {len(M)} and {len(table.centres)}"
        )
    first, second = table.lines
    return TorsionalBuilding(
        M, C, K, table.name, table.floors, table.influence or None,  # type: ignore[arg-type]
        lines=(first, second), centres=np.array(table.centres),
    )  # fmt: skip


def _matrix(key: str, value: Any, si: str, folder: Path) -> Array:
    """A matrix, a diagonal, or a table of both and a unit, or of a file and a unit, in SI."""
    unit = si
    if isinstance(value, Mapping) and "file" in value:
        return _matrix_of_file(key, value, si, folder)
    if isinstance(value, Mapping):
        for name in value:
            if name not in ("unit", "values"):
                raise InputError(unknown(f"{key}.{name}", name, ["unit", "values"]))
        for name in ("unit", "values"):
            if name not in value:
                raise InputError(f'{key}.{name} is missing; write {key} = {{ unit = "{si}", values = [[...], ...] }}')
        unit, value = value["unit"], value["values"]
        if not isinstance(unit, str):
            raise InputError(f'{key}.unit = {unit!r} must be a text such as "{si}"')
    if not isinstance(value, list) or not value:
        raise InputError(f"{key} = {value!r} must be a list of rows, or of the numbers on the diagonal")
    if all(not isinstance(entry, list) for entry in value):
        return np.diag([_number(f"{key}[{i + 1}]", entry, unit, si) for i, entry in enumerate(value)])
    rows = [entry if isinstance(entry, list) else [entry] for entry in value]
    lengths = [len(row) for row in rows]
    if set(lengths) != {len(rows)}:
        raise InputError(f"{key} has {len(rows)} rows of {', '.join(map(str, lengths))} numbers; it must be square")
    return np.array(
        [
            [_number(f"{key}[{i + 1}][{j + 1}]", entry, unit, si) for j, entry in enumerate(row)]
            for i, row in enumerate(rows)
        ]
    )


def own_file(folder: Path, name: str, key: str) -> Path:
    """The file that ``key`` names, in ``folder`` or below it.

    Whoever sends a structure must not be able to have any file of the reader's machine read by it. Links are followed first:
    one that leads out is refused too.
    """
    path = folder / name
    if not path.resolve().is_relative_to(folder.resolve()):
        raise InputError(
            f"{key} = {name!r} leads out of the folder of the structure; only files in that folder or below it are read: "
            "copy the file there"
        )
    return path


def _matrix_of_file(key: str, value: Mapping[str, Any], si: str, folder: Path) -> Array:
    """A matrix, or its diagonal, in a file of text, .npz or .mat, in SI."""
    for name in value:
        if name not in ("file", "unit", "variable"):
            raise InputError(unknown(f"{key}.{name}", name, ["file", "unit", "variable"]))
        if not isinstance(value[name], str):
            raise InputError(f"{key}.{name} = {value[name]!r} must be a text")
    path, variable = own_file(folder, value["file"], f"{key}.file"), value.get("variable", key)
    try:
        array = np.asarray(_content(path, variable), dtype=float)
    except KeyError as problem:
        raise FileError(path, f"holds {problem.args[0]} and no {variable}; name one with {key}.variable") from None
    except OSError as problem:
        raise FileError(path, f"cannot be read ({problem.strerror or problem})") from None
    except (ValueError, TypeError, NotImplementedError) as problem:
        # numpy quotes the text that is not a number: of a message only the place is handed on, not what the file holds.
        place = re.search(r"at row (\d+)(?:, column (\d+))?", str(problem))
        row, column = (place[1], place[2]) if place else ("", "")
        where = f", see row {int(row) + 1}, column {column}" if column else f", see row {row}" if row else ""
        raise FileError(
            path, f"is not a matrix of numbers{where}; give text with a row in each line, .npz, or .mat before v7.3"
        ) from None
    if array.ndim == 2 and 1 in array.shape:
        array = array.ravel()
    if array.ndim == 1:
        array = np.diag(array)
    if array.ndim != 2 or array.shape[0] != array.shape[1]:
        raise FileError(path, f"holds {key} of shape {array.shape}; it must be square, or the numbers on the diagonal")
    try:
        return np.asarray(to_si(array, value.get("unit", si), si), dtype=np.float64)
    except InputError as problem:
        raise InputError(f"{key}.unit: {problem}") from None


def _content(path: Path, variable: str) -> Any:
    """What a file holds: text as one matrix, .npz and .mat by the name of a variable; a KeyError names what there is."""
    if path.suffix.lower() == ".npz":
        with np.load(path, allow_pickle=False) as arrays:
            if variable not in arrays:
                raise KeyError(", ".join(arrays.files) or "nothing")
            return arrays[variable]
    if path.suffix.lower() == ".mat":
        from scipy.io import loadmat

        with warnings.catch_warnings():  # of scipy 1.18: what kind of sparse array comes makes no difference here
            warnings.simplefilter("ignore", DeprecationWarning)
            content = loadmat(path)
        if variable not in content:
            raise KeyError(", ".join(sorted(name for name in content if not name.startswith("__"))) or "nothing")
        array = content[variable]
        return array.toarray() if hasattr(array, "toarray") else array
    text = path.read_text("utf-8")
    return np.loadtxt(text.splitlines(), delimiter="," if "," in text else None, ndmin=2)


def _number(where: str, value: Any, unit: str, si: str) -> float:
    """A number in ``unit``, or a text with a unit of its own, in SI."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise InputError(f'{where} = {value!r} must be a number in {unit}, or a text such as "1 {unit}"')
    try:
        return parse(value, si) if isinstance(value, str) else float(to_si(value, unit, si))
    except InputError as problem:
        raise InputError(f"{where} = {value!r}: {problem}") from None


def _pair(modes: tuple[int, ...]) -> tuple[int, int]:
    if len(modes) != 2:
        raise InputError(f"modes = {list(modes)} must be two modes, such as [1, 2]")
    return modes[0], modes[1]
