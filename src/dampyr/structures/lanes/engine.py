"""A building with dampers, ready to take blocks of histories; one engine serves every damper of the same parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.models.composition import Composition
from dampyr.structures.building import Building
from dampyr.structures.lanes.arithmetic import LANES
from dampyr.structures.lanes.block import compiled
from dampyr.structures.lanes.coordinates import basis_of, step
from dampyr.structures.lanes.text import Text

Array = NDArray[np.float64]
MOST_SITES = 3  # Newton's matrix is written out
CORRECTIONS, CORRECTIONS_IN_SERIES = 1, 3


@dataclass(frozen=True, eq=False)
class Engine:
    """One building, sites and length of step, compiled."""

    text: Text
    compositions: tuple[Composition, ...]
    precision: int
    m: int

    def run(self, motions: Sequence[Array], values: Sequence[Array], rest: Array) -> dict[str, Array]:
        """The peaks and energies of up to 64 histories: quantity -> (lanes, rows).

        ``motions`` are the ground's accelerations, a history each; ``values`` the parameters (lanes, P) of each site; ``rest``
        (lanes, sites) the forces at rest.
        """
        kind = np.float64 if self.precision == 64 else np.float32
        block, count = self._block(values, rest, kind), len(motions)
        ends = np.array([len(motion) for motion in motions])
        ag = np.zeros((int(ends.max()), LANES), kind)
        for lane, motion in enumerate(motions):
            ag[: len(motion), lane] = motion
        kernel = compiled(self.text.source, self.compositions, self.precision)
        h = self.text.step.h
        t = np.array([h / 2, h / 6, 1 / self.m, h / 8, 1.5 / h], kind)
        c, work = np.array(self.text.coefficients, kind), self._scratch(kind)
        found = np.empty((block.shape[0], count))
        first = 0
        for last in np.unique(ends):
            kernel(first, int(last) - 1, self.m, LANES, ag, t, c, block.reshape(-1), work)
            ended = np.flatnonzero(ends == last)
            found[:, ended] = block[:, ended]
            first = int(last) - 1
        return self._read(found)

    def _block(self, values: Sequence[Array], rest: Array, kind: type) -> Array:
        rows = self.text.rows
        block: Array = np.zeros((len(rows.names), LANES), kind)
        for d, parameters in enumerate(values):
            count = len(parameters)
            for k in range(parameters.shape[1]):
                block[rows[f"p{d}_{k}"]] = parameters[0, k]
                block[rows[f"p{d}_{k}"], :count] = parameters[:, k]
            for name in (f"f{d}", f"m{d}"):
                block[rows[name], :count] = rest[:, d]
        return block

    def _scratch(self, kind: type) -> Array:
        width = max([1, *(max(c.n_states, len(c.parameters)) for c in self.compositions)])
        return np.zeros((max(2 * len(self.compositions), 1), width), kind)

    def _read(self, found: Array) -> dict[str, Array]:
        text = self.text
        read: dict[str, list[Array]] = {quantity: [] for quantity in text.quantities}
        for (quantity, _), name in text.peaks.items():
            last = found[text.rows[text.frame.latest(name)]]
            read[quantity].append(np.maximum(found[text.rows[name]], np.abs(last)))
        if "energy" in read:
            read["energy"] = [found[text.rows[f"E{d}"]] for d in range(text.sites)]
        return {quantity: np.stack(rows, axis=1) for quantity, rows in read.items() if rows}


def engine(
    building: Building,
    connections: Array,
    compositions: tuple[Composition, ...],
    dt: float,
    m: int,
    quantities: tuple[str, ...],
    precision: int = 64,
) -> Engine:
    """The engine of ``building`` with sites at ``connections`` (N, n), m steps to a sample of ``dt`` seconds."""
    corrections = CORRECTIONS_IN_SERIES if any(c.in_series for c in compositions) else CORRECTIONS
    one = step(building, connections, dt / m, basis_of(building))
    return Engine(Text(one, compositions, quantities, corrections), compositions, precision, m)


def takes(compositions: Sequence[Composition]) -> bool:
    """Whether the lanes can march these dampers: few, without delay and without a mass of their own."""
    plain = all(c.delay is None and not _asks_for_acceleration(c) for c in compositions)
    return plain and len(compositions) <= MOST_SITES


def _asks_for_acceleration(composition: Composition) -> bool:
    return any("a" in p.force.arguments for p in composition.parts if p.force)
