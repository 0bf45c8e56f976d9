"""What a caller states of a file of a ground motion, which the file does not state itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from dampyr.channel_columns import TextOptions

ACCELERATION = "acceleration"


@dataclass(frozen=True)
class MotionReadOptions(TextOptions):
    """Options of `read`."""

    CHANNELS: ClassVar[Mapping[str, str]] = {"time": "s", ACCELERATION: "m/s^2"}
