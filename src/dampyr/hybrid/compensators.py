r"""Compensators: how the command follows from the displacement that the specimen should have.

`PhaseLeadCompensator` is the sample controller of the benchmark: a phase lead before a PI controller of the error.

The others command the inverse of the plant, a polynomial in the derivatives of the target, taken as backward differences:

.. math:: u = \theta_0 x + \theta_1 \dot x + \theta_2 \ddot x + \theta_3 \dddot x

and estimate its coefficients from the command and the measured displacement, both behind a low-pass filter.
`ModelBasedCompensator` is the published adaptive one (Galmez and Fermandois), a gradient law; `KalmanCompensator`, which is
dampyr's own, a Kalman filter:

.. math:: e = u - \theta^T \phi, \quad g = P \phi, \quad s = R + \phi^T g, \qquad
          \theta \leftarrow \theta + g e / s, \quad P \leftarrow P - g g^T / s

It starts from the nominal plant's inverse, and P is what the stated uncertainties of the plant make of it: directions in which
no plant differs are not searched, so that the poorly excited third derivative does not drift. It forgets nothing: a plant that
changes during the test is followed more and more slowly. It also extrapolates the measured force over the time by which it
reaches the numerical part late, one and a half samples of the benchmark's.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.hybrid.loop_kernel import KALMAN, MODEL_BASED, ORDER, PHASE_LEAD, CompensatorArrays
from dampyr.hybrid.setup import HybridSetup, PlantSpread
from dampyr.units import Quantity

Array = NDArray[np.float64]

FILTER_FREQUENCY = 20.0  # Hz, of the published compensator: above the structure's second mode, below the noise
BAND = np.linspace(0.5, 25.0, 80)  # Hz in which the inverse fits: up to a little more than the filter passes
CORNER = 4.0  # Hz: the motion's displacement falls with the square of the frequency above its first mode


class Compensator(Protocol):
    """What a hybrid test needs of a compensator."""

    def law(self, setup: HybridSetup) -> CompensatorArrays:
        """Its numbers for the kernel, new arrays each time."""

    def linear(self, setup: HybridSetup, theta: Array | None) -> tuple[Array, Array, Array, Array, Array]:
        """A (q, q), b (q,) of the target, b (q,) of the measured displacement, c (q,), d (2,): with ``theta`` fixed."""

    def matched(self, setup: HybridSetup) -> Array | None:
        """The coefficients to which it adapts on the plant of ``setup``; None where it does not adapt."""

    @property
    def extrapolation(self) -> float:
        """Samples over which the measured force is extrapolated."""


@dataclass(frozen=True)
class PhaseLeadCompensator:
    """The sample controller of the benchmark: a PI controller of gains ``kp`` and ``ki`` [1/s] on the error to
    (``lead`` s + ``corner``)/(s + ``corner``) [1/s] times the target."""

    kp: float = 2.0
    ki: float = 95.0
    lead: float = 50.83163360273612
    corner: float = 8570.397339444286
    extrapolation: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        for name in ("kp", "ki"):
            Quantity("", low=0.0).check(name, getattr(self, name))
        for name in ("lead", "corner"):
            Quantity("", low=0.0, open_low=True).check(name, getattr(self, name))

    def coefficients(self, setup: HybridSetup) -> Array:
        """Kp, Ki dt/2, and b0, b1, a1 of the phase lead by Tustin's rule (5,)."""
        twice = 2.0 * setup.rate
        d = twice + self.corner
        return np.array(
            [
                self.kp,
                0.5 * self.ki * setup.dt,
                (self.lead * twice + self.corner) / d,
                (self.corner - self.lead * twice) / d,
                (twice - self.corner) / d,
            ]
        )

    def law(self, setup: HybridSetup) -> CompensatorArrays:
        return _law(PHASE_LEAD, setup, linear=self.coefficients(setup))

    def matched(self, setup: HybridSetup) -> None:
        return None

    def linear(self, setup: HybridSetup, theta: Array | None = None) -> tuple[Array, Array, Array, Array, Array]:
        """States: the last target, the last output of the phase lead, the integral, the last error."""
        kp, ki, b0, b1, a1 = self.coefficients(setup)
        led = np.array([b1, a1, 0.0, 0.0])
        integral = ki * led + [0.0, 0.0, 1.0, ki]
        a = np.array([np.zeros(4), led, integral, led])
        target, measured = np.array([1.0, b0, ki * b0, b0]), np.array([0.0, 0.0, -ki, -1.0])
        return a, target, measured, kp * led + integral, np.array([(kp + ki) * b0, -kp - ki])


