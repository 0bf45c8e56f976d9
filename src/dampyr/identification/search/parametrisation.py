r"""The parametrisation of the laws in a fit: values at chosen inputs, and what they make of the parameter at any other.

Every law is fitted by its values at *knots*, inputs that occur in the records: they are as well conditioned as the records
allow and have the parameter's own unit and limits. The parameter at the input u is :math:`p(u) = \sum_k b_k(u)\,\theta_k`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.models import Constant, Interpolation, Polynomial, WithTemperature
from dampyr.models.codegen.composition import Composition
from dampyr.models.laws import Law
from dampyr.units import Quantity

Array = NDArray[np.float64]
KINDS = ("constant", "polynomial", "interpolation")
OTHERS = "*"  # in `laws`: every parameter that is not named there
MIN_WARMING = (
    2.0  # °C between the coldest and the warmest record: below it a law of temperature would follow their noise
)


@dataclass(frozen=True)
class Column:
    """One parameter in a fit: ``kind`` of law, its ``knots``, or a ``fixed`` value, or the parameter it is ``tied`` to.

    With ``temperatures`` (two, degC) it has a value for each knot at the lower one, then one for each at the higher one, and
    goes straight between them.
    """

    name: str
    quantity: Quantity
    kind: str
    knots: tuple[float, ...]
    fixed: float | None = None
    tied: str | None = None
    temperatures: tuple[float, float] | None = None

    @property
    def size(self) -> int:
        """The number of coefficients that the fit determines for it."""
        return 0 if self.fixed is not None or self.tied else len(self.knots) * (2 if self.temperatures else 1)

    @property
    def logarithmic(self) -> bool:
        """Whether the search is in its logarithm: a parameter that is not linear and must stay positive, or asks for it."""
        q = self.quantity
        return q.logarithmic or (q.open_low and q.low == 0 and not q.linear)

    def basis(self, u: Array | float, temperature: float = math.nan) -> Array:
        """b(u, T), shape (..., size)."""
        if self.temperatures:
            over_input, (low, high) = replace(self, temperatures=None).basis(u), self.temperatures
            s = (temperature - low) / (high - low)
            return np.concatenate(((1.0 - s) * over_input, s * over_input), axis=-1)
        if self.kind == "constant":
            return np.ones((*np.shape(u), 1))
        at = np.asarray(u, dtype=float)
        knots = np.array(self.knots)
        if self.kind == "interpolation":  # a fit asks at its records' inputs only, which differ from a knot by rounding
            return np.eye(knots.size)[np.argmin(np.abs(at[..., None] - knots), axis=-1)]
        out = np.ones((*at.shape, knots.size))  # Lagrange's polynomials: 1 at their own knot, 0 at the others
        for k, knot in enumerate(knots):
            for other in np.delete(knots, k):
                out[..., k] *= (at - other) / (knot - other)
        return out

    def value(self, theta: Array, u: Array | float, temperature: float = math.nan) -> Array:
        """The parameter at ``u`` and, where it depends on it, at a temperature in degC."""
        if self.fixed is not None:
            return np.full(np.shape(u), self.fixed)
        return np.asarray(self.basis(u, temperature) @ theta)

    def law(self, theta: Array, low: float, high: float) -> Law:
        """The law through the fitted values, on the range of the records."""
        if self.fixed is not None:
            return Constant(self.fixed, low, high)
        if self.temperatures:
            plain, half = replace(self, temperatures=None), len(self.knots)
            laws = plain.law(theta[:half], low, high), plain.law(theta[half:], low, high)
            return WithTemperature(*laws, self.temperatures)
        if self.kind == "constant":
            return Constant(float(theta[0]), low, high)
        if self.kind == "interpolation":
            return Interpolation(self.knots, tuple(theta))
        return Polynomial(tuple(self.to_coefficients() @ theta), low, high)

    def to_coefficients(self) -> Array:
        """The matrix from the values at the knots to the coefficients of the law."""
        if self.temperatures:
            once = replace(self, temperatures=None).to_coefficients()
            return np.asarray(np.kron(np.eye(2), once))
        if self.kind != "polynomial":
            return np.eye(self.size)
        return np.asarray(np.linalg.inv(np.vander(self.knots, increasing=True)))

    def labels(self, unit: str) -> list[str]:
        """Names for people: ``dahl.kx`` where there is one value, else ``dahl.kx @ 1.98 V``, or ``dahl.kx @ 1.98 V, 20 °C``."""
        if self.temperatures:
            inputs = [f"{u:g} {unit}, " for u in self.knots] if len(self.knots) > 1 else [""]
            return [f"{self.name} @ {where}{T:.4g} °C" for T in self.temperatures for where in inputs]
        if self.size == 1:
            return [self.name]
        return [f"{self.name} @ {u:g} {unit}" for u in self.knots]


def bases(columns: list[Column], u: Array | float, temperature: float = math.nan) -> list[Array | None]:
    """The basis (1 or n, size) of each column at ``u`` and a temperature in degC; None for a fixed or tied one."""
    return [np.atleast_2d(column.basis(u, temperature)) if column.size else None for column in columns]


def columns(
    composition: Composition,
    inputs: list[Array | float],
    laws: str | Mapping[str, str] | None,
    fixed: Mapping[str, float] | None,
    tied: Mapping[str, str] | None = None,
    temperatures: Sequence[float] = (),
) -> list[Column]:
    """One column per parameter.

    ``inputs`` are those of the records (a number, or an array where it varies during the test). ``laws`` is a kind for all
    parameters, or one per flat name, ``"*"`` standing for those that are not named and that no part holds constant over the
    input: ``"constant"``, ``"interpolation"`` (the default where inputs differ) or ``"polynomial"``, with its degree as
    ``"polynomial:2"`` (at most 3 by default). With ``+temperature``, such as ``"interpolation+temperature"``, the parameter
    is such a law at the lowest and the highest of ``temperatures`` (of each record, degC) and straight between them. ``tied``
    parameters take the law of another.
    """
    tied = dict(tied or {})
    fixed = dict(fixed or {})
    law_of = {OTHERS: laws} if isinstance(laws, str) else dict(laws or {})
    for name, named in (("fixed", {*fixed}), ("laws", {*law_of} - {OTHERS})):
        unknown = sorted(named - set(composition.parameters))
        if unknown:
            raise InputError(f"{name} names {unknown[0]!r}; {composition} has {', '.join(composition.parameters)}")
    varying = any(np.ndim(u) for u in inputs)
    distinct = _list_distinct(inputs)
    lag = None if composition.lag is None else composition.parameters[composition.lag]
    without_ties = []
    for name, quantity in composition.quantities.items():
        wanted = law_of.get(name, "constant" if name in composition.constant else law_of.get(OTHERS))
        if name == lag:  # the delay of the input does not depend on the input
            wanted = "constant"
        wanted, warming = _split_temperature(wanted)
        kind, knots = _choose_kind(name, wanted, distinct, varying)
        value = fixed.get(name)
        if value is not None:
            quantity.check(f"fixed {name}", value)
        span = _span_temperatures(name, temperatures) if warming and value is None else None
        without_ties.append(Column(name, quantity, kind, knots, value, temperatures=span))
    _check_ties(composition, tied, fixed, laws)
    return _tie(without_ties, tied)


def _split_temperature(wanted: str | None) -> tuple[str | None, bool]:
    """A kind of law without ``+temperature``, and whether it had that."""
    kind, plus, more = (wanted or "").partition("+")
    if not plus:
        return wanted, False
    if more.strip() != "temperature":
        raise InputError(
            f"{wanted!r} is an unknown law; what is added can be temperature only, as in interpolation+temperature"
        )
    return kind.strip() or None, True


def _span_temperatures(name: str, temperatures: Sequence[float]) -> tuple[float, float]:
    """The lowest and the highest temperature of the records; InputError where they say nothing of a dependence."""
    unknown = sum(not math.isfinite(T) for T in temperatures)
    if unknown or not temperatures:
        raise InputError(
            f"{name} is to follow the temperature, but {unknown or 'all'} of {len(temperatures)} records have none; give each "
            "a temperature channel in degC, or leave +temperature out"
        )
    low, high = min(temperatures), max(temperatures)
    if high - low < MIN_WARMING:
        raise InputError(
            f"{name} is to follow the temperature, but the records' means lie between {low:.4g} and {high:.4g} °C; they must "
            f"differ by {MIN_WARMING:g} °C or more: add warmer or colder records, or leave +temperature out"
        )
    return low, high


def held_twins(
    composition: Composition,
    laws: str | Mapping[str, str] | None,
    fixed: Mapping[str, float] | None,
    tied: Mapping[str, str] | None,
) -> dict[str, float]:
    """Parameters that are held at 0 because an earlier one does the same, unless something names one of the two."""
    named = {*(laws if isinstance(laws, Mapping) else {}), *(fixed or {}), *(tied or {}), *(tied or {}).values()}
    return {
        name: 0.0
        for name, other in composition.twins.items()
        if name not in named and not (other in (fixed or {}) or other in (tied or {}))
    }


def _check_ties(
    composition: Composition, tied: dict[str, str], fixed: dict[str, float], laws: str | Mapping[str, str] | None
) -> None:
    quantities = composition.quantities
    for name, owner in tied.items():
        for parameter in (name, owner):
            if parameter not in quantities:
                raise InputError(f"tied names {parameter!r}; {composition} has {', '.join(composition.parameters)}")
        if name == owner or owner in tied:
            raise InputError(f"{name} is tied to {owner}, which is tied itself; tie both to one that is free")
        if name in fixed:
            raise InputError(f"{name} is fixed and tied to {owner}; choose one of the two")
        if not isinstance(laws, str) and name in (laws or {}):
            raise InputError(f"{name} takes the law of {owner} that it is tied to; leave it out of laws")
        if quantities[name].unit != quantities[owner].unit:
            units = f"{quantities[name].unit or 'no unit'} and {quantities[owner].unit or 'no unit'}"
            raise InputError(f"{name} and {owner} are in {units}; only parameters of the same unit can be tied")


def _tie(columns: list[Column], tied: dict[str, str]) -> list[Column]:
    """The columns with their ties; an owner respects the limits of all that follow it."""
    by_name = {c.name: c for c in columns}
    for name, owner in tied.items():
        of_owner, of_follower = by_name[owner].quantity, by_name[name].quantity
        shared = replace(
            of_owner,
            low=max(of_owner.low, of_follower.low),
            high=min(of_owner.high, of_follower.high),
            open_low=(of_owner.open_low and of_owner.low >= of_follower.low)
            or (of_follower.open_low and of_follower.low >= of_owner.low),
            linear=of_owner.linear and of_follower.linear,
        )
        by_name[owner] = replace(by_name[owner], quantity=shared)
        by_name[name] = replace(by_name[name], tied=owner)
        held = by_name[owner].fixed
        if held is not None:
            of_follower.check(f"{name}, tied to the fixed {owner},", held)
    return [by_name[c.name] for c in columns]


def _list_distinct(inputs: list[Array | float]) -> list[float]:
    """The inputs that differ, to a millionth of their range."""
    values = np.sort(np.concatenate([np.ravel(u) for u in inputs]))
    step = 1e-6 * max(float(np.ptp(values)), 1e-6)
    return [float(v) for k, v in enumerate(values) if k == 0 or v - values[k - 1] > step]


def _choose_kind(name: str, wanted: str | None, distinct: list[float], varying: bool) -> tuple[str, tuple[float, ...]]:
    if len(distinct) == 1 or wanted == "constant":
        if wanted not in (None, "constant"):
            raise InputError(f"one input, {distinct[0]:g}, cannot give a law of {name}; add records at other inputs")
        return "constant", (distinct[0],)
    kind, _, degree_text = (wanted or ("polynomial" if varying else "interpolation")).partition(":")
    if kind not in KINDS or (degree_text and not (kind == "polynomial" and degree_text.isdigit())):
        raise InputError(
            f"{wanted!r} is an unknown law; choose constant, interpolation, polynomial or polynomial:DEGREE"
        )
    if kind == "interpolation":
        if varying:
            raise InputError(f"{name} by interpolation needs a constant input in each record; use polynomial:DEGREE")
        return kind, tuple(distinct)
    degree = int(degree_text) if degree_text else min(3, len(distinct) - 1)
    if degree >= len(distinct):
        raise InputError(
            f"{len(distinct)} inputs cannot give a polynomial of degree {degree} of {name}; "
            f"lower it to {len(distinct) - 1} or add records at other inputs"
        )
    return kind, _pick_spread(distinct, degree + 1)


def _pick_spread(distinct: list[float], count: int) -> tuple[float, ...]:
    """``count`` of the inputs, as evenly spread as they can be."""
    if count == 1:
        return (distinct[len(distinct) // 2],)
    picked = np.unique(np.round(np.linspace(0, len(distinct) - 1, count)).astype(int))
    return tuple(distinct[k] for k in picked)
