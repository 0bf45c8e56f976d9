r"""A large linear structure on the displacements of a few floors, by its modes.

.. math:: q = B \eta, \quad B = (\phi_1 \dots \phi_k, s_1 \dots s_m), \qquad q = T q_f, \quad T = B B_f^{-1}

:math:`\phi` are the modes with the largest effective mass under a motion of the ground, and :math:`s` the static answers of
what they leave out: :math:`s_1 = K^{-1} M \iota`, :math:`s_{i+1} = K^{-1} M s_i`, made orthogonal to the modes. There are as
many of both together as floors, so that the floors' displacements are the coordinates, and M, C and K of a building:

.. math:: M' = T^T M T, \quad C' = T^T C T, \quad K' = T^T K T, \quad \iota' = M'^{-1} T^T M \iota

Modes are kept exactly, unlike by Guyan's condensation. What is left out is stated: the share of the mass that the modes carry,
and the error of the static answer to the ground's push; `truncation_errors` of a motion compares with all modes.

References: O'Callahan et al., System equivalent reduction expansion process, IMAC 1989; Wilson et al., Dynamic analysis by
direct superposition of Ritz vectors, Earthquake Engineering and Structural Dynamics 10 (1982).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.representation import Summary
from dampyr.structures.building import Building, Condensed

Array = NDArray[np.float64]

STATIC, FLOORS_EACH = 2, 5  # static vectors at most, and one for each so many floors


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

    def _summary(self) -> Summary:
        title, rows = super()._summary()
        text = f"{len(self.retained_modes)} of {len(self.squares)}, with {100 * self.mass_share:.4g} % of the mass"
        return title, [*rows, ("modes kept", text)]

    def truncation_errors(self, motion: GroundMotion) -> tuple[float, float]:
        """The largest relative errors of the floors' peak displacements and of the storeys' peak drifts under ``motion``.

        Without dampers: this building against all modes of the structure, at the samples of the motion. Damping is that of the
        modes' diagonal.
        """
        mine = modal_displacement(*_own_modes(self), motion)
        whole = modal_displacement(self.shapes, self.squares, self.ratios, self.pushes, motion)
        drift = np.eye(self.n) - np.eye(self.n, k=-1)
        pairs = [[np.max(np.abs(each @ x), axis=1) for x in (mine, whole)] for each in (np.eye(self.n), drift)]
        displacement, drifts = (float(np.max(np.abs(own - all_) / np.maximum(all_, 1e-300))) for own, all_ in pairs)
        return displacement, drifts


def truncation(building: Building, motion: GroundMotion) -> tuple[str, tuple[float, float] | None]:
    """The `ModalBuilding.truncation_errors` of a building in modal coordinates, as a sentence and as numbers; "" and None for
    any other."""
    if not isinstance(building, ModalBuilding):
        return "", None
    displacement, drift = errors = building.truncation_errors(motion)
    words = (
        "modal coordinates: "
        f"{len(building.retained_modes)} of {len(building.squares)} modes and what the others answer at rest; "
        f"without a damper, floor displacements are {100 * displacement:.2g} % and drifts {100 * drift:.2g} % off at most"
    )
    return words, errors


def modal_displacement(shapes: Array, squares: Array, ratios: Array, pushes: Array, motion: GroundMotion) -> Array:
    r"""Displacements (floors, samples) from modes, :math:`\ddot\eta + 2\zeta\omega\dot\eta + \omega^2\eta = -\Gamma a_g`.

    ``shapes`` (floors, modes), ``squares`` (modes,) [rad2/s2], ``ratios`` and ``pushes`` (modes,). Exact for a ground
    acceleration that is linear between its samples.
    """
    from scipy.linalg import expm
    from scipy.signal import lfilter

    a, dt = motion.acceleration, motion.dt
    x = np.zeros((len(shapes), motion.n))
    for k in range(len(squares)):
        system = np.zeros((4, 4))
        system[0, 1] = system[2, 3] = 1.0
        system[1, :3] = -squares[k], -2.0 * ratios[k] * np.sqrt(squares[k]), -pushes[k]
        system[:2] *= dt
        step = expm(system)
        now, after = step[:2, 2] - step[:2, 3], step[:2, 3]
        # the displacement alone obeys a recurrence of second order: the state's, less its velocity
        turned = np.array([step[1, 1], -step[0, 1]])
        drive = np.zeros(motion.n)
        drive[1:] = a[:-1] * now[0] + a[1:] * after[0]
        drive[2:] -= a[:-2] * (turned[0] * now[0] + turned[1] * now[1]) + a[1:-1] * (
            turned[0] * after[0] + turned[1] * after[1]
        )
        poles = [1.0, -(step[0, 0] + step[1, 1]), step[0, 0] * step[1, 1] - step[0, 1] * step[1, 0]]
        x += np.outer(shapes[:, k], lfilter([1.0], poles, drive))
    return x


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
    """The structure ``M, C, K`` (m, m) on its degrees of freedom ``keep``, counted from 0, by modes and static vectors.

    ``labels`` (m,) are those of all, ``floors`` (k,) of what is kept, ``influence`` (m,) how each follows the ground (ones by
    default). M must be positive definite. :class:`~dampyr.errors.InputError` where the kept ones do not tell the modes apart.
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
        for _ in range(2):  # once more against what rounding left
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
    reduced = [0.5 * (each + each.T) for each in (T.T @ matrix @ T for matrix in (M, C, K))]
    whole = phi[list(keep)] @ (pushes / squares)
    by_modes = phi[list(keep)][:, chosen] @ (pushes[chosen] / squares[chosen])
    ratios = np.einsum("ij,ij->j", phi, C @ phi) / (2.0 * np.sqrt(squares))
    made = Building(reduced[0], reduced[1], reduced[2], name)
    own = made.frequencies
    nearest = np.sqrt(squares) / (2 * np.pi)
    errors = np.array([f / nearest[np.argmin(np.abs(nearest - f))] - 1.0 for f in own])
    return ModalBuilding(
        made.M,
        made.C,
        made.K,
        name,
        tuple(floors) or tuple(names[i] for i in keep),
        np.linalg.solve(made.M, T.T @ push),
        T,
        names,
        k == m,
        errors,
        tuple(int(i) + 1 for i in chosen),
        float(np.sum(pushes[chosen] ** 2) / np.sum(pushes**2)),
        np.abs(by_modes - whole) / np.max(np.abs(whole)),
        phi[list(keep)],
        squares,
        pushes,
        ratios,
    )


def _own_modes(building: Building) -> tuple[Array, Array, Array, Array]:
    squares, modes = building.modes()
    return modes, squares, building.damping_ratios, modes.T @ (building.M @ building.influence)
