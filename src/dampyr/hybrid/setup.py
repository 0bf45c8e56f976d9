r"""The set-up of a virtual hybrid test: structure, specimen, transfer system, sensors and converters.

The specimen is a mass :math:`m_e` on a spring :math:`k_e` and a dashpot :math:`c_e = 2 \zeta_e \sqrt{k_e m_e}` between two
floors of the structure, or a floor and the ground. The numerical part is what is left without it:

.. math:: (M - M_e) \ddot q + (C - C_e) \dot q + (K - K_e) q = -M \iota\, a_g - \lambda f

The transfer system is a servo-hydraulic actuator in closed loop. Its command u becomes the specimen's displacement x through

.. math:: \ddot y + \beta_1 \dot y + \beta_2 y = a_1 \beta_0\,(g u - x), \qquad \dot f + a_3 f = y - a_2 \dot x, \qquad
          m_e \ddot x + c_e \dot x + k_e x = f

with the force f, which is measured. The defaults are those of the benchmark of Silva et al. (2020).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.shown import Shown
from dampyr.structures import Building
from dampyr.structures.propagator import transition
from dampyr.structures.supports import refuse_supports

Array = NDArray[np.float64]


def _check(owner: Any, name: str, unit: str, low: float, open_low: bool = False, infinite: bool = False) -> None:
    value = getattr(owner, name)
    is_number = isinstance(value, int | float | np.floating | np.integer) and not isinstance(value, bool)
    finite = is_number and (math.isfinite(value) or (infinite and value > 0))
    if not finite or value < low or (open_low and value == low):
        bound = "" if low == -math.inf else f" and {'greater than' if open_low else 'at least'} {low:g}"
        raise InputError(f"{name} = {value!r} {unit}".rstrip() + f" is not allowed; it must be a finite number{bound}")


@dataclass(frozen=True)
class PhysicalSubstructure:
    """The physical part: ``mass`` [kg], ``stiffness`` [N/m] and ``damping_ratio`` (0.01 is 1 %)."""

    mass: float = 29.13
    stiffness: float = 1.19e6
    damping_ratio: float = 0.0097

    def __post_init__(self) -> None:
        _check(self, "mass", "kg", 0.0, open_low=True)
        _check(self, "stiffness", "N/m", 0.0, open_low=True)
        _check(self, "damping_ratio", "", 0.0)

    @property
    def damping(self) -> float:
        """The dashpot [N s/m]."""
        return 2.0 * self.damping_ratio * math.sqrt(self.stiffness * self.mass)


@dataclass(frozen=True)
class TransferSystem:
    """The actuator: ``gain`` g, ``valve_gain`` a1 beta0 [N/(m s3)], ``velocity_gain`` a2 [N/m], ``pole`` a3 [1/s], ``beta1``
    [1/s], ``beta2`` [1/s2], and the largest force ``max_force`` [N]: where the force passes it, it stays there."""

    gain: float = 1.0261
    valve_gain: float = 2.1283e13
    velocity_gain: float = 4.2297e6
    pole: float = 3.3
    beta1: float = 425.0
    beta2: float = 9.9976e4
    max_force: float = 8900.0

    def __post_init__(self) -> None:
        for name in ("gain", "valve_gain", "max_force"):
            _check(self, name, "", 0.0, open_low=True, infinite=name == "max_force")
        for name in ("velocity_gain", "pole", "beta1", "beta2"):
            _check(self, name, "", -math.inf)  # a drawn pole may be below 0: the loop around it holds it


@dataclass(frozen=True)
class PlantSpread:
    """Standard deviations of what differs from one plant to the next: ``stiffness`` of the specimen [N/m], ``pole`` [1/s],
    ``beta1`` [1/s] and ``beta2`` [1/s2] of the actuator."""

    stiffness: float = 5.0e4
    pole: float = 1.3
    beta1: float = 3.3
    beta2: float = 3.3e3

    def __post_init__(self) -> None:
        for spread in fields(self):
            _check(self, spread.name, "", 0.0)


@dataclass(frozen=True)
class Sensors:
    """Noise and converters. ``displacement_noise`` [m2/Hz] and ``force_noise`` [N2/Hz] are powers: variance over rate.

    The converters have ``bits`` over 1 V (steps of 2^-18 V) and end at +-``limit`` V; ``displacement_scale`` [V/m] and
    ``force_scale`` [V/N] are assumed: 1 V is 1 m, as in the benchmark's file, and the limit is the actuator's greatest force.
    """

    displacement_noise: float = 6.25e-14
    force_noise: float = 1.16e-3
    bits: int = 18
    limit: float = 3.8
    displacement_scale: float = 1.0
    force_scale: float = 3.8 / 8900.0

    def __post_init__(self) -> None:
        for name in ("displacement_noise", "force_noise"):
            _check(self, name, "", 0.0)
        for name in ("limit", "displacement_scale", "force_scale"):
            _check(self, name, "", 0.0, open_low=True, infinite=name == "limit")
        if not 0 <= self.bits <= 64:
            raise InputError(f"bits = {self.bits} is not allowed; it must be from 1 to 64, or 0 for no steps")

    @property
    def step(self) -> float:
        """The converters' step [V]; 0 without steps."""
        return 2.0**-self.bits if self.bits else 0.0


