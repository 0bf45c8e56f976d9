"""How many floating-point operations a core can do, measured: chains of fused multiply-adds that wait for nothing."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from dampyr.structures.batch.branchless_math import BLOCK_WIDTH

CHAINS, LINKS, TURNS = 6, 60, 100


@lru_cache(maxsize=2)
def chains(precision: int) -> Callable[[], Any]:
    """One run of the chains; `operations` says how many they are."""
    from numba import njit

    kind = np.float64 if precision == 64 else np.float32
    names: dict[str, Any] = {}
    exec(_text(), names)
    kernel = njit(names["chains"], fastmath={"contract"}, error_model="numpy")
    block = np.ones(BLOCK_WIDTH * CHAINS, kind)
    return lambda: kernel(TURNS, block, kind(0.999), kind(1e-3))


def operations() -> int:
    """How many floating-point operations one run of the chains makes: two for each link."""
    return 2 * CHAINS * LINKS * BLOCK_WIDTH * TURNS


def _text() -> str:
    """x = x*factor + add, ``LINKS`` times in ``CHAINS`` chains, written out."""
    every = range(CHAINS)
    lines = [f"x{k} = b[{k * BLOCK_WIDTH} + l]" for k in every]
    lines += [f"x{k} = x{k}*factor + add" for _ in range(LINKS) for k in every]
    lines += [f"b[{k * BLOCK_WIDTH} + l] = x{k}" for k in every]
    head = [
        "def chains(turns, b, factor, add):",
        "    for i in range(turns):",
        f"        for l in range({BLOCK_WIDTH}):",
    ]
    return "\n".join(head + ["            " + line for line in lines])


def fastest(run: Callable[[], Any], tries: int) -> float:
    """The shortest time [s] of a run: what the core can do when nothing disturbs it."""
    best = float("inf")
    for _ in range(tries):
        start = time.perf_counter()
        run()
        best = min(best, time.perf_counter() - start)
    return best
