"""Rising amplitudes: a ladder of strokes, each with its number of cycles, that ends at the largest.

The ladders are those that independent programs hold as FEMA 461's (ten levels, each 1.4 of the one before, two cycles),
ASCE 41's and the modified ATC-24's; the documents themselves were not read, so a ladder is named "as coded".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from dampyr.campaigns.step import Frequency, Length, Volts
from dampyr.config import Choices

LADDERS: dict[str, tuple[tuple[float, int], ...]] = {
    "FEMA 461 as coded": tuple((1.4**k, 2) for k in range(10)),
    "ASCE 41 as coded": tuple(
        zip((0.0025, 0.005, 0.0075, 0.01, 0.015, 0.02, 0.03, 0.04, 0.06), (3, 3, 3, 3, 3, 3, 2, 2, 2), strict=True)
    ),
    "modified ATC-24 as coded": tuple(zip((0.1, 0.2, 0.3, 0.5, 0.7, 1.0), (3, 3, 3, 2, 2, 1), strict=True)),
}
"""Amplitudes in any unit, and cycles; the last amplitude is the largest."""


@dataclass(frozen=True)
class RisingAmplitude:
    """A ladder of amplitudes at one frequency."""

    ladder: Annotated[str, Choices(LADDERS), "ladder of amplitudes and cycles"]
    largest_amplitude: Annotated[float, Length, "amplitude of the last level"]
    frequency: Annotated[float, Frequency, "cycles per second"]
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0

    def steps(self) -> list[dict[str, Any]]:
        """A sine for each level."""
        levels = LADDERS[self.ladder]
        unit = self.largest_amplitude / levels[-1][0]
        same = {"kind": "sine", "frequency": self.frequency, "voltage": self.voltage}
        return [{**same, "amplitude": unit * amplitude, "cycles": cycles} for amplitude, cycles in levels]
