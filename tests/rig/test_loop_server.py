"""The process that reads a rig, as a server in a thread: the rig comes to rest and the reason is told."""

import os
import socket
import threading
import time
from collections.abc import Callable

import pytest
from tests.rig.served_loop import Served, stroke
from tests.rig_time import HANG

from dampyr.errors import RigFault
from dampyr.rig import Rig
from dampyr.rig.firmware.protocol import State
from dampyr.rig.loop import SILENT


def test_the_interlock_there_stops_it_and_says_so_here() -> None:
    made = Served("broken-cell@1.5s")
    with made.time.passing():
        with pytest.raises(RigFault, match="the interlock stopped the rig: load cell signal") as ended:
            hold(made.rig, 5.0)
        assert ended.value.ring == "interlock"
        made.rig.close()
    made.inner.close()


def hold(rig: Rig, seconds: float) -> None:
    with rig.armed() as table:
        table.rest(seconds)


def test_blocks_that_nobody_takes_stop_the_rig_at_last(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dampyr.rig.loop.HELD", 0.4)

    def wait_for_nothing() -> None:
        with served.rig.armed() as table:
            wait_for(lambda: table.loop.stopped is not None)
            table.rest(0.1)

    with pytest.raises(RigFault, match=r"blocks waited for 0\.4 s to be stored; is the disk too slow"):
        wait_for_nothing()


def test_the_reason_arrives_behind_blocks_that_left_no_place_for_it(
    served: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The host takes them late, as where its disk has paused: it had waited for more, and was told that none came."""
    monkeypatch.setattr("dampyr.rig.loop.HELD", 0.4)
    sent = served.server.blocks
    paused = threading.Event()

    class Slow:
        def send(self, message: object) -> None:
            paused.wait(HANG)
            sent.send(message)

    monkeypatch.setattr(served.server, "blocks", Slow())

    def resume() -> None:
        wait_for(lambda: served.server.loop is not None and served.server.loop.stopped is not None)
        wait_for(lambda: not served.server.loop.reading)  # type: ignore[union-attr]
        paused.set()

    threading.Thread(target=resume, daemon=True).start()
    start = time.monotonic()
    with pytest.raises(RigFault, match=r"blocks waited for 0\.4 s to be stored"), served.rig.armed() as table:
        table.rest(60.0)
    assert time.monotonic() - start < SILENT


def test_a_fault_of_the_uno_since_the_last_block_is_told_where_the_host_asks_for_the_reason(served: Served) -> None:
    with served.rig.armed():
        loop = served.server.loop
        assert loop is not None
        with loop.lock:  # no block is read in between
            served.inner.uno.abort()
            assert loop.stopped is None
            refused = RigFault("the Uno refused JOG: it is in another state", "firmware")
            reason = served.server._do("loop.reason", refused)
    assert str(reason) == "the Uno stopped the table: it was aborted"


def test_samples_that_never_come_stop_the_rig_with_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dampyr.rig.loop.SILENT", 0.3)
    made = Served()
    with pytest.raises(RigFault, match=r"the rig gave no samples for 0\.3 s; is the board still there"):
        hold(made.rig, 5.0)  # time does not pass
    with made.time.passing():
        made.rig.close()
    made.inner.close()


def test_a_host_that_is_gone_leaves_a_rig_at_rest() -> None:
    made = Served()
    uno = made.inner.uno
    with made.time.passing():
        armed = made.rig.armed()
        table = armed.__enter__()
        table.home(here=True)
        table.loop.play(stroke(table.position, 20.0))
        wait_for(lambda: table.loop.status.speed != 0)
        made.link.on_block = lambda _: None
        for each in (made._questions, made._blocks):
            with socket.socket(fileno=os.dup(each.fileno())) as end:
                end.shutdown(socket.SHUT_RDWR)
        made.thread.join(10.0)
        assert not made.thread.is_alive()
    status = uno.heartbeat()
    assert (status.state, status.faults, status.speed, status.duty) == (State.IDLE, 0, 0, 0)
    assert made.inner.board._board.simulator.truth.voltage[-1] == 0.0
    with pytest.raises(RigFault, match="the process that reads the rig has ended"):
        armed.__exit__(None, None, None)
    made.rig.close()
    made.inner.close()


def wait_for(condition: Callable[[], bool]) -> None:
    until = time.monotonic() + HANG
    while not condition():
        assert time.monotonic() < until, "it did not come"
        time.sleep(0.005)
