"""Signals while a rig comes to rest."""

from __future__ import annotations

import os
import signal

import pytest

from dampyr.rig.signal_deferral import deferred_signals

pytestmark = pytest.mark.usefixtures("terminal_signals")


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="no terminals to be closed")
def test_a_signal_that_is_ignored_stays_ignored() -> None:
    """As with nohup: a terminal that is closed does not end the campaign."""
    from dampyr.cli._running import stopped_by_signals

    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with stopped_by_signals(), deferred_signals():
            os.kill(os.getpid(), signal.SIGHUP)
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)
