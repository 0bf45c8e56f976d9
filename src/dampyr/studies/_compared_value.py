"""What was compared, and what came of it: the verdict follows from the numbers by a stated tolerance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Literal

Outcome = Literal["agrees", "differs", "cannot be checked"]
Value = float | str | None


class PrintedNumber(float):
    """A number as the text prints it, which knows its last digit: ``Printed("4466.3").last_digit`` is 0.1."""

    text: str

    def __new__(cls, text: str) -> PrintedNumber:
        number = super().__new__(cls, text)
        number.text = text
        return number

    @property
    def last_digit(self) -> float:
        """What one unit in the last printed digit is worth."""
        return 10.0 ** int(Decimal(self.text).as_tuple().exponent)


@dataclass(frozen=True)
class ComparisonTolerance:
    """How far ours may be from the published value: ``absolute`` + ``relative`` * its size; neither: its printed digits."""

    absolute: float = 0.0
    relative: float = 0.0

    def allows(self, published: float, ours: float) -> bool:
        """Whether the two agree."""
        if not self.absolute and not self.relative:
            return _digits_agree(published, ours)
        return abs(ours - published) <= self.absolute + self.relative * abs(published)

    def words(self, unit: str) -> str:
        """The tolerance for people."""
        parts = [f"{self.absolute:g} {'points' if unit == '%' else unit}".rstrip()] if self.absolute else []
        parts += [f"{100 * self.relative:.3g} %"] if self.relative else []
        return " + ".join(parts) or "the printed digits, rounded or cut"


PRINTED_DIGITS = ComparisonTolerance()


def _digits_agree(published: float, ours: float) -> bool:
    """Whether ``ours`` rounds or is cut to the digits that were printed."""
    unit = published.last_digit if isinstance(published, PrintedNumber) else 1e-9 * abs(published)
    slack = 1e-9 * unit
    excess = math.copysign(1.0, published) * (ours - published)
    return abs(excess) <= 0.5 * unit + slack or -slack <= excess < unit


@dataclass(frozen=True)
class ComparedValue:
    """One quantity of one artefact: the published value, ours from this run, both in ``unit``, and the verdict."""

    artefact: str
    quantity: str
    published: Value
    ours: Value
    unit: str
    verdict: Outcome
    reason: str


@dataclass(frozen=True)
class AlternativeValue:
    """What else the published number could be: ``words`` say how ``value`` was computed."""

    value: float
    words: str


def judge(
    artefact: str,
    quantity: str,
    published: float,
    ours: float,
    unit: str = "",
    tolerance: ComparisonTolerance = PRINTED_DIGITS,
    candidates: Sequence[AlternativeValue] = (),
    otherwise: str = "",
) -> ComparedValue:
    """Compare; where the two differ, the first candidate that gives the published value is the reason, else ``otherwise``."""
    deviation = _describe_deviation(ours - published, published, unit)
    if not math.isfinite(ours):
        return ComparedValue(
            artefact, quantity, published, None, unit, "cannot be checked", f"nothing finite came out; {otherwise}"
        )
    if tolerance.allows(published, ours):
        reason = f"{deviation}; allowed: {tolerance.words(unit)}"
        return ComparedValue(artefact, quantity, published, ours, unit, "agrees", reason)
    matches = [c for c in candidates if tolerance.allows(published, c.value)]
    why = f"the printed value is {matches[0].words} ({matches[0].value:.8g})" if matches else otherwise
    reason = f"{deviation}; allowed: {tolerance.words(unit)}" + (f". Because: {why}" if why else "")
    return ComparedValue(artefact, quantity, published, ours, unit, "differs", reason)


def _describe_deviation(gap: float, published: float, unit: str) -> str:
    """How far off, in the unit and relative to the published value."""
    absolute = f"off by {gap:+.3g} {'points' if unit == '%' else unit}".rstrip()
    if not published or unit == "%":
        return absolute
    ratio = gap / abs(published)
    return absolute + (f" ({100 * ratio:+.2g} %)" if abs(ratio) < 10 else f" ({ratio + 1:.3g} times)")


def claim(artefact: str, quantity: str, published: str, ours: str, holds: bool, reason: str) -> ComparedValue:
    """A statement of the text without a number, checked by a computation: ``holds`` is its result."""
    return ComparedValue(artefact, quantity, published, ours, "", "agrees" if holds else "differs", reason)


def unchecked(artefact: str, quantity: str, published: Value, unit: str, missing: str) -> ComparedValue:
    """What cannot be checked here; ``missing`` says what would be needed."""
    return ComparedValue(artefact, quantity, published, None, unit, "cannot be checked", missing)


def overall(judged: Sequence[ComparedValue]) -> Outcome:
    """The verdict on an artefact: it differs where anything differs, and agrees where anything was checked and all agrees."""
    verdicts = {f.verdict for f in judged}
    if "differs" in verdicts:
        return "differs"
    return "agrees" if "agrees" in verdicts else "cannot be checked"


@dataclass(frozen=True)
class Erratum:
    """A slip of the text: what is printed where, what it should be, and why."""

    place: str
    printed: str
    correct: str
    reason: str
