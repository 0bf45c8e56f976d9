"""The peaks of an ensemble in short: medians and 84 % fractiles across motions and draws of the damper."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from dampyr.structures.ensembles.incremental import BEYOND
from dampyr.structures.ensembles.store import dataset_of
from dampyr.structures.time_history.peaks import groups

BY = ("building", "input")
SHOWN = 6  # scales: with more, a row for each would make a table that nobody reads


@dataclass(frozen=True)
class SummaryRow:
    """One group at one scale: quantity -> (median, 84 % fractile) of the worst storey, floor or damper, SI; None for a
    quantity that the group has not. ``cases`` are all, ``unbounded`` those without peaks, which count as infinite."""

    name: str
    scale: float
    cases: int
    unbounded: int
    peaks: dict[str, tuple[float, float] | None]


def summary(dataset: Any) -> list[SummaryRow]:
    """A row for each building and input (and the bare building) at every scale; of more than six, at the one nearest 1."""
    dataset = dataset_of(dataset)
    scales = np.asarray(dataset.scale.values)
    chosen = range(scales.size) if scales.size <= SHOWN else [int(np.argmin(np.abs(scales - 1.0)))]
    quantities = [str(q) for q in dataset.data_vars if dataset[q].shape[-1]]
    unit = np.ones(dataset.sizes["motion"])
    groups_by_quantity = {q: {group.name: group for group in groups(dataset, q, "worst", unit, BY)} for q in quantities}
    rows = []
    for name, group in max(groups_by_quantity.values(), key=len).items():
        for s in chosen:
            lost = int(np.isnan(group.peaks[..., s]).sum())
            peaks = {
                q: _two(groups_by_quantity[q][name].peaks[..., s]) if name in groups_by_quantity[q] else None
                for q in quantities
            }
            rows.append(SummaryRow(name, float(scales[s]), group.peaks[..., s].size, lost, peaks))
    return rows


def _two(peaks: Any) -> tuple[float, float]:
    median, high = np.quantile(np.where(np.isnan(peaks), BEYOND, peaks), [0.5, 0.84])
    return _bounded(median), _bounded(high)


def _bounded(value: float) -> float:
    return float(value) if value < BEYOND * 1e-6 else math.inf
