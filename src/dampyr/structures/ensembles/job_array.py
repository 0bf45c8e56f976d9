"""An ensemble in parts: each computed by a process of its own, on any machine, and put together afterwards.

Part i of n of the same cases is a file in a folder; parts that exist are used, whichever process wrote them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.atomic_write import whole_file
from dampyr.errors import FileError, InputError
from dampyr.records.files.self_contained import check_contained
from dampyr.structures.ensembles.ensemble import Progress, completed, warn_of
from dampyr.structures.ensembles.ensemble_grid import Cases
from dampyr.structures.ensembles.ensemble_result import EnsembleResult
from dampyr.structures.ensembles.ensemble_workers import Workers, telling_of_the_lost
from dampyr.structures.ensembles.store import (
    DIAGNOSTICS,
    FORMAT,
    Labels,
    allocate_dataset,
    attributes,
    describe,
    made_with,
    read_dataset,
)

Array = NDArray[np.float64]
NAME = re.compile(r"part-(\d+)-of-(\d+)\.h5")


def write_part(
    what: Cases,
    part: int,
    parts: int,
    folder: str | Path,
    executor: Workers | None = None,
    progress: Progress | None = None,
) -> Path:
    """Compute one part of an ensemble and write it into a folder, whole or not at all.

    A part that is there already, of the same cases, is left as it is.

    Parameters
    ----------
    what
        The cases of the whole ensemble, from `ensemble_cases`.
    part, parts
        Which part, counted from 1, of how many.
    folder
        Where to; it is made.
    executor
        As in `ensemble`; by default one thread per core.
    progress
        Called with the cases that are done and all of this part.

    Returns
    -------
    Path
        The file of the part.

    Raises
    ------
    InputError
        There is no such part.
    FileError
        The file holds a part of other cases.

    Examples
    --------
    >>> import dampyr as dp
    >>> motions = [dp.ground_motions.kanai_tajimi(5.0, 0.01, seed=(7, k), pga=3.0) for k in range(1, 4)]
    >>> cases = dp.structures.ensemble_cases(dp.structures.two_storey(), motions)
    >>> [dp.structures.write_part(cases, part, 2, "parts").name for part in (1, 2)]
    ['part-1-of-2.h5', 'part-2-of-2.h5']
    >>> dp.structures.collect("parts").dataset.drift.shape
    (1, 1, 1, 3, 1, 2)
    """
    if not 1 <= part <= parts:
        raise InputError(f"part {part}/{parts} does not exist; count from 1 to {parts}")
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"part-{part:0{len(str(parts))}d}-of-{parts}.h5"
    if path.exists():
        with _opened(path) as file:
            if file.attrs.get("digest") != what.digest:
                raise FileError(
                    path, f"is a part of another ensemble{what.other_version}; choose another folder, or remove it"
                )
        return path
    values, diagnostics = _compute(what, part - 1, parts, executor, progress)
    with whole_file(path) as temporary:
        _write(temporary, what, part, parts, values, diagnostics)
    return path


def _compute(
    what: Cases, index: int, parts: int, executor: Workers | None, progress: Progress | None
) -> tuple[dict[str, Array], Array]:
    shards_of_part = max(1, -(-what.shards() // parts))  # shards of a part, which together are exactly its lines
    lines = what.lines_of(index, parts)
    values = {q: np.full((len(lines), len(what.scales), what.width(q)), np.nan) for q in what.quantities}
    diagnostics, done = [], 0
    numbers = list(range(index * shards_of_part, (index + 1) * shards_of_part))
    with (
        telling_of_the_lost(),
        closing(completed(executor, what, shards_of_part * parts, numbers)) as shards,
    ):
        for shard in shards:
            rows = slice(shard.lines.start - lines.start, shard.lines.stop - lines.start)
            for quantity, shard_values in shard.values.items():
                values[quantity][rows] = shard_values
            diagnostics.append([getattr(shard, name) for name in DIAGNOSTICS])
            done += len(shard.lines) * len(what.scales)
            if progress:
                progress(done, len(lines) * len(what.scales))
    return values, np.array(diagnostics, dtype=float)


def _write(path: Path, what: Cases, part: int, parts: int, values: dict[str, Array], diagnostics: Array) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        describe(file, what, Labels.of(what))
        file.attrs["part"], file.attrs["parts"] = part, parts
        file["told"] = diagnostics
        for quantity, array in values.items():
            file[quantity] = array


def collect(folder: str | Path, out: str | Path | None = None) -> EnsembleResult:
    """Put the parts in ``folder`` together: the result of the whole ensemble; with ``out`` written there too.

    Raises :class:`~dampyr.errors.InputError` where parts are missing (it names them) and
    :class:`~dampyr.errors.FileError` for one that does not belong to the first.
    """
    paths = _all_there(Path(folder))
    with _opened(paths[0]) as first:
        digest, labels = first.attrs["digest"], Labels.read(first["labels"].asstr()[()])
        shapes = {str(q): (int(np.prod(labels.shape[:-1])), *first[q].shape[1:]) for q in first.attrs["quantities"]}
        settings = made_with(first, labels)
    for path in paths:
        with _opened(path) as file:
            if file.attrs["digest"] != digest:
                raise FileError(path, f"does not belong to {paths[0].name}: its cases are others; compute it again")
    if out is not None:
        _write_whole(Path(out), paths, shapes)
        dataset = read_dataset(out)
    else:
        values = {quantity: np.empty(shape) for quantity, shape in shapes.items()}
        dataset = labels.dataset(values, attributes(_joined(paths, values), *settings))
    warn_of(dataset)
    return EnsembleResult(dataset)


def _joined(paths: Sequence[Path], values: Mapping[str, Any]) -> Array:
    """Put what the parts hold into ``values`` (arrays or datasets), a part at a time; the diagnostics of all shards."""
    diagnostics, first = [], 0
    for path in paths:
        with _opened(path) as file:
            diagnostics.append(file["told"][:])
            for quantity, all_rows in values.items():
                rows = file[quantity][:]
                all_rows[first : first + len(rows)] = rows
            first += len(rows)
    width = min(table.shape[1] for table in diagnostics)  # parts of an older version have fewer columns
    return np.concatenate([table[:, :width] for table in diagnostics])


def _write_whole(out: Path, paths: Sequence[Path], shapes: Mapping[str, tuple[int, ...]]) -> None:
    """A file as the ensemble itself would have written, for `read_ensemble`."""
    import h5py

    with whole_file(out) as temporary, h5py.File(temporary, "w") as file:
        with _opened(paths[0]) as first:
            for name in ("format", "digest", "quantities", "accuracy", "precision", "after"):
                if name in first.attrs:
                    file.attrs[name] = first.attrs[name]
            file["labels"] = first["labels"].asstr()[()]
            if "findings" in first:
                file["findings"] = first["findings"].asstr()[:]
        diagnostics = _joined(
            paths, {quantity: allocate_dataset(file, quantity, shape) for quantity, shape in shapes.items()}
        )
        file.attrs["shards"] = len(diagnostics)
        file["told"], file["done"] = diagnostics, np.ones(len(diagnostics), dtype=bool)


def _all_there(folder: Path) -> list[Path]:
    named = {path: NAME.fullmatch(path.name) for path in sorted(folder.glob("part-*-of-*.h5"))}
    part_paths = {(int(name[1]), int(name[2])): path for path, name in named.items() if name}
    if not part_paths:
        raise InputError(f"{folder} holds no part of an ensemble; compute them first, each with its own number")
    counts = sorted({parts for _, parts in part_paths})
    if len(counts) > 1:
        raise InputError(
            f"{folder} holds parts of {' and of '.join(map(str, counts))}; keep those of one division and remove the others"
        )
    parts = counts[0]
    missing = [k for k in range(1, parts + 1) if (k, parts) not in part_paths]
    if missing:
        raise InputError(
            f"{folder}: {len(missing)} of {parts} parts are missing: {ranges(missing)}; compute them first"
        )
    return [part_paths[k, parts] for k in range(1, parts + 1)]


def ranges(numbers: Sequence[int]) -> str:
    """Whole rising numbers as people, and the arrays of a batch system, write them: ``1,4-7``."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][1] + 1:
            runs[-1][1] = number
        else:
            runs.append([number, number])
    return ",".join(str(a) if a == b else f"{a}-{b}" for a, b in runs)


def _opened(path: Path) -> Any:
    import h5py

    try:
        file = h5py.File(path, "r")
    except OSError as error:
        raise FileError(
            path, f"cannot be read as a part of an ensemble ({error}); remove it and compute it again"
        ) from None
    try:
        check_contained(path, file)
    except FileError:
        file.close()
        raise
    if file.attrs.get("format") != FORMAT or "part" not in file.attrs:
        file.close()
        raise FileError(path, "is not a part of an ensemble; remove it and compute it again")
    return file
