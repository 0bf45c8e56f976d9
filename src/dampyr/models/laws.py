r"""Voltage laws: how a parameter follows the input of the damper.

A law is defined on the range of inputs it was calibrated on, ``low`` to ``high``, and has coefficients. The input is
the coil's voltage in V, or its current in A, as the damper says.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.units import Quantity

Array = NDArray[np.float64]


class Law(Protocol):
    """What every law can do."""

    @property
    def kind(self) -> str:
        """What the card calls it."""
        ...

    @property
    def low(self) -> float:
        """The smallest input it was calibrated on."""
        ...

    @property
    def high(self) -> float:
        """The largest input it was calibrated on."""
        ...

    @property
    def coefficients(self) -> tuple[float, ...]:
        """The numbers that a fit determines."""
        ...

    def __call__(self, u: ArrayLike) -> Any:
        """The parameter at the input ``u``."""
        ...

    def with_coefficients(self, coefficients: ArrayLike) -> Self:
        """The same law with other numbers."""
        ...

    def shifted(self, amount: float) -> Self:
        """The same law with ``amount`` added at every input."""
        ...

    def extremes(self) -> tuple[float, float]:
        """The smallest and the largest value inside the range."""
        ...

    def card(self) -> dict[str, Any]:
        """The law as a table of the damper's card."""
        ...


def _check_range(low: float, high: float) -> None:
    if not (np.isfinite(low) and np.isfinite(high) and low <= high):
        raise InputError(f"the range {low:g} to {high:g} of a law is not a range; give finite low <= high")


def _check_numbers(what: str, numbers: ArrayLike) -> tuple[float, ...]:
    values = np.atleast_1d(np.asarray(numbers, dtype=float))
    if values.ndim != 1 or values.size == 0 or not np.all(np.isfinite(values)):
        raise InputError(f"the {what} of a law must be a list of finite numbers, not {numbers!r}")
    return tuple(float(v) for v in values)


@dataclass(frozen=True)
class Constant:
    """The same value at every input of the range; without a range, at every input."""

    value: float
    low: float = -math.inf
    high: float = math.inf
    kind = "constant"

    def __post_init__(self) -> None:
        if not self.is_everywhere:
            _check_range(self.low, self.high)
        _check_numbers("value", self.value)

    @property
    def is_everywhere(self) -> bool:
        """Whether it holds at every input."""
        return (self.low, self.high) == (-math.inf, math.inf)

    @property
    def coefficients(self) -> tuple[float, ...]:
        return (float(self.value),)

    def __call__(self, u: ArrayLike) -> Any:
        return self.value + 0.0 * np.asarray(u, dtype=float)

    def with_coefficients(self, coefficients: ArrayLike) -> Self:
        return replace(self, value=_check_numbers("value", coefficients)[0])

    def shifted(self, amount: float) -> Self:
        return replace(self, value=self.value + amount)

    def extremes(self) -> tuple[float, float]:
        return self.value, self.value

    def card(self) -> dict[str, Any]:
        about = {"kind": self.kind, "value": self.value}
        return about if self.is_everywhere else about | {"range": [self.low, self.high]}


@dataclass(frozen=True)
class Polynomial:
    r""":math:`p(u) = \sum_k c_k u^k`, as in (4.3)-(4.5); ``coefficients`` in rising powers."""

    coefficients: tuple[float, ...]
    low: float
    high: float
    kind = "polynomial"

    def __post_init__(self) -> None:
        _check_range(self.low, self.high)
        object.__setattr__(self, "coefficients", _check_numbers("coefficients", self.coefficients))

    def __call__(self, u: ArrayLike) -> Any:
        return np.polynomial.polynomial.polyval(np.asarray(u, dtype=float), np.array(self.coefficients))

    def with_coefficients(self, coefficients: ArrayLike) -> Self:
        return replace(self, coefficients=_check_numbers("coefficients", coefficients))

    def shifted(self, amount: float) -> Self:
        return replace(self, coefficients=(self.coefficients[0] + amount, *self.coefficients[1:]))

    def turning_points(self) -> Array:
        """The inputs inside the range at which the slope is zero."""
        turning = np.polynomial.Polynomial(self.coefficients).deriv().roots()
        real = turning[
            np.abs(np.imag(turning)) < 1e-12
        ].real  # a double root comes out as a pair with a rounding between
        return np.asarray(real[(real > self.low) & (real < self.high)])

    def extremes(self) -> tuple[float, float]:
        values = self(np.concatenate(([self.low, self.high], self.turning_points())))
        return float(values.min()), float(values.max())

    def card(self) -> dict[str, Any]:
        return {"kind": self.kind, "coefficients": list(self.coefficients), "range": [self.low, self.high]}


