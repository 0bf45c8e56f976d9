r"""Resistance and inductance of the coil, and gain of the supply, from steps of the voltage at a table that stands.

The coil follows :math:`L \dot i = u - R i`; over a sample of length h at a voltage that is held,

.. math:: i_{k+1} = \frac{u_k}{R} + \left(i_k - \frac{u_k}{R}\right) e^{-R h / L}.

R, L, the zero of the current's reading and the part of a sample by which the voltage comes late are those with which this
current is closest to the measured one (least squares). R is given at 20 degC, by the temperature coefficient of copper.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError, RigFault
from dampyr.rig.calibration import Calibration
from dampyr.rig.drive import Drive
from dampyr.rig.session import ArmedRig, Rig
from dampyr.rig.settings import RigSettings
from dampyr.rig.thermal_model import COLD, COPPER

Array = NDArray[np.float64]
PERIOD = 0.01  # s of a set point
STEP = 0.4  # s that a voltage is held: ten of the time constants that coils of dampers have, 5 to 40 ms
LEVELS = (0.0, 0.5, 0.0, 1.0, 0.5, 1.0, 0.0)  # of the highest voltage, one after the other
SHARE = 0.5  # of limits.voltage: it warms the coil by less than a kelvin
AT_REST = 2.0  # K by which the damper may be warmer than is thought: it is to have the room's temperature
LEAST_CURRENT = 0.02  # A at the highest step, from which a coil is taken to be there


@dataclass(frozen=True)
class Coil:
    """A coil with its supply, each value with its standard uncertainty: ``resistance`` at 20 degC [ohm], ``inductance`` [H],
    ``gain`` [V/V] of the supply or None where the coil's voltage is not read; ``misfit`` [A] rms of the current."""

    resistance: float
    resistance_uncertainty: float
    inductance: float
    inductance_uncertainty: float
    gain: float | None
    gain_uncertainty: float | None
    misfit: float

    def into(self, calibration: Calibration) -> Calibration:
        """The calibration with these values."""
        return replace(
            calibration,
            resistance=self.resistance,
            resistance_uncertainty=self.resistance_uncertainty,
            inductance=self.inductance,
            inductance_uncertainty=self.inductance_uncertainty,
            gain=calibration.gain if self.gain is None else self.gain,
            gain_uncertainty=calibration.gain_uncertainty if self.gain is None else self.gain_uncertainty,
        )


def measure_coil(rig: Rig) -> Coil:
    """Arm the rig, give its coil steps of voltage while the table stands, and fit the current.

    Raises :class:`~dampyr.errors.InputError` where nothing reads the current, before anything is armed, and
    :class:`~dampyr.errors.RigFault` where no current flows.
    """
    if "coil_current" not in rig.settings.inputs:
        raise InputError(
            "nothing reads the coil's current: wire a shunt in its circuit to a free input, and name that in "
            "wires.coil_current; without one its resistance has to be measured by hand and written to supply.resistance"
        )
    with rig.armed() as table:
        volts, command = _play_steps(table)
    readings = dict(zip(rig.settings.inputs, volts, strict=True))
    supply = rig.settings.supply
    current = readings["coil_current"] * supply.current_scale
    coil = readings["coil_voltage"] * supply.voltage_scale if "coil_voltage" in readings else None
    return fit_coil(rig.settings, command / supply.gain, coil, current, rig.warmth.temperature)


def _play_steps(table: ArmedRig) -> tuple[Array, Array]:
    """The volts of all inputs (channels, n), and the command at the coil (n,) [V], over steps of the voltage."""
    n = round(STEP / PERIOD)
    voltage = np.repeat(np.array(LEVELS) * SHARE * table.rig.settings.limits.voltage, n)
    drive = Drive(PERIOD, np.full(voltage.size, table.position), voltage, standing=True)
    blocks = [(samples.volts[:, selection], samples.command[selection]) for samples, selection in table.play(drive)]
    return np.concatenate([v for v, _ in blocks], axis=1), np.concatenate([c for _, c in blocks])


def fit_coil(rig: RigSettings, output: Array, coil: Array | None, current: Array, temperature: float) -> Coil:
    """The coil whose current is closest to the measured one.

    ``output`` (n,) V is the board's, ``coil`` (n,) V the coil's as read or None, ``current`` (n,) A; the damper is at
    ``temperature`` degC.
    """
    from scipy.optimize import least_squares

    if float(np.ptp(current)) < LEAST_CURRENT:
        raise RigFault(
            f"the current changed by {np.ptp(current):.2g} A while the coil's voltage was stepped to {output.max():.3g} V: "
            "look at the supply, its enable line, the coil's wires and the shunt",
            "check",
        )
    supply, step = rig.supply, 1.0 / rig.board.rate
    volts = output * supply.gain if coil is None else coil - float(np.mean(coil[output == 0.0][:10]))

    def predicted(values: Array) -> Array:
        resistance, inductance, zero, late = values
        # late is a part of a sample: between two of them the voltage is a mean of both
        delayed = (1.0 - late) * volts + late * np.concatenate(([volts[0]], volts[:-1]))
        return zero + _coil_current(resistance, inductance, step, delayed)

    start = np.array([supply.resistance, min(max(supply.inductance, 1e-4), 1.0), 0.0, 0.0])
    low = [0.05 * supply.resistance, 1e-6, -1.0, -1.0]
    high = [20.0 * supply.resistance, 10.0, 1.0, 2.0]
    fitted = least_squares(
        lambda values: predicted(values) - current, start, bounds=(low, high), x_scale=[1.0, 0.01, 0.01, 1.0]
    )
    resistance, inductance = float(fitted.x[0]), float(fitted.x[1])
    misfit = math.sqrt(float(np.mean(fitted.fun**2)))
    covariance = np.linalg.pinv(fitted.jac.T @ fitted.jac) * misfit**2
    # R is fitted as warm as the coil is, and given as of 20 degC.
    warm = 1.0 + COPPER * (temperature - COLD)
    of_voltage = supply.gain_uncertainty if coil is None else supply.reading_uncertainty
    systematic = math.hypot(supply.reading_uncertainty, of_voltage, COPPER * AT_REST)
    gain = None if coil is None else _supply_gain(output, volts)
    return Coil(
        resistance / warm,
        math.hypot(math.sqrt(covariance[0, 0]), systematic * resistance) / warm,
        inductance,
        math.hypot(math.sqrt(covariance[1, 1]), systematic * inductance),
        gain,
        None if gain is None else supply.reading_uncertainty * gain,
        misfit,
    )


def _coil_current(resistance: float, inductance: float, step: float, volts: Array) -> Array:
    """The current (n,) [A] of a coil that had none."""
    from scipy.signal import lfilter

    decay = math.exp(-resistance * step / inductance)
    return np.asarray(lfilter([0.0, (1.0 - decay) / resistance], [1.0, -decay], volts))


def _supply_gain(output: Array, coil: Array) -> float:
    """Volts at the coil per volt of the board's output, where it was not changed just before."""
    steady = np.concatenate(([False], np.diff(output) == 0.0)) & np.concatenate((np.diff(output) == 0.0, [False]))
    u, v = output[steady], coil[steady]
    return float(u @ v) / float(u @ u)
