"""Limits of peaks as people write them: ``12mm`` of drift, ``1%`` of the height of a storey, ``0.5g``, ``force=1kN``."""

from __future__ import annotations

from dataclasses import dataclass

from dampyr import units
from dampyr.config import unknown
from dampyr.errors import InputError

UNITS = {"displacement": "m", "drift": "m", "acceleration": "m/s^2", "force": "N", "stroke": "m", "energy": "J"}
BY_UNIT = ("drift", "acceleration")  # what a limit is of where it names no quantity
EXAMPLES = "12mm, 1% or 0.5g"


@dataclass(frozen=True)
class Limit:
    """A limit of ``quantity``, SI; with the storeys' ``height`` in m, ``value`` is a drift ratio."""

    quantity: str
    value: float
    height: float | None = None


def limit_of(text: str, height: float | None = None) -> Limit:
    """``12mm`` a drift, ``1%`` a drift over the ``height`` [m], ``0.3g`` an acceleration, ``force=1kN`` what it names.

    Raises :class:`~dampyr.errors.InputError` for what is none of these.
    """
    quantity, sign, size = (part.strip() for part in text.partition("="))
    if not sign:
        quantity, size = "", text.strip()
    elif quantity not in UNITS:
        raise InputError(unknown(f"limit {text!r}: {quantity!r}", quantity, list(UNITS)))
    if size.endswith("%"):
        if quantity not in ("", "drift"):
            raise InputError(f"limit {text!r} is a ratio, which only a drift has; write it as in {EXAMPLES}")
        return Limit("drift", _positive(text, _ratio(text, size)), height)
    for candidate in (quantity,) if quantity else BY_UNIT:
        value = _with_unit(size, UNITS[candidate])
        if value is not None:
            return Limit(candidate, _positive(text, value))
    of = f"a {quantity}" if quantity else "a drift or an acceleration"
    raise InputError(
        f"limit {text!r} has no unit of {of}; write it as in {f'{quantity}=1{UNITS[quantity]}' if quantity else EXAMPLES}"
    )


def limits_of(texts: tuple[str, ...], height: float | None) -> tuple[Limit, ...]:
    """All limits; those in per cent need the height of the storeys, and only these do."""
    limits = tuple(limit_of(text, height) for text in texts)
    ratios = [text for text in texts if text.strip().endswith("%")]
    if ratios and height is None:
        raise InputError(
            f"limit {ratios[0]!r} is a ratio of the storey height; give height too, such as 3 m, or a limit in mm"
        )
    if height is not None and not ratios:
        raise InputError("height belongs to a limit in per cent; give a limit such as 1%, or leave height out")
    return limits


def _ratio(text: str, size: str) -> float:
    try:
        return float(size.removesuffix("%")) / 100
    except ValueError:
        raise InputError(f"limit {text!r} is not a ratio; write it as in 1%") from None


def _with_unit(size: str, unit: str) -> float | None:
    """The value in SI; None for a bare number, and for a unit of another kind."""
    try:
        float(size)
    except ValueError:
        try:
            return units.parse(size, unit)
        except InputError:
            return None
    return None


def _positive(text: str, value: float) -> float:
    if not value > 0:
        raise InputError(f"limit {text!r} is not allowed; it must be greater than 0")
    return value
