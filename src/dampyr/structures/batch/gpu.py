"""Batch engine on a graphics card: a thread per history, its numbers in registers from the first sample to the last.

Needs the extra ``gpu`` and a card of NVIDIA; with ``NUMBA_ENABLE_CUDASIM=1`` in the environment numba runs it on the processor,
slowly, which is how it is tested where there is no card.
"""

from __future__ import annotations

import ast
import math
from functools import lru_cache
from types import FunctionType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError, install_line
from dampyr.models.codegen.composition import Composition
from dampyr.models.codegen.syntax_trees import statements_of
from dampyr.structures.batch.assemble import ARGUMENTS, TIMES, KernelText
from dampyr.structures.batch.branchless_math import constants
from dampyr.structures.batch.building_step import Small
from dampyr.structures.batch.engine import Batch, Engine, grounds
from dampyr.structures.batch.modal import DENSE_UP_TO, step
from dampyr.structures.batch.run_blocks import CONSTANTS, MATH, Numbers, functions_of
from dampyr.structures.building import Building

Array = NDArray[np.float64]
THREADS = 128  # in a block of the card: four warps
MAX_HISTORIES = 16384  # histories in a launch: what bounds the memory on the card


def missing() -> str:
    """Why no card can be used, or nothing."""
    try:
        from numba import cuda
    except ImportError as error:
        return f"numba has no CUDA here ({error}); install the extra: {install_line('gpu')}"
    return "" if cuda.is_available() else "no graphics card with CUDA answers; run on the processor, device='cpu'"


def launch_on_card(engine: Engine, batch: Batch) -> Array:
    """The histories on the card, a thread each."""
    from numba import cuda

    kernel = _compiled(_source(engine.text), engine.compositions, engine.precision)
    [ground] = grounds(batch.motions, batch.scales, len(batch.ends), batch.block.dtype.type)
    ring = engine.ring(batch.block, batch.delays)
    mask = ring.shape[1] // batch.block.shape[1] - 1
    block = cuda.to_device(batch.block)
    arrays = (batch.ends, *ground, batch.times, batch.coefficients, ring)
    ends, *ground_, times, coefficients, ring_ = (cuda.to_device(array) for array in arrays)
    blocks = -(-batch.block.shape[1] // THREADS)
    kernel[blocks, THREADS](ends, engine.m, *ground_, times, coefficients, block, ring_, mask)
    return np.asarray(block.copy_to_host())


def engine(
    building: Building,
    connections: Array,
    compositions: tuple[Composition, ...],
    dt: float,
    m: int,
    quantities: tuple[str, ...],
    precision: int = 64,
    branchless: bool = False,
) -> Engine:
    """As `dampyr.structures.batch.engine.engine`, for the card, whose threads take the exact Bouc-Wen state."""
    if building.n > DENSE_UP_TO:
        size = f"{building.n_floors} floors"
        if building.n > building.n_floors:
            size += f", and {building.n} coordinates, as it was reduced"
        raise InputError(f"{building.name} has {size}; a graphics card takes up to {DENSE_UP_TO}: use device='cpu'")
    text = KernelText(step(building, connections, dt / m), compositions, quantities, ring_width="width")
    return Engine(text, compositions, precision, m, launch_on_card, MAX_HISTORIES)


def _source(text: KernelText) -> str:
    """The text of the kernel: all rows in names, the steps in a loop of the thread."""
    assert isinstance(text.frame, Small)
    rows = text.rows.names
    loads = [f"{name} = b[{k}, l]" for k, name in enumerate(rows) if not name.startswith("~")]
    numbers = [f"c{k} = c[{k}]" for k in range(text.frame.named)]
    names, values = ", ".join(text.updates), ", ".join(text.updates.values())
    stored = [f"b[{rows.index(name)}, l] = {name}" for name in text.updates]
    inner = [*text.lines, f"{names} = {values}", "part = part + share"]
    lines = [
        f"def integrate_history(ends, {', '.join(ARGUMENTS[2:])}):",
        "    l, width = cuda.grid(1), b.shape[1]",
        "    if l < width:",
        f"        {TIMES}",
        *("        " + line for line in [*numbers, *loads]),
        "        for i in range(ends[l] - 1):",
        "            low, high, part = ground[i, motion[l]]*scale[l], ground[i + 1, motion[l]]*scale[l], zero",
        "            for j in range(parts):",
        "                steps = i*parts + j",
        "                slot_0, slot_1 = (2*steps + 1) & mask, (2*steps + 2) & mask",
        *("                " + line for line in inner),
        *("        " + line for line in stored),
    ]
    return "\n".join(lines) + "\n"


@lru_cache(maxsize=64)
def _compiled(source: str, compositions: tuple[Composition, ...], precision: int) -> Any:
    from numba import cuda

    kind = np.float64 if precision == 64 else np.float32
    text = functions_of(compositions)
    tree, numbers = statements_of(text), Numbers()
    numbers.visit(tree)
    plain = (*MATH, "exp", "tanh", "copysign")
    names: dict[str, Any] = {name: getattr(math, name) for name in plain} | {"floor_of": math.floor}
    names |= {name: kind(value) for name, value in (CONSTANTS | numbers.exists | {"eighth": 0.125}).items()}
    names |= {"real": kind, "tiny": constants(precision)["tiny"], "cuda": cuda}
    for part in (ast.unparse(ast.fix_missing_locations(tree)), ON_THE_CARD):
        exec(compile(part, "<parts>", "exec"), names)
    for name, value in list(names.items()):
        if isinstance(value, FunctionType):
            names[name] = cuda.jit(device=True, inline=True)(value)
    exec(compile(source, "<history>", "exec"), names)
    return cuda.jit(fastmath=False)(names["integrate_history"])


# numba's floor is a whole number on the processor and a float on a card, where no place of the ring could be made of it
ON_THE_CARD = """
def eighth_over(t):
    return eighth/t

def floor(t):
    return int(floor_of(t))
"""
