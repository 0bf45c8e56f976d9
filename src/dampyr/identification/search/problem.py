"""The fitting problem: the unknowns of a fit, their kinds and limits, the records, and a point of the search among them."""

from __future__ import annotations

import copy
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.identification.search.fit_data import Piece
from dampyr.identification.search.parametrisation import Column, bases
from dampyr.models.codegen.composition import Composition
from dampyr.models.input_lag import lagged
from dampyr.models.path_integration import acceleration
from dampyr.units import OPEN_MARGIN

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
Integers = NDArray[np.int64]
NUISANCES = ("offset", "gain", "temperature", "state")
VISCOUS = "N s/m"
#: standard deviation of the logarithm that a fit expects of a record's gain and of its viscosity
PRIOR = {"gain": 0.05, "temperature": 0.2}
MISFIT = 0.05  # of the force's spread: against how large an error a prior is weighed
MAX_LOGARITHM = 1.0  # how far the logarithms of gain and viscosity may go from 0


@dataclass(frozen=True)
class SummationPlan:
    """Which columns the kernel sums for a record.

    ``source`` (C,) and ``factor`` (1 or n, C) as in `dampyr.models.path_integration.products_along`; ``parameter`` (C,)
    is the parameter that a column belongs to, or -1; ``to_unknowns`` (C + 1, L + G + 1) makes the unknowns' columns of
    them.
    """

    source: Integers
    factor: Array
    parameter: Integers
    to_unknowns: Array


@dataclass(eq=False)
class Problem:
    """The parameters' columns, the records' pieces, and which ``nuisances`` each record has (its random effects), in order.

    The rest follows from these and is worked out once. A problem is not changed; `dataclasses.replace` makes another one.
    """

    composition: Composition
    columns: list[Column]
    pieces: list[Piece]
    nuisances: tuple[str, ...] = ("offset", "state")

    size: int = field(init=False)  # G, of the coefficients
    slices: list[slice] = field(init=False, repr=False)  # where each parameter's values stand among the coefficients
    owners: list[int] = field(init=False, repr=False)  # the parameter whose values each one takes: itself, unless tied
    varying: bool = field(init=False)  # whether the input varies within a record
    common: tuple[str, ...] = field(init=False)  # the nuisances that are not hysteretic states
    states: list[tuple[float, float]] = field(init=False, repr=False)  # the bounds of each record's initial states
    path_start: Array = field(init=False, repr=False)  # (S,) the states at the start without them: no memory
    locals: int = field(init=False)  # L, of the nuisances of a record
    is_viscous: Bools = field(init=False, repr=False)  # (P,) which parameters follow the temperature
    is_linear: Bools = field(init=False, repr=False)  # (G,) which coefficients the force is affine in
    is_local_linear: Bools = field(
        init=False, repr=False
    )  # (L,) which nuisances the force is affine in, whatever the rest
    is_logarithmic: Bools = field(init=False, repr=False)  # (G,) which coefficients are searched in their logarithm
    limits: tuple[Array, Array] = field(init=False, repr=False)  # (G,) the lowest and highest value of each coefficient
    inner_limits: tuple[Array, Array] = field(
        init=False, repr=False
    )  # (G,) the same, open limits and the 0 of logarithms left by `OPEN_MARGIN`
    local_limits: tuple[Array, Array] = field(init=False, repr=False)  # (L,) of each nuisance
    constant: Array = field(init=False, repr=False)  # (M, P) and
    matrix: Array = field(
        init=False, repr=False
    )  # (M, P, G): parameters = constant + matrix @ theta where no input varies
    accelerations: list[Array] = field(init=False, repr=False)  # along each record, zeros where no part needs it
    plans: list[SummationPlan] = field(init=False, repr=False)  # one per record

    def __post_init__(self) -> None:
        sizes = [c.size for c in self.columns]
        logarithmic = [c.logarithmic for c in self.columns]
        self.varying = any(np.ndim(p.u) for p in self.pieces)
        # Records with one constant input share a plan.
        warming = any(c.temperatures for c in self.columns)
        inputs = [
            (float(r if self.varying else piece.u), piece.temperature if warming else 0.0)
            for r, piece in enumerate(self.pieces)
        ]
        first = {key: inputs.index(key) for key in dict.fromkeys(inputs)}
        bases_at = {key: bases(self.columns, self.pieces[r].u, self.pieces[r].temperature) for key, r in first.items()}
        self.size, ends = sum(sizes), np.cumsum([0, *sizes])
        self.slices = [slice(int(a), int(b)) for a, b in itertools.pairwise(ends)]
        names, quantities = [c.name for c in self.columns], [c.quantity for c in self.columns]
        self.owners = [names.index(c.tied) if c.tied else k for k, c in enumerate(self.columns)]
        self.common = tuple(name for name in ("offset", "gain", "temperature") if name in self.nuisances)
        # A test may begin where a larger one before it has left the damper.
        stroke = max(float(np.ptp(piece.x)) for piece in self.pieces)
        bounds = [
            (-stroke, stroke) if name in self.composition.within_stroke else span
            for name, span in self.composition.states.items()
        ]
        self.states = [bounds[k] for k in self.composition.free_at_start] if "state" in self.nuisances else []
        self.path_start = np.array(self.composition.path0)
        self.locals = len(self.common) + len(self.states)
        self.is_viscous = np.array([q.unit == VISCOUS for q in quantities])
        self.is_linear = np.repeat(np.array([q.linear for q in quantities], dtype=bool), sizes)
        self.is_local_linear = np.array([n == "offset" for n in self.common] + [False] * len(self.states), dtype=bool)
        self.is_logarithmic = np.repeat(np.array(logarithmic, dtype=bool), sizes)
        low = np.repeat(np.array([q.low for q in quantities], dtype=float), sizes)
        high = np.repeat(np.array([q.high for q in quantities], dtype=float), sizes)
        open_low = np.repeat(np.array([q.open_low for q in quantities], dtype=bool), sizes)
        self.limits = low, high
        never_reached = (open_low & np.isfinite(low)) | self.is_logarithmic
        self.inner_limits = np.where(never_reached, low + OPEN_MARGIN, low), high
        reach = {"offset": np.inf, "gain": MAX_LOGARITHM, "temperature": MAX_LOGARITHM}
        local_low = [-reach[name] for name in self.common] + [a for a, _ in self.states]
        local_high = [reach[name] for name in self.common] + [b for _, b in self.states]
        self.local_limits = np.array(local_low, dtype=float), np.array(local_high, dtype=float)
        self.accelerations = [acceleration(self.composition, piece.t, piece.v) for piece in self.pieces]
        self.constant = np.zeros((len(self.pieces), len(self.columns)))
        self.matrix = np.zeros((*self.constant.shape, self.size))
        for k, owner in enumerate(self.owners):
            fixed = self.columns[owner].fixed
            self.constant[:, k] = 0.0 if fixed is None else fixed
            for r, key in enumerate(inputs):
                basis = bases_at[key][owner]
                if not self.varying and basis is not None:
                    self.matrix[r, k, self.slices[owner]] = basis[0]
        plan_at = {key: summation_plan(self, at_input) for key, at_input in bases_at.items()}
        self.plans = [plan_at[key] for key in inputs]

    def inside(self, theta: Array) -> Array:
        """``theta`` inside its limits, which rounding may leave."""
        return np.clip(theta, *self.inner_limits)


