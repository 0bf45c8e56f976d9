"""A building with dampers, ready to take blocks of histories; one engine serves every damper of the same parts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dampyr.models.codegen.composition import Composition
from dampyr.structures.batch.assemble import Text
from dampyr.structures.batch.branchless_math import BLOCK_WIDTH
from dampyr.structures.batch.modal import basis_of, step
from dampyr.structures.batch.run_blocks import compiled
from dampyr.structures.building import Building

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
MAX_SITES = 3  # Newton's matrix is written out


@dataclass(frozen=True, eq=False)
class Engine:
    """One building, sites and length of step, compiled; ``most`` histories at a time."""

    text: Text
    compositions: tuple[Composition, ...]
    precision: int
    m: int
    together: bool = False
    max_histories: ClassVar[int] = 16 * BLOCK_WIDTH

    def run(
        self,
        motions: Sequence[Array],
        values: Sequence[Array],
        rest: Array,
        delays: Array | None = None,
        scales: Array | None = None,
    ) -> dict[str, Array]:
        """The peaks and energies of up to ``most`` histories: quantity -> (lanes, rows).

        ``motions`` are the ground's accelerations, a history each, times ``scales`` (lanes,); ``values`` the parameters
        (lanes, P) of each site; ``rest`` and ``delays`` (lanes, sites) the forces at rest [N] and the delays [s] of the sites.
        """
        kind = np.float64 if self.precision == 64 else np.float32
        steps = np.zeros_like(rest) if delays is None else delays / self.text.step.h
        h = self.text.step.h
        block, ends = self._block(values, rest, steps, kind), np.array([len(motion) for motion in motions])
        t: Array = np.array([h / 2, h / 6, 1 / self.m, h / 8, 1.5 / h], kind)
        c: Array = np.array(self.text.coefficients, kind)
        return self._read(
            self._launch(motions, np.ones(len(motions)) if scales is None else scales, ends, t, c, block, steps)
        )

    def _launch(
        self, motions: Sequence[Array], scales: Array, ends: Integers, t: Array, c: Array, block: Array, steps: Array
    ) -> Array:
        """The block as each history left it at its end (rows, count), as many histories at a time as there are lanes."""
        wide, kind = self.text.block_width, block.dtype.type
        final_block, here = np.empty((block.shape[0], len(ends))), _aligned(block.shape[0] * wide, kind)
        batch = here.reshape(-1, wide)
        late, ring = any(map(self.text.late, range(self.text.sites))), np.empty((0, 0))
        for k, ground in enumerate(grounds(motions, scales, wide, kind)):
            some = slice(k * wide, (k + 1) * wide)
            count = len(ends[some])
            batch[:, :count], batch[:, count:] = block[:, some], block[:, :1]
            if late or k == 0:
                ring = self._ring(batch, steps)
            self._march(ends[some], ground, t, c, batch, ring, final_block[:, some])
        return final_block

    def _march(
        self,
        ends: Integers,
        ground: tuple[Array, Integers, Array],
        t: Array,
        c: Array,
        batch: Array,
        ring: Array,
        final_block: Array,
    ) -> None:
        """The histories of one block, each to its end."""
        kernel = compiled(self.text.source, self.compositions, self.precision, self.together)
        first, mask, lasts = 0, ring.shape[1] // self.text.block_width - 1, sorted(set(ends.tolist()))
        for last in lasts:
            kernel(first, last - 1, self.m, *ground, t, c, batch.reshape(-1), ring, mask)
            ended = slice(len(ends)) if len(lasts) == 1 else np.flatnonzero(ends == last)
            final_block[:, ended] = batch[:, ended]
            first = last - 1

    def _block(self, values: Sequence[Array], rest: Array, steps: Array, kind: type) -> Array:
        """What the histories begin with, a column each."""
        rows = self.text.rows
        block: Array = np.zeros((len(rows.names), len(rest)), kind)
        for d, parameters in enumerate(values):
            for k in range(parameters.shape[1]):
                block[rows[f"p{d}_{k}"]] = parameters[:, k]
            for name in (f"f{d}", f"m{d}", *((f"u{d}", f"R{d}") if self.text.late(d) else ())):
                block[rows[name]] = rest[:, d]
            if self.text.late(d):
                block[rows[f"D{d}"]] = steps[:, d]
        return block

    def _ring(self, block: Array, steps: Array) -> Array:
        """The forces of late dampers at the latest nodes (sites, nodes * lanes): a power of two of them."""
        nodes, wide = 2 * int(np.ceil(steps.max(initial=0.0))) + 6, block.shape[1]
        ring = np.zeros((max(self.text.sites, 1), wide << (nodes - 1).bit_length()), block.dtype)
        for d in range(self.text.sites):
            if self.text.late(d):
                ring[d, :wide] = block[self.text.rows[f"R{d}"]]
        return ring

    def _read(self, final_block: Array) -> dict[str, Array]:
        text = self.text
        read: dict[str, list[Array]] = {quantity: [] for quantity in text.quantities}
        for (quantity, _), name in text.peaks.items():
            last = final_block[text.rows[text.frame.latest(name)]]
            read[quantity].append(np.maximum(final_block[text.rows[name]], np.abs(last)))
        if "energy" in read:
            read["energy"] = [final_block[text.rows[f"E{d}"]] for d in range(text.sites)]
        return {quantity: np.stack(rows, axis=1) for quantity, rows in read.items() if rows}


LINE = 64  # bytes of a line of a core's cache, which eight numbers of a row should not straddle


def _aligned(size: int, kind: type) -> Array:
    """An uninitialised array that begins on a line of the cache."""
    width = np.dtype(kind).itemsize
    buffer: Array = np.empty(size + LINE // width, kind)
    first = -buffer.ctypes.data % LINE // width
    aligned: Array = buffer[first : first + size]
    return aligned


def grounds(motions: Sequence[Array], scales: Array, wide: int, kind: type) -> Iterator[tuple[Array, Integers, Array]]:
    """For each ``wide`` histories: their different motions as columns (samples, motions), which of them each lane has, and
    its scale, 0 where no history is."""
    number = {id(motion): k for k, motion in enumerate(motions)}
    which = np.array([number[id(motion)] for motion in motions])
    columns, previous = np.empty((0, 0)), which[:0]
    for first in range(0, len(motions), wide):
        different, here = np.unique(which[first : first + wide], return_inverse=True)
        if not np.array_equal(different, previous):
            previous, columns = different, np.zeros((max(len(motions[k]) for k in different), len(different)), kind)
            for column, k in zip(columns.T, different, strict=True):
                column[: len(motions[k])] = motions[k]
        who = np.zeros(wide, np.int64)
        scale: Array = np.zeros(wide, kind)
        who[: len(here)], scale[: len(here)] = here, scales[first : first + wide]
        yield columns, who, scale


def engine(
    building: Building,
    connections: Array,
    compositions: tuple[Composition, ...],
    dt: float,
    m: int,
    quantities: tuple[str, ...],
    precision: int = 64,
    together: bool = False,
) -> Engine:
    """The engine of ``building`` with sites at ``connections`` (N, n), m steps to a sample of ``dt`` seconds.

    ``together`` is for dampers whose Bouc-Wen states the lanes can walk together
    (`dampyr.structures.batch.bouc_wen_branchless.holds`).
    """
    one = step(building, connections, dt / m, basis_of(building))
    text = Text(one, compositions, quantities, BLOCK_WIDTH * 64 // precision)
    made = Engine(text, compositions, precision, m, together)
    compiled(text.source, compositions, precision, together)  # by one thread, before several ask for it
    return made


def takes(compositions: Sequence[Composition]) -> bool:
    """Whether the lanes can march these dampers: few, without a mass of their own."""
    return len(compositions) <= MAX_SITES and not any(map(_asks_for_acceleration, compositions))


def _asks_for_acceleration(composition: Composition) -> bool:
    return any("a" in p.force.arguments for p in composition.parts if p.force)
