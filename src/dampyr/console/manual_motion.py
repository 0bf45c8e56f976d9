"""Motions by hand on an armed rig, for as long as the page that asked for them holds control.

A sine is checked as a test of a campaign is; a voltage on the coil stands with the table at rest.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np

from dampyr.campaigns import campaign_of, plan
from dampyr.campaigns.force_prediction import specimen
from dampyr.console.clients import Clients
from dampyr.console.jogging import Jogging
from dampyr.errors import DampyrError, InputError
from dampyr.rig import Drive, RigSettings
from dampyr.rig.session import ArmedRig

MAX_CYCLES = 1000
MAX_SECONDS = 120.0  # of a voltage on the coil at rest: an operator looks at it
PERIOD = 0.01  # s from set point to set point
Motion = Callable[[ArmedRig], None]


class Cancelled(DampyrError):
    """A motion was ended because whoever asked for it is gone, or asked for something else."""


class ManualMotions:
    """The motion that is asked for, and what ends it; ``leaving`` says whether the table is to be disarmed."""

    def __init__(self, clients: Clients, clock: Callable[[], float], leaving: Callable[[], bool]) -> None:
        self.jogging, self.halted = Jogging(clock), threading.Event()
        self._clients, self._leaving = clients, leaving
        self._asked: tuple[str, Motion] | None = None
        self._mover = ""

    def ask(self, client: str, motion: Motion) -> None:
        """Begin ``motion`` with the next block; asked for while the table is armed and nothing else is under way."""
        self.forget()
        self.halted.clear()
        self._asked = client, motion

    def forget(self) -> None:
        """Nothing is asked for any more."""
        self.jogging.forget()
        self._asked = None

    def step(self, table: ArmedRig) -> bool:
        """Perform the motion that is asked for; where there is none take a block, and jog. Whether there was one."""
        if self._asked is None:
            next(table.loop.blocks())
            self.jogging.steer(table, self._clients.holder)
            return False
        (self._mover, motion), self._asked = self._asked, None
        motion(table)
        return True

    def check(self) -> None:
        """Raise `Cancelled` where what moves may not go on."""
        self._clients.silent()
        if self._leaving():
            raise Cancelled("ended: the rig is disarmed")
        if self.halted.is_set():
            raise Cancelled("ended by the operator")
        if self._mover != self._clients.holder:
            raise Cancelled("ended: the page that requested it no longer holds control")


def sine_drive(
    settings: RigSettings, folder: Path | None, amplitude: float, frequency: float, voltage: float, cycles: int
) -> Drive:
    """The drive of a sine of ``amplitude`` [m], ``frequency`` [Hz] and ``voltage`` [V]; not recorded.

    Raises :class:`~dampyr.errors.InputError` where the rig cannot do it, with what it can.
    """
    if not 1 <= cycles <= MAX_CYCLES:
        raise InputError(f"cycles = {cycles} is not allowed; give 1 to {MAX_CYCLES}")
    step = {
        "kind": "sine", "amplitude": f"{amplitude!r} m", "frequency": f"{frequency!r} Hz", "voltage": f"{voltage!r} V",
        "cycles": cycles, "rest_before": "0 s",
    }  # fmt: skip
    campaign = campaign_of({"name": "by hand", "check_amplitude": 0.0, "step": [step]})
    planned = plan(campaign, settings, specimen(settings, folder))
    if planned.refusals:
        raise InputError(planned.refusals[0])
    return planned.tests[0].drive


def check_coil(settings: RigSettings, voltage: float, seconds: float) -> None:
    """Raise :class:`~dampyr.errors.InputError` where a voltage [V] or its duration [s] is not allowed."""
    limit = min(settings.limits.voltage, settings.board.range * settings.supply.gain)
    if not (math.isfinite(voltage) and 0.0 <= voltage <= limit):
        raise InputError(f"voltage = {voltage:g} V is not allowed; the coil takes 0 V to {limit:.4g} V")
    if not 0.0 < seconds <= MAX_SECONDS:
        raise InputError(f"seconds = {seconds:g} s is not allowed; give more than 0 s and at most {MAX_SECONDS:g} s")


def coil_drive(table: ArmedRig, voltage: float, seconds: float) -> Drive:
    """The drive of a voltage [V] on the coil for ``seconds``, with the table at rest where it stands."""
    n = max(2, math.ceil(seconds / PERIOD) + 1)
    volts = np.full(n, voltage)
    volts[-1] = 0.0
    return Drive(PERIOD, np.full(n, table.position), volts, standing=True)


def play(table: ArmedRig, drive: Drive) -> None:
    """Go to where a drive begins, and play it."""
    if not drive.standing:
        table.go(float(drive.displacement[0]))
    for _ in table.play(drive):
        pass
