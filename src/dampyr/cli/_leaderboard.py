"""How many cores the leaderboard takes on the command line."""

from __future__ import annotations

import os

MAX_WORKERS = 8  # each process compiles the models of its own trials, which more of them would only repeat


def cores() -> int:
    """How many processes may share the trials: one for each core, up to `MAX_WORKERS`."""
    available = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(available, MAX_WORKERS)
