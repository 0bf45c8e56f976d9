"""What is fitted to what: the unknowns of a fit, their kinds and limits, and where a search stands among them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.identification.fit_data import Piece
from dampyr.identification.parametrisation import Column
from dampyr.models import Composition

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
NUISANCES = ("offset", "gain", "temperature", "state")
VISCOUS = "N s/m"
#: standard deviation of the logarithm that a fit expects of a record's gain and of its viscosity
PRIOR = {"gain": 0.05, "temperature": 0.2}
MISFIT = 0.05  # of the force's spread: against how large an error a prior is weighed
FURTHEST = 1.0  # how far these logarithms may go


@dataclass(frozen=True)
class Problem:
    """The parameters' columns, the records' pieces, and which ``nuisances`` each record keeps to itself, in order."""

    composition: Composition
    columns: list[Column]
    pieces: list[Piece]
    nuisances: tuple[str, ...] = ("offset", "state")

    @cached_property
    def slices(self) -> list[slice]:
        """Where each parameter's values stand among all coefficients."""
        ends = np.cumsum([0, *(c.size for c in self.columns)])
        return [slice(int(a), int(b)) for a, b in itertools.pairwise(ends)]

    @cached_property
    def owners(self) -> list[int]:
        """For each parameter the one whose values it takes: itself, unless it is tied."""
        names = [c.name for c in self.columns]
        return [names.index(c.tied) if c.tied else k for k, c in enumerate(self.columns)]

    @cached_property
    def size(self) -> int:
        """How many coefficients there are."""
        return sum(c.size for c in self.columns)

    def _of_each(self, values: Sequence[float]) -> Array:
        """What is said of each parameter, for each of its coefficients."""
        return np.repeat(np.array(values, dtype=float), [c.size for c in self.columns])

    @cached_property
    def varying(self) -> bool:
        """Whether the input varies within a record."""
        return any(np.ndim(p.u) for p in self.pieces)

    @cached_property
    def common(self) -> tuple[str, ...]:
        """The nuisances that are not hysteretic states."""
        return tuple(name for name in ("offset", "gain", "temperature") if name in self.nuisances)

    @cached_property
    def states(self) -> list[tuple[float, float]]:
        """The bounds of the states that each record keeps to itself."""
        bounds = list(self.composition.states.values())
        return [bounds[k] for k in self.composition.free_at_start] if "state" in self.nuisances else []

    @cached_property
    def locals(self) -> int:
        """How many nuisances a record has."""
        return len(self.common) + len(self.states)

    @cached_property
    def is_linear(self) -> Bools:
        """Which coefficients the force is affine in."""
        return self._of_each([c.quantity.linear for c in self.columns]).astype(bool)

    @cached_property
    def is_local_linear(self) -> Bools:
        """Which nuisances the force is affine in, whatever the rest."""
        return np.array([name == "offset" for name in self.common] + [False] * len(self.states), dtype=bool)

    @cached_property
    def is_logarithmic(self) -> Bools:
        """Which coefficients are walked in their logarithm."""
        return self._of_each([c.logarithmic for c in self.columns]).astype(bool)

    @cached_property
    def limits(self) -> tuple[Array, Array]:
        """The lowest and highest value of each coefficient."""
        low, high = (self._of_each([getattr(c.quantity, end) for c in self.columns]) for end in ("low", "high"))
        return low, high

    @cached_property
    def local_limits(self) -> tuple[Array, Array]:
        """The lowest and highest value of each nuisance."""
        reach = {"offset": np.inf, "gain": FURTHEST, "temperature": FURTHEST}
        low = [-reach[name] for name in self.common] + [a for a, _ in self.states]
        high = [reach[name] for name in self.common] + [b for _, b in self.states]
        return np.array(low, dtype=float), np.array(high, dtype=float)

    @cached_property
    def inner_limits(self) -> tuple[Array, Array]:
        """The same with an open limit left by a billionth of an SI unit."""
        low, high = self.limits
        open_low = self._of_each([c.quantity.open_low for c in self.columns]).astype(bool)
        return np.where(open_low & np.isfinite(low), low + 1e-9, low), high

    @cached_property
    def affine(self) -> tuple[Array, Array]:
        """The parameters (M, P) of each record as a constant, and a matrix (M, P, G) times the coefficients.

        Only where no input varies within a record.
        """
        shape = len(self.pieces), len(self.columns)
        constant, matrix = np.zeros(shape), np.zeros((*shape, self.size))
        for k, owner in enumerate(self.owners):
            column = self.columns[owner]
            for r, one in enumerate(self.pieces):
                if column.fixed is not None:
                    constant[r, k] = column.fixed
                else:
                    matrix[r, k, self.slices[owner]] = column.basis(one.u)
        return constant, matrix

    def inside(self, theta: Array) -> Array:
        """Rounding may leave a value a hair outside its limit."""
        return np.clip(theta, *self.inner_limits)


