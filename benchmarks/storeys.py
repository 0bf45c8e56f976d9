"""Twenty storeys: the time of one step of one history in modal lanes, in dense lanes, and in the kernel of `respond`."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks._block import block
from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.errors import DampyrWarning
from dampyr.ground_motions import el_centro
from dampyr.structures import respond, shear_building
from dampyr.studies import raminelli_2020

STOREYS, MASS, STIFFNESS, VOLTAGE = 20, 2e4, 4e7, 1.0  # kg, N/m, V
M = 4  # steps of 5 ms
TITLE = f"A shear building of {STOREYS} storeys with one damper: time of one step (5 ms) of one history, one core"


def run(data: Path | None) -> list[Line]:
    """Peaks of displacement and drift, then of the damper's stroke alone, which leaves the step itself; the single response
    keeps its histories too."""
    motion = el_centro()
    building = shear_building([MASS] * STOREYS, [STIFFNESS] * STOREYS, damping_ratio=0.03)
    damper = raminelli_2020.damper()
    quantity_sets = (("displacement", "drift"), ("stroke",))
    modal, step = (block(building, motion, damper, VOLTAGE, M, each) for each in quantity_sets)
    with patch("dampyr.structures.batch.engine.basis_of", lambda _: None):
        dense, dense_step = (block(building, motion, damper, VOLTAGE, M, each) for each in quantity_sets)
    single = partial(respond, building, motion, {1: damper}, VOLTAGE, step=motion.dt / M)
    contenders: dict[str, Callable[[], Any]] = {
        "64 lanes, modal": modal.run,
        "64 lanes, dense": dense.run,
        "64 lanes, modal, stroke only": step.run,
        "64 lanes, dense, stroke only": dense_step.run,
        "respond, one history": single,
    }
    steps = dict.fromkeys(contenders, modal.steps) | {
        "respond, one history": modal.steps / modal.engine.text.block_width
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)  # the published damper was calibrated on smaller motions
        errors = _apart(modal.run(), dense.run())
        lines = race(contenders, {"64 lanes, dense": errors}, rounds=5, budget=30.0)
    return [
        replace(line, median=line.median / steps[line.name], fastest=line.fastest / steps[line.name]) for line in lines
    ]


def _apart(modal: dict[str, Any], dense: dict[str, Any]) -> str:
    gap = max(float(np.max(np.abs(modal[q] / dense[q] - 1.0))) for q in modal)
    return f"peaks within {gap:.0e} of the modal ones"
