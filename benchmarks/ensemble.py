"""Histories per second on one core, each contender at the longest step that keeps its error below 0.1 %: the 21-case suite."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import _diffrax, _opensees, _runge_kutta
from benchmarks._lines import Line, spoken
from benchmarks._suite import EL_CENTRO_SCALES, VOLTS, Case, coarsest, error, histories, motions, suite
from benchmarks._timing import race
from dampyr.errors import DampyrWarning
from dampyr.structures import ensemble as dampyr_ensemble
from dampyr.structures import two_storey
from dampyr.structures.batch.assemble import QUANTITIES
from dampyr.studies import raminelli_2020

TITLE = (
    "Building of chapter 5, published damper, 3 El Centro and 4 synthetic records x 0, 1, 2.25 V: time per history of 31.2 s "
    "on one core, at errors of the first floor's peak below 0.1 %"
)
WANTED = ("displacement", "drift")
SCALES = np.linspace(0.9, 1.1, 384)  # of the suite: 8,064 cases, one shard, all lanes full
COPIES = 24  # of the suite, side by side in diffrax, which gains from more
EL_CENTRO = EL_CENTRO_SCALES.index(1.0)


@dataclass(frozen=True)
class Contender:
    """``run`` takes this many histories; ``description`` is its step and its error."""

    run: Callable[[], Any]
    histories: float
    description: str = ""


def run(data: Path | None) -> list[Line]:
    """dampyr in its ways, OpenSeesPy, a compiled Runge-Kutta loop and diffrax; who is missing is told."""
    absent = [Line(f"{name}: {why}", np.nan, np.nan, 0) for name, why in missing().items()]
    with warnings.catch_warnings(), ThreadPoolExecutor(1) as one:
        warnings.simplefilter("ignore", DampyrWarning)  # the published damper was calibrated on smaller motions
        contenders = ours(one) | peers()
        lines = race({name: each.run for name, each in contenders.items()}, {}, rounds=5, budget=40.0)
    return [per_history(line, contenders[line.name]) for line in lines] + absent


def ours(executor: Any) -> dict[str, Contender]:
    """fast and strict, 64 and 32 bits, two quantities and all."""
    contenders = {}
    for accuracy, precision, quantities in product(("fast", "strict"), (64, 32), (WANTED, QUANTITIES)):
        what = partial(marched, executor, accuracy, precision, quantities)
        label = "displacement + drift" if quantities is WANTED else "all six quantities"
        contenders[f"dampyr, {accuracy}, {precision} bits, {label}"] = Contender(
            partial(what, SCALES), histories(suite()) * len(SCALES), str(error(peaks(what([1.0]))))
        )
    return contenders


def marched(executor: Any, accuracy: str, precision: int, quantities: tuple[str, ...], scales: Any) -> Any:
    """The suite at every scale, as its users would have it."""
    damper = raminelli_2020.damper()
    return dampyr_ensemble(
        two_storey(),
        motions(),
        damper,
        VOLTS,
        scales,
        executor,
        accuracy=accuracy,
        precision=precision,
        quantities=quantities,
    )


def peaks(dataset: Any) -> Any:
    """(21, 2) of an ensemble of the suite: the first floor and the second drift."""
    both = [dataset.displacement.isel(floor=0), dataset.drift.isel(storey=1)]
    return np.stack([values.to_numpy().reshape(-1) for values in both], axis=-1)


def missing() -> dict[str, str]:
    """Peers that cannot run, and why."""
    reasons = {"OpenSeesPy": _opensees.missing(), "diffrax": _diffrax.missing()}
    return {name: why for name, why in reasons.items() if why}


def peers() -> dict[str, Contender]:
    """Those that are there, each at the longest step that its error allows."""
    absent, contenders = missing(), {}
    three = [suite()[EL_CENTRO + k * len(motions())] for k in range(len(VOLTS))]  # one record at each voltage
    contenders |= _peer("compiled Runge-Kutta loop (numba, fastmath)", _runge_kutta.peaks, suite())
    if "diffrax" not in absent:
        contenders |= _peer(f"diffrax, Bosh3, {COPIES * len(suite())} side by side", _bosh3, suite() * COPIES)
    if "OpenSeesPy" not in absent:
        contenders |= _peer("OpenSeesPy, Newmark, BoucWen", _opensees.peaks, three)
    return contenders


_bosh3 = partial(_diffrax.peaks, "Bosh3")


def _peer(name: str, peaks: Callable[[list[Case], int], Any], cases: list[Case]) -> dict[str, Contender]:
    m, worst_error = coarsest(peaks)
    return {
        name: Contender(lambda: peaks(cases, m), histories(cases), f"step {spoken(cases[0].dt / m)}, {worst_error}")
    }


def per_history(line: Line, contender: Contender) -> Line:
    """The line for one history of 31.2 s."""
    median, fastest = line.median / contender.histories, line.fastest / contender.histories
    summary = f"{float(f'{1 / median:.3g}'):,g} histories/s; {contender.description}"
    return replace(line, median=median, fastest=fastest, error=summary)
