"""Time of a simulated rig in real time, shared with the process that reads it.

Such a rig stands for hardware, which waits for nobody; but where the machine is too busy to run the simulation, or the process
that reads it, its clock is held back, and what is late is no fault of the rig's. Its host measures time by that clock.
"""

from __future__ import annotations

import mmap
import struct
import time
from pathlib import Path

LAYOUT = struct.Struct("<dddd")
MAX_HOLD = 1.0  # s of the wall clock: a simulation that does nothing for longer has ended or hangs


class SharedClock:
    """A file of 32 bytes: by how much the clock has been held back [s], when that was written, and both again."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        if not self.path.exists():
            self.path.write_bytes(bytes(LAYOUT.size))
        with self.path.open("r+b") as file:
            self._memory = mmap.mmap(file.fileno(), LAYOUT.size)

    def write(self, held: float, now: float) -> None:
        """Write that the clock has been held back for ``held`` s in all, at ``now`` of the monotonic clock [s]."""
        LAYOUT.pack_into(self._memory, 0, held, now, held, now)

    def _read(self) -> tuple[float, float]:
        while True:
            held, at, again, then = LAYOUT.unpack_from(self._memory)
            if (held, at) == (again, then):  # else it is being written
                return held, at

    @property
    def held(self) -> float:
        """s for which the clock has been held back in all."""
        return self._read()[0]

    def __call__(self) -> float:
        """The monotonic clock less what this one was held back, s; it stands while the simulation does not run."""
        held, at = self._read()
        now = time.monotonic()
        return now - held - (min(max(now - at, 0.0), MAX_HOLD) if at else 0.0)
