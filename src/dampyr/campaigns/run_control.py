"""What a person may do while a campaign runs, from any thread: pause, go on, skip or repeat a test, stop, abort; and what they
see."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

from dampyr.errors import DampyrError, RigFault
from dampyr.rig.interlock import Samples
from dampyr.shown import Shown


class Stopped(DampyrError):
    """A campaign was stopped in order by its operator; it can be run on."""


class Skipped(Stopped):
    """A test was left out by its operator; the campaign goes on with the next one."""


class EndedByProtocol(Stopped):
    """A campaign has come to the end that its protocol sets, before all of its tests have run; the rig is well."""


def exit_status(problem: BaseException) -> Literal["stopped", "aborted", "failed"]:
    """How a test or a campaign ended that ended early."""
    if isinstance(problem, Stopped | KeyboardInterrupt | SystemExit):
        return "stopped"
    return "aborted" if isinstance(problem, RigFault) and problem.ring == "operator" else "failed"


@dataclass(frozen=True, eq=False, repr=False)
class Progress(Shown):
    """How far a campaign is.

    ``done`` of ``total`` tests are complete; ``fraction`` of the one under way; ``time_left`` s of rig time; ``force`` N,
    ``stroke`` m (peak to peak of the last second), ``temperature`` degC; ``samples`` is the block itself, whose displacement a
    record has ``force_delay`` s later, on the force's clock.
    """

    done: int
    total: int
    name: str
    phase: str
    fraction: float = 0.0
    time_left: float = 0.0
    cycles: float = 0.0
    planned_cycles: float = 0.0
    force: float = 0.0
    stroke: float = 0.0
    temperature: float = 0.0
    samples: Samples | None = None
    force_delay: float = 0.0


@dataclass(repr=False)
class RunControl(Shown):
    """The buttons. Pause acts after the test under way; skip, stop and abort at once.

    ``under_way`` is the name of the test that is recorded, empty between two tests.
    """

    abort_now: Callable[[str], None] | None = None
    under_way: str = ""
    _skipped: set[str] = field(default_factory=set)
    _repeated: list[str] = field(default_factory=list)
    _paused: threading.Event = field(default_factory=threading.Event)
    _stopped: threading.Event = field(default_factory=threading.Event)
    _aborted: str = ""

    def pause(self) -> None:
        """Wait, armed and at rest, after the test under way."""
        self._paused.set()

    def resume(self) -> None:
        """Go on."""
        self._paused.clear()

    def skip(self, name: str) -> None:
        """Leave out the test ``name``; the one under way is ended in order. It stays incomplete: the next run records it."""
        self._skipped.add(name)

    def skips(self, name: str) -> bool:
        """Whether a test is to be left out. A second call says no: it may be repeated after it."""
        skipped = name in self._skipped
        self._skipped.discard(name)
        return skipped

    def repeat(self, name: str) -> None:
        """Record the test ``name`` once more, as a further try, after the tests that are left."""
        self._repeated.append(name)

    def repeats(self) -> list[str]:
        """The tests to be recorded once more, asked for since the last call."""
        names, self._repeated = self._repeated, []
        return names

    def stop(self) -> None:
        """End the test under way in order, and the campaign with it."""
        self._stopped.set()

    def abort(self, why: str = "by the operator") -> None:
        """Brake and cut the coil, now."""
        self._aborted = why
        if self.abort_now:
            self.abort_now(why)

    @property
    def aborted(self) -> bool:
        """Whether abort was asked for."""
        return bool(self._aborted)

    @property
    def stopped(self) -> bool:
        """Whether stop was asked for."""
        return self._stopped.is_set()

    @property
    def paused(self) -> bool:
        """Whether the campaign is to wait."""
        return self._paused.is_set()

    def check(self) -> None:
        """Raise :class:`Stopped` or :class:`~dampyr.errors.RigFault` where stop or abort was asked for."""
        if self._aborted:
            raise RigFault(f"aborted: {self._aborted}", "operator")
        if self.stopped:
            raise Stopped("the campaign was stopped by its operator; run it again to go on")
        if self.under_way in self._skipped:
            raise Skipped("skipped by the operator")
