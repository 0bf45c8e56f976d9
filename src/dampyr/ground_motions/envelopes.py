"""Envelopes of the shaking over time: factors between 0 and 1 on the noise of a synthetic ground motion.

An envelope is a function of the times [s] and the duration [s] that gives a factor for each time. These two are published
forms; any other function will do as well.

References
----------
.. [JenningsHousnerTsai1968] P. C. Jennings, G. W. Housner and N. C. Tsai, Simulated earthquake motions, Earthquake Engineering
   Research Laboratory, California Institute of Technology, 1968; the same form in M. Amin and A. H.-S. Ang, "Nonstationary
   stochastic model of earthquake motions", Journal of the Engineering Mechanics Division ASCE 94, 559-583, 1968.
.. [ShinozukaSato1967] M. Shinozuka and Y. Sato, "Simulation of nonstationary random process", Journal of the Engineering
   Mechanics Division ASCE 93, 11-40, 1967.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RisePlateauDecay:
    """(t/t1)^2 up to t1, 1 up to t2, then exp(-c (t - t2)) ([JenningsHousnerTsai1968]_).

    ``rise`` and ``until`` are t1 and t2 as shares of the duration, ``end`` the factor that is left at its end, which gives c.
    """

    rise: float = 0.15
    until: float = 0.5
    end: float = 0.05

    def __post_init__(self) -> None:
        if not (0 < self.rise <= self.until < 1 and 0 < self.end <= 1):
            raise InputError(
                f"rise = {self.rise:g}, until = {self.until:g}, end = {self.end:g} are not allowed; "
                "they must be 0 < rise <= until < 1 and 0 < end <= 1"
            )

    def __call__(self, t: Array, duration: float) -> Array:
        t1, t2 = self.rise * duration, self.until * duration
        c = -np.log(self.end) / (duration - t2)
        return np.where(t < t1, (t / t1) ** 2, np.exp(-c * np.maximum(t - t2, 0.0)))


@dataclass(frozen=True)
class ShinozukaSato:
    """exp(-a t) - exp(-b t), 0 < a < b [1/s], divided by its greatest value ([ShinozukaSato1967]_)."""

    a: float
    b: float

    def __post_init__(self) -> None:
        if not 0 < self.a < self.b < np.inf:
            raise InputError(f"a = {self.a:g} and b = {self.b:g} 1/s are not allowed; they must be 0 < a < b")

    def __call__(self, t: Array, duration: float) -> Array:
        top = np.log(self.b / self.a) / (self.b - self.a)
        return (np.exp(-self.a * t) - np.exp(-self.b * t)) / (np.exp(-self.a * top) - np.exp(-self.b * top))


def stationary(t: Array, duration: float) -> Array:
    """1 throughout: stationary but for the first seconds, in which the filters answer from rest."""
    return np.ones_like(t)