@dataclass(frozen=True)
class Point:
    """Where the search stands: all coefficients (G,), and each record's nuisances (M, L), gains by their logarithm."""

    theta: Array
    local: Array

    def of(self, problem: Problem) -> list[Array]:
        """The coefficients by parameter; a tied one has those of its owner."""
        return [self.theta[problem.slices[k]] for k in problem.owners]

    def nuisance(self, problem: Problem, record: int, name: str) -> float:
        """One nuisance of a record as it enters the equations: 0 N, or the factor 1, where the fit leaves it out."""
        if name not in problem.common:
            return 0.0 if name == "offset" else 1.0
        value = float(self.local[record, problem.common.index(name)])
        return value if name == "offset" else float(np.exp(value))

    def states(self, problem: Problem, record: int) -> Array:
        """The states at the start of a record's motion; none kept means no memory."""
        states = np.array(problem.composition.path0)
        if problem.states:
            states[list(problem.composition.free_at_start)] = self.local[record, len(problem.common) :]
        return states

    def coordinates(self, problem: Problem) -> Array:
        """The coefficients as the search walks them, logarithms where they are."""
        log = problem.is_logarithmic
        return np.where(log, np.log(np.where(log, self.theta, 1.0)), self.theta)


def values_at(problem: Problem, point: Point, record: int) -> Array:
    """The parameter vector (P,) of a record, or (n, P) where its input varies, its own viscosity included."""
    u = problem.pieces[record].u
    if problem.varying:
        owned = zip(problem.owners, point.of(problem), strict=True)
        values = np.stack([problem.columns[k].value(theta, u) for k, theta in owned], axis=-1)
    else:
        constant, matrix = problem.affine
        values = constant[record] + matrix[record] @ point.theta
    if "temperature" in problem.common:
        warmth = point.nuisance(problem, record, "temperature")
        values = values * np.where(is_viscous(problem), warmth, 1.0)
    return values


def is_viscous(problem: Problem) -> Bools:
    """Which parameters follow the temperature: viscous friction."""
    return np.array([c.quantity.unit == VISCOUS for c in problem.columns])


@dataclass(frozen=True)
class Share:
    """A problem that stands by itself within a larger one: its coefficients and records there."""

    problem: Problem
    coefficients: list[int]
    records: list[int]


def apart(problem: Problem) -> list[Share]:
    """The problem as several that share no coefficient: one per input where every law is values at the inputs."""
    free = [c for c in problem.columns if c.size]
    knots = sorted({u for c in free for u in c.knots})
    if problem.varying or any(c.kind != "interpolation" for c in free) or len(knots) < 2:
        return [Share(problem, list(range(problem.size)), list(range(len(problem.pieces))))]
    nearest = [int(np.argmin(np.abs(np.array(knots) - p.u))) for p in problem.pieces]
    return [_share(problem, knots[k], [r for r, at in enumerate(nearest) if at == k]) for k in range(len(knots))]


def _share(problem: Problem, knot: float, records: list[int]) -> Share:
    columns = [replace(c, knots=(knot,)) for c in problem.columns]
    own = [s.start + c.knots.index(knot) for c, s in zip(problem.columns, problem.slices, strict=True) if c.size]
    pieces = [problem.pieces[r] for r in records]
    return Share(Problem(problem.composition, columns, pieces, problem.nuisances), own, records)


def checked_nuisances(composition: Composition, pieces: list[Piece], wanted: Sequence[str]) -> tuple[str, ...]:
    """``wanted`` in order; :class:`~dampyr.errors.InputError` where the records cannot tell them from the damper."""
    requested = (wanted,) if isinstance(wanted, str) else tuple(wanted)
    unknown = [name for name in requested if name not in NUISANCES]
    if unknown:
        raise InputError(f"{unknown[0]!r} is no nuisance; choose among {', '.join(NUISANCES)}")
    for name in ("gain", "temperature"):
        if name in requested:
            _check_company(pieces, name)
    if "temperature" in requested and all(q.unit != VISCOUS for q in composition.quantities.values()):
        raise InputError(
            f"{composition} has no parameter in {VISCOUS}, so nothing follows the temperature; leave it out"
        )
    return tuple(name for name in NUISANCES if name in requested and not (name == "offset" and composition.static))


def _check_company(pieces: list[Piece], name: str) -> None:
    """A record alone at its input cannot tell its own factor from the damper's parameters."""
    levels = [round(float(np.mean(p.u)), 6) for p in pieces]
    for one, level in zip(pieces, levels, strict=True):
        if levels.count(level) < 2:
            raise InputError(
                f"{one.name} is the only record at {level:g} {one.unit}, so its {name} cannot be told from the damper; add "
                f"records at this input or leave {name!r} out"
            )
