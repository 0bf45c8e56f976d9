"""The files of a laboratory that does not know dampyr: thirty sines at five currents, and two motions like an earthquake's."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from dampyr.models import Damper, Polynomial

Array = np.ndarray
CURRENTS = (0.0, 0.25, 0.5, 1.0, 1.5)
MOTIONS = ((25.0, 0.1), (15.0, 0.5), (10.0, 1.0), (5.0, 2.0), (3.0, 3.5), (2.0, 5.0))
HEADER = "Time\tDisplacement\tVelocity\tForce\tCurrent"
UNITS = {"time": "s", "displacement": "mm", "velocity": "mm/s", "force": "N", "current": "A"}
READING = """\
validation = ["earthquake*"]

[units]
time = "s"
displacement = "mm"
velocity = "mm/s"
force = "N"
current = "A"
"""


def specimen() -> Damper:
    """What stands in the rig: hysteresis and friction that no fit of the story has, behind a clevis that gives way."""
    over = (0.0, 1.5)
    laws = {
        "bouc_wen.c0": Polynomial((250.0, 500.0, -80.0), *over),
        "bouc_wen.k0": Polynomial((400.0, 150.0), *over),
        "bouc_wen.kw": Polynomial((15.0, 110.0, -20.0), *over),
        "bouc_wen.rho": Polynomial((3000.0, -600.0), *over),
        "bouc_wen.sigma": Polynomial((0.8,), *over),
        "bouc_wen.n": Polynomial((1.6,), *over),
        "hyperbolic_tangent.ft": Polynomial((30.0, 520.0, -80.0), *over),
        "hyperbolic_tangent.v0": Polynomial((0.010, 0.006), *over),
        "hyperbolic_tangent.c": Polynomial((0.0,), *over),
        "hyperbolic_tangent.s": Polynomial((0.0,), *over),
        "offset.f0": Polynomial((45.0,), *over),
        "compliance.s": Polynomial((5e-7,), *over),
    }
    return Damper("bouc_wen + hyperbolic_tangent + offset + compliance", laws, input="A")


def columns(t: Array, x: Array, current: float, rng: np.random.Generator) -> Array:
    """One test as its rig measures it: mm, mm/s, N with noise and the load cell's steps of 0.5 N, A with noise and a zero."""
    fine = np.linspace(t[0], t[-1], 4 * (t.size - 1) + 1)
    x_fine = np.interp(fine, t, x)
    v = np.gradient(x, t)
    force = specimen().force(fine, x_fine, velocity=np.interp(fine, t, v), current=current)[::4]
    force = 0.5 * np.round((force + rng.normal(0.0, 3.0, t.size)) / 0.5)
    measured = (
        current * (1.0 + rng.normal(0.0, 1e-3)) - (0.014 if current == 0 else 0.0) + rng.normal(0.0, 0.006, t.size)
    )
    return np.column_stack([t, 1e3 * x, 1e3 * v, force, measured])


def sine(amplitude: float, frequency: float) -> tuple[Array, Array]:
    """Time (s) and displacement (m) at 500 Hz, of 6 s or three cycles if that is more; ``amplitude`` in mm."""
    t = np.arange(0.0, max(6.0, 3.0 / frequency), 0.002)
    return t, 1e-3 * amplitude * np.sin(2.0 * np.pi * frequency * t)


def earthquake(seed: int) -> tuple[Array, Array]:
    """Filtered noise under an envelope, 18 mm at its peak, 15 s."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 15.0, 0.002)
    frequency = np.geomspace(0.15, 4.0, 60)
    waves = np.sin(2.0 * np.pi * np.outer(t, frequency) + rng.uniform(0.0, 2.0 * np.pi, 60)) / frequency
    x = waves.sum(axis=1) * np.minimum(1.0, t / 3.0) ** 2 * np.exp(-np.maximum(0.0, t - 9.0) / 4.0)
    return t, 18e-3 * x / np.abs(x).max()


def text(rows: Array, header: str = HEADER, delimiter: str = "\t", end: str = "\n") -> str:
    """Rows as that laboratory's program writes them."""
    lines = [delimiter.join(f"{value:.{k}f}" for value, k in zip(row, (4, 4, 3, 1, 4), strict=True)) for row in rows]
    return end.join([header, *lines]) + end


def write_laboratory(folder: Path, motions: Sequence[tuple[float, float]] = MOTIONS) -> Path:
    """All files of the laboratory, or those of some motions, and a note that somebody left among them."""
    rng = np.random.default_rng(11)
    folder.mkdir()
    for current in CURRENTS:
        for amplitude, frequency in motions:
            rows = columns(*sine(amplitude, frequency), current, rng)
            (folder / f"sine_{amplitude:g}mm_{frequency:g}Hz_{current:g}A.txt").write_text(text(rows))
    for seed, current in ((1, 0.7), (2, 1.2)):
        (folder / f"earthquake_{current:g}A.txt").write_text(text(columns(*earthquake(seed), current, rng)))
    (folder / "README.txt").write_text("Damper no. 3, tested in May.\n2 operators, oil at 23 degC.\n")
    return folder
