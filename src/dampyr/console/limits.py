"""What a process may take that reads or plans for a request: memory, time and output.

The content of a file is unknown until it is read, and a small file can unfold to a large one; so can a campaign of a few lines.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

MIB = 2**20  # bytes
YIELDS = 10  # of niceness: the console may be reading a moving rig at the same time
UNATTENDED = 600  # s of the processor
"""Whoever waits ends it sooner, by the wall clock, unless the console is stopped itself."""
TOO_LONG = "it takes more than the {seconds:g} s that a request may take; {repair}"
TOO_MUCH = "it takes more memory than the {memory:.0f} MiB that a request may take; {repair}"


@dataclass(frozen=True)
class RequestLimits:
    """Of one request: ``memory`` bytes of address space, ``seconds`` of the wall clock, ``written`` bytes.

    ``repair`` says what a person can do where one of them is passed.
    """

    memory: int
    seconds: float
    written: int = 512 * MIB
    repair: str = "request less at once"

    @property
    def too_long(self) -> str:
        """What is said where the time is up."""
        return TOO_LONG.format(seconds=self.seconds, repair=self.repair)

    @property
    def too_much(self) -> str:
        """What is said where the memory is not enough."""
        return TOO_MUCH.format(memory=self.memory / MIB, repair=self.repair)

    def apply(self) -> None:
        """Bound what this process may take, where the system can; the time besides by who waits for it."""
        try:
            import resource
        except ImportError:  # Windows has no such limits
            return
        for what, limit in (
            (resource.RLIMIT_AS, self.memory),
            (resource.RLIMIT_CPU, UNATTENDED),
            (resource.RLIMIT_FSIZE, self.written),
            (resource.RLIMIT_CORE, 0),
        ):
            resource.setrlimit(what, (limit, limit))


def yield_to_rig() -> None:
    """Let this process, of a request or a job, run behind all others, where the system can."""
    if os.name == "posix":
        os.nice(YIELDS)


PLANNING = RequestLimits(1024 * MIB, 30.0, repair="plan fewer or shorter tests at once")
"""400 tests take 300 MiB and 5 s on one core."""
READING = RequestLimits(
    1536 * MIB, 60.0, repair="choose fewer or smaller files, or read them with the command `dampyr records`"
)
"""64 MiB of text take 1 GiB and 20 s."""
LISTING = RequestLimits(1536 * MIB, 60.0, repair="read the file with the command `dampyr records`")
"""For each file of a list."""