def summation_plan(problem: Problem, at_input: Sequence[Array | None]) -> SummationPlan:
    """The plan of a record from the `bases` of the parameters at its input."""
    P, S, L = len(problem.columns), len(problem.path_start), problem.locals
    source: list[int] = []
    factors: list[Array] = []
    targets: list[dict[int, float]] = []
    for k, name in enumerate(problem.common):
        if name != "temperature":
            source.append(P + S + (name == "offset"))
            targets.append({k: 1.0})
    for j, place in enumerate(problem.composition.free_at_start if problem.states else ()):
        source.append(P + place)
        targets.append({len(problem.common) + j: 1.0})
    parameter = [-1] * len(source)
    factors += [np.ones(1)] * len(source)
    for k, owner in enumerate(problem.owners):
        basis, first = at_input[owner], problem.slices[owner].start
        if basis is None:
            if problem.is_viscous[k] and "temperature" in problem.common:
                parameter, factors, targets = [*parameter, k], [*factors, np.ones(1)], [*targets, {}]
        elif problem.varying:
            parameter += [k] * basis.shape[1]
            factors += list(basis.T)
            targets += [{L + first + j: 1.0} for j in range(basis.shape[1])]
        else:
            parameter, factors = [*parameter, k], [*factors, np.ones(1)]
            targets.append({L + first + j: float(b) for j, b in enumerate(basis[0]) if b != 0.0})
    source += [k for k in parameter if k >= 0]
    matrix = np.zeros((len(source) + 1, L + problem.size + 1))
    for row, target in enumerate(targets):
        for at, value in target.items():
            matrix[row, at] = value
    matrix[-1, -1] = 1.0
    varies = any(factor.size > 1 for factor in factors)
    width = np.column_stack(np.broadcast_arrays(*factors)) if varies else np.concatenate((*factors, np.empty(0)))[None]
    return SummationPlan(
        np.array(source, dtype=np.int64), np.ascontiguousarray(width), np.array(parameter, dtype=np.int64), matrix
    )


@dataclass(frozen=True)
class SearchPoint:
    """A point of the search: all coefficients (G,), and each record's nuisances (M, L), gains by their logarithm."""

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
        """The states at the start of a record's motion: no memory where the fit leaves them out."""
        states = problem.path_start.copy()
        if problem.states:
            states[list(problem.composition.free_at_start)] = self.local[record, len(problem.common) :]
        return states

    def coordinates(self, problem: Problem) -> Array:
        """The coefficients in the coordinates of the search: logarithms where `Problem.is_logarithmic`."""
        return to_coordinates(self.theta, problem.is_logarithmic)

    def in_block(self, block: Block) -> SearchPoint:
        """The part of this point that belongs to a block of its problem."""
        return SearchPoint(self.theta[block.coefficients], self.local[block.records])


