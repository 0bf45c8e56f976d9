r"""Does the level of the records drift with the energy that they dissipate? A test, and the estimate where it does.

The rest of each record after its level and its shape error is compared with :math:`\hat F (H - \bar H)`, of which the same
level and shape are taken off: what no mean level and no periodic error can be. The rate :math:`\kappa` of
`dampyr.models.level_drift` is common to all records, the energy within is that of the measured force from 0 on, and the
level of each record stays its own, so that neither strokes, nor inputs, nor sessions can pass for heat. The time constant is
the one of `TIMES` that leaves least. The variance of the rate is that between records (a sandwich), and the drift counts
where Student's t is beyond chance (`CHANCE`) and it moves the level of the median record by `LEAST` or more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.models.level_drift import LevelDrift, energy_within

Array = NDArray[np.float64]
# s, of cooling: a record of some seconds tells it to a factor of three
TIMES = (3.0, 10.0, 30.0, 100.0, 300.0, math.inf)
MIN_RECORDS = 4  # a variance between fewer tells nothing
MAX_SAMPLES = 1000  # of a record: the energy is slow
CHANCE = 0.01  # of both sides, for one time constant of several that are alike
LEAST = 0.02  # of the logarithm of the level, in the median record
MOST = 3.0  # of it, in any record: a twentieth of the force is no damper that warms up
TURNS = 3  # the drift is a factor, and the rate its first order: a third turn changes 30 % of the force by 0.1 % of it
UNKNOWN = 1e-12  # of the square of the modelled force: a motion that tells nothing of heat


@dataclass(frozen=True)
class RecordRest:
    """A record against the fit (n,): measured and modelled force about their means, the functions of the shape error (n, k),
    the power that is dissipated in W, and the samples that are not false."""

    force: Array
    model: Array
    basis: Array
    power: Array
    true: NDArray[np.bool_]
    dt: float

    def thinned(self, energy: Array) -> tuple[Array, Array, Array, Array]:
        """Force, model, basis and energy (n, k) at `MAX_SAMPLES` true samples or fewer."""
        kept = np.flatnonzero(self.true)[:: max(1, int(self.true.sum()) // MAX_SAMPLES)]
        return self.force[kept], self.model[kept], self.basis[kept], energy[kept]


def estimate_drift(rests: Sequence[RecordRest]) -> tuple[LevelDrift, Array] | None:
    """The drift and the mean energy (n,) within each record in J, weighted as its level is; None where it does not count."""
    from scipy.stats import t

    if len(rests) < MIN_RECORDS:
        return None
    energies = [np.stack([energy_within(rest.power, rest.dt, time) for time in TIMES], axis=1) for rest in rests]
    seen = [rest.thinned(energy) for rest, energy in zip(rests, energies, strict=True)]
    # the time constant by the first order of the drift, then the rate at that one as a factor
    first = [_Share.of(*arrays, np.zeros(len(TIMES))) for arrays in seen]
    product, square = (np.sum([getattr(share, name) for share in first], axis=0) for name in ("product", "square"))
    if not np.all(square > 0.0):
        return None
    k = int(np.argmax(product**2 / square))
    rate, time = float(product[k] / square[k]), TIMES[k]
    span = float(np.median([share.span[k] for share in first]))
    if abs(rate) * span < 0.5 * LEAST or abs(rate) * max(share.span[k] for share in first) > MOST:
        return None
    seen = [(force, model, basis, energy[:, [k]]) for force, model, basis, energy in seen]
    for _ in range(TURNS):
        shares = [_Share.of(*arrays, np.array([rate])) for arrays in seen]
        total = float(sum(share.square[0] for share in shares))
        change = float(sum(share.product[0] for share in shares)) / total
        rate += change
        if abs(rate) * max(share.span[0] for share in shares) > MOST:
            return None
    n = len(shares)
    between = sum(float(share.product[0] - share.square[0] * change) ** 2 for share in shares)
    error = math.sqrt(between * n / (n - 1)) / total
    if abs(rate) * span < LEAST or abs(rate) < error * float(t.ppf(1.0 - 0.5 * CHANCE, n - 1)):
        return None
    return LevelDrift(rate, error, float(n - 1), time, span), np.array([share.energy[0] for share in shares])


@dataclass(frozen=True)
class _Share:
    """What one record says of a change of the rate for each of k time constants: products of its rest with the effect of that
    change, the mean energy within and its range."""

    product: Array
    square: Array
    energy: Array
    span: Array

    @classmethod
    def of(cls, force: Array, model: Array, basis: Array, energy: Array, rate: Array) -> _Share:
        scale = float(model @ model)
        if scale <= UNKNOWN * float(force @ force):  # a model that gives nothing has no level
            return cls(*np.zeros((4, energy.shape[1])))
        mean = model**2 / scale @ energy
        away = energy - mean
        # one rate where the drift is a factor; where there are several none has an effect yet
        drifting = model * np.exp(rate[0] * away[:, 0])
        known = np.column_stack((drifting, np.ones(model.size), basis * float(np.std(model))))
        values = np.column_stack((force, drifting[:, None] * away))
        # what the level, the offset and the shape error take up of both
        taken = np.linalg.lstsq(known.T @ known, known.T @ values, rcond=1e-12)[0]
        rest, effect = np.hsplit(values - known @ taken, [1])
        # each record counts alike, whatever its input, by its level and the square of its force
        level = float(taken[0, 0])
        square = np.sum(effect**2, axis=0) / scale
        tells = (square > UNKNOWN * np.ptp(energy, axis=0) ** 2) & (level > 0.0)
        product = (rest.T @ effect)[0] / (scale * level) if level > 0.0 else np.zeros_like(square)
        product = np.where(tells, product, 0.0)
        return cls(product, np.where(tells, square, 0.0), mean, np.ptp(energy, axis=0))