@dataclass(frozen=True)
class _Inverse:
    """What the two inverses share: the filter's frequency [Hz], samples of lead and of extrapolation."""

    def linear(self, setup: HybridSetup, theta: Array | None) -> tuple[Array, Array, Array, Array, Array]:
        """States: the last ``ORDER`` targets."""
        if theta is None:
            raise InputError("the loop of an inverse needs its coefficients; give theta")
        taps = np.zeros(ORDER + 1)
        for i, value in enumerate(theta):
            derivative = np.zeros(1) + value * setup.rate**i  # the i-th, as i backward differences
            for _ in range(i):
                derivative = np.convolve(derivative, [1.0, -1.0])
            taps[: i + 1] += derivative
            taps[: i + 2] += getattr(self, "lead", 0.0) * np.convolve(derivative, [1.0, -1.0])
        a = np.eye(ORDER, k=-1)
        return a, np.eye(ORDER)[0], np.zeros(ORDER), taps[1:], np.array([taps[0], 0.0])

    def matched(self, setup: HybridSetup) -> Array:
        return inverse_coefficients(setup)


@dataclass(frozen=True)
class ModelBasedCompensator(_Inverse):
    """The adaptive model-based compensator of Galmez and Fermandois.

    ``start`` (4,): the coefficients of the unloaded actuator's inverse; ``gains`` (4,): the adaptation's. Coefficients below 0
    are set to 0, as there.
    """

    start: tuple[float, ...] = ()
    gains: tuple[float, ...] = (10**8.4, 10**6.2, 10**2.1, 10**0.8)
    extrapolation: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", tuple(self.start) or unloaded_inverse())
        for name in ("start", "gains"):
            if len(getattr(self, name)) != ORDER or not np.all(np.isfinite(getattr(self, name))):
                raise InputError(f"{name} = {getattr(self, name)!r} must be {ORDER} finite numbers")

    def law(self, setup: HybridSetup) -> CompensatorArrays:
        scale = setup.rate ** np.arange(ORDER)
        return _law(MODEL_BASED, setup, theta=self.start, scale=scale, gain=np.array(self.gains) * setup.dt,
                    extrapolation=self.extrapolation)  # fmt: skip


@dataclass(frozen=True)
class KalmanCompensator(_Inverse):
    """The compensator of dampyr: see the module. Made by `designed` from a nominal set-up.

    ``start`` (4,): the coefficients of the nominal plant's inverse; ``covariance`` (4, 4) of theta/start; ``noise`` [m]: the
    standard deviation of e; ``lead`` samples by which the specimen shall be ahead; ``extrapolation`` samples of the force.
    """

    start: tuple[float, ...]
    covariance: tuple[tuple[float, ...], ...]
    noise: float
    lead: float
    extrapolation: float

    @classmethod
    def designed(
        cls,
        nominal: HybridSetup,
        uncertainty: PlantSpread | None = None,
        noise: float = 2e-4,  # m: from 1e-4 to 2e-3 the criteria hardly change
        lead: float = 0.0,
        extrapolation: float | None = None,
        spread: float = 2.0,  # so that a plant at four standard deviations is still within two
    ) -> KalmanCompensator:
        """The compensator for a nominal plant and those about it.

        Parameters
        ----------
        nominal
            The set-up whose plant's inverse it starts from.
        uncertainty
            Standard deviations of the plants about it; None: those of the benchmark.
        noise
            m, the standard deviation of the command's error that is not the plant's, more than 0.
        lead
            Samples by which the specimen shall be ahead of its target.
        extrapolation
            Samples over which the measured force is extrapolated; None: its delay and half a sample, in which it is held.
        spread
            How many times the uncertainty the plants may be off, more than 0.
        """
        for name, value in (("noise", noise), ("spread", spread)):
            Quantity("", low=0.0, open_low=True).check(name, value)
        start = inverse_coefficients(nominal)
        slopes = _sensitivity(nominal, uncertainty or PlantSpread()) / start[:, None]
        covariance = spread**2 * slopes @ slopes.T + np.eye(ORDER) * FLOOR**2
        late = nominal.force_delay + 0.5 if extrapolation is None else float(extrapolation)
        return cls(tuple(start), tuple(map(tuple, covariance)), noise, lead, late)

    def law(self, setup: HybridSetup) -> CompensatorArrays:
        start = np.array(self.start)
        return _law(
            KALMAN,
            setup,
            theta=np.ones(ORDER),
            scale=start * setup.rate ** np.arange(ORDER),
            covariance=self.covariance,
            noise=self.noise**2,
            lead=self.lead,
            extrapolation=self.extrapolation,
        )


