r"""A structure whose supports move differently: the axles of a car over one road, the piers of a bridge.

With the displacements :math:`y_s` of the supports and :math:`R = -K_{ff}^{-1} K_{fs}`, how the floors follow them through the
springs alone (the pseudo-static influence), the displacements relative to that, :math:`q = x - R y`, obey

.. math:: M \ddot q + C \dot q + K q = -M R\, \ddot y - \sum_d \lambda_d f_d, \qquad a = \ddot q + R \ddot y

Dashpots act on :math:`\dot q`, which is exact where slow motions of the supports do not stretch them, as in a car whose body is
carried by as many springs as it needs; dampers act on the stroke of q likewise, and one that R stretches is refused.

Reference: A. K. Chopra, Dynamics of Structures (2017), section 9.7.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, followed_by_rest
from dampyr.shown import Shown
from dampyr.structures.building import GROUND, Building

Array = NDArray[np.float64]
STRETCHED = 1e-9  # relative: more of a stroke than rounding leaves


@dataclass(frozen=True, eq=False, repr=False)
class SupportedBuilding(Building):
    """A structure on several supports, as `with_supports` and `half_car` make it.

    ``supports`` are their names and ``support_influence`` (n, supports) is R. ``below`` (n,) says which floor each storey
    stands on, by count, 0 for a support: storey i joins the floors below[i - 1] and i. ``influence`` is the sum of R over the
    supports.
    """

    supports: tuple[str, ...] = ()
    support_influence: Array = field(default_factory=lambda: np.zeros((0, 0)))
    below: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        R = np.array(self.support_influence, dtype=float)
        names = tuple(map(str, self.supports))
        if len(set(names)) != len(names) or not names or set(names) & set(GROUND):
            raise InputError(
                f"supports = {list(names)} is not allowed; give different names, not {' or '.join(GROUND)}"
            )
        if R.ndim != 2 or R.shape[1] != len(names) or not np.all(np.isfinite(R)):
            raise InputError(
                f"support_influence has shape {R.shape}; it must be finite numbers, a row for each floor and a column for each "
                f"of {len(names)} supports"
            )
        R.flags.writeable = False
        self._set("support_influence", R)
        self._set("supports", names)
        self._set("influence", R.sum(axis=1))
        super().__post_init__()
        if not self.below:
            self._set("below", tuple(range(self.n)))
        if len(self.below) != self.n or any(not 0 <= floor <= k for k, floor in enumerate(self.below)):
            raise InputError(
                f"below = {list(self.below)} is not allowed; give a lower floor for each of {self.n}, or 0"
            )

    def floor_below(self, storey: int) -> int:
        """See `Building.floor_below`."""
        return self.below[storey - 1]

    def check_stroke(self, place: Any) -> None:
        """InputError where slow motions of the supports would stretch a damper at a place, which responses leave out."""
        row, resolved = self.connection(place), self.resolve_place(place)
        on_support = 0 in resolved if isinstance(resolved, tuple) else not self.floor_below(resolved)
        share = row @ self.support_influence
        # on a support it stands on the one that its floor follows, if it follows a single one
        if np.any(np.abs(share - np.round(share) if on_support else share) > STRETCHED):
            raise InputError(
                f"a damper at {self.place_label(place)} of {self.name} is stretched by slow motions of the supports, which "
                "responses leave out; it may join floors that follow the supports alike, or a support and a floor that only "
                "this one carries"
            )

    def condensed(self, keep: Sequence[int | str]) -> Any:
        """Refused: what is left out would follow the supports, too."""
        raise InputError(
            f"{self.name} has several supports and cannot be condensed to {list(keep)}; condense its matrices first"
        )


@dataclass(frozen=True, eq=False, repr=False)
class SupportMotions(Shown):
    """How supports move: support -> the `GroundMotion` of each, of one step and one length; for `respond`.

    >>> import dampyr as dp
    >>> quake = dp.ground_motions.el_centro()
    >>> later = dp.ground_motions.padded(quake, 0.0, before=0.2)
    >>> both = dp.structures.SupportMotions({"west": dp.ground_motions.padded(quake, 0.2), "east": later})
    >>> both.dt, both.n
    (0.02, 1570)
    """

    motions: Mapping[str, GroundMotion]
    name: str = "support motions"

    def __post_init__(self) -> None:
        if not isinstance(self.motions, Mapping) or not self.motions:
            raise InputError("motions must be a mapping from support to its GroundMotion, with a support at least")
        for support, motion in self.motions.items():
            if not isinstance(motion, GroundMotion):
                raise InputError(f"the motion of {support} is a {type(motion).__name__}; give a GroundMotion")
        first, *others = self.motions.values()
        for motion in others:
            if motion.n != first.n or abs(motion.dt - first.dt) > 1e-9 * first.dt:
                raise InputError(
                    f"the supports move for {first.n} samples of {first.dt:g} s and {motion.n} of {motion.dt:g} s; resample "
                    "and pad the motions to one step and one length"
                )
        object.__setattr__(self, "motions", {str(support): motion for support, motion in self.motions.items()})

    @property
    def dt(self) -> float:
        """The step of all motions [s]."""
        return next(iter(self.motions.values())).dt

    @property
    def n(self) -> int:
        """The number of samples of each."""
        return next(iter(self.motions.values())).n

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return next(iter(self.motions.values())).duration

    def followed_by_rest(self, after: float) -> SupportMotions:
        """The motions with ``after`` seconds of rest; the same object for 0."""
        if after == 0:
            return self
        return SupportMotions(
            {name: followed_by_rest(motion, after) for name, motion in self.motions.items()}, self.name
        )

    def of(self, building: SupportedBuilding) -> list[GroundMotion]:
        """The motions in the order of the supports of a structure; InputError where one is missing or strange."""
        if set(self.motions) != set(building.supports):
            raise InputError(
                f"motions are given for {', '.join(self.motions)}; {building.name} stands on {', '.join(building.supports)}: "
                "give one for each"
            )
        return [self.motions[name] for name in building.supports]


def with_supports(
    M: ArrayLike,
    C: ArrayLike,
    K: ArrayLike,
    supports: Sequence[str],
    floors: Sequence[str] = (),
    name: str = "structure",
) -> SupportedBuilding:
    """A structure on several supports from its matrices, of which the last degrees of freedom are the supports.

    Parameters
    ----------
    M, C
        ``(n, n)`` or ``(n + s, n + s)`` in kg and N s/m; of the latter the rows of the supports count for nothing in M, and
        slow motions of the supports may not stretch the dashpots in C: see above.
    K
        ``(n + s, n + s)`` in N/m: the n floors first, then the s supports, whose columns say how they push.
    supports
        Their s names.
    floors
        The n labels of the floors; by default 1 to n.
    name
        What the structure is called.

    Raises
    ------
    InputError
        The matrices do not fit, the floors are held by no spring, or a dashpot is stretched by slow motions of the supports.

    Examples
    --------
    >>> import dampyr as dp
    >>> K = [[3e6, -1e6, -2e6, 0.0], [-1e6, 3e6, 0.0, -2e6], [-2e6, 0.0, 2e6, 0.0], [0.0, -2e6, 0.0, 2e6]]
    >>> bridge = dp.structures.with_supports([[1e4, 0], [0, 1e4]], [[2e3, 0], [0, 2e3]], K, ("west", "east"))
    >>> bridge.support_influence
    array([[0.75, 0.25],
           [0.25, 0.75]])
    """
    k, count = np.asarray(K, dtype=float), len(supports)
    n = len(k) - count
    if k.ndim != 2 or k.shape[0] != k.shape[1] or n < 1:
        raise InputError(f"K has shape {k.shape}; it must be square, the floors and then {count} supports")
    matrices = {}
    for letter, values in (("M", M), ("C", C)):
        matrix = np.asarray(values, dtype=float)
        if matrix.shape not in ((n, n), (n + count, n + count)):
            raise InputError(
                f"{letter} has shape {matrix.shape}; it must be {n} x {n}, or {n + count} x {n + count} as K is"
            )
        matrices[letter] = matrix
    values, inner = np.linalg.eigvalsh(0.5 * (k[:n, :n] + k[:n, :n].T)), k[:n, :n]
    if values[0] <= 1e-12 * np.max(np.abs(k)):
        raise InputError(
            f"the floors are not held by springs: their stiffness has the eigenvalue {values[0]:g}, which must be above 0"
        )
    R = -np.linalg.solve(inner, k[:n, n:])
    c = matrices["C"]
    if len(c) > n:
        pushed = c[:n, :n] @ R + c[:n, n:]
        if np.max(np.abs(pushed)) > 1e-9 * max(np.max(np.abs(c)), 1e-300):
            raise InputError(
                f"slow motions of the supports stretch dashpots (C R + C_s is up to {np.max(np.abs(pushed)):.3g} N s/m), which "
                f"responses leave out; give C of the {n} floors alone, which acts on their motion relative to the "
                "springs' own"
            )
    building = Building(matrices["M"][:n, :n], c[:n, :n], inner, name, floors)
    return SupportedBuilding(
        building.M, building.C, building.K, name, building.floors, supports=tuple(supports), support_influence=R
    )


def refuse_supports(call: str, *buildings: Any) -> None:
    """:class:`~dampyr.errors.InputError` where a call that knows one ground is given a structure on several supports."""
    for building in buildings:
        if isinstance(building, SupportedBuilding):
            raise InputError(
                f"{building.name} stands on several supports ({', '.join(building.supports)}), and {call} takes structures on "
                "one ground alone; take respond, one case after another"
            )
