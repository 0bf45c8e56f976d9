r"""A building: masses, dashpots and springs that move with the ground; and its condensation to fewer degrees of freedom.

.. math:: M \ddot q + C \dot q + K q = -M \iota\, a_g - \sum_d \lambda_d f_d

q are the displacements relative to the ground, one degree of freedom per storey from the ground up, :math:`\iota` the influence
of the ground motion (ones), :math:`f_d` the force of damper d (positive against positive stroke rate) and :math:`\lambda_d` its
connection. A *place* of a damper is a storey, a number from 1 up, or a pair of floors, each by its label or its count from 1;
0 or "ground" is the ground. Storey i joins the floors i-1 and i.

Condensation leaves degrees of freedom out, their motion following the others through the springs alone (Guyan):

.. math:: q = T q_k, \qquad T_k = I, \quad T_r = -K_{rr}^{-1} K_{rk}, \qquad
          M' = T^T M T, \quad C' = T^T C T, \quad K' = T^T K T

It is exact where what is left out has neither mass nor damping, as the joints of a frame that turn without inertia. Otherwise
every frequency rises: see ``frequency_errors``, and retain more. A damper needs both of its floors among the retained ones.

The ground enters the floors that are kept with their own influence, 1, and the base shear is that of all mass,

.. math:: a_k = \ddot q_k + \iota_k a_g, \qquad V = -\iota'^T M' \ddot q_k - \iota^T M \iota\, a_g, \qquad
          \iota' = M'^{-1} T^T M \iota

which is the static part of what is left out: it moves with the ground (the missing mass). Responses take more coordinates than
the floors: see :mod:`dampyr.structures.time_history.modal_coordinates`.

Reference: R. J. Guyan, Reduction of stiffness and mass matrices, AIAA Journal 3 (1965).
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import DampyrWarning, InputError
from dampyr.shown import Shown

Array = NDArray[np.float64]
GROUND = ("0", "ground")


@dataclass(frozen=True, eq=False, repr=False)
class Building(Shown):
    """Mass ``M`` [kg], damping ``C`` [N s/m] and stiffness ``K`` [N/m], each (n, n), floors from the
    ground up.

    ``floors`` are the labels of the degrees of freedom (default 1 to n), ``influence`` (n,) how each floor
    follows a rigid motion of the ground (default ones). Checked when made: equal square shapes, symmetry, M
    positive definite, K and C positive semi-definite; an :class:`~dampyr.errors.InputError` says which is
    not.
    """

    M: Array
    C: Array
    K: Array
    name: str = "building"
    floors: Sequence[str] = ()
    influence: Array = None  # type: ignore[assignment]
    n: int = field(init=False)

    def __post_init__(self) -> None:
        for letter in "MCK":
            self._set(letter, _matrix(letter, getattr(self, letter)))
        self._set("n", len(self.M))
        sizes = {letter: len(getattr(self, letter)) for letter in "MCK"}
        if len(set(sizes.values())) > 1:
            listed = ", ".join(f"{letter} {size}x{size}" for letter, size in sizes.items())
            raise InputError(f"the matrices differ in size ({listed}); M, C and K must have one row per floor each")
        _check_definite(self)
        self._set("floors", _labels(self))
        self._set("influence", _influence(self))

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    def resolve_place(self, place: Any) -> int | tuple[int, int]:
        """A place in its one form: the storey as an int where it is one, else the pair of counts, 0 for the ground."""
        if not isinstance(place, list | tuple):
            return self._storey(place)
        if len(place) != 2:
            raise InputError(f"{place!r} names {len(place)} floors; a damper stands between 2, such as (0, 2)")
        first, second = (_floor_count(self.floors, floor, self.name) for floor in place)
        if first == second:
            raise InputError(f"{place!r} joins floor {second} to itself; a damper needs two different ends")
        return second if second and first == self.floor_below(second) else (first, second)

    def floor_below(self, storey: int) -> int:
        """The floor that a storey stands on, by count, 0 for the ground: storey i joins the floors i-1 and i."""
        return storey - 1

    @property
    def floors_below(self) -> tuple[int, ...]:
        """What each storey stands on, see `floor_below`."""
        return tuple(self.floor_below(storey) for storey in range(1, self.n_floors + 1))

    @property
    def is_stack(self) -> bool:
        """Whether each floor stands on the one before it."""
        return self.floors_below == tuple(range(self.n_floors))

    def _storey(self, storey: Any) -> int:
        if isinstance(storey, bool) or not isinstance(storey, int | np.integer) or not 1 <= storey <= self.n_floors:
            raise InputError(
                f"storey {storey!r} is not in {self.name}; storeys are whole numbers "
                f"from 1 (ground to first floor) to {self.n_floors}"
            )
        return int(storey)

    def connection(self, place: int | tuple[int | str, int | str]) -> Array:
        """The row (n,) that turns floor displacements into the stroke of a damper there.

        ``place`` is a storey, counted from 1, or two floors (i, j) by label or count, 0 or "ground" for the
        ground: the stroke is q_j - q_i, and (i-1, i) is storey i.
        """
        resolved = self.resolve_place(place)
        first, second = (self.floor_below(resolved), resolved) if isinstance(resolved, int) else resolved
        values = np.zeros(self.n + 1)
        values[first], values[second] = -1.0, 1.0
        return values[1:]

    def place_label(self, place: Any) -> str:
        """A place as a response names it: "storey 1", or the labels of its floors as in "0-2"."""
        resolved = self.resolve_place(place)
        if isinstance(resolved, int):
            return f"storey {resolved}"
        return "-".join(GROUND[0] if k == 0 else self.floors[k - 1] for k in resolved)

    @property
    def n_floors(self) -> int:
        """The number of floors, the first of the coordinates."""
        return self.n

    @property
    def carried(self) -> Array:
        """How each coordinate itself follows a rigid motion of the ground (n,); the influence, where nothing was left out."""
        return self.influence

    def ground_terms(self) -> tuple[Array, float]:
        """What the ground's acceleration adds to the absolute accelerations of M'^-1(-Kq - C dq/dt - forces) (n,), and to the
        base shear [kg]: the static part of what was left out, 0 where nothing was."""
        return np.zeros(self.n), 0.0

    def condensed(self, keep: Sequence[int | str]) -> Condensed:
        """The building on the floors ``keep`` alone, by label or count: see `condense`."""
        return condense(self.M, self.C, self.K, keep, self.name, self.floors, self.influence)

    @property
    def frequencies(self) -> Array:
        """Undamped natural frequencies (n,) [Hz], rising."""
        return np.sqrt(np.maximum(self.modes()[0], 0.0)) / (2 * np.pi)

    @property
    def damping_ratios(self) -> Array:
        r"""Modal damping ratios (n,), :math:`\phi^T C \phi / (2\omega)` for mass-normalised modes, by
        rising frequency.

        Off-diagonal modal damping, which a C that is not classical has, is left out of this figure (never
        out of a response). A mode without stiffness has none: nan.
        """
        square, modes = self.modes()
        modal = np.einsum("ij,ik,kj->j", modes, np.asarray(self.C), modes)
        free = square <= 1e-12 * square[-1]
        return np.where(free, np.nan, modal / (2 * np.sqrt(np.where(free, 1.0, square))))

    def modes(self) -> tuple[Array, Array]:
        """Squared angular frequencies (n,) [rad2/s2], rising, and mass-normalised undamped modes (n, n) as columns."""
        from scipy.linalg import eigh

        values, vectors = eigh(self.K, self.M)
        return values, vectors


def _matrix(letter: str, values: ArrayLike) -> Array:
    array = np.atleast_2d(np.array(values, dtype=float))
    if array.ndim != 2 or array.shape[0] != array.shape[1]:
        raise InputError(f"{letter} has shape {array.shape}; it must be square, one row and one column per floor")
    if not np.all(np.isfinite(array)):
        raise InputError(f"{letter} holds values that are not finite; every entry must be a number")
    uneven = float(np.max(np.abs(array - array.T)))
    if uneven > 1e-9 * float(np.max(np.abs(array))):
        raise InputError(
            f"{letter} is not symmetric: two mirrored entries differ by {uneven:g}; "
            f"make {letter}[i][j] = {letter}[j][i]"
        )
    array.flags.writeable = False
    return array


_SIGNS = (("M", "greater than", "masses"), ("K", "at least", "stiffnesses"), ("C", "at least", "dashpots"))
_MASSLESS = "; what has no mass is left out by dampyr.structures.condense(M, C, K, keep)"


def _check_definite(building: Building) -> None:
    for letter, low, word in _SIGNS:
        values = np.linalg.eigvalsh(getattr(building, letter))
        floor = 1e-12 * float(np.max(np.abs(values)))
        bad = values[0] <= floor if letter == "M" else values[0] < -floor
        if bad:
            raise InputError(
                f"{letter} has the eigenvalue {values[0]:g}; every one must be {low} "
                f"0, so check the signs and sizes of the {word}{_MASSLESS if letter == 'M' else ''}"
            )


def _labels(building: Building) -> tuple[str, ...]:
    count = building.n_floors
    labels = tuple(str(label) for label in building.floors) or tuple(str(i + 1) for i in range(count))
    if len(labels) != count or len(set(labels)) != count:
        raise InputError(f"floors = {list(labels)} does not label {count} floors; give {count} different names")
    if reserved := set(labels) & set(GROUND):
        raise InputError(f"a floor is called {reserved.pop()!r}, which means the ground; give it another name")
    return labels


def _influence(building: Building) -> Array:
    values = np.ones(building.n) if building.influence is None else np.array(building.influence, dtype=float)
    if values.shape != (building.n,) or not np.all(np.isfinite(values)):
        raise InputError(f"influence has shape {values.shape}; it must be {building.n} finite numbers, one per floor")
    values.flags.writeable = False
    return values


def _floor_count(floors: Sequence[str], name: Any, owner: str) -> int:
    """A floor by label (text) or count (a whole number), as its count; 0 is the ground."""
    if isinstance(name, str):
        if name in GROUND or name in floors:
            return 0 if name in GROUND else list(floors).index(name) + 1
    elif isinstance(name, int | np.integer) and not isinstance(name, bool) and 0 <= name <= len(floors):
        return int(name)
    raise InputError(
        f"floor {name!r} is not in {owner}; write 0 for the ground, a whole number up to {len(floors)}, "
        f"or a label: {', '.join(floors)}"
    )


@dataclass(frozen=True, eq=False)
class Whole:
    """The structure of which a building keeps some degrees of freedom: ``M``, ``C`` and ``K`` (m, m), ``influence`` (m,), and
    those that are ``retained``, counted from 0."""

    M: Array
    C: Array
    K: Array
    influence: Array
    retained: tuple[int, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Condensed(Building):
    """A building on k of m degrees of freedom, with the motion of the others.

    ``T`` (m, n) makes displacements of all from the coordinates, in the order of ``all_floors`` (m labels). ``exact`` says
    whether nothing was lost. ``frequency_errors`` (k,) are the relative rises of the natural frequencies above those of the
    whole (nan for a free mode). ``whole`` is the structure; the last ``interior`` of the n coordinates are not floors but
    shapes in which the floors stand still (see `dampyr.structures.time_history.modal_coordinates.refined`).
    """

    T: Array = field(default_factory=lambda: np.zeros((0, 0)))
    all_floors: tuple[str, ...] = ()
    exact: bool = False
    frequency_errors: Array = field(default_factory=lambda: np.zeros(0))
    whole: Whole | None = None
    interior: int = 0

    @property
    def n_floors(self) -> int:
        """The number of floors, the first of the coordinates."""
        return self.n - self.interior

    @property
    def carried(self) -> Array:
        """How each coordinate itself follows a rigid motion of the ground (n,): floors as they do in the whole structure."""
        if self.whole is None:
            return self.influence
        return np.concatenate([self.whole.influence[list(self.whole.retained)], np.zeros(self.interior)])

    def ground_terms(self) -> tuple[Array, float]:
        """See `Building.ground_terms`."""
        if self.whole is None:
            return super().ground_terms()
        mass = float(self.whole.influence @ self.whole.M @ self.whole.influence)
        pull = self.influence @ self.M
        return self.carried - self.influence, mass - float(pull @ self.carried)

    def recover(self, motion: ArrayLike) -> Array:
        """Displacements or velocities (m, T) of all degrees of freedom, from those (k, T) of a response."""
        reduced_motion = np.asarray(motion, dtype=float)
        if reduced_motion.ndim not in (1, 2) or len(reduced_motion) != self.n:
            raise InputError(
                f"a motion of shape {reduced_motion.shape} is not one of {self.n} coordinates; pass one row for each"
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

    The ground's push is kept whole: :math:`\iota' = M'^{-1} T^T M \iota`, and so is its own share of accelerations and base
    shear. Warns (:class:`~dampyr.errors.DampyrWarning`) where the result is not exact, and says by how much the frequencies
    rise.

    Parameters
    ----------
    M, C, K
        ``(m, m)`` in kg, N s/m and N/m, symmetric; M may have rows of zeros.
    keep
        The degrees of freedom that stay, by label or count from 1, in the order in which they are floors from the ground up.
    name
        What the building is called.
    floors
        ``(m,)`` labels of all degrees of freedom; by default 1 to m.
    influence
        ``(m,)``: how each of them follows a rigid motion of the ground; by default ones.

    Returns
    -------
    Condensed
        The building, which also recovers the motion of what was left out.

    Raises
    ------
    InputError
        A degree of freedom that is left out is held by no spring, or the matrices, labels or ``keep`` do not fit.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> K = 1e6 * np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    >>> M = np.diag([1e3, 0.0, 1e3])
    >>> building = dp.structures.condense(M, 0.0 * K, K, keep=[1, 3])
    >>> building.floors, building.exact
    (('1', '3'), True)
    """
    matrices = [_matrix(letter, values) for letter, values in zip("MCK", (M, C, K), strict=True)]
    m, c, k = matrices
    if len({len(matrix) for matrix in matrices}) > 1:
        raise InputError("M, C and K differ in size; they must have one row per degree of freedom each")
    labels = tuple(str(floor) for floor in floors) or tuple(str(i + 1) for i in range(len(k)))
    if len(labels) != len(k):
        raise InputError(f"floors = {list(labels)} does not label {len(k)} degrees of freedom; give {len(k)} names")
    iota = np.ones(len(k)) if influence is None else np.asarray(influence, dtype=float)
    if iota.shape != (len(k),):
        raise InputError(f"influence has shape {iota.shape}; it must be {len(k)} numbers, one per degree of freedom")
    retained = _retained_indices(keep, labels, name)
    left = [i for i in range(len(k)) if i not in retained]
    T = _recovery(k, retained, left, labels)
    building = Building(reduced(T, m), reduced(T, c), reduced(T, k), name, [labels[i] for i in retained])
    pushed = np.asarray(np.linalg.solve(building.M, T.T @ m @ iota), dtype=np.float64)
    errors = _frequency_errors(building, m, k)
    exact = not (np.any(m[left]) or np.any(c[left]))
    if not exact:
        _warn_of_error(name, bool(np.any(c[left])), errors)
    whole = Whole(m, c, k, iota, tuple(retained))
    return Condensed(building.M, building.C, building.K, name, building.floors, pushed, T, labels, exact, errors, whole)


