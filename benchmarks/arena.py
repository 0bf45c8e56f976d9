"""A million controlled cases on all cores, and the laws against one another; run only when asked for."""

from __future__ import annotations

import time
import warnings
from pathlib import Path

import numpy as np

from benchmarks._lines import Line
from dampyr.errors import DampyrWarning
from dampyr.ground_motions import kanai_tajimi
from dampyr.structures import Sensor, arena, control_law, ensemble, two_storey
from dampyr.studies import raminelli_2020

OPT_IN = True  # `python -m benchmarks arena`
MOTIONS, SCALES, SEEDS = 100, 100, 50
QUANTITIES = ("drift", "acceleration")
NAMES = ("bang_bang", "clipped_optimal")
HIGH, SENSORS = 3.212, {"force": Sensor(noise=3.0)}  # V
TITLE = (
    f"{len(NAMES) * MOTIONS * SCALES * SEEDS:,} controlled cases: chapter 5's building, published damper, bang_bang and "
    f"clipped_optimal with a noisy force, {MOTIONS} synthetic records of 30 s x {SCALES} scales x {SEEDS} seeds, peaks of "
    "drift and acceleration"
)


def run(data: Path | None) -> list[Line]:
    """The ensemble, then its arena."""
    motions = [kanai_tajimi(30.0, 0.02, seed=k, pga=4.0, rest=0.0) for k in range(MOTIONS)]
    laws, scales = [control_law(name, high=HIGH, sensors=SENSORS) for name in NAMES], np.linspace(0.05, 2.0, SCALES)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        ensemble(
            two_storey(), motions[:1], raminelli_2020.damper(), laws, scales[:1], quantities=QUANTITIES
        )  # compiles
        start = time.perf_counter()
        result = ensemble(
            two_storey(), motions, raminelli_2020.damper(), laws, scales, seeds=SEEDS, quantities=QUANTITIES
        )
        computed = time.perf_counter()
        found = arena(result, "acceleration")
        end = time.perf_counter()
    rate = f"{result.dataset.attrs['cases'] / (computed - start):,.0f} cases/s"
    winner = f"winner by acceleration: {found.winner or 'none'}"
    return [
        Line("ensemble", computed - start, computed - start, 1, rate),
        Line("arena", end - computed, end - computed, 1, winner),
    ]
