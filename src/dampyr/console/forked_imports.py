"""What the process imports and compiles whose copies answer requests and do jobs; it alone imports this, before all else.

A copy needs milliseconds, and not the second in which all this is imported.
"""

from __future__ import annotations

import os
import signal
from importlib import import_module

# A process that is forked may have no threads, and one that yields to a rig needs none.
os.environ.update(
    dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
)
signal.signal(signal.SIGINT, signal.SIG_IGN)  # a Ctrl-C is for the console

for name in (
    "dampyr.console.request_process",
    "dampyr.console.record_answers",
    "dampyr.console.record_acceptance",
    "dampyr.console.record_uploads",
    "dampyr.console.dampers",
    "dampyr.console.job_work",
    "dampyr.console.jobs.respond",
    "dampyr.console.jobs.identify",
):
    import_module(name)
import_module("dampyr.console.campaign_plans").warm_up()
