"""The same ensemble by one worker and by several: threads of this process, and processes."""

from __future__ import annotations

import os
import warnings
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import ExitStack
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._lines import Line
from benchmarks._suite import VOLTS, motions
from benchmarks._timing import race
from dampyr.errors import DampyrWarning
from dampyr.structures import ensemble, two_storey
from dampyr.studies import raminelli_2020

SCALES = np.linspace(0.5, 1.5, 2400)
TITLE = f"An ensemble of {21 * len(SCALES):,} histories by one worker and by several"


def run(data: Path | None) -> list[Line]:
    """One thread, all cores' threads, as many processes, the pools already there; the numbers are compared to the last bit."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    with warnings.catch_warnings(), ExitStack() as open_:
        warnings.simplefilter("ignore", DampyrWarning)  # the published damper was calibrated on smaller motions
        pools: dict[str, Executor] = {
            "1 thread": ThreadPoolExecutor(1),
            f"{cores} threads": ThreadPoolExecutor(cores),
            "1 process": ProcessPoolExecutor(1, mp_context=get_context("spawn")),
            f"{cores} processes": ProcessPoolExecutor(cores, mp_context=get_context("spawn")),
        }
        contenders = {name: partial(_march, open_.enter_context(pool)) for name, pool in pools.items()}
        first = contenders["1 thread"]()
        same = {
            name: "the same numbers" if first.identical(each()) else "OTHER NUMBERS"
            for name, each in contenders.items()
        }
        lines = race(contenders, same, rounds=5, budget=60.0)
    return lines


def _march(executor: Any) -> Any:
    wanted = ("displacement", "drift")
    return ensemble(
        two_storey(), motions(), raminelli_2020.damper(), VOLTS, SCALES, executor, quantities=wanted
    ).dataset
