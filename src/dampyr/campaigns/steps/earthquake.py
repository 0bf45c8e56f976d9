r"""Earthquake: the displacement of a ground motion, replayed by the table.

.. math:: x = s \iint a\, dt^2

The acceleration is high-pass filtered forward and backward, its baseline is corrected so that the motion ends at rest where it
began, and it is integrated exactly. A table as small and slow as this one cannot follow most records: with ``fit_limits`` the
plan lowers the scale to the largest that the rig can do, and says so. That is the motion's shape and not its strength; a damper
between two floors also does not feel the ground but the storey's drift.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated, ClassVar, Self

import numpy as np

from dampyr.campaigns.paths import PathPiece, around, driven
from dampyr.campaigns.step import Peaks, Period, Rest, Volts, check_ranges
from dampyr.errors import FileError, MissingData
from dampyr.ground_motions import GroundMotion, corrected, el_centro, filtered, read
from dampyr.ground_motions.intensity_measures import pgd, pgv
from dampyr.rig import Drive, RigSettings
from dampyr.units import Quantity

BUILT_IN = "el_centro"


@dataclass(frozen=True)
class Earthquake:
    """A ground motion as a path."""

    motion: Annotated[str, "ground motion: el_centro, or a file beside the campaign"] = BUILT_IN
    scale: Annotated[float, Quantity("", low=0.0, open_low=True), "factor on the record"] = 1.0
    fit_limits: Annotated[bool, "lower the scale to what the rig can do"] = True
    highpass: Annotated[float, Quantity("Hz", low=0.01, high=5.0), "corner frequency of the high-pass filter"] = 0.2
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0
    rest_before: Annotated[float, Rest, "rest before the motion, recorded so that offsets can be read"] = 2.0
    period: Annotated[float, Period, "time from set point to set point"] = 0.01

    lowers: ClassVar[tuple[str, ...]] = ("scale", "voltage")
    named: ClassVar[tuple[str, ...]] = ("title", "scale", "voltage")
    fixed: ClassVar[bool] = False
    learns: ClassVar[bool] = True
    fits: ClassVar[str] = "scale"

    def __post_init__(self) -> None:
        check_ranges(self)

    @property
    def title(self) -> str:
        """What the motion is called in words and names."""
        return self.motion if self.motion == BUILT_IN else Path(self.motion).stem

    def located_in(self, folder: Path) -> Self:
        """The same step with its file looked for in ``folder``."""
        return self if self.motion == BUILT_IN else replace(self, motion=str(folder / self.motion))

    @property
    def contents(self) -> dict[str, str]:
        """A hash of what is in the motion's file: where the file lies does not change a campaign, what is in it does."""
        if self.motion == BUILT_IN:
            return {}
        try:
            return {"motion": hashlib.sha256(Path(self.motion).read_bytes()).hexdigest()}
        except FileNotFoundError:
            raise MissingData(f"{self.motion}: there is no such file; check motion in the campaign") from None
        except OSError as problem:
            raise FileError(self.motion, f"cannot be read ({problem.strerror}); check the file") from problem

    @property
    def ground(self) -> GroundMotion:
        """The motion as it is replayed, of what is in its file now."""
        return prepared(self.motion, self.highpass, self.contents.get("motion", ""))

    def drive(self, rig: RigSettings) -> Drive:
        """The set points of table and coil: between the motion's samples its displacement is a cubic, taken exactly."""
        ground = self.ground
        piece = PathPiece(ground.duration, lambda t: self.scale * displacement(ground, t))
        return driven(around([piece], 0.0, self.rest_before), self.period, self.voltage)

    def peaks(self, rig: RigSettings) -> Peaks:
        """Those of the ground motion, inside its steps too, times the scale."""
        return Peaks(self.scale * pgd(self.ground), self.scale * pgv(self.ground))


@lru_cache(maxsize=8)
def prepared(motion: str, highpass: float, contents: str = "") -> GroundMotion:
    """The ground motion, filtered, and at rest at its end where it began; ``contents`` tells files of one name apart."""
    raw = el_centro() if motion == BUILT_IN else read(motion)
    return corrected(filtered(raw, low=highpass, keep_pads=False))


def displacement(ground: GroundMotion, t: np.ndarray) -> np.ndarray:
    """The displacement [m] at the times ``t`` [s]."""
    a, h = ground.acceleration, ground.dt
    k = np.clip((t / h).astype(int), 0, ground.n - 2)
    s = t - k * h
    slope = (a[k + 1] - a[k]) / h
    return np.asarray(ground.displacement[k] + s * (ground.velocity[k] + s * (a[k] / 2 + s * slope / 6)))