@dataclass(frozen=True)
class Interpolation:
    """A smooth curve through ``values`` at ``knots`` that never leaves the two values it runs between.

    Piecewise cubic Hermite with the slopes of Fritsch and Butland (1984), so it is monotone wherever the values are.
    """

    knots: tuple[float, ...]
    values: tuple[float, ...]
    kind = "interpolation"

    def __post_init__(self) -> None:
        object.__setattr__(self, "knots", _check_numbers("knots", self.knots))
        object.__setattr__(self, "values", _check_numbers("values", self.values))
        if len(self.knots) != len(self.values) or len(self.knots) < 2:
            raise InputError(
                f"a law by interpolation needs two or more knots and as many values, not {len(self.knots)} knots "
                f"and {len(self.values)} values"
            )
        if np.any(np.diff(self.knots) <= 0):
            raise InputError(f"the knots {list(self.knots)} of a law must rise strictly")

    @property
    def low(self) -> float:
        """The first knot."""
        return self.knots[0]

    @property
    def high(self) -> float:
        """The last knot."""
        return self.knots[-1]

    @property
    def coefficients(self) -> tuple[float, ...]:
        return self.values

    @cached_property
    def pieces(self) -> Array:
        """Rising powers of (u - left knot), shape (4, pieces)."""
        from scipy.interpolate import PchipInterpolator

        return np.asarray(PchipInterpolator(self.knots, self.values).c)[::-1]

    def __call__(self, u: ArrayLike) -> Any:
        u = np.asarray(u, dtype=float)
        if u.ndim == 0 and float(u) in self.knots:  # without the curve, which takes a hundred times as long to make
            return np.float64(self.values[self.knots.index(float(u))])
        piece = np.clip(np.searchsorted(self.knots, u, side="right") - 1, 0, len(self.knots) - 2)
        d = u - np.asarray(self.knots)[piece]
        c = self.pieces[:, piece]
        curve = c[0] + d * (c[1] + d * (c[2] + d * c[3]))
        if u.size and (u.min() < self.low or u.max() > self.high):
            return curve
        ends = np.asarray(self.values)[np.stack((piece, piece + 1))]
        return np.minimum(np.maximum(curve, ends.min(axis=0)), ends.max(axis=0))  # which rounding alone could leave

    def with_coefficients(self, coefficients: ArrayLike) -> Self:
        return replace(self, values=_check_numbers("values", coefficients))

    def shifted(self, amount: float) -> Self:
        return replace(self, values=tuple(value + amount for value in self.values))

    def extremes(self) -> tuple[float, float]:
        return min(self.values), max(self.values)

    def card(self) -> dict[str, Any]:
        return {"kind": self.kind, "knots": list(self.knots), "values": list(self.values)}


@dataclass(frozen=True)
class WithTemperature:
    r"""A law at two temperatures of the damper, and straight between them.

    .. math:: p(u, T) = (1 - s)\,p_\text{cold}(u) + s\,p_\text{warm}(u), \qquad
              s = (T - T_\text{cold})/(T_\text{warm} - T_\text{cold})

    ``temperatures`` in degC, rising. It has no value at an input alone: `at_temperature` gives the law that has.
    """

    cold: Law
    warm: Law
    temperatures: tuple[float, float]
    kind = "temperature"

    def __post_init__(self) -> None:
        low, high = _check_numbers("temperatures", self.temperatures)
        if not low < high:
            raise InputError(f"the temperatures {low:g} and {high:g} °C of a law must rise")
        same = type(self.cold) is type(self.warm) and getattr(self.cold, "knots", ()) == getattr(self.warm, "knots", ())
        if not same or len(self.cold.coefficients) != len(self.warm.coefficients):
            raise InputError(
                "the two laws of a law with temperature must be of one kind, with the same knots or degree"
            )

    @property
    def low(self) -> float:
        """The smallest input it was calibrated on."""
        return self.cold.low

    @property
    def high(self) -> float:
        """The largest input it was calibrated on."""
        return self.cold.high

    @property
    def coefficients(self) -> tuple[float, ...]:
        """Those of the cold law, then those of the warm one."""
        return (*self.cold.coefficients, *self.warm.coefficients)

    def share(self, temperature: float) -> float:
        """s, where ``temperature`` stands between the two."""
        low, high = self.temperatures
        return (temperature - low) / (high - low)

    def at_temperature(self, temperature: float) -> Law:
        """The law over the input at one temperature in degC."""
        s, cold, warm = self.share(temperature), np.array(self.cold.coefficients), np.array(self.warm.coefficients)
        return self.cold.with_coefficients((1.0 - s) * cold + s * warm)

    def __call__(self, u: ArrayLike) -> Any:
        raise InputError(
            "this damper's parameters depend on its temperature; give one, such as damper.at_temperature(25.0), in degC"
        )

    def with_coefficients(self, coefficients: ArrayLike) -> Self:
        numbers, half = _check_numbers("coefficients", coefficients), len(self.cold.coefficients)
        return replace(
            self, cold=self.cold.with_coefficients(numbers[:half]), warm=self.warm.with_coefficients(numbers[half:])
        )

    def shifted(self, amount: float) -> Self:
        return replace(self, cold=self.cold.shifted(amount), warm=self.warm.shifted(amount))

    def extremes(self) -> tuple[float, float]:
        both = (*self.cold.extremes(), *self.warm.extremes())
        return min(both), max(both)

    def card(self) -> dict[str, Any]:
        temperatures = list(map(float, self.temperatures))
        return {
            "kind": self.kind,
            "temperatures_degC": temperatures,
            "cold": self.cold.card(),
            "warm": self.warm.card(),
        }


