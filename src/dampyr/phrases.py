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
