"""The kinds of repair by name, and what a repair changed in a record, with the samples as they were: enough to undo it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError

Array = NDArray[np.float64]
REPAIR_KINDS = ("false samples", "gaps", "force drift", "position drift")
GAPS = REPAIR_KINDS[1]
NONE = "none"


def as_repairs(text: object) -> tuple[str, ...]:
    """The kinds that ``text`` names, in their order, "none" being no kind; else an :class:`~dampyr.errors.InputError`.

    A dash is a blank, as shells like it: ``false-samples,gaps``.
    """
    words = [word.strip().replace("-", " ") for word in text.split(",")] if isinstance(text, str) else []
    if words == [NONE]:
        return ()
    unknown = [word for word in words if word not in REPAIR_KINDS]
    if not words or unknown:
        raise InputError(
            f"repair = {text!r} is not known; choose from {', '.join(REPAIR_KINDS)}, several with commas between them, or "
            f"{NONE}, which undoes those that an .h5 file holds"
        )
    return tuple(kind for kind in REPAIR_KINDS if kind in words)


@dataclass(frozen=True, eq=False)
class RepairStep:
    """One repair of a record: the samples that it changed or added.

    Attributes
    ----------
    kind
        Which repair it was, such as "false samples": one of `REPAIR_KINDS`.
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
