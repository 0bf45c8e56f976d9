"""Batch engine: a building with dampers, compiled to run blocks of histories.

One engine serves every damper of the same parts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.models.codegen.composition import Composition
from dampyr.structures.batch.assemble import KernelText
from dampyr.structures.batch.branchless_math import BLOCK_WIDTH
from dampyr.structures.batch.lane_inverse import left_after_period, sizes_of
from dampyr.structures.batch.law_step import SiteControl, pieces_of
from dampyr.structures.batch.modal import basis_of, step
from dampyr.structures.batch.run_blocks import compiled
from dampyr.structures.building import Building
from dampyr.structures.control_laws import lag_of
from dampyr.structures.controller import design_controller

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
MAX_HISTORIES = 16 * BLOCK_WIDTH  # in a call: 16 blocks, whose rows take about half a megabyte
MANY_ROWS = 1000  # beyond, fewer blocks: twenty sites have 2,600 rows


@dataclass(frozen=True)
class Batch:
    """Histories for a launch: ``motions`` and ``scales`` a history each, ``ends`` their numbers of samples, ``block`` what they
    begin with (rows, histories), ``delays`` in steps (histories, sites); the kernel's ``times`` and ``coefficients``."""

    motions: Sequence[Array]
    scales: Array
    ends: Integers
    times: Array
    coefficients: Array
    block: Array
    delays: Array


@dataclass(frozen=True, eq=False)
class Engine:
    """One building, sites and length of step; ``launch`` runs up to ``max_histories`` at a time on one kind of device.

    ``launch(engine, batch)`` gives the block as each history left it at its end (rows, histories).
    """

    text: KernelText
    compositions: tuple[Composition, ...]
    precision: int
    m: int
    launch: Callable[[Any, Batch], Array]
    max_histories: int = MAX_HISTORIES
    branchless: bool = False

    def run(
        self,
        motions: Sequence[Array],
        values: Sequence[Array],
        rest: Array,
        delays: Array | None = None,
        scales: Array | None = None,
    ) -> dict[str, Array]:
        """The peaks and energies of up to ``max_histories`` histories: quantity -> (histories, rows).

        ``motions`` are the ground's accelerations, a history each, times ``scales`` (histories,); ``values`` the parameters
        (histories, P) of each site; ``rest`` and ``delays`` (histories, sites) the forces at rest [N] and the delays [s].
        """
        kind = np.float64 if self.precision == 64 else np.float32
        h = self.text.step.h
        steps = np.zeros_like(rest) if delays is None else delays / h
        batch = Batch(
            motions,
            np.ones(len(motions)) if scales is None else scales,
            np.array([len(motion) for motion in motions]),
            np.array([h / 2, h / 6, 1 / self.m, h / 8, 1.5 / h], kind),
            np.array(self.text.coefficients, kind),
            self._block(values, rest, steps, kind),
            steps,
        )
        return self._read(self.launch(self, batch))

    def _block(self, values: Sequence[Array], rest: Array, steps: Array, kind: type) -> Array:
        """The block at the start, a history in each column."""
        rows = self.text.rows
        block: Array = np.zeros((len(rows.names), len(rest)), kind)
        for d, parameters in enumerate(values):
            for name, column in zip(self.text.value_rows(d), parameters.T, strict=True):
                block[rows[name]] = column
            for name in (f"f{d}", f"mf{d}", *((f"u{d}", f"R{d}") if self.text.is_delayed(d) else ())):
                block[rows[name]] = rest[:, d]
            if self.text.is_delayed(d):
                block[rows[f"D{d}"]] = steps[:, d]
        for name, value in self.text.starts_at.items():
            block[rows[name]] = value
        return block

    def ring(self, block: Array, steps: Array) -> Array:
        """The forces of delayed dampers at the latest nodes (sites, nodes * width): a power of two of them, all at rest."""
        nodes, wide = 2 * int(np.ceil(steps.max(initial=0.0))) + 6, block.shape[1]
        ring = np.zeros((max(self.text.sites, 1), wide << (nodes - 1).bit_length()), block.dtype)
        for row, d in enumerate(self.text.order):
            if self.text.is_delayed(d):
                ring[row, :wide] = block[self.text.rows[f"R{d}"]]
        return ring

    def _read(self, final_block: Array) -> dict[str, Array]:
        text = self.text
        for law in text.laws.values():
            law.check(final_block)
        read: dict[str, list[Array]] = {quantity: [] for quantity in text.quantities}
        for (quantity, _), name in text.peaks.items():
            last = final_block[text.rows[text.frame.latest(name)]]
            read[quantity].append(np.maximum(final_block[text.rows[name]], np.abs(last)))
        if "energy" in read:
            read["energy"] = [final_block[text.rows[f"E{d}"]] for d in range(text.sites)]
        return {quantity: np.stack(rows, axis=1) for quantity, rows in read.items() if rows}


