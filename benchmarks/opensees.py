"""OpenSeesPy's loop as its step shrinks: its peaks go to those of `respond`, at first order."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import _opensees
from benchmarks._lines import Line, spoken
from benchmarks._suite import VOLTS, case
from benchmarks._timing import race
from dampyr.errors import DampyrWarning
from dampyr.ground_motions import el_centro
from dampyr.structures import respond, two_storey
from dampyr.studies import raminelli_2020

TITLE = "Chapter 5's building, El Centro 1940, damper at 0, 1 and 2.25 V by OpenSeesPy as its step shrinks: time per history"
STEPS = (20, 40, 80, 160)  # to a sample of 0.02 s


def run(data: Path | None) -> list[Line] | str:
    """`respond` to 2e-6, then OpenSeesPy with steps that halve."""
    if why := _opensees.missing():
        return f"OpenSeesPy is {why}"
    cases = [case(el_centro(), volts) for volts in VOLTS]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)  # the published damper was calibrated on smaller motions
        contenders: dict[str, Callable[[], Any]] = {"dampyr, respond to 2e-6": ours}
        contenders |= {f"OpenSeesPy, {spoken(0.02 / m)}": partial(_opensees.peaks, cases, m) for m in STEPS}
        lines = race(contenders, _describe_errors(contenders), rounds=3, budget=20.0)
    return [replace(line, median=line.median / len(VOLTS), fastest=line.fastest / len(VOLTS)) for line in lines]


def ours() -> Any:
    """(voltages, 2): the peaks of the first floor and of the second storey's drift."""
    damper = {1: raminelli_2020.damper()}
    responses = [respond(two_storey(), el_centro(), damper, voltage=volts, accuracy=2e-6) for volts in VOLTS]
    return np.array([(one.peak_displacement[0], one.peak_drift[1]) for one in responses])


def _describe_errors(contenders: dict[str, Callable[[], Any]]) -> dict[str, str]:
    """How far each step is from ours, and so what the two finest steps go to."""
    reference, *results = (contender() for contender in contenders.values())
    rows = [f"peaks {_percent(peaks / reference - 1.0)} from ours" for peaks in results]
    limit = 2.0 * results[-1] - results[-2]
    rows[-1] += f"; carried on to no step {_percent(limit / reference - 1.0)}"
    return dict(zip(list(contenders)[1:], rows))


def _percent(gaps: Any) -> str:
    """The largest differences of first floor and second drift."""
    return " and ".join(f"{100 * gap:.2g} %" for gap in np.abs(gaps).max(axis=0))
