"""Quantities with units at the boundary; SI inside.

Units are spoken where people type and read: in files, tables, plots and arguments such as ``"12.4 mm"``.
Everything between is SI: m, m/s, N, s, V, A, 1/m.
"""

from __future__ import annotations

import math
import re
import tokenize
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from dampyr.errors import InputError

STANDARD_GRAVITY = 9.80665
"""m/s2, exact by definition; what one g is wherever dampyr reads or shows g."""

ROUNDING = 1e-7
"""Of the largest term of a sum: what arithmetic may leave a limit by, square roots of rounded covariances included."""

OPEN_MARGIN = 1e-9
"""SI units by which a value stays off a limit that it must not reach."""


@dataclass(frozen=True)
class Quantity:
    """What a number means: its SI unit and the range that is allowed.

    Used as an annotation, ``kx: Annotated[float, Quantity("N s/m", low=0)]``.

    Parameters
    ----------
    unit
        The SI unit, such as ``"N s/m"``; empty for a number without one.
    low, high
        The least and the greatest value that is allowed; by default every finite one is.
    open_low
        Whether ``low`` itself is not allowed.
    linear
        Whether a force is proportional to this parameter, so that a fit solves it and does not search it.
    logarithmic
        Whether a fit searches it in its logarithm although it may be 0; it comes to within 1e-9 SI units of that.

    Examples
    --------
    >>> from dampyr.units import Quantity
    >>> Quantity("m", low=0.0, high=0.1).range_in_words()
    'at least 0 and at most 0.1'
    """

    unit: str
    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False
    linear: bool = False
    logarithmic: bool = False

    def check(self, name: str, value: float) -> None:
        """Raise :class:`InputError` unless ``value`` is finite and in the range."""
        below = value <= self.low if self.open_low else value < self.low
        if not math.isfinite(value) or below or value > self.high:
            shown = f"{value:g}"
            if value not in (self.low, self.high) and shown in (f"{self.low:g}", f"{self.high:g}"):
                shown = repr(float(value))  # all digits, so that it is not told to be what it must be
            value_in_words = f"{shown} {self.unit}".rstrip()
            raise InputError(f"{name} = {value_in_words} is not allowed; it must be {self.range_in_words()}")

    def without_rounding(self, values: Any, size: float) -> Any:
        """``values``, those beyond a limit by rounding alone (1e-7 of ``size``, their largest term) on its allowed side."""
        values, slack = np.asarray(values, dtype=float), ROUNDING * size
        below = (values < self.low) & (values >= self.low - slack)
        above = (values > self.high) & (values <= self.high + slack)
        lowest = self.low + OPEN_MARGIN if self.open_low else self.low
        return np.where(below, lowest, np.where(above, self.high, values))

    def range_in_words(self) -> str:
        """The allowed range, as a person would say it."""
        above = "greater than" if self.open_low else "at least"
        low = f"{above} {self.low:g}" if math.isfinite(self.low) else ""
        high = f"at most {self.high:g}" if math.isfinite(self.high) else ""
        return " and ".join(part for part in (low, high) if part) or "finite"


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint

    registry: Any = pint.UnitRegistry(autoconvert_offset_to_baseunit=True)
    registry.formatter.default_format = "~"
    return registry


# what the published tables are in; pint takes most of the start of a command, and is left out where these do
EVERYDAY = {
    ("m", "m"): 1.0,
    ("mm", "m"): 1e-3,
    ("mm/s", "m/s"): 1e-3,
    ("N", "N"): 1.0,
    ("N s/mm", "N s/m"): 1e3,
    ("N/mm", "N/m"): 1e3,
    ("1/mm", "1/m"): 1e3,
    ("s", "s"): 1.0,
    ("V", "V"): 1.0,
    ("A", "A"): 1.0,
}


@lru_cache(maxsize=256)
def _scale(unit: str, si: str) -> tuple[float, float]:
    """``(factor, shift)`` such that ``value_si = factor*value + shift``."""
    return (EVERYDAY[unit, si], 0.0) if (unit, si) in EVERYDAY else _by_pint(unit, si)


