"""The loop that reads an armed rig: every sample once, and the first reason is what is told."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from tests.rig.drives import sine
from tests.rig_time import SimulatedTime

from dampyr.errors import RigFault
from dampyr.rig import Rig, RigSettings, simulated
from dampyr.rig.interlock import Samples
from dampyr.rig.player import Player


def test_a_request_that_the_uno_refuses_after_a_fault_of_its_own_names_the_fault() -> None:
    """It trips after it has told its status for a block, and refuses what it is asked before the next."""

    def requested(rig: Rig) -> None:
        send = rig.uno.points

        def late(first: int, points: list[int]) -> int:
            rig.uno.abort()
            return send(first, points)

        with rig.armed() as table:
            table.home(here=True)
            rig.uno.points = late  # type: ignore[method-assign]
            list(table.play(sine(0.004, 1.0, 2.0)))

    with simulated() as rig, pytest.raises(RigFault, match="the Uno stopped the table: it was aborted"):
        requested(rig)


def test_an_uno_that_does_not_answer_is_not_asked_for_its_fault_before_the_way_to_rest() -> None:
    requests: list[str] = []

    def requested(rig: Rig) -> None:
        heartbeat = rig.uno.heartbeat

        def silent(first: int, points: list[int]) -> int:
            rig.uno.heartbeat = lambda: requests.append("heartbeat") or heartbeat()  # type: ignore[method-assign, func-returns-value]
            raise RigFault("the Uno does not answer SETPOINTS, asked 3 times; check its cable and its power")

        with rig.armed() as table:
            table.home(here=True)
            cut = table.loop.cut
            table.loop.cut = lambda: requests.append("cut") or cut()  # type: ignore[method-assign, func-returns-value]
            rig.uno.points = silent  # type: ignore[method-assign]
            list(table.play(sine(0.004, 1.0, 2.0)))

    with simulated() as rig, pytest.raises(RigFault, match="does not answer SETPOINTS"):
        requested(rig)
    assert requests[0] == "cut"


def test_a_watcher_sees_every_sample_once() -> None:
    seen: list[Samples] = []
    with simulated() as rig:
        rig.watchers.append(seen.append)
        with rig.armed() as table:
            table.home(here=True)
            table.go(0.002)
    numbers = np.concatenate([np.arange(each.first, each.first + each.n) for each in seen])
    assert np.array_equal(numbers, np.arange(numbers[-1] + 1))


def test_a_reader_that_fails_stops_the_rig_and_says_so() -> None:
    def broken(_: Samples) -> None:
        raise KeyError("x")

    clock = SimulatedTime()
    with clock.passing(), clock.connect(RigSettings()) as rig:
        rig.watchers.append(broken)
        with pytest.raises(RigFault, match="reading the rig failed: KeyError"), rig.armed() as table:
            table.rest(5.0)


def test_a_drive_is_prepared_while_blocks_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its path is interpolated and its kernel compiled before the loop is asked to wait, or the Uno finds its host silent."""
    prepare, free = Player.prepare, []

    def watched(player: Player) -> None:
        with ThreadPoolExecutor(1) as reader:  # the lock lets its own thread in
            free.append(reader.submit(table.loop.lock.acquire, timeout=0.0).result())
            reader.submit(table.loop.lock.release).result()
        prepare(player)

    with simulated() as rig, rig.armed() as table:
        table.home(here=True)
        monkeypatch.setattr(Player, "prepare", watched)
        table.go(0.002)
    assert free == [True]