def reduced(T: Array, matrix: Array) -> Array:
    """``T' matrix T``, symmetric."""
    small = T.T @ matrix @ T
    return np.asarray(0.5 * (small + small.T))  # rounding leaves the two halves a few digits apart


def _retained_indices(keep: Sequence[int | str], labels: tuple[str, ...], name: str) -> list[int]:
    retained = [_floor_count(labels, floor, name) - 1 for floor in keep]
    if not retained or -1 in retained or len(set(retained)) != len(retained):
        raise InputError(
            f"keep = {list(keep)} is not allowed; give different floors of {name}, the ground not among them"
        )
    return retained


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


def _frequency_errors(condensed: Building, m: Array, k: Array) -> Array:
    """How far the frequencies lie above the lowest of the whole, whose mass may be singular."""
    from scipy.linalg import eigh

    # mass and stiffness may both be singular: the shifted stiffness is not, and without mass 1/omega^2 is 0 and not infinite
    shift = 1e-3 * np.trace(k) / np.trace(m)
    inverse = eigh(m, k + shift * m, eigvals_only=True)[::-1][: condensed.n]
    square = 1.0 / inverse - shift
    square_condensed = (2 * np.pi * condensed.frequencies) ** 2
    free = square <= 1e-9 * square[-1]
    return np.where(free, np.nan, np.sqrt(np.maximum(square_condensed / np.where(free, 1.0, square), 0.0)) - 1.0)


def _warn_of_error(name: str, damped: bool, errors: Array) -> None:
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
