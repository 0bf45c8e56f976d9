"""A laboratory with the simulated rig: dampers that its tests should tell, and its settings."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from dampyr.models import Damper, Polynomial
from dampyr.rig import RigSettings

VOLTAGES = (0.0, 0.8712, 1.98, 3.212)
BANDWIDTH = 20.0  # Hz of the velocity


def cubic(*values: float) -> Polynomial:
    """The cubic through these values at the four voltages."""
    coefficients = np.linalg.solve(np.vander(np.array(VOLTAGES), increasing=True), np.array(values))
    return Polynomial(tuple(map(float, coefficients)), VOLTAGES[0], VOLTAGES[-1])


DAHL = Damper(
    "dahl",
    {
        "dahl.kx": cubic(802.0, 1314.0, 2576.0, 5573.0),
        "dahl.kw": cubic(50.2, 209.7, 380.6, 562.0),
        "dahl.rho": cubic(20000.0, 17000.0, 13500.0, 7800.0),
    },
)
HYPERBOLIC_TANGENT = Damper(
    "hyperbolic_tangent",
    {
        "hyperbolic_tangent.c": cubic(800.0, 1300.0, 2500.0, 5500.0),
        "hyperbolic_tangent.ft": cubic(50.0, 210.0, 380.0, 560.0),
        "hyperbolic_tangent.s": 0.0,
        "hyperbolic_tangent.v0": cubic(0.004, 0.004, 0.005, 0.006),
    },
)


def laboratory(folder: Path, damper: Damper, rate: float = 100.0) -> RigSettings:
    """The original rig with this specimen, sampled more slowly than it could be, so that a campaign takes seconds."""
    folder.mkdir(parents=True, exist_ok=True)
    card = damper.save(folder / "specimen.toml")
    settings = RigSettings()
    board = replace(settings.board, rate=rate, block=0.07, velocity_bandwidth=BANDWIDTH)
    return replace(settings, board=board, specimen=replace(settings.specimen, card=str(card), data_sheet=""))
