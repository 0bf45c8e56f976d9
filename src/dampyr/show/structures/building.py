"""What a building shows."""

from __future__ import annotations

import numpy as np

from dampyr.phrases import extent, listing
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.structures.building import Building

FEW = 4  # floors and modes that a short text lists one by one


@describe.register
def describe_building(building: Building) -> Description:
    """Floors, masses and modes."""
    few = building.n <= FEW
    modes = ", ".join(
        f"{f:.4g} Hz ({100 * z:.3g} %)" for f, z in list(zip(building.frequencies, building.damping_ratios))[:FEW]
    )
    masses = np.diag(building.M)
    rows = [
        ("floors", f"{building.n_floors}: {listing([str(f) for f in building.floors])}"),
        ("masses", ", ".join(f"{m:.4g}" for m in masses) + " kg" if few else extent(masses, "kg")),
        ("modes", modes + ("" if few else f" and {building.n - FEW} more")),
    ]
    return Description(f"{type(building).__name__} {building.name!r}", rows, frame=lambda: _columns(building))


def _columns(building: Building) -> DataFrameColumns:
    """The modes: frequency, period and damping ratio, one row a mode."""
    f = building.frequencies
    with np.errstate(divide="ignore"):
        columns = {"frequency_Hz": f, "period_s": 1.0 / f, "damping_ratio": building.damping_ratios}
    return DataFrameColumns(columns, range(1, building.n + 1), "mode")
