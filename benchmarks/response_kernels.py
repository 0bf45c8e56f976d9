"""The kernel of `respond`: calls under a constant input and under laws, with one damper and with twenty, and compilation."""

from __future__ import annotations

import os
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.errors import DampyrWarning
from dampyr.ground_motions import el_centro
from dampyr.models import Damper
from dampyr.models.codegen import kernel_cache, kernels
from dampyr.structures import Building, control_law, respond, shear_building, two_storey
from dampyr.structures.sites import make_sites
from dampyr.structures.time_history.kernel_run import runner
from dampyr.studies import raminelli_2020

STOREYS, MASS, STIFFNESS, STEP = 20, 2e4, 4e7, 0.005  # kg, N/m, s
VOLTAGE = 1.98
TITLE = (
    "The kernel of respond, El Centro 1940, published damper: a call, and the first call in a folder without kernels"
)


def run(data: Path | None) -> list[Line]:
    """Calls at the strict accuracy for two storeys, at a step of 5 ms for twenty; then what is compiled, one by one."""
    tower = shear_building([MASS] * STOREYS, [STIFFNESS] * STOREYS, damping_ratio=0.03)
    damper, motion = raminelli_2020.damper(), el_centro()
    everywhere = dict.fromkeys(range(1, STOREYS + 1), damper)
    inputs = {"constant": VOLTAGE} | {
        name: control_law(name, high=VOLTAGE) for name in ("bang_bang", "clipped_optimal")
    }
    contenders: dict[str, Callable[[], Any]] = {
        f"two storeys, {name}": partial(respond, two_storey(), motion, {1: damper}, value)
        for name, value in inputs.items()
    }
    for count, dampers in ((1, {1: damper}), (STOREYS, everywhere)):
        contenders[f"{STOREYS} storeys, dampers: {count}"] = partial(
            respond, tower, motion, dampers, VOLTAGE, step=STEP
        )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)  # the published damper was calibrated on smaller motions
        lines = race(contenders, {}, rounds=9, budget=30.0)
    return [*lines, *_first_calls(tower, damper, everywhere)]


def _first_calls(tower: Building, damper: Damper, everywhere: dict[Any, Damper]) -> Iterator[Line]:
    """Compilation in a folder of its own; the formulas that all dampers share are compiled by the calls before."""
    law = control_law("on_off", high=VOLTAGE)
    with _no_kernels():
        for name, dampers, value in (
            ("first call, 1 damper", {1: damper}, VOLTAGE),
            ("first call, 1 damper under a law", {1: damper}, law),
            ("then 2 dampers", {1: damper, 2: damper}, VOLTAGE),
            (f"then {STOREYS} dampers", everywhere, VOLTAGE),
        ):
            sites = make_sites(tower, dampers, value, None, False)
            start = time.perf_counter()
            runner(tower, el_centro(), sites).greatest_slopes()
            spent = time.perf_counter() - start
            yield Line(name, spent, spent, 1)


@contextmanager
def _no_kernels() -> Iterator[None]:
    """A folder without kernels in the place of the user's."""
    kernels_in_memory = (kernel_cache.cache_folder, kernels.bind, kernels._bound)
    with tempfile.TemporaryDirectory() as folder, patch.dict(os.environ, DAMPYR_CACHE=folder):
        for cache in kernels_in_memory:
            cache.cache_clear()
        yield
    for cache in kernels_in_memory:
        cache.cache_clear()
