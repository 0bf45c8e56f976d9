"""The same step on a graphics card: a thread per history, its numbers in registers from the first sample to the last.

Needs the extra ``gpu`` and a card of NVIDIA; with ``NUMBA_ENABLE_CUDASIM=1`` in the environment numba runs it on the processor,
slowly, which is how it is tested where there is no card.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Sequence
from functools import lru_cache
from types import FunctionType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.models.codegen.composition import Composition, namespace_of
from dampyr.structures.batch.assemble import WRITTEN_OUT_UP_TO, Text
from dampyr.structures.batch.branchless_math import constants
from dampyr.structures.batch.building_step import Small
from dampyr.structures.batch.engine import Engine, Integers, grounds
from dampyr.structures.batch.modal import step
from dampyr.structures.batch.run_blocks import CONSTANTS, MATH, Numbers
from dampyr.structures.building import Building

Array = NDArray[np.float64]
THREADS = 128  # in a block of the card
MAX_HISTORIES = 16384  # histories in a launch: what bounds the memory on the card


def missing() -> str:
    """Why no card can be used, or nothing."""
    try:
        from numba import cuda
    except ImportError as error:
        return f"numba has no CUDA here ({error}); install dampyr[gpu]"
    return "" if cuda.is_available() else "no graphics card with CUDA answers; run on the processor, device='cpu'"


class GpuEngine(Engine):
    """An engine that takes as many histories at a time as the card holds."""

    max_histories: ClassVar[int] = MAX_HISTORIES

    def _launch(
        self, motions: Sequence[Array], scales: Array, ends: Integers, t: Array, c: Array, block: Array, steps: Array
    ) -> Array:
        from numba import cuda

        kernel = _compiled(_source(self.text), self.compositions, self.precision)
        [ground], ring = grounds(motions, scales, len(ends), block.dtype.type), self._ring(block, steps)
        mask = ring.shape[1] // block.shape[1] - 1
        on_card = cuda.to_device(block)
        ends_, *ground_, t_, c_, ring_ = (cuda.to_device(a) for a in (ends, *ground, t, c, ring))
        blocks = -(-block.shape[1] // THREADS)
        kernel[blocks, THREADS](ends_, self.m, *ground_, t_, c_, on_card, ring_, mask)
        return np.asarray(on_card.copy_to_host())


def engine(
    building: Building,
    connections: Array,
    compositions: tuple[Composition, ...],
    dt: float,
    m: int,
    quantities: tuple[str, ...],
    precision: int = 64,
    together: bool = False,
) -> GpuEngine:
    """As `dampyr.structures.batch.engine.engine`, for the card, whose threads take the exact Bouc-Wen state."""
    if 2 * building.n > WRITTEN_OUT_UP_TO:
        raise InputError(
            f"{building.name} has {building.n} floors; a graphics card takes up to {WRITTEN_OUT_UP_TO // 2}: use device='cpu'"
        )
    text = Text(step(building, connections, dt / m), compositions, quantities, wide="wide")
    return GpuEngine(text, compositions, precision, m)


def _source(text: Text) -> str:
    """The text of the kernel: all rows in names, the steps in a loop of the thread."""
    assert isinstance(text.frame, Small)
    rows = text.rows.names
    given = [f"{name} = b[{k}, l]" for k, name in enumerate(rows) if not name.startswith("~")]
    numbers = [f"c{k} = c[{k}]" for k in range(text.frame.named)]
    names, values = ", ".join(text.updates), ", ".join(text.updates.values())
    stored = [f"b[{rows.index(name)}, l] = {name}" for name in text.updates]
    inner = [*text.lines, f"{names} = {values}", "part = part + share"]
    lines = [
        "def history(ends, m, g, who, scale, t, c, b, w, mask):",
        "    l, wide = cuda.grid(1), b.shape[1]",
        "    if l < wide:",
        "        dt, sixth, share, eighth_step, three_half_rate = t[0], t[1], t[2], t[3], t[4]",
        *("        " + line for line in [*numbers, *given]),
        "        for i in range(ends[l] - 1):",
        "            low, high, part = g[i, who[l]]*scale[l], g[i + 1, who[l]]*scale[l], zero",
        "            for j in range(m):",
        "                steps = i*m + j",
        "                slot_0, slot_1 = (2*steps + 1) & mask, (2*steps + 2) & mask",
        *("                " + line for line in inner),
        *("        " + line for line in stored),
    ]
    return "\n".join(lines) + "\n"


@lru_cache(maxsize=64)
def _compiled(source: str, compositions: tuple[Composition, ...], precision: int) -> Any:
    from numba import cuda

    kind = np.float64 if precision == 64 else np.float32
    text = namespace_of(compositions)[0] if compositions else ""
    tree, numbers = ast.parse(text), Numbers()
    numbers.visit(tree)
    plain = (*MATH, "exp", "tanh", "copysign", "floor")
    names: dict[str, Any] = {name: getattr(math, name) for name in plain}
    names |= {name: kind(value) for name, value in (CONSTANTS | numbers.exists | {"eighth": 0.125}).items()}
    names |= {"real": kind, "tiny": constants(precision)["tiny"], "cuda": cuda}
    for part in (ast.unparse(ast.fix_missing_locations(tree)), EIGHTH):
        exec(compile(part, "<parts>", "exec"), names)
    for name, value in list(names.items()):
        if isinstance(value, FunctionType):
            names[name] = cuda.jit(device=True, inline=True)(value)
    exec(compile(source, "<history>", "exec"), names)
    return cuda.jit(fastmath=False)(names["history"])


EIGHTH = "def eighth_over(t):\n    return eighth/t\n"
