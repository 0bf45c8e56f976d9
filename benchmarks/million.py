"""A million histories on all cores to a file on the disk; run only when asked for."""

from __future__ import annotations

import sys
import tempfile
import time
import warnings
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks._lines import Line
from dampyr.errors import DampyrWarning
from dampyr.ground_motions import GroundMotion, kanai_tajimi
from dampyr.models import Damper
from dampyr.structures import ensemble, two_storey
from dampyr.studies import raminelli_2020

OPT_IN = True  # `python -m benchmarks million`
DAMPERS = MOTIONS = SCALES = 100
VOLTAGE, SPREAD = 1.0, 0.1  # V; of each parameter, as the standard deviation of its logarithm
TITLE = (
    f"{DAMPERS * MOTIONS * SCALES:,} histories: chapter 5's building, {DAMPERS} dampers x {MOTIONS} synthetic records of 30 s "
    f"x {SCALES} scales, all six quantities, to a file"
)


def run(data: Path | None) -> list[Line] | str:
    """One run: its time, its largest memory, and how large its file is."""
    watch = Watch()
    with warnings.catch_warnings(), tempfile.TemporaryDirectory(dir=".", prefix=".million-") as folder:
        warnings.simplefilter("ignore", DampyrWarning)
        path, motions = Path(folder) / "million.h5", _motions()
        start = time.perf_counter()
        dataset = ensemble(
            two_storey(),
            motions,
            dampers(),
            scales=np.linspace(0.05, 2.0, SCALES),
            voltage=0.0,
            out=path,
            progress=watch,
        ).dataset
        spent, size = time.perf_counter() - start, path.stat().st_size
    if not dataset.drift.notnull().all():
        return "some histories grew without bound"
    rate = f"{dataset.attrs['cases'] / spent:,.0f} histories/s; {size / 1e6:.0f} MB on the disk; {watch}"
    return [Line(f"dampyr, error estimate {dataset.attrs['error_estimate']:.0e}", spent, spent, 1, rate)]


def dampers() -> list[Damper]:
    """The published damper at 1 V, each parameter spread by a tenth."""
    published = raminelli_2020.damper().values(VOLTAGE, static=False)
    spread = np.exp(SPREAD * np.random.default_rng(1).standard_normal((DAMPERS, len(published))))
    names = ("dahl.kx", "dahl.kw", "dahl.rho")
    return [Damper("dahl", dict(zip(names, map(float, published * row)))) for row in spread]


def _motions() -> list[GroundMotion]:
    return [kanai_tajimi(30.0, 0.02, seed=k, pga=4.0, rest=0.0) for k in range(MOTIONS)]


@dataclass
class Watch:
    """The largest memory so far, looked at while cases are done."""

    seen: dict[int, float] = field(default_factory=dict)  # tenths done -> MB

    def __call__(self, done: int, size: int) -> None:
        self.seen.setdefault(10 * done // size, memory())

    def __str__(self) -> str:
        summary = ", ".join(f"{self.seen[k]:.0f} MB at {10 * k} %" for k in (1, 5, 9) if k in self.seen)
        return f"largest memory {summary}, {memory():.0f} MB with the result"


def memory() -> float:
    """The largest memory of this process so far [MB]; NaN where the system does not tell."""
    try:
        import resource
    except ImportError:
        return float("nan")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1e-6 if sys.platform == "darwin" else 1.024e-3)
