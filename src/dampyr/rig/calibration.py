"""Calibration: from volts and counts to newtons and metres, and the measurement of the load cell's scale.

Two points: the volts without load and under a known force. Shunt: a resistor across one arm of the bridge unbalances it as a
known force would, without a weight.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from math import pi, sqrt
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tomli_w
from numpy.typing import NDArray

from dampyr.atomic_write import write_whole
from dampyr.config import fill, load_toml
from dampyr.errors import FileError, InputError
from dampyr.rig.settings import LoadCell, RigSettings
from dampyr.shown import Shown
from dampyr.units import Quantity

Array = NDArray[np.float64]
MEASURED = ("bandwidth", "gain", "resistance", "inductance")  # values that may be absent, with their uncertainty
SPREAD = 0.02  # by which a measured scale may differ from the one before without a warning


@dataclass(frozen=True, repr=False)
class Calibration(Shown):
    """force = scale*(volts - zero) [N], displacement = count*(counts + 1/2 - middle) [m], temperature = slope*volts + base.

    ``noise`` is the force's at rest, rms; ``bandwidth`` that of the load cell's amplifier; ``gain`` the supply's, volts at the
    coil per volt of command; ``resistance`` (at 20 degC) and ``inductance`` the coil's. Each may come with its standard
    uncertainty, and is None where it was not measured: then the rig's settings hold.
    """

    scale: Annotated[float, Quantity("N/V")]
    zero: Annotated[float, Quantity("V")]
    count: Annotated[float, Quantity("m", low=0.0, open_low=True)]
    middle: Annotated[float, Quantity("")] = 0.0
    slope: Annotated[float, Quantity("K/V")] = 100.0
    base: Annotated[float, Quantity("degC")] = 0.0
    how: str = "from the rig's settings"
    scale_uncertainty: Annotated[float | None, Quantity("N/V", low=0.0)] = None
    zero_uncertainty: Annotated[float | None, Quantity("V", low=0.0)] = None
    noise: Annotated[float | None, Quantity("N", low=0.0)] = None
    bandwidth: Annotated[float | None, Quantity("Hz", low=0.0, open_low=True)] = None
    bandwidth_uncertainty: Annotated[float | None, Quantity("Hz", low=0.0)] = None
    gain: Annotated[float | None, Quantity("V/V", low=0.0, open_low=True)] = None
    gain_uncertainty: Annotated[float | None, Quantity("V/V", low=0.0)] = None
    resistance: Annotated[float | None, Quantity("ohm", low=0.0, open_low=True)] = None
    resistance_uncertainty: Annotated[float | None, Quantity("ohm", low=0.0)] = None
    inductance: Annotated[float | None, Quantity("H", low=0.0)] = None
    inductance_uncertainty: Annotated[float | None, Quantity("H", low=0.0)] = None

    def __post_init__(self) -> None:
        if self.scale == 0.0:
            raise InputError("scale = 0 N/V is not allowed; it must not be 0: no force would show")
        for name in MEASURED:
            if getattr(self, name) is None and getattr(self, f"{name}_uncertainty") is not None:
                raise InputError(
                    f"{name}_uncertainty = {getattr(self, f'{name}_uncertainty'):g} is not allowed without {name}; give both, "
                    "or neither"
                )

    def force(self, volts: Array) -> Array:
        """N."""
        return self.scale * (volts - self.zero)

    def displacement(self, counts: NDArray[np.int64]) -> Array:
        """m from the middle of the stroke: the middle of each count."""
        return self.count * (counts.astype(np.float64) + 0.5 - self.middle)

    def temperature(self, volts: Array) -> Array:
        """degC."""
        return self.slope * volts + self.base

    def corrected(self, rig: RigSettings) -> RigSettings:
        """The settings with what was measured in the place of what was assumed, and its uncertainty; where nothing was
        measured, with that of a certificate."""
        cell: dict[str, Any] = {}
        supply: dict[str, Any] = {}
        encoder: dict[str, Any] = {}
        if (certified := rig.certificates.standard("load_cell")) is not None:
            cell["scale_uncertainty"] = certified
        if (certified := rig.certificates.standard("coil_voltage")) is not None:
            supply["reading_uncertainty"] = certified
        if (certified := rig.certificates.standard("encoder")) is not None:
            encoder["accuracy"] = sqrt(3.0) * certified  # which is a limit
        if self.scale_uncertainty is not None:
            cell["scale_uncertainty"] = self.scale_uncertainty / abs(self.scale)
        if self.zero_uncertainty is not None:
            cell["zero_uncertainty"] = self.zero_uncertainty * abs(self.scale)
        if self.noise is not None:
            cell["noise"] = self.noise
        if self.bandwidth is not None:
            relative = (self.bandwidth_uncertainty or 0.0) / self.bandwidth
            cell |= {"bandwidth": self.bandwidth, "delay_uncertainty": relative / (2.0 * pi * self.bandwidth)}
        for name in ("gain", "resistance"):
            value, uncertainty = getattr(self, name), getattr(self, f"{name}_uncertainty")
            if value is not None:
                supply |= {name: value, f"{name}_uncertainty": (uncertainty or 0.0) / value}
        if self.inductance is not None:
            supply["inductance"] = self.inductance
        return replace(
            rig,
            load_cell=replace(rig.load_cell, **cell),
            supply=replace(rig.supply, **supply),
            encoder=replace(rig.encoder, **encoder),
        )

    def zeroed(self, volts: float) -> Calibration:
        """The same with these volts at no force."""
        return replace(self, zero=volts)


NAME = "calibration.toml"


def save_calibration(calibration: Calibration, folder: str | Path, metadata: Mapping[str, str] | None = None) -> Path:
    """Write ``calibration.toml`` into the folder of a ``rig.toml``, whole or not at all; ``metadata`` is kept beside it."""
    path = Path(folder) / NAME
    numbers = {
        key: value for key, value in asdict(calibration).items() if key != "middle" and value is not None
    }  # homing finds the middle each time
    write_whole(path, tomli_w.dumps({"calibration": numbers, "told": dict(metadata or {})}))
    return path


def load_calibration(folder: str | Path) -> Calibration | None:
    """The calibration beside a ``rig.toml``; None where there is none, :class:`FileError` where it is wrong."""
    path = Path(folder) / NAME
    if not path.is_file():
        return None
    try:
        return fill(Calibration, load_toml(path).get("calibration", {}), "calibration")
    except FileError:
        raise
    except InputError as problem:
        raise FileError(path, str(problem)) from None


def calibration_of(rig: RigSettings) -> Calibration:
    """The calibration of the settings."""
    return Calibration(rig.load_cell.scale, rig.load_cell.zero, rig.encoder.count)


def two_point(zero: float, loaded: float, force: float) -> float:
    """N/V: ``force`` [N] changed the volts from ``zero`` to ``loaded``; :class:`InputError` where they hardly differ."""
    if abs(loaded - zero) < 0.01:
        raise InputError(
            f"the load of {force:g} N changed the signal by {abs(loaded - zero) * 1e3:.2g} mV only; it must be 10 mV or "
            "more: check the cell's wires, or take a heavier load"
        )
    return force / (loaded - zero)


def shunt_force(cell: LoadCell, resistor: float) -> float:
    r"""The force [N] that a shunt ``resistor`` [ohm] across one arm of the full bridge simulates.

    .. math:: \frac{\Delta U}{U} = \frac{R_b}{4 R_s + 2 R_b}, \qquad F = \frac{\Delta U/U}{S} F_n

    with the arm R_b, the shunt R_s and the sensitivity S [V/V] at the capacity F_n.
    """
    if not resistor > 0.0:
        raise InputError(f"shunt = {resistor:g} ohm is not allowed; it must be greater than 0")
    return cell.bridge / (4.0 * resistor + 2.0 * cell.bridge) / cell.sensitivity * cell.capacity


def shunt_point(cell: LoadCell, resistor: float, zero: float, shunted: float) -> float:
    """N/V from a shunt ``resistor`` [ohm] that changed the volts from ``zero`` to ``shunted``."""
    return two_point(zero, shunted, shunt_force(cell, resistor))


def doubt(scale: float, before: float) -> str:
    """A sentence where a new scale is far from the one before; empty where it is not."""
    change = scale / before - 1.0
    if abs(change) <= SPREAD:
        return ""
    return (
        f"the scale {scale:.4g} N/V differs from {before:.4g} N/V by {change:+.1%}; check the cell and its load, and calibrate "
        "it again if they are not right"
    )