IDEAL = Sensors(0.0, 0.0, 0, math.inf)
"""Without noise and converters."""


@dataclass(frozen=True, eq=False, repr=False)
class HybridSetup(Shown):
    """A structure, the specimen at ``place`` (a storey, or two floors), actuator, sensors, and the ``rate`` [Hz] of the loop.

    The force reaches the numerical part ``force_delay`` samples late. :class:`~dampyr.errors.InputError` where the structure
    cannot stand without the specimen: it has less mass, damping or stiffness than the specimen.
    """

    structure: Building
    specimen: PhysicalSubstructure = field(default_factory=PhysicalSubstructure)
    transfer: TransferSystem = field(default_factory=TransferSystem)
    sensors: Sensors = field(default_factory=Sensors)
    place: Any = 1
    rate: float = 4096.0
    force_delay: int = 1
    numerical: Building = field(init=False)

    def __post_init__(self) -> None:
        refuse_supports("a hybrid test", self.structure)
        _check(self, "rate", "Hz", 0.0, open_low=True)
        if isinstance(self.force_delay, bool) or self.force_delay not in (0, 1, 2, 3, 4, 5, 6):
            raise InputError(
                f"force_delay = {self.force_delay!r} is not allowed; it must be a whole number from 0 to 6"
            )
        object.__setattr__(self, "numerical", _numerical(self.structure, self.specimen, self.connection))

    @property
    def connection(self) -> Array:
        """The row (n,) that makes the specimen's displacement of the floors'."""
        return self.structure.connection(self.place)

    @property
    def dt(self) -> float:
        """The time step [s]."""
        return 1.0 / self.rate

    @cached_property
    def plant_step(self) -> tuple[Array, Array]:
        """The plant over one sample with its command held, exactly: the states' map (5, 5), the command's (5,)."""
        from scipy.linalg import expm

        a, b = plant_matrices(self)
        # exp([[A, b], [0, 0]] h) holds both maps: the command as a further state that does not change.
        augmented = np.zeros((6, 6))
        augmented[:5, :5], augmented[:5, 5] = a * self.dt, b * self.dt
        both = expm(augmented)
        return np.ascontiguousarray(both[:5, :5]), np.ascontiguousarray(both[:5, 5])

    @cached_property
    def numerical_step(self) -> tuple[Array, Array, Array]:
        """The numerical part over one sample, exactly, the ground linear, the force held: see `building_step`."""
        return building_step(self.numerical, self.connection, self.dt)

    def with_plant(self, stiffness: float, pole: float, beta1: float, beta2: float) -> HybridSetup:
        """The same set-up with another plant."""
        return replace(
            self,
            specimen=replace(self.specimen, stiffness=stiffness),
            transfer=replace(self.transfer, pole=pole, beta1=beta1, beta2=beta2),
        )


def _numerical(structure: Building, specimen: PhysicalSubstructure, row: Array) -> Building:
    """The structure without the specimen; the ground moves all of its mass."""
    pair = np.outer(row, row)
    parts = {"M": specimen.mass, "C": specimen.damping, "K": specimen.stiffness}
    M, C, K = (getattr(structure, letter) - value * pair for letter, value in parts.items())
    try:
        influence = np.linalg.solve(M, structure.M @ structure.influence)
        return Building(M, C, K, f"{structure.name} without the specimen", structure.floors, influence)
    except (InputError, np.linalg.LinAlgError) as problem:
        raise InputError(
            f"the structure without the specimen cannot stand by itself ({problem}); take a specimen of less mass, damping "
            f"or stiffness than {specimen.mass:g} kg, {specimen.damping:.4g} N s/m, {specimen.stiffness:g} N/m"
        ) from None


def plant_matrices(setup: HybridSetup) -> tuple[Array, Array]:
    """``A`` (5, 5) and ``b`` (5,) of the actuator with the specimen; states y, dy/dt, f, x, dx/dt."""
    t, s = setup.transfer, setup.specimen
    a, b = np.zeros((5, 5)), np.zeros(5)
    a[0, 1] = 1.0
    a[1] = [-t.beta2, -t.beta1, 0.0, -t.valve_gain, 0.0]
    b[1] = t.valve_gain * t.gain
    a[2] = [1.0, 0.0, -t.pole, 0.0, -t.velocity_gain]
    a[3, 4] = 1.0
    a[4] = [0.0, 0.0, 1.0 / s.mass, -s.stiffness / s.mass, -s.damping / s.mass]
    return a, b


def building_step(building: Building, row: Array, dt: float) -> tuple[Array, Array, Array]:
    """A building over ``dt`` s, exactly: the states' map (2n, 2n), that of the ground's acceleration at both ends (2n, 2),
    linear between, and that of a force held against ``row`` (2n,)."""
    maps, n = transition(building, row[None, :], dt, 1.0), 2 * building.n
    return (
        np.ascontiguousarray(maps[:, :n]),
        np.ascontiguousarray(maps[:, n : n + 2]),
        np.ascontiguousarray(maps[:, n + 2 :].sum(axis=1)),
    )