def to_coordinates(values: Array, logarithmic: Bools) -> Array:
    """Values (..., p) with the logarithm of those that are ``logarithmic`` (p,); minus infinity for 0."""
    with np.errstate(divide="ignore"):
        return np.where(logarithmic, np.log(np.where(logarithmic, values, 1.0)), values)


def to_values(coordinates: Array, logarithmic: Bools) -> Array:
    """The values (..., p) at coordinates that `to_coordinates` gives."""
    return np.where(logarithmic, np.exp(np.where(logarithmic, coordinates, 0.0)), coordinates)


def has_lag(problem: Problem) -> bool:
    """Whether inputs lag behind their commands: the composition has a lag, and an input varies."""
    return problem.composition.lag is not None and problem.varying


def input_at(problem: Problem, point: SearchPoint, record: int, more: float = 0.0) -> Array | float:
    """The input of a record, behind its command by the lag of the point and ``more`` s where there is a lag."""
    piece, k = problem.pieces[record], problem.composition.lag
    if k is None or not problem.varying:
        return piece.u
    tau = float(problem.columns[k].value(point.of(problem)[k], 0.0)) + more
    return lagged(piece.t, piece.u, tau)


def values_at(problem: Problem, point: SearchPoint, record: int, u: Array | float) -> Array:
    """The parameter vector (P,) of a record, or (n, P) where its input ``u`` varies, its own viscosity included."""
    if problem.varying:
        owned = zip(problem.owners, point.of(problem), strict=True)
        values = np.stack(
            [problem.columns[k].value(theta, u, problem.pieces[record].temperature) for k, theta in owned], axis=-1
        )
    else:
        values = problem.constant[record] + problem.matrix[record] @ point.theta
    if "temperature" in problem.common:
        values = values * np.where(problem.is_viscous, point.nuisance(problem, record, "temperature"), 1.0)
    return values


@dataclass(frozen=True)
class Block:
    """A problem that shares no coefficient with the rest of a larger one: its coefficients and records there."""

    problem: Problem
    coefficients: list[int]
    records: list[int]


def independent_blocks(problem: Problem) -> list[Block]:
    """The problem as several that share no coefficient: one per input where every law is values at the inputs."""
    free = [c for c in problem.columns if c.size]
    knots = sorted({u for c in free for u in c.knots})
    if problem.varying or any(c.kind != "interpolation" or c.temperatures for c in free) or len(knots) < 2:
        return [Block(problem, list(range(problem.size)), list(range(len(problem.pieces))))]
    nearest = [int(np.argmin(np.abs(np.array(knots) - p.u))) for p in problem.pieces]
    blocks = []
    for k, knot in enumerate(knots):
        records = [r for r, at in enumerate(nearest) if at == k]
        columns = [replace(c, knots=(knot,)) for c in problem.columns]
        coefficients = [
            s.start + c.knots.index(knot) for c, s in zip(problem.columns, problem.slices, strict=True) if c.size
        ]
        pieces = [problem.pieces[r] for r in records]
        blocks.append(Block(Problem(problem.composition, columns, pieces, problem.nuisances), coefficients, records))
    return blocks


def with_held(problem: Problem, values: Mapping[int, float]) -> Problem:
    """The problem with some coefficients (place -> value) held: their limits leave no step, all others stay free.

    A search must begin at these values. A held coefficient is no longer logarithmic, as the step of one has limits of its own.
    """
    held = copy.copy(problem)
    places, numbers = list(values), list(values.values())
    for name in ("limits", "inner_limits"):
        low, high = (side.copy() for side in getattr(problem, name))
        low[places] = high[places] = numbers
        setattr(held, name, (low, high))
    held.is_logarithmic = problem.is_logarithmic.copy()
    held.is_logarithmic[places] = False
    return held


def checked_nuisances(composition: Composition, pieces: list[Piece], wanted: Sequence[str]) -> tuple[str, ...]:
    """``wanted`` in order; :class:`~dampyr.errors.InputError` where the records cannot distinguish them from the damper."""
    requested = (wanted,) if isinstance(wanted, str) else tuple(wanted)
    for name in ("gain", "temperature"):
        if name in requested:
            _check_shared_inputs(pieces, name)
    if "temperature" in requested and all(q.unit != VISCOUS for q in composition.quantities.values()):
        raise InputError(
            f"{composition} has no parameter in {VISCOUS}, so nothing follows the temperature; leave it out"
        )
    return tuple(name for name in NUISANCES if name in requested and not (name == "offset" and composition.static))


def _check_shared_inputs(pieces: list[Piece], name: str) -> None:
    """Refuse a factor of a record that is alone at its input: it would be one with the damper's parameters."""
    levels = [round(float(np.mean(p.u)), 6) for p in pieces]
    for piece, level in zip(pieces, levels, strict=True):
        if levels.count(level) < 2:
            raise InputError(
                f"{piece.name} is the only record at {level:g} {piece.unit}, so its {name} cannot be distinguished from "
                f"the damper; add records at this input or leave {name!r} out"
            )
