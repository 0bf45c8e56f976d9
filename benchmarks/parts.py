"""Other dampers than Dahl's in an ensemble: what a history costs with them."""

from __future__ import annotations

import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.errors import DampyrWarning
from dampyr.ground_motions import el_centro
from dampyr.models import Damper
from dampyr.structures import ensemble, two_storey

TITLE = (
    "Ensembles with other parts, chapter 5's building, El Centro 1940, displacement + drift: time per history, one core"
)
SCALES = np.linspace(0.5, 1.5, 512)
ONE_BY_ONE = 32  # cases are enough where no lanes take them
KX, KW, RHO = 1400.0, 200.0, 2e4  # N s/m, N, 1/m
DAHL = {"dahl.kx": KX, "dahl.kw": KW, "dahl.rho": RHO}
TANH = {"c": KX, "ft": KW, "v0": 0.01, "s": 0.0}
BOUC_WEN = {"c0": KX, "k0": 0.0, "kw": KW, "rho": RHO, "sigma": 1.0, "n": 1.5}
DAMPERS: dict[str, dict[str, float]] = {
    "dahl": DAHL,
    "hyperbolic_tangent": {f"hyperbolic_tangent.{name}": value for name, value in TANH.items()},
    "bouc_wen": {f"bouc_wen.{name}": value for name, value in BOUC_WEN.items()},
    "dahl + compliance": DAHL | {"compliance.s": 2e-7},
    "dahl + delay": DAHL | {"delay.tau": 0.008},
}


def run(data: Path | None) -> list[Line]:
    """Each damper in a call of its own."""
    with warnings.catch_warnings(), ThreadPoolExecutor(1) as one:
        warnings.simplefilter("ignore", DampyrWarning)
        summaries, calls, counts = {}, {}, {}
        for name, values in DAMPERS.items():
            march = partial(_march, Damper(name, values), one)
            dataset = march(SCALES[:2])
            vectorised = not dataset.attrs["one_by_one"]
            scales = SCALES if vectorised else SCALES[:: len(SCALES) // ONE_BY_ONE]
            calls[name], counts[name] = partial(march, scales), len(scales)
            summaries[name] = f"error estimate {dataset.attrs['error_estimate']:.0e}" + (
                "" if vectorised else ", one by one"
            )
        lines = race(calls, summaries, rounds=5, budget=30.0)
    return [
        replace(line, median=line.median / counts[line.name], fastest=line.fastest / counts[line.name])
        for line in lines
    ]


def _march(damper: Damper, executor: Any, scales: Any) -> Any:
    wanted = ("displacement", "drift")
    return ensemble(
        two_storey(), el_centro(), damper, scales=scales, voltage=[0.0], executor=executor, quantities=wanted
    ).dataset
