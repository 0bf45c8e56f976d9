"""The way out of an armed rig: the coil first, whatever interrupts it, and the first reason is what is reported."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from tests.rig.wires.process import over_wires

from dampyr.errors import RigFault
from dampyr.rig import Drive, Rig, RigSettings, simulated
from dampyr.rig.session import ArmedRig
from dampyr.rig.signal_deferral import deferred_signals
from dampyr.rig.simulation.simulator import Simulator, parse_faults

pytestmark = pytest.mark.usefixtures("terminal_signals")
WITHOUT_ENABLE = replace(RigSettings(), supply=replace(RigSettings().supply, enable_line=False))


def made(settings: RigSettings | None = None) -> tuple[Rig, Simulator]:
    rig = simulated(settings)
    return rig, rig.board.simulator


def stroke(seconds: float = 3.0, volts: float = 2.0) -> Drive:
    t = np.arange(round(seconds / 0.01) + 1) * 0.01
    return Drive(0.01, 0.010 * (1 - np.cos(2 * np.pi * t)) / 2, np.full(t.size, volts))


def moving(rig: Rig, then: Callable[[ArmedRig], object], at: int = 30) -> None:
    """Arm a table in mid-stroke, move it with the coil live, and do something."""
    with rig.armed() as table:
        table.home()
        table.go(0.0)
        for k, _ in enumerate(table.play(stroke())):
            if k == at:
                then(table)


def dead_and_at_rest(simulator: Simulator) -> None:
    simulator.run_unattended(0.5)
    assert simulator.command == 0.0
    assert not simulator.twin.enabled
    assert not np.isnan(simulator.at_rest_since)
    assert not np.isnan(simulator.coil_dead_since)


@pytest.mark.parametrize("how", ["abort", "interlock", "leave", "soft stop"])
def test_the_coil_is_cut_before_the_uno_is_asked(how: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The serial wire is dead: each request waits for a reply that does not come, and the coil is at 0 V all the while."""
    rig, simulator = made(WITHOUT_ENABLE)
    order: list[str] = []
    write = rig.board.write

    def begin(table: ArmedRig) -> None:
        for name in ("abort", "stop", "disarm"):
            monkeypatch.setattr(rig.uno, name, lambda name=name: order.append(name))
        monkeypatch.setattr(rig.board, "write", lambda volts: (order.append("coil"), write(volts)))
        if how == "abort":
            table.abort()
        elif how == "interlock":
            table.loop.halt(RigFault("the interlock", "interlock"))
        elif how == "soft stop":
            table.soft_stop()
        raise RigFault("leave")

    with pytest.raises(RigFault):
        moving(rig, begin)
    assert order[0] == "coil"
    assert {"stop", "disarm"} <= set(order)
    assert simulator.command == 0.0


@pytest.mark.parametrize("at", ["cut", "_stop", "settle", "end"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_second_interrupt_does_not_cut_the_way_out_short(at: str, number: int) -> None:
    rig, simulator = made(WITHOUT_ENABLE)

    def begin(table: ArmedRig) -> None:
        tables.append(table)
        step = next(each for each in table._way_out if each.__name__ == at)

        def interrupted() -> None:
            os.kill(os.getpid(), number)
            os.kill(os.getpid(), number)
            step()

        table._way_out[table._way_out.index(step)] = interrupted
        raise KeyboardInterrupt

    tables: list[ArmedRig] = []
    with pytest.raises(KeyboardInterrupt):
        moving(rig, begin)
    assert not tables[0]._way_out
    dead_and_at_rest(simulator)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_interrupt_before_the_deferral_is_survived(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C once more, in the moment between the block's end and the way out."""
    from dampyr.rig import session

    rig, simulator = made(WITHOUT_ENABLE)
    calls: list[bool] = []

    def deferred(discard: bool = False):
        calls.append(discard)
        if len(calls) == 1:
            raise KeyboardInterrupt
        return deferred_signals(discard)

    monkeypatch.setattr(session, "deferred_signals", deferred)
    with pytest.raises(KeyboardInterrupt):
        moving(rig, lambda _: (_ for _ in ()).throw(ValueError("mine")))
    assert calls == [False, True] or calls == [True, True]
    dead_and_at_rest(simulator)


def test_an_interrupt_while_a_block_is_left_in_order_is_not_lost() -> None:
    rig, simulator = made()

    def run() -> None:
        with rig.armed() as table:
            table.home()
            step = table._way_out[1]
            table._way_out[1] = lambda: (os.kill(os.getpid(), signal.SIGINT), step())[1]

    with pytest.raises(KeyboardInterrupt):
        run()
    dead_and_at_rest(simulator)


class Broken(Exception):
    """What an instrument says."""


def fails(words: str) -> Callable[[], None]:
    def fail() -> None:
        raise Broken(words)

    return fail


def test_closing_goes_on_and_keeps_the_first_reason() -> None:
    rig, _ = made()
    closed: list[str] = []
    rig.uno.close = fails("the port is gone")  # type: ignore[method-assign]
    rig.board.close = fails("the board is gone")  # type: ignore[method-assign]
    rig.on_close += [fails("the first callback"), lambda: closed.append("second")]
    with pytest.raises(ValueError, match="the true reason") as raised, rig:
        raise ValueError("the true reason")
    assert raised.value.__notes__ == ["the port is gone", "the board is gone", "the first callback"]
    assert closed == ["second"]


def test_closing_alone_says_what_failed_after_all_was_closed() -> None:
    rig, _ = made()
    closed: list[str] = []
    rig.board.close = fails("the board is gone")  # type: ignore[method-assign]
    rig.on_close += [lambda: closed.append("callback")]
    with pytest.raises(Broken, match="the board is gone"):
        rig.close()
    assert closed == ["callback"]


def test_a_simulator_that_is_killed_leaves_the_first_reason() -> None:
    done: list[str] = []

    def run() -> None:
        with over_wires() as rig:
            process = rig.on_close[0].__self__._process  # type: ignore[attr-defined]
            rig.on_close.append(lambda: done.append("closed"))
            with rig.armed() as table:
                table.home()
                process.kill()
                process.wait()
                table.rest(5.0)

    with pytest.raises(RigFault) as raised:
        run()
    assert "closed" in done
    assert "lost" in str(raised.value) or "gives an error" in str(raised.value) or "was closed" in str(raised.value)


def test_a_rig_says_whether_it_was_armed() -> None:
    rig, _ = made()
    assert not rig.was_armed
    with rig.armed():
        pass
    assert rig.was_armed


def test_a_fault_in_mid_stroke_is_the_reason_although_the_wire_dies_too() -> None:
    rig, simulator = made()

    def die(_: ArmedRig) -> None:
        simulator.faults = parse_faults(
            [f"board-timeout@{simulator.time:.3f}s", f"unplugged-serial@{simulator.time:.3f}s"]
        )

    with pytest.raises(RigFault, match="the simulated board gives an error") as raised:
        moving(rig, die)
    assert any("does not answer" in note for note in raised.value.__notes__)
    dead_and_at_rest(simulator)
