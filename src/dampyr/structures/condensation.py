r"""Degrees of freedom left out, their motion following the others through the springs alone (Guyan).

.. math:: q = T q_k, \qquad T_k = I, \quad T_r = -K_{rr}^{-1} K_{rk}, \qquad
          M' = T^T M T, \quad C' = T^T C T, \quad K' = T^T K T

Exact where what is left out has neither mass nor damping, as the joints of a frame that turn without inertia. Otherwise
every frequency rises: see ``frequency_errors``, and keep more. A damper needs both of its floors among those that are kept.

Reference: R. J. Guyan, Reduction of stiffness and mass matrices, AIAA Journal 3 (1965).
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import DampyrWarning, InputError
from dampyr.structures.building import Building
from dampyr.structures.connection import counted

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Condensed(Building):
    """A building on k of m degrees of freedom, which knows where the others are.

    ``T`` (m, k) makes displacements of all from those that are kept, in the order of ``all_floors`` (m
    labels). ``exact`` says whether nothing was lost. ``frequency_errors`` (k,) are the relative rises of the
    natural frequencies above those of the whole (nan for a free mode).
    """

    T: Array = field(default_factory=lambda: np.zeros((0, 0)))
    all_floors: tuple[str, ...] = ()
    exact: bool = False
    frequency_errors: Array = field(default_factory=lambda: np.zeros(0))

    def recover(self, motion: ArrayLike) -> Array:
        """Displacements or velocities (m, T) of all degrees of freedom, from those (k, T) of a response."""
        reduced_motion = np.asarray(motion, dtype=float)
        if reduced_motion.ndim not in (1, 2) or len(reduced_motion) != self.n:
            raise InputError(
                f"a motion of shape {reduced_motion.shape} is no motion of {self.n} floors; pass one row for each"
            )
        return self.T @ reduced_motion


def condense(
    M: ArrayLike,
    C: ArrayLike,
    K: ArrayLike,
    keep: Sequence[int | str],
    name: str = "building",
    floors: Sequence[str] = (),
    influence: ArrayLike | None = None,
) -> Condensed:
    r"""A building from matrices (m, m) of which some degrees of freedom may have no mass.

    ``keep`` are those that stay, by label or count from 1, in the order in which they shall be floors from the
    ground up; ``floors`` (m labels, default 1 to m) and ``influence`` (m,) are those of all. The ground's push
    is kept whole: :math:`\iota' = M'^{-1} T^T M \iota`. Warns (:class:`~dampyr.errors.DampyrWarning`) where the
    result is not exact, and says by how much the frequencies rise; :class:`~dampyr.errors.InputError` where a
    degree of freedom that is left out is held by no spring.
    """
    m, c, k = _matrices(M, C, K)
    labels = _labels(floors, len(k))
    retained = _retained_indices(keep, labels, name)
    left = [i for i in range(len(k)) if i not in retained]
    T = _recovery(k, retained, left, labels)
    made = Building(_reduced(T, m), _reduced(T, c), _reduced(T, k), name, [labels[i] for i in retained])
    pushed = np.asarray(np.linalg.solve(made.M, T.T @ m @ _influence(influence, len(k))), dtype=np.float64)
    errors = _frequency_errors(made, m, k)
    exact = not (np.any(m[left]) or np.any(c[left]))
    if not exact:
        _warn(name, bool(np.any(c[left])), errors)
    return Condensed(made.M, made.C, made.K, name, made.floors, pushed, T, labels, exact, errors)


def _reduced(T: Array, matrix: Array) -> Array:
    small = T.T @ matrix @ T
    return np.asarray(0.5 * (small + small.T))


def _matrices(*given: ArrayLike) -> list[Array]:
    matrices = [_square(letter, values) for letter, values in zip("MCK", given, strict=True)]
    if len({len(each) for each in matrices}) > 1:
        raise InputError("M, C and K differ in size; they must have one row per degree of freedom each")
    return matrices


def _influence(values: ArrayLike | None, size: int) -> Array:
    iota = np.ones(size) if values is None else np.asarray(values, dtype=float)
    if iota.shape != (size,):
        raise InputError(f"influence has shape {iota.shape}; it must be {size} numbers, one per degree of freedom")
    return iota


def _square(letter: str, values: ArrayLike) -> Array:
    array = np.array(values, dtype=float)
    if array.ndim != 2 or array.shape[0] != array.shape[1] or not np.all(np.isfinite(array)):
        raise InputError(f"{letter} has shape {array.shape}; it must be square, of finite numbers")
    if np.max(np.abs(array - array.T)) > 1e-9 * np.max(np.abs(array)):
        raise InputError(f"{letter} is not symmetric; make {letter}[i][j] = {letter}[j][i]")
    return array


def _retained_indices(keep: Sequence[int | str], labels: tuple[str, ...], name: str) -> list[int]:
    retained = [counted(labels, each, name) - 1 for each in keep]
    if not retained or -1 in retained or len(set(retained)) != len(retained):
        raise InputError(
            f"keep = {list(keep)} is not allowed; give different floors of {name}, the ground not among them"
        )
    return retained


def _labels(floors: Sequence[str], size: int) -> tuple[str, ...]:
    labels = tuple(str(each) for each in floors) or tuple(str(i + 1) for i in range(size))
    if len(labels) != size:
        raise InputError(f"floors = {list(labels)} does not label {size} degrees of freedom; give {size} names")
    return labels


def _recovery(k: Array, retained: list[int], left: list[int], labels: tuple[str, ...]) -> Array:
    T = np.zeros((len(k), len(retained)))
    T[retained] = np.eye(len(retained))
    if left:
        block = k[left][:, left]
        values = np.linalg.eigvalsh(block)
        if values[0] <= 1e-12 * np.max(np.abs(k)):
            raise InputError(
                f"what is left out ({', '.join(labels[i] for i in left)}) is not held by springs: its stiffness has "
                f"the eigenvalue {values[0]:g}, which must be greater than 0; keep more, or add the springs"
            )
        T[left] = -np.linalg.solve(block, k[left][:, retained])
    return T


def _frequency_errors(made: Building, m: Array, k: Array) -> Array:
    """How far the frequencies lie above the lowest of the whole, whose mass may be singular."""
    from scipy.linalg import eigh

    shift = 1e-3 * np.trace(k) / np.trace(m)
    inverse = eigh(m, k + shift * m, eigvals_only=True)[::-1][: made.n]
    square = 1.0 / inverse - shift
    ours = (2 * np.pi * made.frequencies) ** 2
    free = square <= 1e-9 * square[-1]
    return np.where(free, np.nan, np.sqrt(np.maximum(ours / np.where(free, 1.0, square), 0.0)) - 1.0)


def _warn(name: str, damped: bool, errors: Array) -> None:
    finite_errors = np.nan_to_num(errors)
    worst = int(np.argmax(finite_errors))
    lost = "mass and damping" if damped else "mass"
    warnings.warn(
        f"{name}: what was left out has {lost}, so the condensed building is not exact: frequency 1 "
        f"rises by {100 * finite_errors[0]:.2g} %, the worst, frequency {worst + 1}, by {100 * finite_errors[worst]:.2g} %; "
        "keep more where that matters",
        DampyrWarning,
        stacklevel=3,
    )
