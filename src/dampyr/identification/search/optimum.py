"""The end of a search, and what is known of the fit there: made once by `search`, and taken by all that comes after it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.identification.search.normal_equations import (
    NormalEquations,
    equations_from_sums,
    modelled_force,
    products,
    with_priors,
)
from dampyr.identification.search.problem import Block, Problem, SearchPoint, independent_blocks
from dampyr.models import Damper

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Optimum:
    """A problem at the end of its search, or an independent block of it there: ``part_of`` is then the whole, and which block.

    All that follows from the model's forces and derivatives at that point is worked out when it is first needed, and once.
    """

    problem: Problem
    point: SearchPoint
    part_of: tuple[Optimum, Block] | None = None

    @cached_property
    def forces(self) -> list[Array]:
        """The modelled force (n,) along each record, its own offset, gain and initial states included, N."""
        if self.part_of is not None:
            whole, block = self.part_of
            return [whole.forces[r] for r in block.records]
        return [modelled_force(self.problem, self.point, r) for r in range(len(self.problem.pieces))]

    @cached_property
    def residuals(self) -> list[Array]:
        """Measured less modelled force (n,) along each record, N."""
        return [piece.force - force for piece, force in zip(self.problem.pieces, self.forces, strict=True)]

    @cached_property
    def cluster_sums(self) -> list[Array]:
        """The weighted sums of products (g, K, K) of each record by cluster, over [nuisances, coefficients, residual].

        J'WJ, J'Wr and r'Wr of derivatives by the coefficients themselves, also of those that are searched in their logarithm;
        the priors of a record's nuisances go with its first cluster.
        """
        if self.part_of is not None:
            whole, block = self.part_of
            return _select_block(whole.cluster_sums, block, self.problem)
        return _sum_by_cluster(self.problem, self.point)

    @cached_property
    def curvature_sums(self) -> list[Array]:
        """The same, weighted by the second derivative of the loss: `cluster_sums` where the loss is squares."""
        if not self.is_robust:
            return self.cluster_sums
        if self.part_of is not None:
            whole, block = self.part_of
            return _select_block(whole.curvature_sums, block, self.problem)
        pieces = [p if p.second_weight is None else replace(p, weight=p.second_weight) for p in self.problem.pieces]
        return _sum_by_cluster(replace(self.problem, pieces=pieces), self.point)

    @property
    def is_robust(self) -> bool:
        """Whether the loss is another one than squares."""
        return any(piece.second_weight is not None for piece in self.problem.pieces)

    @cached_property
    def equations(self) -> NormalEquations:
        """The normal equations around the optimum, in the coordinates of the search; ``reduced`` is without the nuisances."""
        return equations_from_sums(self.problem, self.point, np.stack([sums.sum(axis=0) for sums in self.cluster_sums]))

    @property
    def information(self) -> Array:
        """(G, G) of the coefficients in the coordinates of the search, the nuisances eliminated."""
        return self.equations.reduced.matrix

    @cached_property
    def law_matrix(self) -> Array:
        """(C, G) from the fitted numbers to the coefficients of all laws of the damper; rows of fixed parameters are zero."""
        owners = [self.problem.columns[k] for k in self.problem.owners]
        T = np.zeros((sum(max(column.size, 1) for column in owners), self.problem.size))
        row = 0
        for column, k in zip(owners, self.problem.owners, strict=True):
            if column.size:
                T[row : row + column.size, self.problem.slices[k]] = column.to_coefficients()
            row += max(column.size, 1)
        return T

    def law_coefficients(self, theta: Array) -> Array:
        """The coefficients (C,) of all laws, in the order of the parameters, of other fitted numbers ``theta`` (G,)."""
        owners = [self.problem.columns[k] for k in self.problem.owners]
        fixed = [np.zeros(c.size) if c.size else np.array([c.fixed], dtype=float) for c in owners]
        return np.asarray(np.concatenate(fixed) + self.law_matrix @ theta)

    def draw_dampers(self, n: int, damper: Damper, draw: Callable[[], Array], trouble: str) -> list[Damper]:
        """``n`` times ``damper`` with fitted numbers (G,) by ``draw``; those that leave the allowed values are drawn again.

        They may leave them between the knots of a law. Raises InputError, with ``trouble`` as its end, where fewer than 1 %
        of the draws are admissible.
        """
        if n < 1:
            raise InputError(f"n = {n} is not allowed; give 1 or more")
        dampers: list[Damper] = []
        for _ in range(100 * n):
            with suppress(InputError):
                dampers.append(damper.with_coefficients(self.law_coefficients(draw())))
            if len(dampers) == n:
                return dampers
        raise InputError(f"only {len(dampers)} of {100 * n} draws were admissible{trouble}")

    @cached_property
    def blocks(self) -> tuple[Optimum, ...]:
        """The blocks that share no coefficient, one where the problem has no such blocks."""
        return tuple(
            Optimum(block.problem, self.point.in_block(block), (self, block))
            for block in independent_blocks(self.problem)
        )

    @property
    def places(self) -> list[int]:
        """The places of the coefficients among those of the whole problem."""
        return list(range(self.problem.size)) if self.part_of is None else self.part_of[1].coefficients


def _sum_by_cluster(problem: Problem, point: SearchPoint) -> list[Array]:
    cluster_sums = products(problem, point, by_cluster=True)
    first = with_priors(problem, point, np.stack([sums[0] for sums in cluster_sums]))
    for sums, changed in zip(cluster_sums, first, strict=True):
        sums[0] = changed
    return cluster_sums


def _select_block(sums: list[Array], block: Block, problem: Problem) -> list[Array]:
    """The sums of the block's records, over its coefficients only: those of the other blocks have no effect on them."""
    L, last = problem.locals, sums[0].shape[1] - 1
    places = np.array([*range(L), *(L + place for place in block.coefficients), last])
    return [sums[r][:, places[:, None], places] for r in block.records]
