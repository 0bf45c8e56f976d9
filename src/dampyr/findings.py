"""Findings: what a person should look at in a record, a fit, a damper or a response; one sentence each, the worst first.

Every result has ``findings``, and what is made of a result has those of it that matter (`handed_on`), in the same words.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, singledispatch
from itertools import chain
from typing import Any, Literal, Protocol, get_args, overload

from dampyr.errors import InputError

Severity = Literal["wrong", "doubt", "note"]
SEVERITIES: tuple[Severity, ...] = get_args(Severity)
NUMBERS = re.compile(r"[-+−]?\d[\d.]*(e[-+]?\d+)?(, [-+−]?\d[\d.]*(e[-+]?\d+)?)*")  # one, or several in a list
PLURAL = re.compile(r"(# (?:\w+ )?\w+?)s\b")  # of what is counted, such as "2 false samples"
OF_DAMPER = "the damper's fit"  # the source of what a damper hands on


@dataclass(frozen=True)
class Finding:
    """One sentence, without its capital and its full stop, on what a person should look at.

    ``severity`` is "wrong" (the numbers cannot be used as they are), "doubt" (look before you use them) or "note" (good to
    know). ``about`` names the records that it is about, none where it is about the whole result. ``source`` says what
    has handed it on, such as "the damper's fit" or a case; empty where it is of the result itself.
    """

    severity: Severity
    words: str
    about: tuple[str, ...] = ()
    source: str = ""

    def __post_init__(self) -> None:
        if self.severity not in SEVERITIES:
            raise InputError(f"severity = {self.severity!r} is not allowed; choose {', '.join(SEVERITIES)}")

    def __str__(self) -> str:
        from dampyr.phrases import listing  # with numpy, which a command line that only helps does not need

        source = f"{self.source}: " if self.source else ""
        if not self.about:
            return source + self.words
        first, *others = self.about
        return f"{source}{first}: {self.words}" + (f"; likewise {listing(others, 3)}" if others else "")

    @property
    def sentence(self) -> str:
        """With a full stop, and a capital where it does not begin with the name of a record, which keeps its letters."""
        from dampyr.phrases import full_stop, sentence

        return full_stop(str(self)) if self.about and not self.source else sentence(str(self))

    @property
    def kind(self) -> str:
        """What it says without its numbers, which is the same for all records that it is said of."""
        return PLURAL.sub(r"\1", NUMBERS.sub("#", self.words))

    def as_dict(self) -> dict[str, Any]:
        """For JSON, cards and files: severity and words, and about and source where there are any."""
        about = {"about": list(self.about)} if self.about else {}
        return (
            {"severity": self.severity, "words": self.words} | about | ({"source": self.source} if self.source else {})
        )

    @classmethod
    def from_dict(cls, table: Mapping[str, Any]) -> Finding:
        """From `as_dict`; KeyError or TypeError where it is something else."""
        about = tuple(map(str, table.get("about", ())))
        return cls(table["severity"], str(table["words"]), about, str(table.get("source", "")))


def as_dicts(findings: Iterable[Finding]) -> list[dict[str, Any]]:
    """The findings of a result for its JSON and for a card."""
    return [finding.as_dict() for finding in findings]


def findings_row(findings: Sequence[Finding]) -> list[tuple[str, str]]:
    """The worst of some `dampyr.findings` as a row, and one on how many more there are; no row where there are none."""
    from dampyr.phrases import counted

    if not findings:
        return []
    more = len(findings) - 1
    worst = ("note" if findings[0].severity == "note" else "look at", str(findings[0]))
    return [worst, ("", f"and {counted(more, 'more finding')}")] if more else [worst]


class HasFindings(Protocol):
    """A result: a record, a fit, a damper, a response."""

    @property
    def findings(self) -> Sequence[Finding]:
        """What a person should look at in it, the worst first."""


def worst_first(*groups: Iterable[Finding]) -> tuple[Finding, ...]:
    """All findings, each once, the worst first, else in their order; what is said alike of several records is one finding."""
    merged: dict[tuple[str, str, str], Finding] = {}
    for finding in chain(*groups):
        key = finding.severity, finding.source, finding.kind if finding.about else finding.words
        same = merged.get(key)
        if same is not None:
            merged[key] = replace(same, about=tuple(dict.fromkeys((*same.about, *finding.about))))
        else:
            merged[key] = finding
    return tuple(sorted(merged.values(), key=lambda finding: SEVERITIES.index(finding.severity)))


def besides(findings: Iterable[Finding], sentences: Iterable[str]) -> list[Finding]:
    """The findings without those whose sentence stands already, as that of a verdict does."""
    printed = set(sentences)
    return [finding for finding in findings if finding.sentence not in printed]


def handed_on(results: Iterable[HasFindings], source: str = "", besides: Iterable[Finding] = ()) -> tuple[Finding, ...]:
    """What is wrong and what is in doubt in ``results``, each once, as whatever is made of them repeats it; notes stay behind.

    ``source`` says what hands it on. What is said ``besides`` of one of the same records already is left out.
    """
    stated = [(finding.kind, {*finding.about}) for finding in besides]
    return worst_first(
        replace(finding, source=finding.source or source)
        for result in results
        for finding in result.findings
        if finding.severity != "note"
        and not any(finding.kind == kind and {*finding.about} & about for kind, about in stated)
    )


@singledispatch
def findings_of(result: Any) -> tuple[Finding, ...]:
    """The findings of a result whose class lies below what they are worked out with: registered there, by its type."""
    raise TypeError(f"nothing works out the findings of {type(result).__name__}")


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
