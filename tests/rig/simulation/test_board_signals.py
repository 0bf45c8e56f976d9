"""Signals of the simulated board: volts of a force, whole steps within its range, and commands beyond it."""

from dataclasses import replace

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.rig.settings import RigSettings
from dampyr.rig.simulation.board_signals import RANGE, BoardError, command_of, converted, volts_of_force


def test_a_force_in_volts() -> None:
    rig = RigSettings()
    rig = replace(rig, load_cell=replace(rig.load_cell, scale=500.0, zero=0.25))
    np.testing.assert_allclose(volts_of_force(rig, np.array([0.0, 1000.0, -500.0])), [0.25, 2.25, -0.75])


def test_a_converter_of_three_bits_has_eight_steps() -> None:
    """From -4 V to 3 V: the highest code is a step below the range."""
    rig = RigSettings()
    rig = replace(rig, board=replace(rig.board, range=4.0, bits=3))
    given = np.array([-9.0, -4.0, -0.6, -0.4, 0.4, 0.6, 2.4, 3.4, 3.9, 9.0])
    np.testing.assert_array_equal(converted(rig, given), [-4.0, -4.0, -1.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0])


def test_a_command_beyond_the_range_is_the_boards_error() -> None:
    rig = RigSettings()
    assert command_of(rig, 1.0) == pytest.approx(1.0, abs=rig.board.range / 2**rig.board.bits)
    with pytest.raises(BoardError, match=f"error {RANGE}: the requested value is not supported") as raised:
        command_of(rig, -1.001 * rig.board.range)
    assert raised.value.code == RANGE
    with pytest.raises(InputError, match="not finite"):
        command_of(rig, float("nan"))
