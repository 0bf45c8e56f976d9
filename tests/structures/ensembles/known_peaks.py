"""An ensemble of one storey whose peaks, and so whose curves, are known."""

from __future__ import annotations

from typing import Any

import numpy as np

from dampyr.structures.ensembles.store import Labels

SCALES = np.linspace(0.2, 4.0, 20)


def made(capacity: np.ndarray, scales: np.ndarray = SCALES, dampers: tuple[str, ...] = ("damper",), **more: Any) -> Any:
    """An ensemble of one storey whose peak is scale / capacity; ``capacity`` (damper, input, motion)."""
    _, u, m = capacity.shape
    pga = more.get("pga", np.ones(m))
    labels = Labels(
        ["tower"], list(dampers), list(range(u)), [f"motion {k}" for k in range(m)], scales.tolist(), "voltage",
        [0.5], list(pga), [list(pga)],
    )  # fmt: skip
    peaks = scales / capacity[..., None]
    return labels.dataset({"drift": peaks.reshape(-1, len(scales), 1)}, {})


def drawn(motions: int, theta: float = 1.5, beta: float = 0.4, seed: int = 1, draws: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return theta * np.exp(beta * rng.standard_normal((1, 1, motions))) * np.ones((draws, 1, 1))
