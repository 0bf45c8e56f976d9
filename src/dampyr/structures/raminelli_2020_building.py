"""The two buildings of the laboratory, each two storeys."""

from __future__ import annotations

import numpy as np

from dampyr.structures.building import Building
from dampyr.structures.shear import shear_building


def two_storey() -> Building:
    """The two-storey building (5.2), in SI: 145.8 kg floors, 2.0856 and 5.4603 Hz, 3.0 % damping in
    both modes.

    The dissertation prints N s2/mm, N/mm and N s/mm; one of each is 1000 of the SI unit. Source: Raminelli
    2020, eq. (5.2), after Aguirre et al. 2010.
    """
    per_mm = 1000.0
    return Building(
        M=np.array([[0.1458, 0.0], [0.0, 0.1458]]) * per_mm,
        C=np.array([[0.2489, -0.0830], [-0.0830, 0.1659]]) * per_mm,
        K=np.array([[131.1, -65.55], [-65.55, 65.55]]) * per_mm,
        name="two-storey building (5.2)",
    )


def two_storey_model() -> Building:
    """The small two-storey model, light and hardly damped: 24.3 kg floors, 1.687 and 4.626 Hz.

    Storeys of 6820 and 8220 N/m with dashpots of 0.939 and 0.29 N s/m, from the ground up: 0.06 % of
    critical damping in the first mode, so that the dampers do nearly all of it. Source: the later
    two-storey laboratory model of the same group as :func:`two_storey`; the numbers as they were
    passed on, not from a printed page.
    """
    return shear_building([24.3, 24.3], [6820.0, 8220.0], dashpots=[0.939, 0.29], name="two-storey laboratory model")
