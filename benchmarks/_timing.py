"""Timing contenders against each other: in turn, round after round, so that what slows the machine slows all of them."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping
from typing import Any

from benchmarks._lines import Line

SHORTEST = 0.02  # s that a measurement lasts at least, by repeating quick contenders


def race(
    contenders: Mapping[str, Callable[[], Any]], errors: Mapping[str, str], rounds: int = 5, budget: float = 15.0
) -> list[Line]:
    """Medians over ``rounds`` in turn; no further round is begun once ``budget`` s are spent. Each runs before."""
    repeats = {name: _repeats(run) for name, run in contenders.items()}
    times: dict[str, list[float]] = {name: [] for name in contenders}
    start = time.perf_counter()
    for _ in range(rounds):
        for name, run in contenders.items():
            times[name].append(_clock(run, repeats[name]))
        if time.perf_counter() - start > budget:
            break
    return [Line(name, statistics.median(t), min(t), len(t), errors.get(name, "")) for name, t in times.items()]


def _repeats(run: Callable[[], Any]) -> int:
    """How often a contender is repeated within one measurement: once it is warm, so that its clock is fine enough."""
    first = _clock(run, 1)
    return 1 if first > 1.0 else max(1, round(SHORTEST / max(_clock(run, 1), 1e-9)))


def _clock(run: Callable[[], Any], repeats: int) -> float:
    start = time.perf_counter()
    for _ in range(repeats):
        run()
    return (time.perf_counter() - start) / repeats
