"""What a building did in an earthquake: histories at the samples of the ground motion, peaks and energies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


_UNITS = {
    "ground_acceleration": ("time", "m/s^2"),
    "displacement": ("floor time", "m"),
    "velocity": ("floor time", "m/s"),
    "acceleration": ("floor time", "m/s^2"),
    "drift": ("storey time", "m"),
    "base_shear": ("time", "N"),
    "force": ("damper time", "N"),
    "input": ("damper time", ""),
    "stroke": ("damper time", "m"),
    "peak_displacement": ("floor", "m"),
    "peak_drift": ("storey", "m"),
    "peak_acceleration": ("floor", "m/s^2"),
    "peak_base_shear": ("", "N"),
    "peak_force": ("damper", "N"),
}  # name -> dims, unit


@dataclass(frozen=True, eq=False)
class Energy:
    """Energies [J] in coordinates relative to the ground, (samples,) each; ``dampers`` is (sites, samples).

    ``residual`` = input - kinetic - strain - viscous - dampers; it is the error of the balance and falls
    with the step.
    """

    input: Array
    kinetic: Array
    strain: Array
    viscous: Array
    dampers: Array

    @property
    def damper(self) -> Array:
        """What all dampers took together, (samples,)."""
        return self.dampers.sum(axis=0)

    @property
    def residual(self) -> Array:
        """What does not add up, (samples,)."""
        return self.input - self.kinetic - self.strain - self.viscous - self.damper


@dataclass(frozen=True, eq=False)
class Response:
    """The response of a building with n floors and N damper sites, T samples.

    Histories stand at the samples of the ground motion. Peaks of displacement and drift are those of the
    motion itself, between samples too; peaks of acceleration, base shear and force are the largest at the
    half steps.
    """

    time: Array  # (T,) s
    ground_acceleration: Array  # (T,) m/s2
    displacement: Array  # (n, T) m, relative to the ground
    velocity: Array  # (n, T) m/s, relative to the ground
    acceleration: Array  # (n, T) m/s2, absolute
    drift: Array  # (n, T) m, storey 1 first
    base_shear: Array  # (T,) N that springs, dashpots and dampers hand to the ground, signed as displacement
    force: Array  # (N, T) N, as applied; positive opposes positive velocity
    stroke: Array  # (N, T) m, what each site's floors move apart
    input: Array  # (N, T) V or A at the coil, as the force of the same sample was made; a jump at a sample acts from there on
    peak_displacement: Array  # (n,) m
    peak_drift: Array  # (n,) m
    peak_acceleration: Array  # (n,) m/s2, absolute
    peak_base_shear: float  # N
    peak_force: Array  # (N,) N
    energy: Energy
    storeys: tuple[int, ...]  # (N,) where the sites are; 0 for one that joins other floors than a storey does
    inputs: tuple[float | None, ...]  # (N,) V or A; None where a law sets it
    floors: tuple[str, ...]
    scheme: str  # "linear" (no damper), "exact path" or "general"
    step: float  # s
    accuracy: float | None  # the change of a peak on halving the step that was asked for; None where the step was given
    error_estimate: (
        float | None
    )  # the largest relative change of a peak in the last halving; None where the step was given
    converged: bool
    reason: str
    title: str = ""
    sites: tuple[str, ...] = ()  # (N,) where the sites are, such as "storey 1" and "0-2"
    laws: tuple[str, ...] = ()  # (N,) what sets the inputs, in words; empty where they are constant
    input_units: tuple[str, ...] = ()  # (N,) "V" or "A"
    outside: tuple[str, ...] = ()  # calibrated limits of displacement and velocity that the motion leaves, in words

    def to_xarray(self) -> Any:
        """The histories and peaks as an ``xarray.Dataset`` with dims time, floor, storey and damper;
        units in ``attrs``."""
        import xarray

        data = {k: (dims.split(), np.asarray(getattr(self, k)), {"units": unit}) for k, (dims, unit) in _UNITS.items()}
        units = set(self.input_units)
        data["input"][2]["units"] = units.pop() if len(units) == 1 else "V or A"
        for part in ("input", "kinetic", "strain", "viscous", "damper", "residual"):
            data[f"energy_{part}"] = (["time"], getattr(self.energy, part), {"units": "J"})
        count = len(self.storeys)
        coordinates = {
            "time": ("time", self.time, {"units": "s"}),
            "floor": list(self.floors),
            "storey": np.arange(1, len(self.floors) + 1),
            "damper": np.arange(1, count + 1),
            "damper_site": ("damper", np.array(self.sites, dtype=str)),
            "damper_storey": ("damper", np.array(self.storeys, dtype=int)),
            "damper_law": ("damper", np.array(self.laws, dtype=str)),
            "damper_input_unit": ("damper", np.array(self.input_units, dtype=str)),
        }
        return xarray.Dataset(data, coords=coordinates, attrs=self._attributes())

    def _attributes(self) -> dict[str, Any]:
        attributes = {
            "scheme": self.scheme,
            "step_s": self.step,
            "converged": int(self.converged),
            "title": self.title,
        }
        if self.error_estimate is not None:
            attributes["error_estimate"] = self.error_estimate
        return attributes
