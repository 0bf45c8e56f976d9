"""The response spectrum of El Centro 1940, against numpy over all periods at once and scipy's lsim, at the samples."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.ground_motions import el_centro, spectrum

Array = NDArray[np.float64]

PERIODS = np.linspace(0.05, 5.0, 100)
DAMPING = 0.05
TITLE = "Response spectrum of El Centro 1940, 100 periods from 0.05 to 5 s, 5 %: peak displacements"


def run(data: Path | None) -> list[Line]:
    """dampyr with the peaks inside the steps and at the samples; the peers' errors are against the former."""
    contenders: dict[str, Callable[[], Array]] = {
        "dampyr, peaks inside the step": lambda: spectrum(el_centro(), PERIODS, DAMPING).displacement,
        "dampyr, at the samples": lambda: spectrum(el_centro(), PERIODS, DAMPING, sampled=True).displacement,
        "numpy, all periods in step": textbook,
        "scipy, lsim for each period": by_lsim,
    }
    true = contenders["dampyr, peaks inside the step"]()
    errors = {name: f"{100 * np.max(1 - of() / true):.2g} % short at most" for name, of in contenders.items()}
    return race(contenders, errors, rounds=3)


def textbook() -> Array:
    """Nigam and Jennings with the coefficients as printed in textbooks, the largest sample."""
    motion, z = el_centro(), DAMPING
    a, h = motion.acceleration, motion.dt
    w = 2 * np.pi / PERIODS
    d, e = w * np.sqrt(1 - z**2), np.exp(-z * w * h)
    s, c = np.sin(d * h), np.cos(d * h)
    root = np.sqrt(1 - z**2)
    A, B = e * (z / root * s + c), e * s / d
    C = (2 * z / (w * h) + e * (((1 - 2 * z**2) / (d * h) - z / root) * s - (1 + 2 * z / (w * h)) * c)) / w**2
    D = (1 - 2 * z / (w * h) + e * ((2 * z**2 - 1) / (d * h) * s + 2 * z / (w * h) * c)) / w**2
    A1, B1 = -e * w / root * s, e * (c - z / root * s)
    C1 = (-1 / h + e * ((w / root + z / (h * root)) * s + c / h)) / w**2
    D1 = (1 - e * (z / root * s + c)) / (w**2 * h)
    u, v, peak = np.zeros_like(w), np.zeros_like(w), np.zeros_like(w)
    for p, q in zip(-a[:-1], -a[1:], strict=True):
        u, v = A * u + B * v + C * p + D * q, A1 * u + B1 * v + C1 * p + D1 * q
        np.maximum(peak, np.abs(u), out=peak)
    return peak


def by_lsim() -> Array:
    """scipy's linear simulation, its input linear between samples too, the largest sample."""
    from scipy.signal import lsim

    motion = el_centro()
    omegas = 2 * np.pi / PERIODS
    systems = (([-1.0], [1.0, 2 * DAMPING * w, w * w]) for w in omegas)
    return np.array([np.abs(lsim(each, motion.acceleration, motion.time)[1]).max() for each in systems])
