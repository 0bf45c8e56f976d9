"""Priority of a process that must not be late: what reads a rig, and a simulated rig that follows the wall clock."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from typing import Any

ROUND_ROBIN = 10  # of 99: above all ordinary processes, below the kernel's own threads
NICE = -10
CONSOLE_NICE = -5
HIGH_PRIORITY_CLASS, ABOVE_NORMAL_PRIORITY_CLASS = 0x80, 0x8000  # of SetPriorityClass
TICK = 1  # ms of Windows' timers; 15.6 ms unless a process asks for less


def before_ordinary() -> None:
    """Give this process more of a busy processor than ordinary ones get, where the system allows it: aborts go through it."""
    if sys.platform == "win32":
        set_priority_class(ABOVE_NORMAL_PRIORITY_CLASS)
        return
    with suppress(AttributeError, OSError):
        os.setpriority(os.PRIO_PROCESS, 0, CONSOLE_NICE)


def raise_priority() -> str:
    """Run this thread, and those that it starts, before all ordinary ones, as far as the system allows it; how, in words.

    Real-time scheduling (``SCHED_RR``) needs a privilege: that of root, ``CAP_SYS_NICE``, or a line in ``limits.conf`` such
    as ``@lab - rtprio 10``. Without it a better niceness is tried; without that nothing changes, and a host that is busier than
    its cores may make the interlock stop the rig. On Windows the process gets the class "high", which needs no privilege, and
    its timers a tick of a millisecond.
    """
    if sys.platform == "win32":
        return _raise_on_windows()
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


def _raise_on_windows() -> str:
    """The class of the process and the tick of its timers; Windows takes the tick back when the process ends."""
    priority = "class high" if set_priority_class(HIGH_PRIORITY_CLASS) else "ordinary"
    return f"{priority}, timers of {f'{TICK} ms' if shorten_tick() else 'the usual tick'}"


def set_priority_class(priority_class: int) -> bool:
    """Give this process a priority class (``SetPriorityClass`` of kernel32); whether Windows did."""
    from ctypes import wintypes

    kernel = _library("kernel32")
    kernel.GetCurrentProcess.restype = wintypes.HANDLE  # a handle is as wide as a pointer, and -1 here
    kernel.SetPriorityClass.argtypes = [wintypes.HANDLE, wintypes.DWORD]
    return bool(kernel.SetPriorityClass(kernel.GetCurrentProcess(), priority_class))


def shorten_tick() -> bool:
    """Ask for timers of `TICK` ms for this process (``timeBeginPeriod`` of winmm); whether Windows granted it."""
    return int(_library("winmm").timeBeginPeriod(TICK)) == 0  # TIMERR_NOERROR


def _library(name: str) -> Any:
    """A library of Windows."""
    import ctypes

    return ctypes.WinDLL(name, use_last_error=True)  # type: ignore[attr-defined,unused-ignore]
