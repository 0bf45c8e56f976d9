"""Peaks of an ensemble as pelicun and the tools of SimCenter read them: a table for each building, damper and input.

A row is a realisation, a motion at a scale; a column is called ``event-demand-location-direction``:

- ``1-PFA-0-1``, peak acceleration of the ground, and ``1-PFA-k-1`` of floor k, absolute, m/s2 (``mps2``),
- ``1-PID-k-1``, peak drift of storey k over its height (``rad``),
- ``1-PFD-k-1``, peak displacement of floor k against the ground, m.

The first row of a file, ``Units``, names the units. The direction is 1, the only one.

Source: NHERI SimCenter, documentation of the PBE application, "Standard Format for Demand Data", and the units that pelicun 3
knows (settings/default_units.json).
"""

from __future__ import annotations

import itertools
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from dampyr.atomic_write import write_whole
from dampyr.errors import InputError
from dampyr.phrases import counted
from dampyr.source_digest import full_version
from dampyr.structures.ensembles.store import BARE, origin_of
from dampyr.structures.time_history.peaks import storey_heights

ABOUT = "about.txt"
UNITS = {"PFA": "mps2", "PID": "rad", "PFD": "m"}
DIMS = ("building", "damper", "input")
QUANTITIES = {"acceleration": "PFA", "drift": "PID", "displacement": "PFD"}


def demand_tables(dataset: Any, height: ArrayLike) -> dict[str, Any]:
    """The tables (`pandas.DataFrame`, SI) by what they are of, such as "no damper" or "1.98 V".

    ``height`` of the storeys in m, one or one each. Cases without a peak, such as those whose motion grew beyond bounds, are
    left out; ``attrs["left_out"]`` of a table counts them.

    Raises :class:`~dampyr.errors.InputError` for a height that is not above 0, and where the ensemble has no drifts and
    accelerations.

    >>> import dampyr as dp
    >>> result = dp.structures.ensemble(dp.structures.two_storey(), dp.ground_motions.el_centro(), scales=[0.5, 1.0])
    >>> [table] = dp.structures.demand_tables(result.dataset, height=3.0).values()
    >>> list(table)
    ['1-PFA-0-1', '1-PFA-1-1', '1-PFA-2-1', '1-PID-1-1', '1-PID-2-1', '1-PFD-1-1', '1-PFD-2-1']
    """
    import pandas as pd

    missing = [name for name in ("acceleration", "drift") if name not in dataset]
    if missing:
        raise InputError(f"this ensemble has no {' and no '.join(missing)}; compute it with these quantities")
    heights = storey_heights(height, dataset.sizes["storey"])
    tables: dict[str, Any] = {}
    for place in itertools.product(*(range(dataset.sizes[dim]) for dim in DIMS)):
        case = dataset.isel(dict(zip(DIMS, place, strict=True)))
        columns = {"1-PFA-0-1": np.outer(np.asarray(case.pga), np.abs(np.asarray(case.scale))).ravel()}
        for quantity, demand in QUANTITIES.items():
            if quantity in case:
                peaks = np.asarray(case[quantity], float) / (heights if quantity == "drift" else 1.0)
                columns |= {f"1-{demand}-{k}-1": row for k, row in enumerate(peaks.reshape(-1, peaks.shape[-1]).T, 1)}
        # a building of fewer storeys than another one has none of the upper ones
        table = pd.DataFrame(columns).dropna(axis="columns", how="all")
        whole = table[np.isfinite(table).all(axis="columns")].reset_index(drop=True)
        whole.attrs["left_out"] = len(table) - len(whole)
        name = _name(dataset, case)
        if str(np.asarray(case.damper_name)) == BARE and place[DIMS.index("input")]:
            continue  # without a damper every input is the same
        if name in tables:  # two buildings of one name
            name = f"{name} ({sum(other.startswith(name) for other in tables) + 1})"
        tables[name] = whole
    return tables


def _name(dataset: Any, case: Any) -> str:
    """What a table is of: what differs between the tables, and the damper where nothing does."""
    names = {dim: str(np.asarray(case[f"{dim}_name"])) for dim in DIMS}
    bare = names["damper"] == BARE
    told = [
        name
        for dim, name in names.items()
        if (dataset.sizes[dim] > 1 and not (bare and dim == "input")) or (dim == "damper" and bare)
    ]
    return ", ".join(told) or names["damper"]


def write_demands(dataset: Any, height: ArrayLike, folder: str | Path) -> list[Path]:
    """Write `demand_tables` as ``.csv`` files, named after what they are of, and return their paths.

    The format has no place for remarks: ``about.txt``, the last path, says what the dampers' origin is and how many cases of
    each file are left out.
    """
    paths = []
    about = [f"dampyr {full_version()}", *filter(None, [origin_of(dataset).notice])]
    for name, table in demand_tables(dataset, height).items():
        units = [UNITS[label.split("-")[1]] for label in table]
        rows = [",".join(["", *table]), ",".join(["Units", *units])]
        rows += [",".join([str(k), *map(repr, map(float, row))]) for k, row in enumerate(table.to_numpy())]
        path = Path(folder) / f"demands_{re.sub(r'[^A-Za-z0-9.]+', '_', name).strip('_')}.csv"
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, "\n".join(rows) + "\n")
        paths.append(path)
        left_out = table.attrs["left_out"]
        told = f", {counted(left_out, 'case')} without a peak left out" if left_out else ""
        about.append(f"{path.name}: {counted(len(table), 'realisation')} of {name}{told}")
    write_whole(Path(folder) / ABOUT, "\n".join(about) + "\n")
    return [*paths, Path(folder) / ABOUT]
