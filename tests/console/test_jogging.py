"""Jogging: it stops by itself, with its page, and before the ends of the stroke."""

import pytest
from tests.console.bench_runs import Until, position
from tests.rig_time import RealTime

from dampyr.console.bench_session import Bench
from dampyr.errors import InputError

pytestmark = pytest.mark.endure


def test_a_jog_that_is_not_asked_for_again_stops(armed: Bench, until: Until) -> None:
    armed.jog("a", 0.005)
    until(lambda: armed.state().jogging)
    until(lambda: not armed.state().jogging, 2.0)
    assert position(armed) < 0.005 * 1.5


def test_a_jog_stops_with_its_page(armed: Bench, until: Until) -> None:
    armed.clients.join("b")
    armed.jog("a", 0.005)
    until(lambda: armed.state().jogging)
    armed.clients.disconnect("a")
    until(lambda: not armed.state().jogging, 2.0)
    assert armed.state().holder == ""
    assert armed.state().phase == "armed"  # "b" still looks on


def test_the_ends_of_the_stroke_are_not_jogged_into(armed: Bench, bench_time: RealTime, until: Until) -> None:
    def on() -> None:
        while True:
            armed.jog("a", 0.010)
            bench_time.sleep(0.05)

    with pytest.raises(InputError, match="before the end of its stroke; jog the other way"):
        on()
    until(lambda: not armed.state().jogging)
    assert 0.030 < position(armed) < 0.037
    assert armed.state().phase == "armed"
