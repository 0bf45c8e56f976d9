"""Control of Python's garbage collector, whose pauses are kept short while a rig is connected.

A full collection stops every thread while it walks through all objects: 0.3 s in a process that serves the console, longer than
the watchdog or an abort may wait. What exists is set aside before energy is let in, so that later collections see only what
is new.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from threading import Lock

_lock = Lock()
_holders: list[bool] = []  # of each rig: whether objects were frozen already before the first


def freeze_objects() -> None:
    """Collect once, and let later collections look at new objects only."""
    gc.collect()
    gc.freeze()
    gc.collect()  # of nothing: so that the next full one is due early, and short


def disable_gc() -> Callable[[], None]:
    """Freeze all objects, for all threads; the function returned undoes it, once, unless another rig needs it or froze them."""
    with _lock:
        _holders.append(_holders[0] if _holders else gc.get_freeze_count() > 0)
        freeze_objects()
    held = True

    def release() -> None:
        nonlocal held
        with _lock:
            if held:
                held, foreign = False, _holders.pop()
                if not (_holders or foreign):
                    gc.unfreeze()

    return release
