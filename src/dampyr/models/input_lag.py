"""The input as it lags behind its command, for the part `lag`."""

from __future__ import annotations

from functools import lru_cache
from math import exp
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.models.codegen.kernels import jit

Array = NDArray[np.float64]


def follow(t, command, tau, out):
    """Fill ``out`` with the first-order lag behind a command that is straight between samples."""
    out[0] = command[0]
    for i in range(1, t.size):
        dt = t[i] - t[i - 1]
        slope = (command[i] - command[i - 1]) / dt
        behind = out[i - 1] - command[i - 1] + slope * tau
        out[i] = command[i] - slope * tau + behind * exp(-dt / tau)


@lru_cache(maxsize=1)
def _compiled() -> Any:
    return jit(follow, keep=True)


def lagged(t: Array, command: Array | float, tau: float) -> Array | float:
    """The input (n,) behind the command (n,), tau in s; a constant command, and tau = 0, is followed at once."""
    if np.ndim(command) == 0 or tau == 0.0:
        return command
    out = np.empty(t.size)
    _compiled()(np.ascontiguousarray(t), np.ascontiguousarray(command, dtype=float), float(tau), out)
    return out
