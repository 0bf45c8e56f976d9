"""What a person should look at in a record, a fit or a damper: one sentence each, the worst first, each once."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import Any, Literal, get_args, overload

from dampyr.errors import InputError

Severity = Literal["wrong", "doubt", "note"]
SEVERITIES: tuple[Severity, ...] = get_args(Severity)
NUMBER = re.compile(r"[-+−]?\d")


@dataclass(frozen=True)
class Finding:
    """One sentence, without its capital and its full stop, on what a person should look at.

    ``severity`` is "wrong" (the numbers cannot be used as they are), "doubt" (look before you use them) or "note" (good to
    know). ``about`` names the records that it is about, none where it is about the whole result.
    """

    severity: Severity
    words: str
    about: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.severity not in SEVERITIES:
            raise InputError(f"severity = {self.severity!r} is not allowed; choose {', '.join(SEVERITIES)}")

    def __str__(self) -> str:
        from dampyr.representation import listing  # with numpy, which a command line that only helps does not need

        if not self.about:
            return self.words
        first, *others = self.about
        return f"{first}: {self.words}" + (f"; likewise {listing(others, 3)}" if others else "")

    @property
    def kind(self) -> str:
        """What it says up to its first number, which is the same for all records that it is said of."""
        return NUMBER.split(self.words, maxsplit=1)[0]


def worst_first(*groups: Iterable[Finding]) -> tuple[Finding, ...]:
    """All findings, each once, the worst first, else in their order; what is said alike of several records is one finding."""
    merged: dict[tuple[str, str], Finding] = {}
    for one in chain(*groups):
        key = one.severity, one.kind if one.about else one.words
        same = merged.get(key)
        if same is not None:
            merged[key] = replace(same, about=tuple(dict.fromkeys((*same.about, *one.about))))
        else:
            merged[key] = one
    return tuple(sorted(merged.values(), key=lambda one: SEVERITIES.index(one.severity)))


class Findings(Sequence[Finding]):
    """The findings that ``make`` returns when they are first looked at, in the place of a tuple of them."""

    def __init__(self, make: Callable[[], Iterable[Finding]]) -> None:
        self._make = make

    @cached_property
    def _findings(self) -> tuple[Finding, ...]:
        return tuple(self._make())

    @overload
    def __getitem__(self, k: int) -> Finding: ...
    @overload
    def __getitem__(self, k: slice) -> Sequence[Finding]: ...
    def __getitem__(self, k: int | slice) -> Finding | Sequence[Finding]:
        return self._findings[k]

    def __len__(self) -> int:
        return len(self._findings)

    def __reduce__(self) -> tuple[Any, ...]:
        return tuple, (self._findings,)
