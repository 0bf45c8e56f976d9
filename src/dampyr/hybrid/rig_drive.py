"""The drive of a hybrid test on the rig, whose set points follow from the measured force."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError, RigFault
from dampyr.hybrid.substructure import GAINS, LARGEST_LAG, Substructure, lag_of
from dampyr.rig.drive import Drive
from dampyr.rig.firmware.protocol import QUEUE
from dampyr.rig.interlock import Samples
from dampyr.rig.player import Player
from dampyr.rig.settings import RigSettings
from dampyr.structures.control_laws import describe_law

Array = NDArray[np.float64]
REPAIR = "take a lower scale or voltage, a slower clock, a shorter board.block, or a better model of the damper"
DECIDING = 0.01  # s that a law's decisions of a block may take; so much earlier its set points leave
STOPPING = 3.0  # s in which the table goes from where the test ends back to the middle


@dataclass
class HybridPlayer(Player):
    """The computed part, fed with each block: it identifies the lag, makes the steps that were measured, sends what follows."""

    def __post_init__(self) -> None:
        assert isinstance(self.drive, HybridDrive)
        self.hybrid: HybridDrive = self.drive
        self._points = round(self.drive.period * self.rig.board.rate)  # samples of a step
        self._late = round(self.rig.force_delay * self.rig.board.rate)
        self._measured: list[tuple[Array, Array]] = []
        self._first = 0  # sample of the drive with which what is in `_measured` begins
        self._identified = False
        self._static = 0.0

    def prepare(self) -> None:
        """Make the run of the computed part, whose kernel may have to be compiled."""
        part = self.hybrid.substructure
        # Two decisions of a run that is thrown away: what a law calls first at its second one is compiled then, too.
        part.run().fix(1 if part.law is None else round(part.law.period / part.h) + 1)
        self.run = part.run()

    def target(self, first: int, n: int) -> None:
        """None: what the table is sent follows from what was measured, and is known too late to be compared."""

    @property
    def ahead(self) -> int | None:
        """Under a law less than else: the later it decides, the less of its measures is predicted."""
        if not self.hybrid.law:
            return None
        return math.ceil(law_lead(self.rig, self.hybrid.reserve) * self.rig.board.rate)

    def voltage(self, first: int, n: int) -> Array:
        """The coil's voltage for n samples from ``first`` on: during the test what the law decides."""
        volts, part = super().voltage(first, n), self.hybrid.substructure
        step = (np.arange(first, first + n) - self.start) // self._points - self.hybrid.lead_in
        during = (step >= 0) & (step < part.steps)
        if self.hybrid.law and during.any():
            self._fix(int(step[during][-1]) + 1)
            volts[during] = self.run.commands[step[during]] * self.hybrid.volts_per_input
        return volts

    def _fix(self, until: int) -> None:
        """Fix what the law decides; a RigFault where it asks for more than it may."""
        try:
            self.run.fix(until)
        except InputError as problem:
            raise RigFault(f"{describe_stop(self.run.about, self.run.now)}: {problem}", "check") from None

    def take(self, samples: Samples) -> None:
        """Make the steps that a block completes."""
        after = samples.first + samples.n
        if after > self.start and not self.finished:
            skip = max(0, self.start - samples.first)
            self._measured.append((samples.displacement[skip:], samples.force[skip:]))
            self._compute(after - self.start)

    def _follow(self, now: int) -> None:
        """Send the first set points a block before their time, and follow them from ``start`` on: they all are at rest."""
        hybrid = self.hybrid
        self.ratio = self.clock.ratio.value
        self.points = math.ceil((hybrid.n - 1) * self.ratio - 1e-9) + 1
        if not self.sent and now >= self.start - self.rig.block_samples:
            self._keep_filled(0, QUEUE)
        if now >= self.start:
            self.running = True
            self.uno.follow(self._period, self.points)

    def _compute(self, taken: int) -> None:
        """Make the steps that the first ``taken`` samples complete."""
        zero = self.hybrid.lead_in * self._points
        if taken - self._late <= zero:
            return
        x, force = (np.concatenate(blocks) for blocks in zip(*self._measured, strict=True))
        if not self._identified:
            self._identify(x[:zero], force)
            self._first, x, force = zero, x[zero:], force[zero:]
        steps = min((taken - self._late - self._first) // self._points, self.hybrid.substructure.steps - self.run.now)
        for k in range(steps):
            # The load cell's filter is late by so many samples: the force of a step stands that much further on.
            rows = slice(k * self._points + self._late, (k + 1) * self._points + self._late)
            self.run.measured(float(x[(k + 1) * self._points - 1]), float(np.mean(force[rows])) - self._static)
        self._first += steps * self._points
        self._measured = [(x[steps * self._points :], force[steps * self._points :])]
        if self.run.energy_error > self.hybrid.substructure.energy_limit:
            raise RigFault(
                describe_energy_error(self.run.energy_error, self.hybrid.substructure, self.run.now), "check"
            )

    def _identify(self, x: Array, force: Array) -> None:
        """The lag and the gain from the motion before the test, and the static force from its whole cycles."""
        hybrid = self.hybrid
        first, last = hybrid.cycles
        self._static = static_force(force, first * self._points + self._late, last * self._points + self._late)
        sent, achieved = hybrid.displacement[: hybrid.lead_in], x[:: self._points]
        lag, gain = lag_of(sent[: len(achieved)], achieved, hybrid.period, LARGEST_LAG * hybrid.clock)
        if not GAINS[0] < gain < GAINS[1]:
            raise RigFault(
                f"the table moved {100 * gain:.0f} % of what it was sent before the hybrid test; look at its motor, its "
                "encoder and its load, or lower the voltage",
                "check",
            )
        self.run.begin(lag / hybrid.clock, gain)
        self._identified = True

    def _keep_filled(self, followed: int, free: int) -> None:
        """Set points until the next block has come; those of the test follow from what was measured."""
        hybrid, taken = self.hybrid, self._first + sum(len(x) for x, _ in self._measured)
        ahead = self.rig.board.block + hybrid.reserve + (DECIDING if hybrid.law else 0.0)
        seconds = taken / self.rig.board.rate + ahead
        until = min(self.points, math.ceil(seconds / hybrid.period * self.ratio) + 2)
        if self.sent < until:
            # The Uno's set points lie between those of the drive, which are on the board's clock, as its own is another one.
            at = np.minimum(np.arange(self.sent, until) / self.ratio, hybrid.n - 1.0)
            first, last = math.floor(at[0]), math.ceil(at[-1])
            points = self._set_points(first, last - first + 1)
            self.uno.points(self.sent, self._in_counts(np.interp(at, np.arange(first, last + 1), points)))
            self.sent = until

    def _set_points(self, first: int, n: int) -> Array:
        """Set points ``first`` to ``first`` + n of the drive, from the lead-in, the test and the way back."""
        hybrid, steps = self.hybrid, self.hybrid.substructure.steps
        index = np.arange(first, first + n) - hybrid.lead_in
        points = hybrid.displacement[first : first + n].copy()
        during = (index > 0) & (index <= steps)
        if during.any():
            self._fix(int(index[during][-1]))
            self.run.set_points(int(index[during][-1]))
            points[during] = self.run.sent[index[during]]
            self._check_speed(index[during])
        after = index > steps
        if after.any():
            velocity = (self.run.sent[steps] - self.run.sent[steps - 1]) / hybrid.period
            points[after] = way_back(self.run.sent[steps], velocity, (index[after] - steps) * hybrid.period)
        return points

    def _check_speed(self, index: Any) -> None:
        """A RigFault where the building wants to move faster than the rig may."""
        speed = float(np.abs(np.diff(self.run.sent[index[0] - 1 : index[-1] + 1])).max()) / self.drive.period
        limit = self.rig.limits.speed
        if speed > limit:
            raise RigFault(
                f"{describe_stop(self.run.about, self.run.now)}: the building wants to move at {1e3 * speed:.3g} mm/s, the "
                f"limit is {1e3 * limit:.3g} mm/s; {REPAIR}",
                "check",
            )


@dataclass(frozen=True, eq=False, repr=False)
class HybridDrive(Drive):
    """A drive whose ``displacement`` is what is expected: the lead-in of ``lead_in`` set points, the test, and the way back.

    ``cycles`` : first and last set point of whole cycles of the lead-in, in which the static force is measured. ``clock`` : how
    much slower than the structure's own time the test runs. ``reserve`` : s of set points sent beyond the next block.
    ``volts_per_input`` : at the coil for the input of the damper's model, which a law decides on.
    """

    substructure: Substructure = field(kw_only=True)
    lead_in: int = field(kw_only=True)
    cycles: tuple[int, int] = field(kw_only=True)
    clock: float = field(default=1.0, kw_only=True)
    reserve: float = field(default=0.034, kw_only=True)
    volts_per_input: float = field(default=1.0, kw_only=True)

    player: ClassVar[type[Player]] = HybridPlayer

    @property
    def law(self) -> str:
        """The control law that decides on what the building is predicted to do, in words."""
        part = self.substructure
        return "" if part.law is None or part.model is None else describe_law(part.law, part.model.input)

    @property
    def voltage_range(self) -> tuple[float, float]:
        """Under a law its own bounds, whatever it is expected to ask for."""
        law = self.substructure.law
        if law is None:
            return super().voltage_range
        return law.low * self.volts_per_input, law.high * self.volts_per_input


def law_lead(rig: RigSettings, reserve: float) -> float:
    """s by which a law's voltage is asked for before its time: a block and twice what set points have in reserve.

    Twice, as a board whose command ends stops at once, while an Uno follows what it has been sent.
    """
    return rig.board.block + 2.0 * reserve


def static_force(force: Array, first: int, last: int) -> float:
    """The mean force [N] over whole cycles: that of a loop which lies even about it."""
    return float(np.mean(force[first:last]))


def way_back(place: float, velocity: float, t: Any) -> Array:
    """From ``place`` [m] and ``velocity`` [m/s] back to rest in the middle in `STOPPING` s: a polynomial of fifth degree."""
    u, slope = np.clip(t / STOPPING, 0.0, 1.0), velocity * STOPPING
    remaining = 1.0 + u * u * u * (-10.0 + u * (15.0 - 6.0 * u))
    moving = u + u * u * u * (-6.0 + u * (8.0 - 3.0 * u))
    return np.asarray(place * remaining + slope * moving)


def describe_energy_error(error: float, part: Substructure, now: int) -> str:
    """Why a test was stopped."""
    return (
        f"{describe_stop(part, now)}: the table's lag put {100 * error:.0f} % of the ground's energy into the structure, "
        f"the limit is {100 * part.energy_limit:g} %; {REPAIR}"
    )


def describe_stop(part: Substructure, now: int) -> str:
    """How a message of a test that was stopped begins."""
    return f"the hybrid test was stopped after {now * part.h:.2f} s of the structure's time"
