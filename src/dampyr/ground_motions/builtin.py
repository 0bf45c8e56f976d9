"""The ground motion that comes with dampyr."""

from __future__ import annotations

from functools import lru_cache
from importlib.resources import files

import numpy as np

from dampyr.ground_motions.motion import GroundMotion
from dampyr.units import STANDARD_GRAVITY


@lru_cache(maxsize=1)
def el_centro() -> GroundMotion:
    """El Centro 1940, north-south: a zero at t = 0 and the 1559 values of the Peknold/Chopra record,
    0.02 s, 0.31882 g.

    g = 9.80665 m/s2. ``el_centro_1940_ns.csv`` beside this file says where the numbers are from.
    """
    text = (files("dampyr.ground_motions") / "el_centro_1940_ns.csv").read_text(encoding="ascii")
    rows = [line.split(",") for line in text.splitlines() if line and not line.startswith("#")]
    values = np.array([float(row[1]) for row in rows[1:]])
    return GroundMotion(
        acceleration=values * STANDARD_GRAVITY,
        dt=0.02,
        name="El Centro 1940 NS",
        source="Imperial Valley earthquake, 18 May 1940, El Centro, north-south, "
        "Peknold version (Chopra, Dynamics of Structures)",
    )
