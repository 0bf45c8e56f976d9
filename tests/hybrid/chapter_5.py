"""The building of chapter 5 under the strong part of El Centro, and its damper."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.hybrid import Substructure
from dampyr.models import Damper
from dampyr.structures import Response, respond, two_storey
from dampyr.studies import raminelli_2020

VOLTAGES = (0.0, 0.8712, 3.212)
HARDEST_QUICK = [*(pytest.param(value, marks=pytest.mark.prove) for value in VOLTAGES[:2]), VOLTAGES[2]]
PRINTED = {0.0: 27.208, 0.8712: 16.446, 3.212: 3.3755}  # mm, first floor: `dampyr simulate`, FACTS
STRONG = 6.0  # s of El Centro that the quick tests take: the floors' peaks come by 2.64 s


def strong_part() -> GroundMotion:
    """The part of El Centro in which the building's peaks lie."""
    whole = el_centro()
    return whole.changed(whole.acceleration[: round(STRONG / whole.dt) + 1], "its strong part")


SHAKES = [strong_part, pytest.param(el_centro, marks=pytest.mark.prove)]  # motions of a test


@cache
def all_computed(voltage: float, motion: Callable[[], GroundMotion] = strong_part) -> Response:
    """The building under the strong part or all of it, its damper at a voltage."""
    return respond(two_storey(), motion(), raminelli_2020.damper(), voltage=voltage)


def shaken(
    voltage: float,
    model: Damper | None = None,
    motion: Callable[[], GroundMotion] = strong_part,
    **changes: object,
) -> Substructure:
    """Chapter 5's building under the strong part of El Centro, or all of it, its damper predicted by ``model``."""
    record, h = motion(), 0.001
    response = all_computed(voltage, motion)
    ground = np.interp(np.arange(int(record.duration / h) + 1) * h, record.time, record.acceleration)
    about = Substructure(
        two_storey(), 1, ground, h, model, voltage, size=float(response.peak_displacement[0]),
        input_energy=float(response.energy.input[-1]),
    )  # fmt: skip
    return replace(about, **changes)


def peak(run) -> float:
    """mm of the first floor."""
    return 1e3 * float(np.abs(run.z[: run.now + 1, 0]).max())
