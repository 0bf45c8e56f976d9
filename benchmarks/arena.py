"""A million controlled cases on all cores, ten thousand on a published benchmark, and the laws against one another; run only
when asked for."""

from __future__ import annotations

import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._lines import Line
from dampyr.errors import DampyrWarning
from dampyr.ground_motions import kanai_tajimi
from dampyr.models import Damper
from dampyr.structures import Sensor, arena, control_law, ensemble, two_storey
from dampyr.studies import load_structure, raminelli_2020

OPT_IN = True  # `python -m benchmarks arena`
MOTIONS, SCALES, SEEDS = 100, 100, 50
OF_THE_FRAME = 50, 10, 10  # motions, scales and seeds
STRONGER = 2000.0  # times the published damper's forces: 1 MN, for a frame of 20 storeys
QUANTITIES = ("drift", "acceleration")
NAMES = ("bang_bang", "clipped_optimal")
HIGH, SENSORS = 3.212, {"force": Sensor(noise=3.0)}  # V
TITLE = (
    f"{len(NAMES) * MOTIONS * SCALES * SEEDS:,} controlled cases: chapter 5's building, published damper, bang_bang and "
    f"clipped_optimal with a noisy force, {MOTIONS} synthetic records of 30 s x {SCALES} scales x {SEEDS} seeds, peaks of "
    f"drift and acceleration; and {len(NAMES) * int(np.prod(OF_THE_FRAME)):,} of the 20-storey benchmark frame"
)


def run(data: Path | None) -> list[Line]:
    """The ensembles, and their arenas."""
    laws = [control_law(name, high=HIGH, sensors=SENSORS) for name in NAMES]
    noisy = {"force": Sensor(noise=3.0 * STRONGER)}
    of_the_frame = [control_law(name, high=HIGH, lag=0.01, sensors=noisy) for name in NAMES]
    frame = load_structure("ohtori_2004")
    return [
        *_lines("chapter 5's building", two_storey(), raminelli_2020.damper(), laws, (MOTIONS, SCALES, SEEDS)),
        *_lines("benchmark frame", frame, _stronger(), of_the_frame, OF_THE_FRAME),
    ]


def _stronger() -> Damper:
    """The published damper with forces as a large building needs."""
    damper = raminelli_2020.damper()
    per_force = np.repeat([key in ("dahl.kx", "dahl.kw") for key in damper.all_laws], 4)
    return damper.with_coefficients(np.where(per_force, STRONGER, 1.0) * damper.coefficients)


def _lines(name: str, building: Any, damper: Damper, laws: list[Any], sizes: tuple[int, int, int]) -> list[Line]:
    motions = [kanai_tajimi(30.0, 0.02, seed=k, pga=4.0, rest=0.0) for k in range(sizes[0])]
    scales = np.linspace(0.05, 2.0, sizes[1])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        ensemble(building, motions[:1], damper, laws, scales[:1], quantities=QUANTITIES)  # compiles
        start = time.perf_counter()
        result = ensemble(building, motions, damper, laws, scales, seeds=sizes[2], quantities=QUANTITIES)
        computed = time.perf_counter()
        found = arena(result, "acceleration")
        end = time.perf_counter()
    cases = result.dataset.attrs["cases"]
    rate = f"{cases:,} cases, {cases / (computed - start):,.0f} a second"
    winner = f"winner by acceleration: {found.winner or 'none'}"
    return [
        Line(f"{name}, ensemble", computed - start, computed - start, 1, rate),
        Line(f"{name}, arena", end - computed, end - computed, 1, winner),
    ]
