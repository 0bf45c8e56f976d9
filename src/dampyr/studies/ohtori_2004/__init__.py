"""The 20-storey benchmark building of Ohtori et al. (2004): its elastic frame, from two tables.

Y. Ohtori, R. E. Christenson, B. F. Spencer, S. J. Dyke, "Benchmark control problems for seismically excited nonlinear
buildings", Journal of Engineering Mechanics 130 (2004). Two frames of 138 nodes and 242 elements each, pinned below two
basement levels and held horizontally at the ground; the floors are rigid horizontally; Rayleigh damping of 2 % in modes 1
and 5. The tables were made from the numbers of the benchmark's published program.

`structure` is the building on its 20 floors, by modes. `STOREY_HEIGHTS` [m] and `FLOOR_MASSES` [kg] are those with which the
benchmark evaluates drift ratios and the base shear. A response's own base shear is that of all that moves, the basement's
floor below the ground level included; the benchmark's is ``FLOOR_MASSES @ response.acceleration``.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dampyr.structures import Building

__all__ = ["FLOOR_MASSES", "STOREY_HEIGHTS", "STRUCTURES", "structure"]

STOREY_HEIGHTS = (5.4864, *(3.9624,) * 19)
"""Heights [m] of the 20 storeys, with which the benchmark evaluates drift ratios."""
FLOOR_MASSES = (563320.0, *(551640.0,) * 18, 583760.0)
"""Masses [kg] of the 20 floors, with which the benchmark evaluates the base shear."""


def structure() -> Building:
    """The building, from its file."""
    from dampyr import structures

    return structures.load(Path(__file__).parent / "structure.toml")


STRUCTURES = {"ohtori_2004": structure}
"""The building, by its name on the command line."""