def launch_blocks(engine: Engine, batch: Batch) -> Array:
    """The histories on the processor, a block at a time."""
    width, kind, text = engine.text.block_width, batch.block.dtype.type, engine.text
    final_block, buffer = (
        np.empty((batch.block.shape[0], len(batch.ends))),
        _aligned(batch.block.shape[0] * width, kind),
    )
    block = buffer.reshape(-1, width)
    delayed, ring = any(map(text.is_delayed, range(text.sites))), np.empty((0, 0))
    kernel = compiled(
        text.source, engine.compositions, engine.precision, engine.branchless, text.functions, text.searches
    )
    for k, ground in enumerate(grounds(batch.motions, batch.scales, width, kind)):
        some = slice(k * width, (k + 1) * width)
        ends = batch.ends[some]
        block[:, : len(ends)], block[:, len(ends) :] = batch.block[:, some], batch.block[:, :1]
        if delayed or k == 0:
            ring = engine.ring(block, batch.delays)
        first, mask, lasts = 0, ring.shape[1] // width - 1, sorted(set(ends.tolist()))
        for last in lasts:  # histories of different lengths: each is read where it ends
            kernel(first, last - 1, engine.m, *ground, batch.times, batch.coefficients, block.reshape(-1), ring, mask)
            ended = np.flatnonzero(ends == last)
            final_block[:, some][:, ended] = block[:, ended]
            first = last - 1
    return final_block


CACHE_LINE = 64  # bytes; eight numbers of a row should not straddle two lines


def _aligned(size: int, kind: type) -> Array:
    """An uninitialised array that begins on a line of the cache."""
    width = np.dtype(kind).itemsize
    buffer: Array = np.empty(size + CACHE_LINE // width, kind)
    first = -buffer.ctypes.data % CACHE_LINE // width
    aligned: Array = buffer[first : first + size]
    return aligned


def grounds(motions: Sequence[Array], scales: Array, width: int, kind: type) -> Iterator[tuple[Array, Integers, Array]]:
    """For each ``width`` histories: their different motions as columns (samples, motions), which of them each history has, and
    its scale, 0 where there is no history."""
    number = {id(motion): k for k, motion in enumerate(motions)}
    which = np.array([number[id(motion)] for motion in motions])
    columns, previous = np.empty((0, 0)), which[:0]
    for first in range(0, len(motions), width):
        different, column_of = np.unique(which[first : first + width], return_inverse=True)
        if not np.array_equal(different, previous):
            previous, columns = different, np.zeros((max(len(motions[k]) for k in different), len(different)), kind)
            for column, k in zip(columns.T, different, strict=True):
                column[: len(motions[k])] = motions[k]
        who = np.zeros(width, np.int64)
        scale: Array = np.zeros(width, kind)
        who[: len(column_of)], scale[: len(column_of)] = column_of, scales[first : first + width]
        yield columns, who, scale


def engine(
    building: Building,
    connections: Array,
    compositions: tuple[Composition, ...],
    dt: float,
    m: int,
    quantities: tuple[str, ...],
    precision: int = 64,
    branchless: bool = False,
    controls: tuple[SiteControl | None, ...] = (),
) -> Engine:
    """The engine of ``building`` with sites at ``connections`` (N, n), m steps to a sample of ``dt`` seconds.

    ``branchless`` is for dampers whose Bouc-Wen states can be integrated without branches
    (`dampyr.structures.batch.bouc_wen_branchless.is_vectorisable`). ``controls`` are the laws of the sites, if they have some.
    """
    building_step = step(building, connections, dt / m, basis_of(building))
    text = KernelText(building_step, compositions, quantities, BLOCK_WIDTH * 64 // precision, controls=controls)
    blocks = max(1, MAX_HISTORIES // BLOCK_WIDTH * MANY_ROWS // max(MANY_ROWS, len(text.rows.names)))
    compiled_engine = Engine(text, text.kinds, precision, m, launch_blocks, BLOCK_WIDTH * blocks, branchless)
    # by one thread, before several ask for it
    compiled(text.source, text.kinds, precision, branchless, text.functions, text.searches)
    return compiled_engine


def control_of(building: Building, connections: Array, d: int, law: Any, damper: Any, dt: float, m: int) -> SiteControl:
    """The law of damper ``d`` at m steps to a sample of ``dt`` seconds, for the engine of ``building``."""
    controller, n, basis = design_controller(law, building, connections, d), building.n, basis_of(building)
    rows = (
        controller.rows
        if basis is None
        else np.hstack([controller.rows[:, : 2 * n] @ basis, controller.rows[:, 2 * n :]])
    )
    every, left = round(law.period * m / dt), left_after_period(law, damper)
    return SiteControl(controller, rows, every, lag_of(law, damper), pieces_of(damper), sizes_of(law, damper), left)


def can_run(compositions: Sequence[Composition]) -> bool:
    """Whether an engine can run these dampers: those without a mass of their own."""
    return not any(map(_uses_acceleration, compositions))


def _uses_acceleration(composition: Composition) -> bool:
    return any("a" in p.force.arguments for p in composition.parts if p.force)
