r"""Choice among records that exist, by their motion and input alone: which few predict the others best.

The records' forces are not looked at: a record g is taken to have parameters that deviate by :math:`\delta_g` from those of the
damper, alike where amplitude and frequency are alike (a model is wrong in the same way for the same motion), and a gain of its
own. Of a fit to the chosen records the expected mean square of the error of the predicted force, over its spread, is for a
record r

.. math:: \mathrm{tr}\, A_r\, \mathrm{cov}(\hat\theta - \theta - \delta_r), \qquad
   \hat\theta - \theta = \Big(\sum_g A_g\Big)^{-1} \sum_g A_g\, \delta_g

with the information A of each record's motion. Its mean over all records, every input counting the same, is made small: one
record after the other, then by exchanges. Without a damper the motion is weighed with a viscous Dahl model whose viscous
force at the greatest speed is its friction, and whose pre-sliding path is a hundredth of the median stroke.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrWarning, InputError
from dampyr.input_kinds import NO_INPUT
from dampyr.models import Constant, Damper
from dampyr.planning.expected_information import (
    GAIN,
    RIDGE,
    CoefficientLayout,
    assumed_spread,
    expected_information,
    layout,
)
from dampyr.records import Record, measure, nominal_inputs

Array = NDArray[np.float64]
ALIKE = 2.0  # factor of amplitude or frequency over which deviations lose their likeness: exp(-1/2) of it
MISFIT = (
    0.10  # of each parameter, by what the model misses: as good models of the published campaign change along its line
)
SLIDING = 0.01  # of the median stroke: the pre-sliding path of the motion's own damper
BLIND = "its force was replaced, for a choice by its motion"
__all__ = ["choose_records", "expected_misses"]


def choose_records(records: Sequence[Record], n: int, damper: Damper | None = None) -> list[Record]:
    """The ``n`` records that are expected to predict the others best, in their order; their forces are not looked at.

    Parameters
    ----------
    records
        two or more with inputs; one is alike another where amplitude, frequency and input are.
    n
        how many of them.
    damper
        of which the motion is weighed; without it a viscous Dahl model, see above.

    Raises
    ------
    InputError
        an ``n`` that is not below the number of records, or a record of which the input or the motion is not known.
    """
    listed = nominal_inputs(list(records))
    if not 1 <= n < len(listed):
        raise InputError(f"n = {n} of {len(listed)} records is not a choice; give 1 to {len(listed) - 1}")
    misses = expected_misses(listed, damper)
    chosen: list[int] = []
    while len(chosen) < n:
        others = [k for k in range(len(listed)) if k not in chosen]
        chosen.append(min(others, key=lambda k: misses([*chosen, k])))
    improved = True
    while improved:
        improved = False
        for place in range(n):
            rest = chosen[:place] + chosen[place + 1 :]
            now = misses(chosen)
            options = [k for k in range(len(listed)) if k not in rest]
            best = min(options, key=lambda k: misses([*rest, k]))
            if misses([*rest, best]) < now * (1.0 - 1e-9):
                chosen[place], improved = best, True
    return [records[k] for k in sorted(chosen)]


def expected_misses(records: Sequence[Record], damper: Damper | None = None) -> Misses:
    """The criterion of `choose_records` for these records."""
    without = [r.name for r in records if r.input is None or np.ptp(np.asarray(_input_of(r)))]
    if without:
        raise InputError(f"{without[0]}: its input is not known or varies, and records are chosen by it; leave it out")
    inputs = np.array([float(np.mean(_input_of(r))) for r in records])
    # without a damper the displacement stands for the force: something that a record can be measured by
    blind = [
        _replace_force(r, damper) if damper else r.replace(note=BLIND, force=1e3 * r.displacement) for r in records
    ]
    measured = [measure(record) for record in blind]
    stroke = np.array([m.peak_to_peak_m for m in measured])
    place = np.log(np.column_stack((stroke, [m.frequency_hz for m in measured]))) / np.log(ALIKE)
    if damper is None:
        fastest = max(m.peak_speed for m in measured)
        has_input = records[0].input != NO_INPUT
        low, high = (float(inputs.min()), float(inputs.max())) if has_input else (-np.inf, np.inf)
        damper = Damper(
            "dahl",
            {
                "dahl.kx": Constant(1.0 / fastest, low, high),
                "dahl.kw": Constant(1.0, low, high),
                "dahl.rho": Constant(1.0 / (SLIDING * float(np.median(stroke))), low, high),
            },
            input=str(records[0].input),
        )
        blind = [_replace_force(r, damper) for r in records]
    plan = layout(damper, list(inputs))
    spread = assumed_spread(plan)
    A = np.stack([expected_information(plan, record, spread).A for record in blind])
    return Misses(plan, A, place, inputs)


def _input_of(record: Record) -> float | Array:
    value = 0.0 if record.input == NO_INPUT else record.input_channel
    return np.nan if value is None else value


def _replace_force(record: Record, damper: Damper) -> Record:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        force = damper.force_of_motion(
            record.time,
            record.displacement,
            record.voltage,
            record.current,
            velocity=record.velocity,
            allow_extrapolation=True,
        )
    return record.replace(note=BLIND, force=force)


@dataclass(frozen=True, eq=False)
class Misses:
    """The expected root mean square error, over the force's spread, of predictions by a fit to the chosen records: ``A``
    (n, G, G) is the information of each record, ``place`` (n, 2) its amplitude and frequency in `ALIKE`, ``inputs`` (n,)."""

    plan: CoefficientLayout
    A: Array
    place: Array
    inputs: Array

    def __call__(self, chosen: Sequence[int]) -> float:
        """The mean over all records, every input counting the same."""
        S, A, G = list(chosen), self.A, self.A.shape[1]
        gain = np.where(self.plan.is_linear, 1.0, 0.0)
        of_gain = GAIN**2 * np.outer(gain, gain)
        alike = MISFIT**2 * self._alike
        of_chosen = A[S]
        B = np.linalg.inv(of_chosen.sum(axis=0) + RIDGE * np.eye(G))
        meat = np.einsum("gij,gh,hjk->ik", of_chosen, alike[np.ix_(S, S)], of_chosen) + (
            of_chosen @ of_gain @ of_chosen
        ).sum(axis=0)
        C = B @ (meat + RIDGE**2 * np.eye(G)) @ B
        shared = np.einsum("gij,gr->rij", of_chosen, alike[S])
        shared[S] += of_chosen @ of_gain
        squares = np.einsum("rij,ji->r", A, C) - 2.0 * np.einsum("rij,jk,rki->r", A, B, shared)
        squares += MISFIT**2 * np.einsum("rii->r", A) + np.einsum("rij,ji->r", A, of_gain)
        return float(np.sqrt(max(float(self._weights @ squares), 0.0)))

    @cached_property
    def _alike(self) -> Array:
        between = self.place[:, None] - self.place[None]
        return np.asarray(np.exp(-0.5 * np.sum(between**2, axis=-1)))

    @cached_property
    def _weights(self) -> Array:
        _, which, counts = np.unique(np.round(self.inputs, 6), return_inverse=True, return_counts=True)
        return np.asarray(1.0 / counts[which] / counts.size)
