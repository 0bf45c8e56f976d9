"""The frame of the benchmark on its 20 floors, from its files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dampyr.structures import Building

STOREY_HEIGHTS = (5.4864, *(3.9624,) * 19)
"""Heights [m] of the 20 storeys, with which the benchmark evaluates drift ratios."""
FLOOR_MASSES = (563320.0, *(551640.0,) * 18, 583760.0)
"""Masses [kg] of the 20 floors, with which the benchmark evaluates the base shear."""


def structure() -> Building:
    """The building, from its file."""
    from dampyr import structures

    return structures.load(Path(__file__).parent / "structure.toml")
