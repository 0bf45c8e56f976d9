"""Memory of this process."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

STATM = Path("/proc/self/statm")


def resident() -> float:
    """MiB of this process that are in memory; a skip where the system does not say."""
    if not STATM.exists():
        pytest.skip("this system does not say how much memory a process has")
    return int(STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20
