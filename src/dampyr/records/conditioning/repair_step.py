"""What a repair changed in a record, with the samples as they were before: enough to undo it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RepairStep:
    """One repair of a record: the samples that it changed or added.

    Attributes
    ----------
    kind
        Which repair it was, such as "false samples": one of `dampyr.records.conditioning.repair.REPAIRS`.
    time
        ``(k,)`` in s: the samples, by their time.
    before, after
        ``(k,)`` for each channel that was changed, in SI: as it was, and as it became. NaN before: the sample was not there.
    words
        What was done, as it stands in the record's findings.
    """

    kind: str
    time: Array
    before: Mapping[str, Array]
    after: Mapping[str, Array]
    words: str = ""

    def __post_init__(self) -> None:
        for name in ("before", "after"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    @property
    def added(self) -> bool:
        """Whether the samples were not there before."""
        return any(bool(np.isnan(values).any()) for values in self.before.values())

    def __reduce__(self) -> tuple[object, ...]:
        return RepairStep, (self.kind, self.time, dict(self.before), dict(self.after), self.words)
