"""The thread that owns the rig: all access to it happens here, one thing after another, except an abort."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable

POLL = 0.25  # s between two looks at an idle rig
PATIENCE = 20.0  # s in which the rig is let go of in order


class RigThread:
    """Does jobs in their order, and ``look`` where none comes for `POLL`; ``leave`` is its last one, after `close`.

    No exception ends it, or nothing could be disarmed any more: each is passed to ``tell``.
    """

    def __init__(self, look: Callable[[], None], tell: Callable[[Exception], None], leave: Callable[[], None]) -> None:
        self.jobs: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self.closing = threading.Event()
        self._look, self._tell, self._leave = look, tell, leave
        self._thread = threading.Thread(target=self._work, name="bench", daemon=True)
        self._thread.start()

    @property
    def wanted(self) -> bool:
        """Whether a job waits, or the end."""
        return not self.jobs.empty() or self.closing.is_set()

    def close(self) -> None:
        """Begin no further job, leave, and end."""
        self.closing.set()
        self.jobs.put(lambda: None)  # an idle thread leaves at once, and not at its next look
        self._thread.join(PATIENCE)

    def _work(self) -> None:
        job = self._look
        while job is not self._leave:
            try:
                job = self.jobs.get(timeout=POLL)
            except queue.Empty:
                job = self._look
            if self.closing.is_set():
                job = self._leave
            try:
                job()
            except Exception as problem:
                self._tell(problem)
