"""Specimen of the simulated rig: what the plant needs of a damper."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.input_kinds import input_arguments
from dampyr.models import Constant, Damper
from dampyr.models.laws import Law

Array = NDArray[np.float64]
ROWS = 513  # of the parameter table, linear between rows: 6 mV apart over 3.2 V
CLOSING = 10.0  # N that close 71 % of the free play


def add_free_play(damper: Damper, free_play: float) -> Damper:
    """The damper in series with the play of its pins, ``free_play`` m from one side to the other."""
    if free_play == 0.0:
        return damper
    laws: dict[str, Law | float] = dict(damper.all_laws)
    if "free_play.g" in laws:
        return replace(damper, laws=laws | {"free_play.g": damper.all_laws["free_play.g"].shifted(0.5 * free_play)})
    low, high = damper.range
    added: dict[str, Law | float] = {
        "free_play.g": Constant(0.5 * free_play, low, high),
        "free_play.fc": Constant(CLOSING, low, high),
    }
    return replace(damper, parts=(*damper.composition.names, "free_play"), laws=laws | added, covariance=None)


def table_of(damper: Damper) -> Array:
    """The parameters over the calibrated inputs, (ROWS, P)."""
    return np.ascontiguousarray(damper.values(np.linspace(*damper.range, ROWS)))


def delay_index(damper: Damper, dt: float, capacity: int) -> int:
    """The index of the delay among the parameters, -1 without one; InputError where it is longer than the force history."""
    k = damper.composition.delay
    if k is None:
        return -1
    max_delay = list(damper.all_laws.values())[k].extremes()[1]
    if max_delay / dt > capacity - 2:
        raise InputError(
            f"delay.tau = {max_delay:g} s is longer than the simulated rig's force history; "
            f"give at most {(capacity - 2) * dt:g} s"
        )
    return k


def input_lag(damper: Damper) -> float:
    """The time constant of the specimen's own lag, s; 0 without one."""
    k = damper.composition.lag
    return 0.0 if k is None else float(damper.values(damper.range[0])[k])


def force_at_rest(damper: Damper, position: float) -> float:
    """The force in N where the table is at rest at ``position`` m with the lowest calibrated input and no memory."""
    path, still = [position, position], [0.0, 0.0]  # the velocity is given: two samples have no derivative
    lowest = input_arguments(damper.input, damper.range[0])
    return float(damper.force([0.0, 1.0], path, velocity=still, **lowest)[0])
