"""What a loop that reads a rig offers, in this process and in another one alike; blocks that wait for who reads them."""

import inspect
import threading

import pytest
from tests.rig.served_loop import Served

from dampyr.errors import RigFault
from dampyr.rig import RigSettings
from dampyr.rig.acquisition import Acquisition
from dampyr.rig.loop import HELD, Loop, WaitingBlocks
from dampyr.rig.loop_process import RemoteLoop

MEMBERS = {name for name in {*vars(Loop), *Loop.__annotations__} if not name.startswith("_")}


@pytest.mark.parametrize("kind", [Acquisition, RemoteLoop])
def test_both_loops_take_what_the_protocol_says(kind: type) -> None:
    for name, member in vars(Loop).items():
        if inspect.isfunction(member) and not name.startswith("_"):
            assert inspect.signature(getattr(kind, name)) == inspect.signature(member), name


def test_the_loop_of_another_process_offers_nothing_that_it_cannot_do(served: Served) -> None:
    with served.rig.armed() as table:
        assert isinstance(table.loop, RemoteLoop)
        public = {name for name in dir(table.loop) if not name.startswith("_")}
        assert public - {"link", "rig", "player", "waiting"} == MEMBERS
        for name in ("next", "index", "status", "calibration", "stopped", "lock"):
            getattr(table.loop, name)


def test_a_queue_that_nobody_reads_halts_the_rig_and_keeps_what_it_has() -> None:
    halted: list[RigFault] = []
    blocks = WaitingBlocks(HELD / 5, lambda fault: halted.append(fault) or fault)  # type: ignore[func-returns-value]
    for number in range(7):
        blocks.put(number)  # type: ignore[arg-type]
    assert len(blocks) == 5
    assert [fault.ring for fault in halted] == ["interlock"] * 2
    assert "blocks waited for 10 s to be stored; is the disk too slow?" in str(halted[0])
    blocks.stop(halted[0])  # there is no place for it: who reads on is told by the loop
    assert [blocks.take() for _ in range(5)] == list(range(5))
    assert blocks.poll(0.0) is None


def test_a_fault_comes_after_the_blocks_before_it(monkeypatch: pytest.MonkeyPatch) -> None:
    blocks = WaitingBlocks(RigSettings().board.block, lambda fault: fault)
    blocks.put("a block")  # type: ignore[arg-type]
    fault = RigFault("the interlock stopped the rig", "interlock")
    threading.Timer(0.05, blocks.stop, (fault,)).start()
    assert blocks.take() == "a block"
    with pytest.raises(RigFault) as stopped:
        blocks.take()
    assert stopped.value is fault
    monkeypatch.setattr("dampyr.rig.loop.SILENT", 0.05)
    with pytest.raises(RigFault, match=r"the rig gave no samples for 0\.05 s; is the board still there\?"):
        blocks.take()
