"""What virtual hybrid tests on random plants show."""

from __future__ import annotations

import numpy as np

from dampyr.hybrid.criteria import CRITERIA
from dampyr.hybrid.random_plants import PLANT, BatchResult
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.table import Cell, Table


@describe.register
def describe_batch(batch: BatchResult) -> Description:
    """How many plants are unstable, the worst of them; all criteria in a table."""
    rows = [("plants", str(len(batch.plants))), ("unstable", str(batch.unstable))]
    for name in ("J2", "J4"):
        k, values = batch.worst(name), batch.true[:, CRITERIA.index(name)]
        where = ", ".join(f"{key} {value:.4g}" for key, value in zip(PLANT, batch.plants[k], strict=True))
        rows.append((name, f"median {np.nanmedian(values):.3g} %, worst {values[k]:.3g} % at {where}"))
    return Description(
        f"BatchResult of {batch.name!r}", rows, tables=[lambda: _criteria(batch)], frame=lambda: _plants(batch)
    )


def _criteria(batch: BatchResult) -> Table:
    """Each criterion over the plants."""
    rows: list[list[Cell]] = [
        [name, *(float(f(batch.true[:, k])) for f in (np.nanmedian, lambda v: np.nanquantile(v, 0.95), np.nanmax)),
         batch.worst(name)]
        for k, name in enumerate(CRITERIA)
    ]  # fmt: skip
    return Table(("criterion", "median", "95 %", "worst", "of plant"), rows)


def _plants(batch: BatchResult) -> DataFrameColumns:
    """Plants and criteria, one row a plant."""
    columns = {name: batch.plants[:, k] for k, name in enumerate(PLANT)}
    columns |= {name: batch.true[:, k] for k, name in enumerate(CRITERIA)}
    columns |= {f"{name}_measured": batch.measured[:, k] for k, name in enumerate(CRITERIA[:5])}
    return DataFrameColumns(columns | {"radius": batch.radius, "at_limit": batch.at_limit, "diverged": batch.diverged})