AS_WRITTEN: dict[str, dict[str, str]] = {
    "s": dict.fromkeys(("sec", "secs", "second", "seconds"), "s") | dict.fromkeys(("msec", "msecs"), "ms"),
    "m": dict.fromkeys(("inch", "inches", "in"), "inch") | dict.fromkeys(("mil", "mils"), "thou") | {"MM": "mm"},
    "m/s": dict.fromkeys(("ips", "inch/s", "in/sec", "in/s"), "inch/s") | dict.fromkeys(("fps", "ft/sec"), "ft/s"),
    "m/s^2": {
        **dict.fromkeys(("g", "g's", "gs"), "standard_gravity"),
        **{"%g": "centistandard_gravity", "mg": "millistandard_gravity"},
        **dict.fromkeys(("gal", "gals", "cm/s/s", "cm/sec/sec"), "cm/s**2"),
    },
    "N": {
        **dict.fromkeys(("newton", "newtons"), "N"),
        **dict.fromkeys(("lb", "lbs", "lbf", "lbsf", "pound", "pounds"), "lbf"),  # a pound of a force is no mass
        **dict.fromkeys(("klb", "klbs", "klbf", "kip", "kips"), "kip"),
        **dict.fromkeys(("kgf", "kp"), "kgf"),
    },
    "V": dict.fromkeys(("volt", "volts"), "V"),
    "A": dict.fromkeys(("amp", "amps", "ampere", "amperes"), "A"),
    "degC": {
        **dict.fromkeys(
            ("degc", "°c", "deg c", "deg_c", "celsius", "c"), "degC"
        ),  # C and F are no coulomb and no farad
        **dict.fromkeys(("degf", "°f", "deg f", "deg_f", "fahrenheit", "f"), "degF"),
        **dict.fromkeys(("k", "kelvin"), "kelvin"),
    },
}
"""Units as people and testing machines write them, by the SI unit they measure: in lower case, with pint's spelling."""
UNIT_WORDS = {
    *[
        "s",
        "ms",
        "us",
        "min",
        "m",
        "cm",
        "mm",
        "um",
        "µm",
        "ft",
        "n",
        "kn",
        "dan",
        "mn",
        "tonf",
        "tf",
        "v",
        "mv",
        "a",
        "ma",
    ],
    *[
        "m/s",
        "cm/s",
        "mm/s",
        "ft/s",
        "m/sec",
        "cm/sec",
        "mm/sec",
        "m/s2",
        "cm/s2",
        "mm/s2",
        "m/s^2",
        "cm/s^2",
        "mm/s^2",
    ],
    *(word.lower() for words in AS_WRITTEN.values() for word in words),
}
"""What a cell in a line of units below names may be, in lower case and without a full stop."""
# as drawings and programs write them: (what is written, how pint reads it)
SPELLINGS = (
    (r"·", "*"),
    (r"²", "**2"),
    (r"³", "**3"),
    (r"[µμ]", "u"),
    (r"(?<=[A-Za-z])([234])(?![\w.*])", r"**\1"),  # m/s2, kN m2, cm4
    (r"\bK(?=(N|Pa|g)(m|mm|s)?\b)", "k"),
    (r"\b([kM]?N)(m|mm|s)\b", r"\1*\2"),  # kNm, kNs/m
    (r"\blbm\b", "lb"),
)


def _spelled(unit: str, si: str) -> str:
    """A unit in pint's spelling; InputError for a ton, which is three different masses."""
    if match := re.search(r"\b((kilo|mega)?tons?|tonf|ton_force|force_ton)\b", unit):
        force = "f" in match[0]
        allowed = "tf, short_ton*g_0 or long_ton*g_0" if force else "t, short_ton or long_ton"
        which = f"1000 kg, 907.2 kg or 1016 kg{' of weight' if force else ''}"
        raise InputError(f"{match[0]} in the unit {unit!r} may be {which}; write {allowed}")
    plain, words = unit.strip().rstrip("."), AS_WRITTEN.get(si, {})
    if word := words.get(plain, words.get(plain.lower())):
        return word
    for written, read in SPELLINGS:
        unit = re.sub(written, read, unit)
    return unit


def _by_pint(unit: str, si: str) -> tuple[float, float]:
    import pint

    registry = _registry()
    spelled = _spelled(unit, si)
    try:
        source, target = (
            registry.parse_units(spelled.replace("^", "**")),
            registry.parse_units(si.replace("^", "**")),
        )
    except (
        pint.errors.PintError,
        ValueError,
        TypeError,
        AttributeError,
        AssertionError,
        tokenize.TokenError,
    ) as problem:
        raise InputError(f"unknown unit {unit!r}; write a unit such as mm, m/s, N, V, s, g") from problem
    try:
        # two points make the line: units of temperature have a shift, all others only a factor
        at_zero = registry.Quantity(0.0, source).to(target).magnitude
        at_one = registry.Quantity(1.0, source).to(target).magnitude
    except pint.errors.PintError as problem:
        weight = "; for the weight of a mass write kgf" if si == "N" and source == registry.kilogram else ""
        raise InputError(
            f"the unit {unit!r} does not measure what {si!r} measures; write a unit such as {si}{weight}"
        ) from problem
    return float(at_one - at_zero), float(at_zero)


