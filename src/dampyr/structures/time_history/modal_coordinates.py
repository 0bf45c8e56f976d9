r"""A large linear structure on the displacements of a few floors, by its modes.

.. math:: q = B \eta, \quad B = (\phi_1 \dots \phi_k, s_1 \dots s_m), \qquad q = T q_f, \quad T = B B_f^{-1}

:math:`\phi` are the modes with the largest effective mass under a motion of the ground, and :math:`s` the static answers of
what they leave out: :math:`s_1 = K^{-1} M \iota`, :math:`s_{i+1} = K^{-1} M s_i`, made orthogonal to the modes. There are as
many of both together as floors, so that the floors' displacements are the coordinates, and M, C and K of a building:

.. math:: M' = T^T M T, \quad C' = T^T C T, \quad K' = T^T K T, \quad \iota' = M'^{-1} T^T M \iota

Modes are kept exactly, unlike by Guyan's condensation. What is left out is stated: the share of the mass that the modes carry,
and the error of the static answer to the ground's push; `truncation_errors` of a motion compares with all modes.

A damper's force excites other shapes than the ground does. When dampers are known, such a building, and one by Guyan, takes
more coordinates, shapes in which the floors stand still (`refined`):

.. math:: q = T q_f + \Psi p, \qquad \psi_d = K^{-1} \lambda_d - T (K^{-1} \lambda_d)_f

one static answer for each damper, and as many modes of the structure with its floors held as there are coordinates by then,
20 at least, those with the largest effective mass under motions of the floors. A structure of few degrees of freedom is whole
then. Of a larger one the response says how far its peaks lie from those with half as many coordinates (`Truncation`).

References: O'Callahan et al., System equivalent reduction expansion process, IMAC 1989; Wilson et al., Dynamic analysis by
direct superposition of Ritz vectors, Earthquake Engineering and Structural Dynamics 10 (1982); R. R. Craig, M. C. C. Bampton,
Coupling of substructures for dynamic analyses, AIAA Journal 6 (1968).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, resampled
from dampyr.structures.building import Building, Condensed, Whole, reduced
from dampyr.structures.time_history.response import Truncation, relative_change

Array = NDArray[np.float64]

MORE = 20  # modes with the floors held that a response adds at least, where a structure has so many
FINE = 0.005  # s, between the points at which peaks of all modes are taken at most
STATIC, FLOORS_EACH = 2, 5  # static vectors at most, and one for each so many floors
INDEPENDENT = 1e-8  # of the squares of unit vectors: what a new shape must have of its own


@dataclass(frozen=True, eq=False, repr=False)
class ModalBuilding(Condensed):
    """A building on k of m degrees of freedom, by modes.

    As :class:`~dampyr.structures.building.Condensed`, and ``retained_modes``, counted from 1 by rising frequency of the whole;
    ``mass_share``, of the mass that follows the ground, that these modes carry; ``static_error`` (k,), relative, of the
    floors' static answer to the ground's push by the modes alone; the static vectors take that one away. ``shapes``,
    ``squares`` and ``pushes`` are those of all modes: (k, m) at the floors, (m,) squared angular frequencies [rad2/s2], (m,)
    participation; ``ratios`` (m,) of critical damping.
    """

    retained_modes: tuple[int, ...] = ()
    mass_share: float = 1.0
    static_error: Array = field(default_factory=lambda: np.zeros(0))
    shapes: Array = field(default_factory=lambda: np.zeros((0, 0)))
    squares: Array = field(default_factory=lambda: np.zeros(0))
    pushes: Array = field(default_factory=lambda: np.zeros(0))
    ratios: Array = field(default_factory=lambda: np.zeros(0))

    def truncation_errors(self, motion: GroundMotion) -> Truncation:
        """The largest relative errors of the floors' peak displacements and accelerations, of the storeys' peak drifts and of
        the peak base shear under ``motion``.

        Without dampers: this building against all modes of the structure, at the samples of the motion, or every 5 ms. Damping
        is that of the modes' diagonal.
        """
        squares, modes = self.modes()
        pushes = modes.T @ (self.M @ self.influence)
        direct, missing = self.ground_terms()
        motion = resampled(motion, motion.dt / math.ceil(motion.dt / FINE), "linear")
        n, a = self.n_floors, motion.acceleration
        x, acceleration, shear = modal_response(modes[:n], squares, self.damping_ratios, pushes, motion)
        missing += float(self.influence @ self.M @ direct)  # beside the modes' accelerations, not the floors'
        reduced_peaks = _peaks_of(x, acceleration + np.outer(direct[:n], a), shear + missing * a)
        whole_peaks = _peaks_of(*modal_response(self.shapes, self.squares, self.ratios, self.pushes, motion))
        return Truncation(
            self.n, len(self.squares), "all modes, without dampers", *map(relative_change, reduced_peaks, whole_peaks)
        )


def _peaks_of(x: Array, acceleration: Array, shear: Array) -> list[Array]:
    drifts = np.diff(x, axis=0, prepend=0.0)
    return [np.max(np.abs(history), axis=-1) for history in (x, drifts, acceleration, shear)]


def refined(building: Building, places: Sequence[Any] = ()) -> Building:
    """``building`` as responses take it where dampers stand at ``places``: with more coordinates than floors where it was
    reduced, and the same building where nothing is left out.

    A place is a storey or two floors, as in `respond`. The first coordinates are the floors; the others are shapes in which
    the floors stand still.
    """
    return refinements(building, np.array([building.connection(place) for place in places]).reshape(-1, building.n))[0]


def refinements(building: Building, rows: Array) -> tuple[Building, Building | None]:
    """`refined` for dampers with the connections ``rows`` (N, floors), and the same with half as many coordinates, by which it
    is judged: None where nothing is left out. ``building`` itself where it is not a reduced one."""
    if not isinstance(building, Condensed) or building.exact or building.whole is None or building.interior:
        return building, None
    return _refinements(building, tuple(map(tuple, rows.tolist())))


@lru_cache(maxsize=64)
def _refinements(building: Condensed, rows: tuple[tuple[float, ...], ...]) -> tuple[Building, Building | None]:
    assert building.whole is not None
    whole = building.whole
    statics = _static_answers(building, whole, rows)
    held, damped = _modes_with_floors_held(whole)
    first = building.n + statics.shape[1]
    count = max(first, MORE)
    complete = held.shape[1] <= count
    shapes = held if complete else np.hstack([statics, held[:, :count]])
    fine = replace(_with_interior(building, shapes), exact=complete and not damped)
    if complete or damped:  # where dashpots stand on what has no mass, half as many coordinates do not judge it
        return fine, None
    half = (first + count + 1) // 2 - first
    return fine, _with_interior(building, np.hstack([statics, held[:, :half]]))


def _static_answers(building: Condensed, whole: Whole, rows: tuple[tuple[float, ...], ...]) -> Array:
    """The static answers (m, r) to forces of dampers, less what the floors have of them; those of Guyan have all."""
    if not isinstance(building, ModalBuilding):
        return np.zeros((len(whole.K), 0))
    retained = list(whole.retained)
    forces = np.zeros((len(whole.K), len(rows)))
    forces[retained] = np.reshape(rows, (len(rows), len(retained))).T
    answers = np.linalg.solve(whole.K, forces)
    rest = answers - building.T @ answers[retained]
    independent = np.sum(rest * (whole.M @ rest), axis=0) > 1e-12 * np.sum(answers * (whole.M @ answers), axis=0)
    return np.asarray(rest[:, independent])


def _modes_with_floors_held(whole: Whole) -> tuple[Array, bool]:
    """The modes (m, modes) of the structure with its floors held, first those that carry most mass under motions of the floors;
    and whether dashpots act on what has no mass, which has no mode."""
    from scipy.linalg import eigh

    retained = list(whole.retained)
    left = [i for i in range(len(whole.K)) if i not in whole.retained]
    inner = whole.M[np.ix_(left, left)]
    flexibility, shapes = eigh(inner, whole.K[np.ix_(left, left)])  # 1/omega2, which is 0 without mass
    massive = flexibility > 1e-12 * flexibility[-1]
    damped = bool(
        np.any(np.abs(whole.C[left][:, left] @ shapes[:, ~massive]) > 1e-12 * np.max(np.abs(whole.C), initial=0.0))
    )
    flexibility, shapes = flexibility[massive], shapes[:, massive]
    following = -np.linalg.solve(whole.K[np.ix_(left, left)], whole.K[np.ix_(left, retained)])
    driven = shapes.T @ (inner @ following + whole.M[np.ix_(left, retained)])
    order = np.argsort(-np.sum(driven**2, axis=1) / flexibility, kind="stable")
    modes = np.zeros((len(whole.K), len(order)))
    modes[left] = shapes[:, order]
    return modes, damped


def _with_interior(building: Condensed, shapes: Array) -> Condensed:
    """``building`` with the independent of ``shapes`` (m, r), in which its floors stand still, as further coordinates."""
    whole = building.whole
    assert whole is not None
    if not shapes.shape[1]:
        return building
    shapes = shapes / np.sqrt(np.sum(shapes * (whole.M @ shapes), axis=0))
    squares, turn = np.linalg.eigh(reduced(shapes, whole.M))
    independent = squares > INDEPENDENT
    floor = np.trace(building.M) / building.n  # so that coordinates weigh as floors do
    interior = np.sqrt(floor) * (shapes @ (turn[:, independent] / np.sqrt(squares[independent])))
    interior[list(whole.retained)] = 0.0
    T = np.hstack([building.T, interior])
    M, C, K = (reduced(T, matrix) for matrix in (whole.M, whole.C, whole.K))
    influence = np.asarray(np.linalg.solve(M, T.T @ (whole.M @ whole.influence)), dtype=np.float64)
    return replace(building, M=M, C=C, K=K, influence=influence, T=T, interior=interior.shape[1])


def modal_response(
    shapes: Array, squares: Array, ratios: Array, pushes: Array, motion: GroundMotion
) -> tuple[Array, Array, Array]:
    r"""Displacements and absolute accelerations (floors, samples) and base shear (samples,) from modes,
    :math:`\ddot\eta + 2\zeta\omega\dot\eta + \omega^2\eta = -\Gamma a_g`.

    ``shapes`` (floors, modes), ``squares`` (modes,) [rad2/s2], ``ratios`` and ``pushes`` (modes,). Exact for a ground
    acceleration that is linear between its samples. Each mode's acceleration is :math:`\ddot\eta + \Gamma a_g`: that of the
    floors is whole where all modes are given.
    """
    from scipy.linalg import expm
    from scipy.signal import lfilter

    a, dt = motion.acceleration, motion.dt
    x, acceleration, shear = np.zeros((len(shapes), motion.n)), np.zeros((len(shapes), motion.n)), np.zeros(motion.n)
    for k in range(len(squares)):
        system = np.zeros((4, 4))
        system[0, 1] = system[2, 3] = 1.0
        system[1, :3] = -squares[k], -2.0 * ratios[k] * np.sqrt(squares[k]), -pushes[k]
        system[:2] *= dt
        step = expm(system)
        now, after = step[:2, 2] - step[:2, 3], step[:2, 3]
        # displacement and velocity each obey a recurrence of second order (Cayley and Hamilton): the state's, less the other
        adjugate = np.array([[step[1, 1], -step[0, 1]], [-step[1, 0], step[0, 0]]])
        poles = [1.0, -(step[0, 0] + step[1, 1]), step[0, 0] * step[1, 1] - step[0, 1] * step[1, 0]]
        drive = np.zeros((2, motion.n))
        drive[:, 1:] = np.outer(now, a[:-1]) + np.outer(after, a[1:])
        drive[:, 2:] -= np.outer(adjugate @ now, a[:-2]) + np.outer(adjugate @ after, a[1:-1])
        eta, rate = lfilter([1.0], poles, drive)
        restoring = -2.0 * ratios[k] * np.sqrt(squares[k]) * rate - squares[k] * eta
        x += np.outer(shapes[:, k], eta)
        acceleration += np.outer(shapes[:, k], restoring)
        shear += pushes[k] * restoring
    return x, acceleration, shear


def modal_condensation(
    M: Array,
    C: Array,
    K: Array,
    keep: Sequence[int],
    name: str = "structure",
    labels: Sequence[str] = (),
    influence: Array | None = None,
    floors: Sequence[str] = (),
) -> ModalBuilding:
    """A structure on some of its degrees of freedom, by modes and static vectors.

    Parameters
    ----------
    M, C, K
        ``(m, m)`` in kg, N s/m and N/m, M positive definite.
    keep
        The k degrees of freedom that are floors, counted from 0.
    name, labels
        What the structure and its m degrees of freedom are called; by default 1 to m.
    influence
        ``(m,)``: how each follows a rigid motion of the ground; by default ones.
    floors
        ``(k,)`` labels of the floors; by default those of their degrees of freedom.

    Raises
    ------
    InputError
        The structure can move without a spring, or the floors do not tell the modes apart.
    """
    from scipy.linalg import eigh

    m, k = len(M), len(keep)
    iota = np.ones(m) if influence is None else np.asarray(influence, dtype=float)
    names = tuple(labels) or tuple(str(i + 1) for i in range(m))
    squares, phi = eigh(K, M)
    if squares[0] <= 1e-14 * squares[-1]:
        raise InputError("the structure can move without a spring; hold every degree of freedom")
    push = M @ iota
    pushes = phi.T @ push
    static = min(STATIC, k // FLOORS_EACH)
    chosen: NDArray[np.int64] = np.sort(np.argsort(-(pushes**2), kind="stable")[: k - static])
    B, force = phi[:, chosen], push
    for _ in range(static):
        s = np.linalg.solve(K, force)
        for _ in range(2):  # Gram and Schmidt, once more against what rounding left
            s = s - B @ (B.T @ (M @ s))
        s /= np.sqrt(s @ M @ s)
        B, force = np.column_stack([B, s]), M @ s
    at = B[list(keep)]
    if np.linalg.cond(at) > 1e6:
        raise InputError(
            f"the floors {', '.join(names[i] for i in keep)} do not tell {k} modes of the structure apart; "
            "keep others, one for each storey"
        )
    T = B @ np.linalg.inv(at)
    small = [reduced(T, matrix) for matrix in (M, C, K)]
    whole = phi[list(keep)] @ (pushes / squares)
    by_modes = phi[list(keep)][:, chosen] @ (pushes[chosen] / squares[chosen])
    ratios = np.einsum("ij,ij->j", phi, C @ phi) / (2.0 * np.sqrt(squares))
    building = Building(small[0], small[1], small[2], name)
    frequencies = building.frequencies
    nearest = np.sqrt(squares) / (2 * np.pi)
    errors = np.array([f / nearest[np.argmin(np.abs(nearest - f))] - 1.0 for f in frequencies])
    return ModalBuilding(
        building.M,
        building.C,
        building.K,
        name,
        tuple(floors) or tuple(names[i] for i in keep),
        np.linalg.solve(building.M, T.T @ push),
        T,
        names,
        k == m,
        errors,
        Whole(np.array(M), np.array(C), np.array(K), iota, tuple(keep)),
        retained_modes=tuple(int(i) + 1 for i in chosen),
        mass_share=float(np.sum(pushes[chosen] ** 2) / np.sum(pushes**2)),
        static_error=np.abs(by_modes - whole) / np.max(np.abs(whole)),
        shapes=phi[list(keep)],
        squares=squares,
        pushes=pushes,
        ratios=ratios,
    )
