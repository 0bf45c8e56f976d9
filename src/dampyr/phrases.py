"""Numbers and lists in the words of sentences and tables."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np


def extent(values: Any, unit: str, factor: float = 1.0) -> str:
    """The range of an array, such as ``-9.8 … 9.8 mm``, times ``factor``; NaN is left out."""
    numbers = factor * np.asarray(values, dtype=float)
    numbers = numbers[np.isfinite(numbers)]
    if numbers.size == 0:
        return "no finite value"
    low, high = float(numbers.min()), float(numbers.max())
    return (f"{low:.4g} {unit}" if low == high else f"{low:.4g} … {high:.4g} {unit}").rstrip()


def rounded(value: float, digits: int) -> str:
    """A number to so many digits, without an exponent from a thousandth to a million: ``110`` and not ``1.1e+02``."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.15g}" if math.isfinite(value) and 1e-3 <= abs(value) < 1e6 else text


def with_reach(value: float, reach: float) -> str:
    """A value and half of its interval, of which two digits are said, and of the value no more: ``15 ± 15``, ``12.7 ± 2.2``."""
    if not (math.isfinite(value) and math.isfinite(reach) and reach > 0.0):
        return f"{rounded(value, 4)} ± {rounded(reach, 2)}"
    last = math.floor(math.log10(float(f"{reach:.2g}"))) - 1  # the power of ten of the second digit
    if last > 4 or max(abs(value), reach) < 1e-3:
        leading = math.floor(math.log10(max(abs(value), reach)))
        return f"{rounded(value, max(leading - last + 1, 1))} ± {rounded(reach, 2)}"
    places = max(-last, 0)
    return f"{round(value, -last):.{places}f} ± {round(reach, -last):.{places}f}"


def listing(items: Sequence[str], limit: int = 4) -> str:
    """Items separated by commas, those beyond the first few counted."""
    more = len(items) - limit
    return ", ".join(items[:limit]) + (f" and {more} more" if more > 0 else "")


def sentence(text: str) -> str:
    """A clause, such as a finding or a note, with a capital and a full stop; a name at its head keeps its letters."""
    first = text.partition(" ")[0]
    return full_stop(text if {".", "_", "@"} & set(first) else text[:1].upper() + text[1:])


def full_stop(text: str) -> str:
    """A clause with its full stop; a question has its mark."""
    return text if text.endswith("?") else f"{text}."


def counted(number: int, noun: str) -> str:
    """Such as ``1 record`` and ``3 records``."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def percent(ratio: float | None) -> str:
    """A ratio in percent, such as ``8.7 %``; a dash where there is none."""
    return "–" if ratio is None or np.isnan(ratio) else f"{100 * ratio:.3g} %"
