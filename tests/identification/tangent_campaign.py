"""Campaigns of a hyperbolic tangent with compliance, and of Dahl's model without velocities."""

import numpy as np
from tests.identification.synthetic import sine

from dampyr.models import Damper, Interpolation
from dampyr.records import Record

VOLTS = (0.0, 1.0, 2.0)

NAME = "hyperbolic_tangent"

LAWS = {
    f"{NAME}.c": Interpolation(VOLTS, (700.0, 1200.0, 1700.0)),
    f"{NAME}.ft": Interpolation(VOLTS, (60.0, 210.0, 360.0)),
    f"{NAME}.v0": 0.006,
    f"{NAME}.s": 0.0,
    "compliance.s": 3e-6,
}


def campaign(per_input: int = 4) -> list[Record]:
    truth = Damper(f"{NAME} + compliance", LAWS)
    return [
        sine(truth, u, f"{u:g}V-{k}", 0.004 + 0.002 * k, 1.4 - 0.2 * k, noise=2.0, seed=k)
        for u in VOLTS
        for k in range(per_input)
    ]


def without_velocity(rate: float = 200.0, seconds: float = 45.0) -> list[Record]:
    """Dahl at two voltages, sines of 0.1 to 5 Hz whose displacement alone was recorded."""
    laws = {"dahl.kx": Interpolation((0.0, 2.0), (900.0, 1900.0)), "dahl.kw": Interpolation((0.0, 2.0), (70.0, 300.0))}
    truth = Damper("dahl", laws | {"dahl.rho": 2500.0})
    made = []
    for u in (0.0, 2.0):
        for f in (0.1, 0.7, 5.0):
            t = np.arange(0.0, seconds if f < 1.0 else 8.0, 1.0 / rate)
            run = np.maximum(t - 0.5, 0.0)
            x = 0.006 * np.minimum(run * f, 1.0) * np.sin(2.0 * np.pi * f * run)
            force = truth.force(t, x, voltage=u) + np.random.default_rng(int(10 * f)).normal(100.0, 1.0, t.size)
            made.append(Record(t, x, force, voltage=u, name=f"{u:g}V-{f:g}Hz"))
    return made
