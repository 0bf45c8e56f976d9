"""Kinds of step: found by their names, and those whose drive can be learned."""

import pytest

from dampyr.campaigns.kinds import available_steps, kind, learning_steps
from dampyr.campaigns.steps.voltage_steps import VoltageSteps
from dampyr.errors import InputError


def test_a_kind_is_the_class_that_is_called_as_its_file() -> None:
    assert kind("voltage_steps") is VoltageSteps
    assert [kind(name).__module__.rpartition(".")[2] for name in available_steps()] == available_steps()


def test_a_kind_that_is_none_is_refused_with_those_there_are() -> None:
    with pytest.raises(InputError, match=r"'sinus'.*did you mean 'sine'|'sinus'.*sine"):
        kind("sinus")


def test_those_that_move_until_their_end_by_other_than_set_points_do_not_learn() -> None:
    assert set(available_steps()) - set(learning_steps()) == {"hybrid", "rest", "reversals", "warm_up"}
