"""Memory of this process, and of those that it has started."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

PROC = Path("/proc")


def resident(pid: int | None = None) -> float:
    """MiB of a process, or of this one, that are in memory; a skip where the system does not say."""
    statm = PROC / (str(pid) if pid else "self") / "statm"
    if not statm.exists():
        pytest.skip("this system does not say how much memory a process has")
    return int(statm.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


def descendants(pid: int | None = None) -> list[int]:
    """The processes that a process, or this one, has started, and those that these have."""
    tasks = (PROC / str(pid or os.getpid()) / "task").glob("*/children")
    children = [int(child) for task in tasks for child in task.read_text().split()]
    return [*children, *(each for child in children for each in descendants(child))]
