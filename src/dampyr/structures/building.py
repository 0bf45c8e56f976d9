r"""A building: masses, dashpots and springs that move with the ground.

.. math:: M \ddot q + C \dot q + K q = -M \iota\, a_g - \sum_d \lambda_d f_d

q are the displacements relative to the ground, one degree of freedom per storey from the ground up,
:math:`\iota` the influence of the ground motion (ones), :math:`f_d` the force of damper d (positive against
positive stroke rate) and :math:`\lambda_d` its connection: storey i joins the floors i-1 and i, floor 0 is
the ground; a damper may also join any two floors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.representation import as_html, as_text, extent, listing
from dampyr.structures.connection import GROUND, row

if TYPE_CHECKING:
    from dampyr.structures.condensation import Condensed

Array = NDArray[np.float64]


FEW = 4  # floors and modes that a short text lists one by one


@dataclass(frozen=True, eq=False, repr=False)
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

    def connection(self, place: int | tuple[int | str, int | str]) -> Array:
        """The row (n,) that turns floor displacements into the stroke of a damper there.

        ``place`` is a storey, counted from 1, or two floors (i, j) by label or count, 0 or "ground" for the
        ground: the stroke is q_j - q_i, and (i-1, i) is storey i.
        """
        return row(self, place)

    def condensed(self, keep: Sequence[int | str]) -> Condensed:
        """The building on the floors ``keep`` alone, by label or count: see
        :func:`~dampyr.structures.condensation.condense`."""
        from dampyr.structures.condensation import condense

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

    def to_dataframe(self) -> Any:
        """The modes as a ``pandas.DataFrame``: frequency, period and damping ratio, one row a mode."""
        from pandas import DataFrame

        f = self.frequencies
        with np.errstate(divide="ignore"):
            table = {"frequency_Hz": f, "period_s": 1.0 / f, "damping_ratio": self.damping_ratios}
        return DataFrame(table, index=range(1, self.n + 1)).rename_axis("mode")

    def __repr__(self) -> str:
        return as_text(*self._summary())

    def _repr_html_(self) -> str:
        return as_html(*self._summary())

    def _summary(self) -> tuple[str, list[tuple[str, str]]]:
        few = self.n <= FEW
        modes = ", ".join(
            f"{f:.4g} Hz ({100 * z:.3g} %)" for f, z in list(zip(self.frequencies, self.damping_ratios))[:FEW]
        )
        rows = [
            ("floors", f"{self.n}: {listing([str(f) for f in self.floors])}"),
            (
                "masses",
                ", ".join(f"{m:.4g}" for m in np.diag(self.M)) + " kg" if few else extent(np.diag(self.M), "kg"),
            ),
            ("modes", modes + ("" if few else f" and {self.n - FEW} more")),
        ]
        return f"{type(self).__name__} {self.name!r}", rows

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


def _check_sizes(building: Building) -> None:
    sizes = {letter: len(getattr(building, letter)) for letter in "MCK"}
    if len(set(sizes.values())) > 1:
        sizes_text = ", ".join(f"{letter} {size}x{size}" for letter, size in sizes.items())
        raise InputError(f"the matrices differ in size ({sizes_text}); M, C and K must have one row per floor each")


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
    labels = tuple(str(label) for label in building.floors) or tuple(str(i + 1) for i in range(building.n))
    if len(labels) != building.n or len(set(labels)) != building.n:
        raise InputError(
            f"floors = {list(labels)} does not label {building.n} floors; give {building.n} different names"
        )
    if reserved := set(labels) & set(GROUND):
        raise InputError(f"a floor is called {reserved.pop()!r}, which means the ground; give it another name")
    return labels


def _influence(building: Building) -> Array:
    values = np.ones(building.n) if building.influence is None else np.array(building.influence, dtype=float)
    if values.shape != (building.n,) or not np.all(np.isfinite(values)):
        raise InputError(f"influence has shape {values.shape}; it must be {building.n} finite numbers, one per floor")
    values.flags.writeable = False
    return values
