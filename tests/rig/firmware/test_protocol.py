"""docs/reference/protocol.md says what the frames, the firmware's model and the host do: numbers, tables, widths."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from dampyr.rig.firmware import control_core as c
from dampyr.rig.firmware import protocol, twin
from dampyr.rig.firmware.protocol import BODIES, Fault, Reason, Reply, Request, State
from dampyr.rig.instruments.arduino_uno import driver as uno
from dampyr.rig.instruments.arduino_uno import wire

PAGE = (Path(__file__).parents[3] / "docs/reference/protocol.md").read_text("utf-8")
TEXT = " ".join(PAGE.split())
WIDTHS = {"u8": "B", "u16": "H", "u32": "I", "i16": "h", "i32": "i"}


def rows(first: str) -> list[list[str]]:
    """The cells of the table whose header begins with ``first``."""
    table = PAGE.partition(f"| {first} |")[2].partition("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table]


@pytest.mark.parametrize(("first", "kinds"), [("type | request", Request), ("type | reply", Reply)])
def test_types_and_bodies(first: str, kinds: type[Request] | type[Reply]) -> None:
    table = rows(first)
    assert [(int(row[0], 16), row[1]) for row in table] == [(kind.value, kind.name) for kind in kinds]
    for row, kind in zip(table, kinds, strict=True):
        if kind is not Request.SETPOINTS:
            form = "<" + "".join(WIDTHS[word] for word in re.findall(r"\b[ui](?:8|16|32)\b", row[2]))
            assert form == BODIES[kind].format, kind.name


def test_states_faults_and_reasons() -> None:
    assert [(int(row[0]), row[1]) for row in rows("number | state")] == [(state.value, state.name) for state in State]
    assert [(1 << int(row[0]), row[1]) for row in rows("bit | fault")] == [(fault.value, fault.name) for fault in Fault]
    reasons = TEXT.partition("NAK reasons: ")[2].partition(". ")[0]
    assert [int(number) for number in re.findall(r"(?:^|, )(\d+) ", reasons)] == [reason.value for reason in Reason]


def test_where_requests_are_allowed() -> None:
    every = {state.name for state in State}
    for row in rows("type | request"):
        kind = Request[row[1]]
        allowed = {state.name for state in twin.ALLOWED.get(kind, tuple(State))}
        if kind is not Request.HOME:
            assert (every if row[3].startswith("all") else set(row[3].split(", "))) == allowed


@pytest.mark.parametrize(
    "sentence",
    [
        f"Version {protocol.VERSION}.",
        f"more than {protocol.MAX_BODY + 5} bytes between its two zeros",
        f"The host sends nothing for {wire.BOOT:g} s",
        f"sends HELLO each {uno.HELLO_INTERVAL:g} s until {wire.ANSWER:g} s after opening",
        f"does not fit into the queue of {c.QUEUE} nothing is taken",
        f"-{twin.FARTHEST} <= low < high <= {twin.FARTHEST}, 1 <= speed <= {twin.FASTEST}",
        f"wired <= {c.ENDS_WIRED | c.EMERGENCY_WIRED}",
        f"slew >= 1, current < {twin.FULL_SCALE}",
        f"for more than {c.OVER_TIME} ms on end",
        f"by more than {c.JUMP} counts in a millisecond",
        f"{c.SLOW} counts/s (2 mm/s) by the set point, which is never more than {c.SLOW_AHEAD} counts ahead",
        f"duty at most {c.SLOW_DUTY}, which pushes",
        f"the brake above {c.SLOW_BRAKE} counts/s; SPEED above {c.SLOW_FAULT}",
        f"high - low + {2 * c.SPARE} counts to either side",
        f"high - low + {c.SPARE} counts beyond its start",
        f"goes {c.EDGE} counts farther out",
        f"The sweep is {c.FIRST_SWEEP} counts to either side at first",
        f"less than {c.STALL_MOVE} counts moved, and the duty was at least {c.STALL_DUTY}",
        f"would have made more than {c.FREE_TRAVEL} counts",
        f"the second > {c.FREE_TRAVEL * c.RATE}",
        f"max(0, |duty| - d) * {c.FULL_SPEED}/{255 - c.DEAD_DUTY} each millisecond, with d = {c.DEAD_DUTY}, and {c.STALL_DUTY}",
        f"more than {c.AWAY} counts (5 mm) away",
        f"passed more than {c.INDEX_SHIFT} counts from its place",
        f"went {c.REVERSED} counts against the duty, or any at more than {c.SLOW_FAULT} counts/s, before",
        f"before it has gone {c.PROVEN} with it",
        f"count {c.WINDOW} ms ago) * {c.RATE // c.WINDOW}; 0 until ten positions",
        f"|away| <= {c.STILL} the duty is 0; else wanted = speed + {c.GAIN}*away",
        f"({c.DEAD_DUTY} + |wanted|*{255 - c.DEAD_DUTY}/{c.FULL_SPEED})",
        f"the motor's lag is {c.AHEAD} ms",
        f"STOPPING: {c.STOP_TIME} ms are counted down; ARMED at 0, or when the speed is 0 and {c.WINDOW} ms have gone",
    ],
)
def test_its_numbers_are_those_of_the_model(sentence: str) -> None:
    assert sentence in TEXT
