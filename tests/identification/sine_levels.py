"""Levels of sines for tests of what cuts and judges cycles."""

import numpy as np

RATE = 500.0  # samples a second


def motion(*levels: tuple[float, float, int], taper: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Time and displacement of sines of so many m, Hz and cycles, one after another, between rests; with ``taper`` the first
    grows over a cycle and the last one fades."""
    parts = []
    for amplitude, frequency, cycles in levels:
        phase = np.arange(0.0, cycles, frequency / RATE)
        parts.append(amplitude * np.sin(2.0 * np.pi * phase))
    x = np.concatenate(parts)
    if taper:
        from_ends = np.arange(x.size) * np.arange(x.size)[::-1] / x.size
        x = x * np.sin(0.5 * np.pi * np.clip(from_ends / (RATE / levels[0][1]), 0.0, 1.0)) ** 2
    still = np.zeros(round(2.0 * RATE))
    x = np.concatenate([still, x, still])
    return np.arange(x.size) / RATE, x


def force_of(time: np.ndarray, x: np.ndarray) -> np.ndarray:
    velocity = np.gradient(x, time)
    return 300.0 * np.tanh(velocity / 2e-3) + 3000.0 * velocity
