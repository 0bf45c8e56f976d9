"""Read latency: the age of samples on the board when they are read, by the host's clock."""

from __future__ import annotations

import math
from dataclasses import dataclass

DRIFT = 2e-4  # s/s by which the clocks of host and board may differ


@dataclass
class Lateness:
    """The age of the latest sample when it is read: its excess over the least that was ever seen.

    The board's clock starts at a moment that the host does not know, so the promptest reading so far counts as prompt. Clocks
    that differ by up to `DRIFT` make nothing late.
    """

    rate: float
    _least: float = math.inf
    _last: float = -math.inf

    def of(self, sample: int, now: float) -> float:
        """s; ``sample`` is the number of the latest one, ``now`` the host's monotonic time [s] right after it was read."""
        age = now - sample / self.rate
        forgiven = self._least + DRIFT * (now - self._last) if math.isfinite(self._least) else math.inf
        self._least, self._last = min(age, forgiven), now
        return age - self._least
