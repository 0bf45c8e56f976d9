"""Synthetic tests with known truth."""

import numpy as np

from dampyr.models import Damper
from dampyr.records import Record

DAHL = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})


def sine(
    damper: Damper,
    voltage: float,
    name: str = "test",
    amplitude: float = 0.01,
    frequency: float = 1.0,
    noise: float = 0.0,
    offset: float = 120.0,
    w0: float | None = None,
    seed: int = 0,
    seconds: float = 6.0,
) -> Record:
    """A sine after half a second of rest, its amplitude growing over the first cycle."""
    t = np.arange(0.0, seconds, 0.005)
    run = np.maximum(t - 0.5, 0.0)
    x = amplitude * np.minimum(run * frequency, 1.0) * np.sin(2 * np.pi * frequency * run)
    v = np.gradient(x, t)
    states = None if w0 is None else np.full(damper.composition.n_states, w0)
    force = damper.force(t, x, voltage=voltage, velocity=v, state0=states)
    rng = np.random.default_rng(seed)
    return Record(
        time=t,
        displacement=x,
        velocity=v,
        force=force + offset + rng.normal(0.0, noise, t.size) if noise else force + offset,
        voltage=voltage,
        name=name,
    )
