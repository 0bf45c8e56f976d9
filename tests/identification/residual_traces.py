"""Residuals of known character along a sine that drifts."""

import numpy as np
from scipy.signal import lfilter

from dampyr.identification.fits.residuals import (
    Trace,
)

DT, F = 0.005, 1.25

N = 8000  # 50 whole periods

T = DT * np.arange(N)

X = 0.01 * np.sin(2 * np.pi * F * T) + 4e-4 * T  # drifts by more than its amplitude

V = 0.01 * 2 * np.pi * F * np.cos(2 * np.pi * F * T)

RNG = np.random.default_rng(7)

NOISE = RNG.normal(0.0, 2.0, N)


def trace(residual: np.ndarray, name: str = "a", u: float = 1.0, **changes: object) -> Trace:
    finite = {"stroke": 0.02, "frequency": F} | changes
    return Trace(name, T, X, V, 100.0 * np.sign(V) + residual, residual, u, **finite)


def ar1(phi: float, sigma: float, n: int = N, seed: int = 3) -> np.ndarray:
    """Noise of standard deviation ``sigma`` with the autocorrelation phi**k."""
    white = np.random.default_rng(seed).normal(0.0, sigma * np.sqrt(1 - phi**2), n + 500)
    return np.asarray(lfilter([1.0], [1.0, -phi], white)[500:])
