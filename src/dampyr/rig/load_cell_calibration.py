"""Calibration of the load cell step by step: zero, then a known load or a shunt; for the command line and the console alike."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from dampyr.errors import InputError
from dampyr.rig.calibration import doubt, save_calibration, shunt_point, two_point
from dampyr.rig.session import Rig
from dampyr.units import STANDARD_GRAVITY, parse


class Calibrating:
    """The steps; ``calibration`` is the calibration so far, ``doubt`` a sentence where its scale is far from the settings'."""

    def __init__(self, rig: Rig, seconds: float = 2.0) -> None:
        assert rig.calibration is not None
        self.rig, self.seconds, self.calibration = rig, seconds, rig.calibration
        self.noise = float("nan")
        self._zeroed = False

    def zero(self) -> float:
        """Read the cell without load; the volts."""
        volts = self._volts()
        self.calibration, self._zeroed = replace(self.calibration.zeroed(volts), how="zero read, scale as before"), True
        return volts

    def loaded(self, load: str) -> float:
        """Read the cell under a known load, a mass or a force; the scale in N/V."""
        force = force_of(load)
        self._scaled(two_point(self._require_zero(), self._volts(), force), f"two points, {force:.5g} N")
        return self.calibration.scale

    def shunted(self, resistor: str) -> float:
        """Read the cell with a shunt switched in; the scale in N/V."""
        ohm = parse(resistor, "ohm")
        self._scaled(
            shunt_point(self.rig.settings.load_cell, ohm, self._require_zero(), self._volts()), f"shunt, {ohm:g} ohm"
        )
        return self.calibration.scale

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

    def _scaled(self, scale: float, how: str) -> None:
        self.calibration = replace(self.calibration, scale=scale, how=how)

    def _volts(self) -> float:
        volts, _ = self.rig.listen(self.seconds)
        self.noise = float(np.std(volts[0])) * abs(self.calibration.scale)
        return float(np.mean(volts[0]))


def force_of(load: str) -> float:
    """N of a load as typed: a force, or a mass times standard gravity."""
    try:
        force = parse(load, "N")
    except InputError:
        force = parse(load, "kg") * STANDARD_GRAVITY
    if force == 0.0:
        raise InputError(f"load = {load!r} is not a load; give a force or a mass that is not 0")
    return force
