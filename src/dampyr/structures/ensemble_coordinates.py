"""The names on the axes of an ensemble: made from its cases, written into its file and read back."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, sa
from dampyr.structures.building import Building
from dampyr.structures.control_law import describe_law, is_control_law
from dampyr.structures.ensemble_grid import AXES, Cases

Array = NDArray[np.float64]
BARE = "no damper"
SA_DAMPING = 0.05
UNIT_OF = {"voltage": "V", "current": "A"}
UNITS = {"displacement": "m", "drift": "m", "acceleration": "m/s^2", "force": "N", "stroke": "m", "energy": "J"}
ALONG = {
    "displacement": "floor",
    "drift": "storey",
    "acceleration": "floor",
    "force": "site",
    "stroke": "site",
    "energy": "site",
}


@dataclass(frozen=True, eq=False)
class Labels:
    """What stands along each axis. ``sa`` is the pseudo-acceleration (building, motion) [m/s2] of each unscaled motion at the
    building's first ``period`` [s] and 5 % damping, ``pga`` (motion,) its peak [m/s2]. ``inputs`` are NaN where there is no
    constant one, ``input_name`` says in words what there is."""

    building: list[str]
    damper: list[str]
    inputs: list[float]
    motion: list[str]
    scale: list[float]
    kind: str
    period: list[float]
    pga: list[float]
    sa: list[list[float]]
    input_name: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, what: Cases) -> Labels:
        """Those of checked cases."""
        periods = [_first_period(building) for building in what.buildings]
        return cls(
            [building.name for building in what.buildings],
            _damper_names(what.placements),
            [u if isinstance(u, float) else float("nan") for u in what.inputs],
            [motion.name for motion in what.motions],
            what.scales.tolist(),
            what.kind,
            periods,
            [motion.pga for motion in what.motions],
            [[_sa(motion, period) for motion in what.motions] for period in periods],
            [_input_name(u, UNIT_OF[what.kind]) for u in what.inputs],
        )

    @property
    def shape(self) -> tuple[int, int, int, int, int]:
        """How many of each, in the order of `AXES`."""
        return len(self.building), len(self.damper), len(self.inputs), len(self.motion), len(self.scale)

    def text(self) -> str:
        """As JSON, for a file; floats come back to the last bit."""
        return json.dumps({each.name: getattr(self, each.name) for each in fields(self)})

    @classmethod
    def read(cls, text: str) -> Labels:
        """From `text`."""
        return cls(**json.loads(text))

    def dataset(self, values: Mapping[str, ArrayLike], attributes: Mapping[str, Any]) -> Any:
        """The labelled peaks; ``values`` quantity -> (lines, scales, width)."""
        import xarray

        data = {
            quantity: (
                (*AXES, ALONG[quantity]),
                np.reshape(array, (*self.shape, np.shape(array)[-1])),
                {"units": UNITS[quantity]},
            )
            for quantity, array in values.items()
        }
        coordinates = self._coordinates()
        for dims, array, _ in data.values():
            coordinates[dims[-1]] = np.arange(1, array.shape[-1] + 1)
        return xarray.Dataset(data, coords=coordinates, attrs=dict(attributes))

    def _coordinates(self) -> dict[str, Any]:
        acceleration = {"units": "m/s^2"}
        return {
            "building_name": ("building", self.building),
            "period": ("building", np.array(self.period), {"units": "s"}),
            "damper_name": ("damper", self.damper),
            "input": ("input", np.array(self.inputs), {"units": UNIT_OF[self.kind]}),
            "input_name": ("input", self.input_name or [_input_name(u, UNIT_OF[self.kind]) for u in self.inputs]),
            "motion_name": ("motion", self.motion),
            "pga": ("motion", np.array(self.pga), acceleration),
            "sa": (("building", "motion"), np.array(self.sa), acceleration | {"damping": SA_DAMPING}),
            "scale": np.array(self.scale),
        }


def _first_period(building: Building) -> float:
    """Infinite where the building floats."""
    lowest = float(building.frequencies[0])
    return 1.0 / lowest if lowest > 0 else float("inf")


def _sa(motion: GroundMotion, period: float) -> float:
    """Not a number where the spectrum does not reach, at periods far below the motion's step or without end."""
    try:
        return sa(motion, period, SA_DAMPING)
    except InputError:
        return float("nan")


def _input_name(u: Any, unit: str) -> str:
    """A number with its unit, a law in words, nothing for the bare building."""
    if is_control_law(u):
        return describe_law(u, unit)
    return "" if u is None or u != u else f"{u:g} {unit}"


def _damper_names(placements: tuple[Mapping[Any, Any], ...]) -> list[str]:
    several = sum(bool(placement) for placement in placements) > 1
    return [BARE if not p else f"damper {k}" if several else "damper" for k, p in enumerate(placements, 1)]