def from_card(table: dict[str, Any]) -> Law:
    """The law that a card's table describes; :class:`~dampyr.errors.InputError` names what is wrong with it."""
    kind = table.get("kind")
    try:
        if kind == "constant":
            return Constant(float(table["value"]), *map(float, table.get("range", ())))
        if kind == "polynomial":
            return Polynomial(tuple(table["coefficients"]), *map(float, table["range"]))
        if kind == "interpolation":
            return Interpolation(tuple(table["knots"]), tuple(table["values"]))
        if kind == "temperature":
            low, high = map(float, table["temperatures_degC"])
            return WithTemperature(from_card(table["cold"]), from_card(table["warm"]), (low, high))
    except KeyError as missing:
        raise InputError(f"a law of kind {kind!r} lacks {missing.args[0]!r}; add it") from None
    except (TypeError, ValueError) as problem:
        if isinstance(problem, InputError):
            raise
        raise InputError(f"a law of kind {kind!r} holds something that is not a number: {problem}") from None
    raise InputError(f"unknown law {kind!r}; choose constant, polynomial, interpolation or temperature")


def onto_limits(law: Law, quantity: Quantity) -> Law:
    """``law``, on a limit of its ``quantity`` where it misses that by rounding alone (`Quantity.without_rounding`).

    A straight line through two values at a limit, or a mean of two such values, comes out beyond it by the last digit. A
    polynomial is moved as a whole, and by a few roundings more, so that it keeps to the limit however its terms are summed.
    What is farther beyond comes back as it is.
    """
    if isinstance(law, WithTemperature):
        cold, warm = (onto_limits(side, quantity) for side in (law.cold, law.warm))
        return law if cold is law.cold and warm is law.warm else replace(law, cold=cold, warm=warm)
    numbers = np.array(law.coefficients)
    if isinstance(law, Polynomial):
        size = float(np.abs(numbers) @ max(abs(law.low), abs(law.high)) ** np.arange(numbers.size))
        ends = np.array(law.extremes())
        away = quantity.without_rounding(ends, size) - ends
        move = float(away[np.argmax(np.abs(away))])
        return law.shifted(move + np.copysign(4.0 * numbers.size * np.finfo(float).eps * size, move)) if move else law
    moved = quantity.without_rounding(numbers, float(np.abs(numbers).max()))
    return law if np.array_equal(moved, numbers) else law.with_coefficients(moved)


# The laws as piecewise polynomials, for kernels in which the input changes as they run:
# p(u) = sum_j c_kj (u - u_k)^j between the knots u_k and u_k+1; the first and the last piece extend beyond the range.


def polynomials(law: Law) -> tuple[Array, Array]:
    """The knots (K,) where pieces begin, and their coefficients (K, degree + 1) in rising powers."""
    if isinstance(law, Constant):
        return np.zeros(1), np.array([[law.value]])
    if isinstance(law, Polynomial):
        return np.zeros(1), np.array([law.coefficients])
    if isinstance(law, Interpolation):
        return np.array(law.knots[:-1]), np.ascontiguousarray(law.pieces.T)
    if isinstance(law, WithTemperature):
        law(0.0)  # says what to give
    raise InputError(
        f"a law of kind {law.kind!r} cannot follow an input that changes; take constant, polynomial or interpolation"
    )


def polynomial_table(damper: Any, static: bool = True) -> tuple[Array, Array]:
    """All laws of a damper: knots (P, K), infinite where a law has fewer, and coefficients (P, K, degree + 1).

    ``static=False`` sets static forces (the offset) to zero.
    """
    laws = [polynomials(law) for law in damper.all_laws.values()]
    max_knots, width = max(len(knots) for knots, _ in laws), max(c.shape[1] for _, c in laws)
    knots, coefficients = np.full((len(laws), max_knots), np.inf), np.zeros((len(laws), max_knots, width))
    for k, (at, c) in enumerate(laws):
        knots[k, : len(at)], coefficients[k, : len(at), : c.shape[1]] = at, c
    if not static:
        coefficients[list(damper.composition.static)] = 0.0
    return knots, coefficients


def look_up(knots: Any, coefficients: Any, u: float, out: Any) -> None:
    """Fill ``out`` with the parameters at ``u``; plain Python for numba."""
    for k in range(knots.shape[0]):
        piece = 0
        while piece + 1 < knots.shape[1] and u >= knots[k, piece + 1]:
            piece += 1
        d, total = u - knots[k, piece], 0.0
        for j in range(coefficients.shape[2] - 1, -1, -1):
            total = total * d + coefficients[k, piece, j]
        out[k] = total