def in_si(values: Any, si: str, name: str) -> Any:
    """What a caller gave, in the SI unit ``si``: the unit of a quantity (pint, astropy) or of a labelled array (xarray) counts.

    A labelled array has its unit in ``attrs["units"]`` or ``attrs["unit"]``; without one it is SI, as plain numbers are. A text
    is a number with its unit. A list of quantities or texts is one of numbers. Raises :class:`~dampyr.errors.InputError`,
    which begins with ``name``, where the unit is unknown or measures something else.
    """
    if isinstance(values, list | tuple) and any(isinstance(item, str) or _unit_of(item)[1] for item in values):
        return np.array([in_si(item, si, name) for item in values], dtype=float)
    try:
        if isinstance(values, str):
            return parse(values, si)
        numbers, unit = _unit_of(values)
        return to_si(numbers, unit, si) if unit else values
    except InputError as problem:
        raise InputError(f"{name}: {problem}") from None


def _unit_of(values: Any) -> tuple[Any, str]:
    """The numbers of a quantity or of a labelled array, and the unit of these; "" where none is stated."""
    quantity: Any
    for quantity in (values, getattr(values, "data", None)):
        if hasattr(quantity, "magnitude") and hasattr(quantity, "units"):  # pint, also in a labelled array
            return quantity.magnitude, str(quantity.units) or "dimensionless"
        if hasattr(quantity, "unit") and hasattr(quantity, "value"):  # astropy
            return quantity.value, str(quantity.unit) or "dimensionless"
    attributes = getattr(values, "attrs", None)
    if isinstance(attributes, dict):
        stated = attributes.get("units", attributes.get("unit", ""))
        return np.asarray(values, dtype=float), str(stated).strip()
    return values, ""


def to_si(values: Any, unit: str, si: str) -> Any:
    """Numbers in ``unit`` as numbers in the SI unit ``si``: a float for a number, else an array."""
    factor, shift = _scale(unit, si)
    if np.isscalar(values):
        return float(values) * factor + shift  # type: ignore[arg-type]
    return np.asarray(values, dtype=float) * factor + shift


def from_si(values: Any, unit: str, si: str) -> Any:
    """Numbers in the SI unit ``si`` as numbers in ``unit``."""
    factor, shift = _scale(unit, si)
    if np.isscalar(values):
        return (float(values) - shift) / factor  # type: ignore[arg-type]
    return (np.asarray(values, dtype=float) - shift) / factor


_FOR_PEOPLE = {
    "N s/m": ("N s/mm", 1e-3),
    "N/m": ("N/mm", 1e-3),
    "m/N": ("mm/kN", 1e6),
    "1/m": ("1/mm", 1e-3),
    "m": ("mm", 1e3),
    "m/s": ("mm/s", 1e3),
    "s": ("ms", 1e3),
}


def for_people(unit: str) -> tuple[str, float]:
    """The unit in which people read a parameter held in the SI ``unit``, and the factor to it.

    Examples
    --------
    >>> from dampyr.units import for_people
    >>> for_people("N s/m")
    ('N s/mm', 0.001)
    """
    return _FOR_PEOPLE.get(unit, (unit, 1.0))


UNIT_SYSTEMS = {"mm-N": "mm, N, J", "SI": "m, N, J", "in-lb": "in, lbf, in lbf"}
"""Systems of units that tables and axes may be in."""
_IN_LB = {
    "m": ("in", 1.0 / 0.0254),
    "m/s": ("in/s", 1.0 / 0.0254),
    "N": ("lbf", 1.0 / 4.4482216152605),
    "J": ("in lbf", 1.0 / (0.0254 * 4.4482216152605)),
    "N/m": ("lbf/in", 0.0254 / 4.4482216152605),
    "N s/m": ("lbf s/in", 0.0254 / 4.4482216152605),
}


def in_system(unit: str, system: str) -> tuple[str, float]:
    """The unit of one of the `UNIT_SYSTEMS` for what is held in the SI ``unit``, and the factor to it; seconds stay seconds.

    Examples
    --------
    >>> from dampyr.units import in_system
    >>> in_system("N/m", "in-lb")[0]
    'lbf/in'
    """
    if system not in UNIT_SYSTEMS:
        raise InputError(f"unit_system = {system!r} is not known; choose from {', '.join(UNIT_SYSTEMS)}")
    if unit == "s" or system == "SI":
        return unit, 1.0
    return _IN_LB.get(unit, (unit, 1.0)) if system == "in-lb" else for_people(unit)


_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?(?![\d.,_])")


def parse(text: str | float, si: str) -> float:
    """A quantity as typed, ``"12.4 mm"`` or ``"0.3g"``, in the SI unit ``si``; a bare number is SI already.

    Examples
    --------
    >>> from dampyr.units import parse
    >>> parse("12.4 mm", "m")
    0.0124
    """
    if isinstance(text, int | float):
        return float(text)
    match = _NUMBER.match(text.strip())
    if match is None:
        raise InputError(f"{text!r} is not a quantity; write a number and a unit, such as '12.4 mm'")
    return round_trip(to_si(float(match[0]), text.strip()[match.end() :].strip() or si, si))


def round_trip(value: float) -> float:
    """Drop the last bit of noise that a unit factor leaves: 12.4 mm is 0.0124 m, not 0.012400000000000001."""
    return float(f"{value:.15g}")
