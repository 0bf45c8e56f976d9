r"""A building: masses, dashpots and springs that move with the ground.

.. math:: M \ddot q + C \dot q + K q = -M \iota\, a_g - \sum_d \lambda_d f_d

q are the displacements relative to the ground, one degree of freedom per storey from the ground up,
:math:`\iota` the influence of the ground motion (ones), :math:`f_d` the force of damper d (positive against
positive stroke rate) and :math:`\lambda_d` its connection: storey i joins the floors i-1 and i, floor 0 is
the ground.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Building:
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
        _check_sizes(self)
        _check_definite(self)
        self._set("floors", _labels(self))
        self._set("influence", _influence(self))

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    def connection(self, storey: int) -> Array:
        """The row (n,) that turns floor displacements into the drift of ``storey``, counted from 1."""
        if isinstance(storey, bool) or not isinstance(storey, int | np.integer) or not 1 <= storey <= self.n:
            raise InputError(
                f"storey {storey!r} is not in {self.name}; storeys are whole numbers "
                f"from 1 (ground to first floor) to {self.n}"
            )
        row = np.zeros(self.n)
        row[storey - 1] = 1.0
        if storey > 1:
            row[storey - 2] = -1.0
        return row

    @property
    def frequencies(self) -> Array:
        """Undamped natural frequencies (n,) [Hz], rising."""
        return np.sqrt(np.maximum(self._modes()[0], 0.0)) / (2 * np.pi)

    @property
    def damping_ratios(self) -> Array:
        r"""Modal damping ratios (n,), :math:`\phi^T C \phi / (2\omega)` for mass-normalised modes, by
        rising frequency.

        Off-diagonal modal damping, which a C that is not classical has, is left out of this figure (never
        out of a response). A mode without stiffness has none: nan.
        """
        square, modes = self._modes()
        modal = np.einsum("ij,ik,kj->j", modes, np.asarray(self.C), modes)
        free = square <= 1e-12 * square[-1]
        return np.where(free, np.nan, modal / (2 * np.sqrt(np.where(free, 1.0, square))))

    def _modes(self) -> tuple[Array, Array]:
        from scipy.linalg import eigh

        values, vectors = eigh(self.K, self.M)
        return values, vectors


def two_storey() -> Building:
    """The two-storey building (5.2), in SI: 145.8 kg floors, 2.0856 and 5.4603 Hz, 3.0 % damping in
    both modes.

    The dissertation prints N s2/mm, N/mm and N s/mm; one of each is 1000 of the SI unit. Source: Raminelli
    2020, eq. (5.2), after Aguirre et al. 2010.
    """
    per_mm = 1000.0
    return Building(
        M=np.array([[0.1458, 0.0], [0.0, 0.1458]]) * per_mm,
        C=np.array([[0.2489, -0.0830], [-0.0830, 0.1659]]) * per_mm,
        K=np.array([[131.1, -65.55], [-65.55, 65.55]]) * per_mm,
        name="two-storey building (5.2)",
    )


def shear_building(
    masses: ArrayLike,
    stiffnesses: ArrayLike,
    damping_ratio: float | None = None,
    dashpots: ArrayLike | None = None,
    method: str = "rayleigh",
    name: str = "shear building",
) -> Building:
    r"""A building with a mass per floor and a spring per storey, from the ground up.

    Parameters
    ----------
    masses, stiffnesses : (n,) [kg], [N/m]
    damping_ratio : of the first two modes (``method="rayleigh"``, :math:`C = \alpha M + \beta K`) or of
        every mode (``method="modal"``)
    dashpots : (n,) [N s/m], one per storey, instead of a ratio. Give one of the two.
    """
    mass, spring = _positive("masses", masses), _positive("stiffnesses", stiffnesses)
    if len(mass) != len(spring):
        raise InputError(f"{len(mass)} masses and {len(spring)} stiffnesses do not match; give one of each per storey")
    if (damping_ratio is None) == (dashpots is None):
        raise InputError("a shear building takes either damping_ratio= or dashpots=; give one of the two")
    M, K = np.diag(mass), _storeys(spring)
    if dashpots is not None:
        each = np.asarray(dashpots, dtype=float)
        if each.shape != mass.shape or not np.all(np.isfinite(each)) or each.min() < 0:
            raise InputError(
                f"dashpots = {each.tolist()} must be {len(mass)} finite numbers of at least 0 N s/m, one per storey"
            )
        return Building(M, _storeys(each), K, name)
    return Building(M, _damping(M, K, float(damping_ratio), method), K, name)  # type: ignore[arg-type]


def _storeys(values: Array) -> Array:
    """The matrix of one element per storey: its drift times its value, at both of its floors."""
    n = len(values)
    drift = np.eye(n) - np.eye(n, k=-1)
    return drift.T @ np.diag(values) @ drift


def _damping(M: Array, K: Array, ratio: float, method: str) -> Array:
    from scipy.linalg import eigh

    if not 0 <= ratio < 1:
        raise InputError(f"damping_ratio = {ratio:g} is not allowed; it must be at least 0 and below 1 (0.03 is 3 %)")
    if method not in ("rayleigh", "modal"):
        raise InputError(f"damping method {method!r} is not known; choose 'rayleigh' or 'modal'")
    square, modes = eigh(K, M)
    omega = np.sqrt(square)
    if method == "modal":
        shapes = M @ modes
        return shapes @ np.diag(2 * ratio * omega) @ shapes.T
    first, second = omega[0], omega[min(1, len(omega) - 1)]
    return 2 * ratio * (first * second * M + K) / (first + second)


def _positive(name: str, values: ArrayLike) -> Array:
    array = np.atleast_1d(np.asarray(values, dtype=float))
    if array.ndim != 1 or not len(array) or not np.all(np.isfinite(array)) or array.min() <= 0:
        raise InputError(f"{name} = {array.tolist()} must be a list of finite numbers greater than 0, one per storey")
    return array


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


def _check_sizes(building: Building) -> None:
    sizes = {letter: len(getattr(building, letter)) for letter in "MCK"}
    if len(set(sizes.values())) > 1:
        found = ", ".join(f"{letter} {size}x{size}" for letter, size in sizes.items())
        raise InputError(f"the matrices differ in size ({found}); M, C and K must have one row per floor each")


_SIGNS = (("M", "greater than", "masses"), ("K", "at least", "stiffnesses"), ("C", "at least", "dashpots"))


def _check_definite(building: Building) -> None:
    for letter, low, word in _SIGNS:
        values = np.linalg.eigvalsh(getattr(building, letter))
        floor = 1e-12 * float(np.max(np.abs(values)))
        bad = values[0] <= floor if letter == "M" else values[0] < -floor
        if bad:
            raise InputError(
                f"{letter} has the eigenvalue {values[0]:g}; every one must be {low} "
                f"0, so check the signs and sizes of the {word}"
            )


def _labels(building: Building) -> tuple[str, ...]:
    labels = tuple(str(label) for label in building.floors) or tuple(str(i + 1) for i in range(building.n))
    if len(labels) != building.n or len(set(labels)) != building.n:
        raise InputError(
            f"floors = {list(labels)} does not label {building.n} floors; give {building.n} different names"
        )
    return labels


def _influence(building: Building) -> Array:
    values = np.ones(building.n) if building.influence is None else np.array(building.influence, dtype=float)
    if values.shape != (building.n,) or not np.all(np.isfinite(values)):
        raise InputError(f"influence has shape {values.shape}; it must be {building.n} finite numbers, one per floor")
    values.flags.writeable = False
    return values
