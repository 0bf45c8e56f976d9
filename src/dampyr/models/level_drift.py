r"""How the level of a record goes with the energy that it has dissipated: most dampers weaken as they heat up.

.. math:: F = e^{\kappa\,(H - H_u)}\,\hat F(x, v; \theta), \qquad \dot H = F v - H/\tau, \quad H = 0
          \text{ where the record begins}

H is the energy in J that is still in the damper, where what surrounds it takes up the rest with the time constant
:math:`\tau`. :math:`H_u` is that at which the fitted force at an input stands, as the coefficients have taken up the mean
level of their records (`ShapeError.energy` of the prediction error). A record that begins warm has that in its own level.
`dampyr.identification.parameter_uncertainty.drift_estimate` finds the numbers.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.phrases import percent, rounded

Array = NDArray[np.float64]
ROUNDS = 6  # of the drifting force: where it goes to half along the record, the last one changes it by less than 0.1 %


@dataclass(frozen=True)
class LevelDrift:
    """``rate`` of the logarithm of the level by the energy in 1/J, its standard error and degrees of freedom, the time constant
    in s, infinite where nothing cools, and the ``energy`` in J that the median record has brought into the damper."""

    rate: float
    rate_error: float
    freedom: float
    time_constant: float
    energy: float

    def __post_init__(self) -> None:
        if not math.isfinite(self.rate):
            raise InputError(f"rate = {self.rate:g} is not allowed; it must be finite, in 1/J")
        if not (math.isfinite(self.rate_error) and self.rate_error >= 0.0):
            raise InputError(
                f"rate_error = {self.rate_error:g} is not allowed; it must be finite and at least 0, in 1/J"
            )
        if not (math.isfinite(self.energy) and self.energy >= 0.0):
            raise InputError(f"energy = {self.energy:g} is not allowed; it must be finite and at least 0, in J")
        for name in ("freedom", "time_constant"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"{name} = {getattr(self, name):g} is not allowed; it must be greater than 0, or inf")

    @property
    def change(self) -> float:
        """By which share the level of the median record has changed at its end: -0.1 where its force has fallen by 10 %."""
        return math.expm1(self.rate * self.energy)

    @property
    def words(self) -> str:
        """What the records show, and what takes it into account."""
        way = "falls" if self.rate < 0.0 else "rises"
        error = (1.0 + self.change) * self.energy * self.rate_error
        cooling = f", which cools with about {self.time_constant:g} s" if math.isfinite(self.time_constant) else ""
        return (
            f"the level {way} with the energy that a record dissipates: by {percent(abs(self.change))} (standard error "
            f"{rounded(100.0 * error, 2)} %) in the median record, which brings {rounded(self.energy, 3)} J into the "
            f"damper{cooling}; bands have it, and forces and buildings have the mean level of the records"
        )

    def draw_rate(self, rng: np.random.Generator) -> float:
        """A rate in 1/J, by Student's t."""
        return float(self.rate + self.rate_error * rng.standard_t(self.freedom))

    def applied(self, force: Array, velocity: Array, dt: float, stands_at: float, rate: float) -> Array:
        """The force (n,) in N, which stands at an energy within of ``stands_at`` J, as it drifts with a ``rate`` in 1/J.

        What the damper dissipates is the drifting force: each round takes that of the last one.
        """
        drifting = force
        for _ in range(ROUNDS):
            energy = energy_within(drifting * velocity, dt, self.time_constant)
            drifting = force * np.exp(rate * (energy - stands_at))
        return drifting

    def card(self) -> dict[str, float]:
        """The table of a card."""
        return asdict(self)


def energy_within(power: Array, dt: float, time_constant: float) -> Array:
    """The energy (n,) in J that is in a damper which takes up a ``power`` (n,) in W and loses it with a time constant in s."""
    from scipy.signal import lfilter

    return np.asarray(lfilter([dt], [1.0, -math.exp(-dt / time_constant)], power), dtype=float)
