"""What a building shows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dampyr.phrases import extent, listing
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.structures.building import Building
from dampyr.structures.torsion import TorsionalBuilding
from dampyr.structures.vehicle import HalfCar

Array = NDArray[np.float64]
FEW = 4  # floors and modes that a short text lists one by one


@describe.register
def describe_building(building: Building) -> Description:
    """Floors, masses and modes."""
    masses = np.diag(building.M)
    return _described(building, [("masses", _in_words(masses, "kg"))])


def _in_words(values: Array, unit: str) -> str:
    return ", ".join(f"{value:.4g}" for value in values) + f" {unit}" if len(values) <= FEW else extent(values, unit)


def _described(building: Building, rows: list[tuple[str, str]]) -> Description:
    """Floors, then ``rows``, then modes."""
    few = building.n <= FEW
    modes = ", ".join(
        f"{f:.4g} Hz ({100 * z:.3g} %)" for f, z in list(zip(building.frequencies, building.damping_ratios))[:FEW]
    )
    rows = [
        ("floors", f"{building.n_floors}: {listing([str(f) for f in building.floors])}"),
        *rows,
        ("modes", modes + ("" if few else f" and {building.n - FEW} more")),
    ]
    return Description(f"{type(building).__name__} {building.name!r}", rows, frame=lambda: _columns(building))


@describe.register
def describe_torsional_building(building: TorsionalBuilding) -> Description:
    """Floors, the mass of each that turns, where its lines and centres lie, and modes."""
    pairs = np.asarray(building.M).reshape(building.n // 2, 2, building.n // 2, 2)
    masses = np.array([pairs[k, :, k, :].sum() for k in range(building.n // 2)])
    first, second = building.lines
    rows = [
        ("masses", _in_words(masses, "kg")),
        ("lines", f"at {first:.4g} and {second:.4g} m"),
        ("centres", "at " + _in_words(building.centres, "m")),
    ]
    return _described(building, rows)


@describe.register
def describe_half_car(car: HalfCar) -> Description:
    """Floors, masses, axles, and modes."""
    body = float(np.asarray(car.M)[np.ix_((1, 3), (1, 3))].sum())
    weights = " and ".join(f"{weight:.4g}" for weight in car.static_loads)
    rows = [
        ("masses", f"body {body:.4g}, wheels {car.M[0, 0]:.4g} and {car.M[2, 2]:.4g} kg"),
        (
            "axles",
            f"{car.wheelbase:.4g} m apart, {weights} N on them; centre of mass {car.centre:.4g} m behind the front one",
        ),
    ]
    return _described(car, rows)


def _columns(building: Building) -> DataFrameColumns:
    """The modes: frequency, period and damping ratio, one row a mode."""
    f = building.frequencies
    with np.errstate(divide="ignore"):
        columns = {"frequency_Hz": f, "period_s": 1.0 / f, "damping_ratio": building.damping_ratios}
    return DataFrameColumns(columns, range(1, building.n + 1), "mode")
