"""A command on the sample clock: value k is output at start + (k + 1) period, and held."""

import math

import numpy as np
import pytest

from dampyr.rig.simulation.timed_command import TimedCommand

START, RATE = 2.0, 100.0


def at(sample: float) -> float:
    """The time at which the value before a sample's is output."""
    return START + sample / RATE


def test_each_value_is_output_at_its_time_and_held() -> None:
    values = np.array([0.5, 1.5, 1.5, 3.0])
    command = TimedCommand(START, RATE, values[:2])
    command.queue(values[2:])
    assert command.due(at(0.9)) is None
    for k, value in enumerate(values):
        assert command.held(at(k + 0.5)) == len(values) - k
        assert command.due(at(k + 1)) == command.due(at(k + 1.9)) == value
    assert not command.empty(at(len(values)))
    assert command.due(at(len(values) + 0.9)) == 3.0
    assert command.empty(at(len(values) + 1))
    assert command.due(at(10)) == 3.0  # the last one stays at the output


@pytest.mark.parametrize("dropped", [False, True])
def test_the_next_change_is_that_of_the_next_value_that_differs(dropped: bool) -> None:
    command = TimedCommand(START, RATE, np.array([1.0, 1.0, 1.0, 2.0]))
    if dropped:
        assert command.due(at(2)) == 1.0
    assert command.next_change(at(2.5), 1.0) == pytest.approx(at(4))
    assert command.next_change(at(2.5), 0.0) == pytest.approx(at(3))
    assert command.next_change(at(4), 2.0) == math.inf
