"""The records of a campaign that was performed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import overload

from dampyr.findings import Finding, handed_on
from dampyr.origin import Origin, combined
from dampyr.records import Record, read_campaign
from dampyr.shown import Shown


@dataclass(frozen=True, repr=False)
class RecordedCampaign(Shown, Sequence[Record]):
    """The records of the complete tests in ``folder``, the latest try of each, in the order in which the tests ran.

    They are read when the first of them is used.
    """

    folder: Path

    @cached_property
    def records(self) -> tuple[Record, ...]:
        """All of them."""
        return tuple(read_campaign(self.folder, role=None))

    def __len__(self) -> int:
        return len(self.records)

    @overload
    def __getitem__(self, place: int) -> Record: ...
    @overload
    def __getitem__(self, place: slice) -> tuple[Record, ...]: ...
    def __getitem__(self, place: int | slice) -> Record | tuple[Record, ...]:
        return self.records[place]

    @property
    def origin(self) -> Origin:
        """That of the records together."""
        return combined(record.origin for record in self.records)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong or in doubt in the records."""
        return handed_on(self.records)
