"""A building with dampers, ready to take blocks of histories; one engine serves every damper of the same parts."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dampyr.models.composition import Composition
from dampyr.structures.building import Building
from dampyr.structures.lanes.arithmetic import LANES
from dampyr.structures.lanes.block import compiled
from dampyr.structures.lanes.coordinates import basis_of, step
from dampyr.structures.lanes.text import Text

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
MOST_SITES = 3  # Newton's matrix is written out


@dataclass(frozen=True, eq=False)
class Engine:
    """One building, sites and length of step, compiled; ``most`` histories at a time."""

    text: Text
    compositions: tuple[Composition, ...]
    precision: int
    m: int
    together: bool = False
    most: ClassVar[int] = 16 * LANES

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
        """The block as each history left it at its end (rows, count), 64 histories at a time."""
        found, here = np.empty((block.shape[0], len(ends))), _aligned(block.shape[0] * LANES, block.dtype.type)
        lanes = here.reshape(-1, LANES)
        for first in range(0, len(ends), LANES):
            some = slice(first, first + LANES)
            count = len(ends[some])
            lanes[:, :count], lanes[:, count:] = block[:, some], block[:, :1]
            ag, ring = _ground(motions[some], scales[some], LANES, block.dtype.type), self._ring(lanes, steps)
            self._march(ends[some], ag, t, c, lanes, ring, found[:, some])
        return found

    def _march(self, ends: Integers, ag: Array, t: Array, c: Array, lanes: Array, ring: Array, found: Array) -> None:
        """The histories of one block, each to its end."""
        kernel = compiled(self.text.source, self.compositions, self.precision, self.together)
        first, mask = 0, ring.shape[1] // LANES - 1
        for last in np.unique(ends):
            kernel(first, int(last) - 1, self.m, LANES, ag, t, c, lanes.reshape(-1), ring, mask)
            ended = np.flatnonzero(ends == last)
            found[:, ended] = lanes[:, ended]
            first = int(last) - 1

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

    def _read(self, found: Array) -> dict[str, Array]:
        text = self.text
        read: dict[str, list[Array]] = {quantity: [] for quantity in text.quantities}
        for (quantity, _), name in text.peaks.items():
            last = found[text.rows[text.frame.latest(name)]]
            read[quantity].append(np.maximum(found[text.rows[name]], np.abs(last)))
        if "energy" in read:
            read["energy"] = [found[text.rows[f"E{d}"]] for d in range(text.sites)]
        return {quantity: np.stack(rows, axis=1) for quantity, rows in read.items() if rows}


LINE = 64  # bytes of a line of a core's cache, which eight numbers of a row should not straddle


def _aligned(size: int, kind: type) -> Array:
    """An uninitialised array that begins on a line of the cache."""
    width = np.dtype(kind).itemsize
    room: Array = np.empty(size + LINE // width, kind)
    first = -room.ctypes.data % LINE // width
    found: Array = room[first : first + size]
    return found


_held = threading.local()


def _ground(motions: Sequence[Array], scales: Array, wide: int, kind: type) -> Array:
    """Scaled motions of different lengths as the columns of one array (samples, wide), which the thread keeps for the next."""
    size = max(map(len, motions)) * wide
    if getattr(_held, "size", 0) < size or _held.ground.dtype != kind:
        _held.size, _held.ground = size, _aligned(size, kind)
    ag: Array = _held.ground[:size].reshape(-1, wide)
    for _, group in groupby(range(len(motions)), key=lambda lane: id(motions[lane])):
        lanes = list(group)
        motion: Array = motions[lanes[0]].astype(kind)
        some = slice(lanes[0], lanes[-1] + 1)
        np.multiply(motion[:, None], scales[some].astype(kind), out=ag[: len(motion), some])
        ag[len(motion) :, some] = 0.0
    ag[:, len(motions) :] = 0.0
    return ag


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

    ``together`` is for dampers whose Bouc-Wen states the lanes can walk together (`dampyr.structures.lanes.flow.holds`).
    """
    one = step(building, connections, dt / m, basis_of(building))
    made = Engine(Text(one, compositions, quantities), compositions, precision, m, together)
    compiled(made.text.source, compositions, precision, together)  # by one thread, before several ask for it
    return made


def takes(compositions: Sequence[Composition]) -> bool:
    """Whether the lanes can march these dampers: few, without a mass of their own."""
    return len(compositions) <= MOST_SITES and not any(map(_asks_for_acceleration, compositions))


def _asks_for_acceleration(composition: Composition) -> bool:
    return any("a" in p.force.arguments for p in composition.parts if p.force)
