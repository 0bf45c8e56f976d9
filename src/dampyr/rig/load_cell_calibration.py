r"""Calibration of the load cell step by step: zero, then a known load or a shunt; for the command line and the console alike.

Each value comes with its standard uncertainty: that of a mean of samples, from the means of `PARTS` parts of a reading, whose
noise need not be white; that of the load or of the shunt; and the cell's linearity and hysteresis.

The amplifier's bandwidth follows from a shunt that is switched in while the cell is read: the reading goes to its new value as
:math:`1 - e^{-t/\tau}`, and the bandwidth is :math:`1/(2 \pi \tau)`. A pure delay does not show in it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from dampyr.errors import InputError
from dampyr.rig.calibration import Array, doubt, save_calibration, shunt_point, two_point
from dampyr.rig.coil_calibration import Coil, measure_coil
from dampyr.rig.interlock import RAIL
from dampyr.rig.session import Rig
from dampyr.rig.shunt import SHUNT_UNCERTAINTY
from dampyr.units import STANDARD_GRAVITY, parse

PARTS = 10  # of a reading, from whose means the uncertainty of the whole is taken
LOAD_UNCERTAINTY = 1.0e-3  # of a load: a weight of class M3 or a scale of a laboratory, or better
GRAVITY_UNCERTAINTY = 1.5e-3  # of a mass: the local gravity is between 9.780 and 9.832 m/s2
AMPLIFIER_RATE = 20000.0  # Hz: a step through 1 kHz takes eight samples to get to 90 %
FASTEST_READING = 200000.0  # Hz of all inputs together: a PCI-6221 reads 250,000 a second
FAST_BLOCK = 0.1  # s
LEAST_STEP = 20.0  # times the noise


class Calibrating:
    """The steps; ``calibration`` is the calibration so far, ``doubt`` a sentence where its scale is far from the settings'."""

    def __init__(self, rig: Rig, seconds: float = 2.0) -> None:
        assert rig.calibration is not None
        self.rig, self.seconds, self.calibration = rig, seconds, rig.calibration
        self.noise = float("nan")
        self._zeroed = False

    def zero(self) -> float:
        """Read the cell without load; the volts."""
        volts, error = self._volts()
        zeroed = replace(self.calibration.zeroed(volts), how="zero read, scale as before", noise=self.noise)
        self.calibration, self._zeroed = replace(zeroed, zero_uncertainty=error), True
        return volts

    def loaded(self, load: str) -> float:
        """Read the cell under a known load, a mass or a force; the scale in N/V."""
        force = force_of(load)
        zero, (volts, error) = self._require_zero(), self._volts()
        self._set_scale(
            two_point(zero, volts, force), volts, error, load_uncertainty(load), f"two points, {force:.5g} N"
        )
        return self.calibration.scale

    def shunted(self, resistor: str) -> float:
        """Read the cell with a shunt switched in; the scale in N/V."""
        ohm = parse(resistor, "ohm")
        zero, (volts, error) = self._require_zero(), self._volts()
        scale = shunt_point(self.rig.settings.load_cell, ohm, zero, volts)
        self._set_scale(scale, volts, error, SHUNT_UNCERTAINTY, f"shunt, {ohm:g} ohm")
        return self.calibration.scale

    def amplifier(self, seconds: float = 5.0) -> float:
        """Read the cell while its shunt is switched in; the amplifier's bandwidth in Hz.

        Raises :class:`~dampyr.errors.InputError` where no such step is in the reading.
        """
        rate = min(AMPLIFIER_RATE, FASTEST_READING / len(self.rig.settings.inputs))
        time, volts = self._read_fast(rate, seconds)
        bandwidth, uncertainty = step_bandwidth(time, volts, self.rig.settings.step)
        self.calibration = replace(self.calibration, bandwidth=bandwidth, bandwidth_uncertainty=uncertainty)
        return bandwidth

    def coil(self) -> Coil:
        """Measure the coil and its supply by steps of the voltage; see `dampyr.rig.coil_calibration`."""
        measured = measure_coil(self.rig)
        self.calibration = measured.into(self.calibration)
        return measured

    def _read_fast(self, rate: float, seconds: float) -> tuple[Array, Array]:
        """Time [s] and the cell's volts (n,) at another rate than the rig's."""
        board, n, block = self.rig.board, round(rate * seconds), round(rate * FAST_BLOCK)
        board.start(rate, np.zeros(n + 2 * block))
        try:
            blocks = [board.read(block)[0][0] for _ in range(-(-n // block))]
        finally:
            board.stop()
        volts = self._within_range(np.concatenate(blocks))
        return np.arange(len(volts)) / rate, volts

    @property
    def doubt(self) -> str:
        """A sentence where the scale is far from that of the settings; empty where it is not."""
        return doubt(self.calibration.scale, self.rig.settings.load_cell.scale)

    def save(self, folder: str | Path, metadata: Mapping[str, str] | None = None) -> Path:
        """Save it next to the rig's settings, and use it from now on."""
        self.rig.use(self.calibration)
        return save_calibration(self.calibration, folder, metadata)

    def _require_zero(self) -> float:
        if not self._zeroed:
            raise InputError("the zero was not read yet; read it first, without load")
        return self.calibration.zero

    def _set_scale(self, scale: float, volts: float, error: float, load: float, how: str) -> None:
        """Take a scale from ``volts`` with its ``error`` [V], under a load of the relative uncertainty ``load``."""
        cell, change = self.rig.settings.load_cell, abs(volts - self.calibration.zero)
        line = np.sqrt(2.0 / 3.0) * cell.linearity * cell.capacity / abs(scale * change)
        read = np.hypot(error, self.calibration.zero_uncertainty or 0.0) / change
        relative = float(np.sqrt(load**2 + read**2 + line**2))
        noise = None if self.calibration.noise is None else self.calibration.noise * abs(scale / self.calibration.scale)
        self.calibration = replace(
            self.calibration, scale=scale, scale_uncertainty=relative * abs(scale), noise=noise, how=how
        )

    def _within_range(self, volts: Array) -> Array:
        """The volts; :class:`InputError` where some are at the end of the converter's range."""
        limit, largest = RAIL * self.rig.settings.board.range, float(np.abs(volts).max())
        if largest >= limit:
            raise InputError(
                f"the cell reads {largest:.4g} V, which is at the end of the board's range, {limit:.4g} V or more: look at the "
                "cell's wires and amplifier, or take a lighter load"
            )
        return volts

    def _volts(self) -> tuple[float, float]:
        """The mean of the cell's volts, and its standard uncertainty."""
        volts = self._within_range(self.rig.listen(self.seconds)[0][0])
        self.noise = float(np.std(volts)) * abs(self.calibration.scale)
        means = np.array([float(np.mean(part)) for part in np.array_split(volts, PARTS)])
        error = float(np.std(means, ddof=1)) / np.sqrt(PARTS)
        return float(np.mean(volts)), float(np.hypot(error, self.rig.settings.step / np.sqrt(12.0)))


def step_bandwidth(time: Array, volts: Array, resolution: float = 0.0) -> tuple[float, float]:
    r"""Bandwidth [Hz] and its standard uncertainty from a step in a reading ``volts`` (n,) at ``time`` (n,) [s].

    ``resolution`` [V] is the converter's step.

    :math:`v = a + b (1 - e^{-(t - t_0)/\tau})` from :math:`t_0` on is fitted by least squares. Where the step takes less than a
    sample, the bandwidth is at least :math:`1/(2 \pi \tau)` with the sample's length for :math:`\tau`; that is given, with
    half of it. :class:`~dampyr.errors.InputError` where there is no step, or more than one.
    """
    from scipy.optimize import least_squares

    dt = float(time[1] - time[0])
    low, high = (float(np.median(part)) for part in (volts[: len(volts) // 20], volts[-(len(volts) // 20) :]))
    noise = max(1.4826 * float(np.median(np.abs(volts[: len(volts) // 20] - low))), resolution / 3.5, 1e-9)
    if abs(high - low) < LEAST_STEP * noise:
        raise InputError(
            f"the reading went from {low:.5g} V to {high:.5g} V with a noise of {noise:.2g} V: no step of {LEAST_STEP:g} times "
            "the noise is in it; switch the shunt in while the cell is read, after a second and for the rest of it"
        )
    share = (volts - low) / (high - low)
    half = int(np.argmax(share > 0.5))
    late = int(np.argmax(share[half:] > 0.9)) + 1
    near = slice(max(0, half - 20 * late), min(len(volts), half + 40 * late))
    t, v = time[near] - time[half], volts[near]

    def residuals(values: Array) -> Array:
        a, b, start, tau = values
        elapsed = np.clip((t - start) / tau, 0.0, 700.0)  # exp(-700) is still a number
        return np.asarray(a + b * (1.0 - np.exp(-elapsed)) - v)

    tau0 = max(late * dt / 1.6, 0.3 * dt)  # from a half to nine tenths it takes 1.6 time constants
    fitted = least_squares(
        residuals,
        [low, high - low, -0.7 * tau0, tau0],
        x_scale=[noise, abs(high - low), tau0, tau0],
        bounds=([-np.inf, -np.inf, -np.inf, 0.05 * dt], np.inf),
    )
    tau, misfit = float(fitted.x[3]), float(np.sqrt(np.mean(fitted.fun**2)))
    farthest = float(np.abs(fitted.fun).max())  # of a few samples, which a long stretch dilutes in the mean
    if misfit > 5.0 * noise + 0.02 * abs(high - low) or farthest > 10.0 * noise + 0.1 * abs(high - low):
        raise InputError(
            f"the reading does not go straight to its new value ({misfit:.2g} V rms and {farthest:.2g} V at most off, with a "
            f"noise of {noise:.2g} V): does the switch bounce, or was it switched twice? try again"
        )
    if tau < dt:
        return 1.0 / (2.0 * np.pi * dt), 0.5 / (2.0 * np.pi * dt)
    parts = np.array_split(fitted.fun, max(2, len(fitted.fun) // late))  # slow errors count as many times as they last
    slow = max(1.0, float(np.std([float(np.mean(part)) for part in parts])) / misfit * np.sqrt(late))
    covariance = np.linalg.pinv(fitted.jac.T @ fitted.jac) * (slow * misfit) ** 2
    error = float(np.hypot(np.sqrt(covariance[3, 3]), 0.1 * dt))
    return 1.0 / (2.0 * np.pi * tau), error / tau / (2.0 * np.pi * tau)


def load_uncertainty(load: str) -> float:
    """Relative, of a load as typed: a mass is subject to the local gravity besides."""
    try:
        parse(load, "N")
    except InputError:
        return float(np.hypot(LOAD_UNCERTAINTY, GRAVITY_UNCERTAINTY))
    return LOAD_UNCERTAINTY


def force_of(load: str) -> float:
    """N of a load as typed: a force, or a mass times standard gravity."""
    try:
        force = parse(load, "N")
    except InputError:
        force = parse(load, "kg") * STANDARD_GRAVITY
    if force == 0.0:
        raise InputError(f"load = {load!r} is not a load; give a force or a mass that is not 0")
    return force
