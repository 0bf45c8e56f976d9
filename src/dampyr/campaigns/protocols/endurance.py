r"""Endurance: many cycles of one sine in blocks, each a test with its record, and the decay of the force.

.. math:: d_k = 1 - F_k / F_{ref}

:math:`F_k` is the median over the steady cycles of block k of half of a cycle's range of force, so that an offset does not
enter; the reference is the first block, or another whose fluid is warm already. Where a block's decay is above
``stop_decay`` the campaign ends there, in order, and its journal says why. Cycles count over the blocks that are complete,
without those of run-in and run-out, and a campaign that is run again goes on counting.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from dampyr.campaigns.protocol_result import ProtocolFigure, ProtocolLimit
from dampyr.campaigns.step import Count, Frequency, Length, Volts
from dampyr.errors import InputError
from dampyr.records.cycle_analysis.device_figures import device_figures
from dampyr.records.record import Record
from dampyr.units import Quantity


@dataclass(frozen=True)
class Endurance:
    """Blocks of one sine."""

    amplitude: Annotated[float, Length, "amplitude of the motion, half of the peak to peak"]
    frequency: Annotated[float, Frequency, "cycles per second"]
    cycles: Annotated[int, Count, "steady cycles in all"]
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0
    block_cycles: Annotated[int, Count, "steady cycles of a block; the last has what is left"] = 100
    reference_block: Annotated[int, Count, "number of the block with which the others are compared"] = 1
    stop_decay: Annotated[
        float | None,
        Quantity("", low=0.0, high=1.0),
        "decay of the force above which the campaign ends; none: it runs on",
    ] = None

    quantities: ClassVar[Mapping[str, str]] = {"force": "N", "decay": ""}

    def __post_init__(self) -> None:
        if self.reference_block > self._blocks:
            raise InputError(
                f"reference_block = {self.reference_block} is not among the {self._blocks} blocks of {self.cycles} cycles; "
                "give a smaller number"
            )

    @property
    def _blocks(self) -> int:
        return -(-self.cycles // self.block_cycles)

    def steps(self) -> list[dict[str, Any]]:
        """A sine for each block."""
        same = {"kind": "sine", "amplitude": self.amplitude, "frequency": self.frequency, "voltage": self.voltage}
        return [
            {**same, "cycles": min(self.block_cycles, self.cycles - k * self.block_cycles)} for k in range(self._blocks)
        ]

    def counted(self, blocks: int) -> dict[str, str]:
        """What a record says of the counter when so many blocks are complete before it."""
        return {"cycles_before": str(min(self.cycles, blocks * self.block_cycles)), "cycles_in_all": str(self.cycles)}

    def ends(self, blocks: Sequence[Callable[[], Record]]) -> str:
        """Why the campaign ends after these complete blocks, which are read by being called; empty where it goes on."""
        if self.stop_decay is None or len(blocks) < self.reference_block:
            return ""
        decay = _decay(blocks[-1](), _force(blocks[self.reference_block - 1]()))
        if decay <= self.stop_decay:
            return ""
        cycles = min(self.cycles, len(blocks) * self.block_cycles)
        return (
            f"the force has decayed by {100 * decay:.3g} % in block {len(blocks)}, after {cycles} of {self.cycles} cycles: "
            f"more than stop_decay = {100 * self.stop_decay:g} %"
        )

    def limits(self) -> tuple[ProtocolLimit, ...]:
        """The decay at which it stops."""
        if self.stop_decay is None:
            return ()
        return (ProtocolLimit("decay", None, self.stop_decay, source="stop_decay of the protocol"),)

    def figures(self, records: Sequence[Record]) -> list[ProtocolFigure]:
        """Force and decay of each block."""
        numbers = {record.name: int(record.name.partition("-")[0]) for record in records}
        reference = next((record for record in records if numbers[record.name] == self.reference_block), None)
        first = None if reference is None else _force(reference)
        figures = []
        for record in records:
            number = numbers[record.name]
            conditions = {"block": number, "cycles": min(self.cycles, number * self.block_cycles)}
            decay = None if first is None else _decay(record, first)
            reason = "" if first is not None else f"block {self.reference_block}, the reference, has no complete record"
            figures.append(ProtocolFigure(record.name, "force", _force(record), conditions))
            figures.append(ProtocolFigure(record.name, "decay", decay, conditions, reason))
        return figures


def _force(record: Record) -> float:
    return float(np.median([cycle.largest_force for cycle in device_figures(record)]))


def _decay(record: Record, reference: float) -> float:
    return 1.0 - _force(record) / reference
