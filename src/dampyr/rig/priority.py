"""Priority of a process that must not be late: what reads a rig, and a simulated rig that follows the wall clock."""

from __future__ import annotations

import os
from contextlib import suppress

ROUND_ROBIN = 10  # of 99: above all ordinary processes, below the kernel's own threads
NICE = -10
CONSOLE_NICE = -5


def before_ordinary() -> None:
    """Give this process more of a busy processor than ordinary ones get, where the system allows it: aborts go through it."""
    with suppress(AttributeError, OSError):
        os.setpriority(os.PRIO_PROCESS, 0, CONSOLE_NICE)


def raise_priority() -> str:
    """Run this thread, and those that it starts, before all ordinary ones, as far as the system allows it; how, in words.

    Real-time scheduling (``SCHED_RR``) needs a privilege: that of root, ``CAP_SYS_NICE``, or a line in ``limits.conf`` such
    as ``@lab - rtprio 10``. Without it a better niceness is tried; without that nothing changes, and a host that is busier than
    its cores may make the interlock stop the rig.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(ROUND_ROBIN))
        return "real time"
    except (AttributeError, OSError):  # another system, or not allowed
        pass
    try:
        os.nice(NICE)
        return f"niceness {NICE}"
    except (AttributeError, OSError):
        return "ordinary"