FLOOR = 2e-3  # relative s.d. in each coefficient by itself: what the inverse of third order leaves out


def _law(kind: int, setup: HybridSetup, **numbers: Any) -> CompensatorArrays:
    from scipy.signal import butter

    b, a = butter(4, FILTER_FREQUENCY / (0.5 * setup.rate))
    zeros: dict[str, Any] = {
        "linear": np.zeros(5), "theta": np.zeros(ORDER), "scale": np.ones(ORDER), "gain": np.zeros(ORDER),
        "covariance": np.zeros((ORDER, ORDER)), "noise": 1.0, "lead": 0.0, "extrapolation": 0.0, "b": b, "a": a,
    }  # fmt: skip
    arrays: dict[str, Any] = {
        name: float(value) if isinstance(zeros[name], float) else np.array(value, dtype=float)
        for name, value in (zeros | numbers).items()
    }
    return CompensatorArrays(kind, **arrays)


def unloaded_inverse() -> tuple[float, ...]:
    """The published start: the lowest four coefficients of the actuator's inverse against a spring of 1 N/m, no mass."""
    valve_gain, velocity_gain, pole, beta1, beta2 = 2.13e13, 4.23e6, 3.3, 425.0, 1e5
    denominator = np.polymul([1.0, beta1, beta2], [1.0 + velocity_gain, pole])
    denominator[-1] += valve_gain
    return tuple(float(value) for value in (denominator / valve_gain)[::-1])


def inverse_coefficients(setup: HybridSetup) -> Array:
    r"""theta (4,) [1, s, s2, s3] of the inverse of the plant as the loop sees it, with its held command and the differences.

    Least squares of the tracking error :math:`\theta^T D(z) H(z) - 1` over `BAND`, weighted as the motion's displacement falls;
    H is the plant from command to displacement, D the differences.
    """
    states, command = setup.plant_step
    z = np.exp(2j * np.pi * BAND * setup.dt)
    commands = np.broadcast_to(command[:, None], (len(z), 5, 1))
    response = np.linalg.solve(z[:, None, None] * np.eye(5) - states, commands)[:, 3, 0]
    sizes = (2.0 * np.pi * CORNER) ** -np.arange(ORDER)
    columns = ((1.0 - 1.0 / z) * setup.rate)[:, None] ** np.arange(ORDER) * response[:, None] * sizes
    weight = 1.0 / (1.0 + (BAND / CORNER) ** 2)
    rows = columns * weight[:, None]
    solution = np.linalg.lstsq(
        np.vstack([rows.real, rows.imag]), np.concatenate([weight, np.zeros_like(weight)]), rcond=None
    )[0]
    return solution * sizes


def _sensitivity(nominal: HybridSetup, uncertainty: PlantSpread) -> Array:
    """The change of theta (4, 4) for one standard deviation of stiffness, pole, beta1, beta2, by central differences."""
    t = nominal.transfer
    centre = {"stiffness": nominal.specimen.stiffness, "pole": t.pole, "beta1": t.beta1, "beta2": t.beta2}
    columns = []
    for name in centre:
        size = getattr(uncertainty, name)
        above, below = (
            inverse_coefficients(nominal.with_plant(**(centre | {name: centre[name] + sign * size})))
            for sign in (1, -1)
        )
        columns.append(0.5 * (above - below))
    return np.array(columns).T
