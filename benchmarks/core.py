"""What share of the core's arithmetic the ensemble's kernel gets: floating-point operations per second against the peak."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from benchmarks import _operations, _peak
from benchmarks._block import Block, block
from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.ground_motions import el_centro
from dampyr.structures import two_storey
from dampyr.structures.batch.assemble import QUANTITIES
from dampyr.studies import raminelli_2020

TITLE = "Floating-point operations of the kernel of fast ensembles beside the peak of a core (FMA = 2), measured: time per 10^9"
GIGA = 1e9
M = 4  # steps of 5 ms
WANTED = ("displacement", "drift")


def run(data: Path | None) -> list[Line]:
    """The peak, then the kernel with two quantities and with all, in 64 and in 32 bits."""
    blocks = {precision: _blocks(precision) for precision in (64, 32)}
    contenders, counts = {}, {}
    for precision, here in blocks.items():
        name = f"peak, {precision} bits"
        contenders[name], counts[name] = _peak.chains(precision), float(_peak.operations())
        for label, one in here.items():
            contenders[label], counts[label] = one.run, float(_operations.total(one.engine) * one.steps)
    lines = {line.name: line for line in race(contenders, {}, rounds=15)}
    return [_per_giga(line, counts, lines, blocks) for line in lines.values()]


def _blocks(precision: int) -> dict[str, Block]:
    kinds = {"displacement + drift": WANTED, "all six quantities": QUANTITIES}
    return {f"kernel, {precision} bits, {label}": _block(quantities, precision) for label, quantities in kinds.items()}


def _block(quantities: tuple[str, ...], precision: int) -> Block:
    return block(two_storey(), el_centro(), raminelli_2020.damper(), 1.0, M, quantities, precision)


def _per_giga(
    line: Line, counts: dict[str, float], lines: dict[str, Line], blocks: dict[int, dict[str, Block]]
) -> Line:
    """The line for 10^9 operations, and the share of the peak of its precision."""
    each = GIGA / counts[line.name]
    summary = f"{1 / (line.median * each):.3g} GFlop/s"
    for precision, here in blocks.items():
        if line.name in here:
            one, top = here[line.name], lines[f"peak, {precision} bits"]
            share = counts[line.name] / line.median * top.median / counts[top.name]
            summary += f", {100 * share:.0f} % of the peak; {_operations.total(one.engine)} operations a step"
            summary += f", {line.median / one.steps * GIGA:.3g} ns a step"
    return replace(line, median=line.median * each, fastest=line.fastest * each, error=summary)
