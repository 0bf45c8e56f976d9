r"""Hybrid: a damper on the rig in a building that is computed; see `dampyr.hybrid.substructure`.

.. math:: M \ddot q + C \dot q + K q = -M \iota\, s\, a_g - \lambda f

At each step the building's displacement at the damper goes to the table, and the measured force f, less the static force, goes
back into the building. Before, whole cycles of a small sine show the table's lag and gain, and the static force. A table as
small and slow as this one cannot move as a building does under most records: with ``fit_limits`` the plan lowers the scale s to
what the rig can do, and says so. A ``clock`` of 5 lets the building's time pass 5 times slower instead; a force that depends on
the velocity is wrong then, and the plan says by how much.

With ``control`` a law sets the voltage at its samples, a whole number of ``period`` apart. It measures the computed building
and ground and the load cell's force as they will be when its voltage is at the coil: a block and twice ``reserve`` later,
predicted as the set points are. The coil follows it with the lag of the rig's coil (``supply.inductance`` over
``supply.resistance``), unless the law is given a ``lag`` of its own.
"""

from __future__ import annotations

import hashlib
import math
import warnings
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

import numpy as np

from dampyr.campaigns.paths import AFTER, Array, PathPiece, hold, raised, sampled
from dampyr.campaigns.step import Count, Length, Peaks, Period, Rest, Time, Volts, check_ranges
from dampyr.errors import DampyrWarning, FileError, InputError, MissingData
from dampyr.ground_motions import GroundMotion, el_centro, read
from dampyr.hybrid.delayed_actuator import run_delayed
from dampyr.hybrid.rig_drive import DECIDING, STOPPING, HybridDrive, law_lead, way_back
from dampyr.hybrid.substructure import Substructure, SubstructureRun, substructure_of
from dampyr.input_kinds import input_arguments
from dampyr.models import Damper, published
from dampyr.rig import RigSettings
from dampyr.rig.instruments.catalogue import OUTPUT
from dampyr.rig.specimen import specimen_of
from dampyr.structures import Building, Response, load, respond, two_storey
from dampyr.structures.control_laws import law_of
from dampyr.units import Quantity

BUILT_IN = "el_centro"
HEAVIER = 10.0  # than the building of chapter 5, so that its damper on this table is stable
GROWING, STEADY, FADING = 1, 4, 3  # cycles of the sine before the test
REST = 0.5  # s between it and the test
TABLE_LAG = 0.005  # s that a table is late with set points which its firmware feeds forward
LAG_ERROR = 1e-3  # s by which the lag may be wrong, of the rig's time: one sample
RATE_ERROR = 0.02  # of the greatest force that a slower clock may change


@dataclass(frozen=True)
class Hybrid:
    """A building of which the damper is on the rig, in an earthquake."""

    structure: Annotated[str, "building: heavy_two_storey, two_storey, or a TOML file beside the campaign"] = (
        "heavy_two_storey"
    )
    motion: Annotated[str, "ground motion: el_centro, or a file beside the campaign"] = BUILT_IN
    scale: Annotated[float, Quantity("", low=0.0, open_low=True), "factor on the record"] = 1.0
    fit_limits: Annotated[bool, "lower the scale to what the rig can do"] = True
    clock: Annotated[float, Quantity("", low=1.0, high=100.0), "factor by which the building's time passes slower"] = (
        1.0
    )
    storey: Annotated[int, Count, "storey in which the damper stands"] = 1
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0
    duration: Annotated[
        float, Quantity("s", low=0.0), "part of the record that is used, from its begin; 0: all of it"
    ] = 0.0
    model: Annotated[str, "card of the damper that predicts the force ahead; empty: the rig's specimen"] = ""
    adaptive: Annotated[bool, "follow the table's lag during the test"] = True
    lead_amplitude: Annotated[float, Length, "amplitude of the sine before the test"] = 0.002
    energy_limit: Annotated[float, Quantity("", low=0.001, high=1.0), "error of energy at which the test stops"] = 0.1
    reserve: Annotated[
        float,
        Time,
        "time of the set points that are sent beyond the next block: for a late host, and two requests on a line of 16 ms",
    ] = 0.034
    rest_before: Annotated[float, Rest, "rest before the motion, recorded so that offsets can be read"] = 1.0
    period: Annotated[float, Period, "time from set point to set point"] = 0.002
    control: Annotated[
        str, "control law that sets the voltage, such as on_off:period=4ms,high=2; empty: the voltage stays"
    ] = field(default="", repr=False)

    lowers: ClassVar[tuple[str, ...]] = ("scale", "voltage")
    fixed: ClassVar[bool] = False
    closed_loop: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.control and self.voltage:
            raise InputError("voltage and control both set the coil's voltage; give one of the two")

    @property
    def named(self) -> tuple[str, ...]:
        """The fields in a test's name and words."""
        return ("title", "scale", "control" if self.control else "voltage")

    @property
    def title(self) -> str:
        """What structure and motion are called in words and names."""
        return f"{Path(self.structure).stem}+{Path(self.motion).stem}"

    @property
    def h(self) -> float:
        """The step [s] of the building's time."""
        return self.period / self.clock

    def located_in(self, folder: Path) -> Self:
        """The same step with its files looked for in ``folder``."""
        located: dict[str, Any] = {name: str(folder / file) for name, file in self._files.items()}
        return replace(self, **located)

    @property
    def _files(self) -> dict[str, str]:
        """The files that it names, by field."""
        built_in = {"structure": (*BUILDINGS,), "motion": (BUILT_IN,), "model": ("", *published.available_sets())}
        return {name: getattr(self, name) for name, names in built_in.items() if getattr(self, name) not in names}

    @property
    def contents(self) -> dict[str, str]:
        """A hash of what is in each file: where it lies does not change a campaign, what is in it does."""
        hashes = {}
        for name, file in self._files.items():
            try:
                hashes[name] = hashlib.sha256(Path(file).read_bytes()).hexdigest()
            except FileNotFoundError:
                raise MissingData(f"{file}: there is no such file; check {name} in the campaign") from None
            except OSError as problem:
                raise FileError(file, f"cannot be read ({problem.strerror}); check the file") from problem
        return hashes

    def damper(self, rig: RigSettings) -> Damper:
        """The model that predicts the force, without what is the rig's own: delay and lag."""
        return _without_delays(_card(self.model, self.contents.get("model", "")) if self.model else specimen_of(rig))

    def law(self, rig: RigSettings) -> Any:
        """The control law, its coil as late as the rig's unless it says otherwise; None without one.

        InputError where this rig cannot offer it.
        """
        if not self.control:
            return None
        damper = self.damper(rig)
        if not damper.has_input:
            raise InputError("the damper's model has no input, which a control law would set; leave out control")
        if rig.wires.supply != OUTPUT:
            raise InputError(
                f"control = {self.control}: the rig's supply ({rig.wires.supply}) has no sample clock, so a law's voltage "
                "would come at times that are not known; wire an output of the board to it (wires.supply), or leave out control"
            )
        law = law_of(self.control, damper)
        return law if law.lag else replace(law, lag=rig.supply.inductance / rig.supply.resistance / self.clock)

    def input(self, rig: RigSettings) -> Any:
        """What the model takes: the control law, or what `input_of` gives for the voltage."""
        return self.law(rig) or input_of(self.damper(rig), self.voltage, rig)

    def computed(self, rig: RigSettings) -> Response:
        """The response of the building with the damper's model: all of it computed."""
        return _compute(self, self.damper(rig), self.input(rig), tuple(sorted(self.contents.items())))

    def substructure(self, rig: RigSettings) -> Substructure:
        """The computed part."""
        law, computed, building = self.law(rig), self.computed(rig), building_of(self.structure)
        value = self.input(rig) if law is None else law.low
        part = substructure_of(building, self.storey, computed, self.h, self.damper(rig), value)
        if law is not None:
            part = replace(part, law=law, law_lead=law_lead(rig, self.reserve) / self.clock)
        return replace(
            part, adaptive=self.adaptive, size=max(self.lead_amplitude, part.size), energy_limit=self.energy_limit
        )

    def drive(self, rig: RigSettings) -> HybridDrive:
        """The set points of table and coil as they are expected; during the test they follow from the measured force."""
        part, response = self.substructure(rig), self.computed(rig)
        frequency = self._lead_frequency(rig)
        grown, faded = GROWING / frequency, FADING / frequency
        total = grown + STEADY / frequency + faded

        def sine(t: Array) -> Array:
            shape = raised(t / grown) * raised((total - t) / faded)
            return np.asarray(self.lead_amplitude * shape * np.sin(2 * math.pi * frequency * t))

        before = sampled([hold(0.0, self.rest_before), PathPiece(total, sine), hold(0.0, REST)], self.period)
        inside = np.arange(1, part.steps + 1) * self.h
        stroke, rate = response.stroke[0], response.velocity.T @ part.row
        during = hermite(response.time, stroke, rate, inside)
        t = np.arange(1, math.ceil((STOPPING + AFTER) / self.period) + 1) * self.period
        after = way_back(float(during[-1]), float(rate[-1]) / self.clock, t)
        x = np.concatenate([before, during, after])
        begin = self.rest_before + grown
        steady_cycles = round(begin / self.period), round((begin + STEADY / frequency) / self.period)
        voltage, per_input = np.full(x.size, self.voltage), 1.0
        if part.law is not None:
            per_input = rig.supply.resistance if self.damper(rig).input == "A" else 1.0
            voltage[:] = part.law.low * per_input
            expected = np.interp(inside - self.h, response.time, response.input[0])  # over the steps that begin then
            voltage[len(before) - 1 : len(before) - 1 + part.steps] = per_input * expected
        return HybridDrive(
            self.period, x, voltage, substructure=part, lead_in=len(before) - 1, cycles=steady_cycles,
            clock=self.clock, reserve=self.reserve, volts_per_input=per_input,
        )  # fmt: skip

    def _lead_frequency(self, rig: RigSettings) -> float:
        """That of the building's first mode on the rig's clock, or what a third of the rig's speed allows."""
        first = float(building_of(self.structure).frequencies[0]) / self.clock
        return min(first, rig.limits.speed / 3.0 / (2 * math.pi * self.lead_amplitude))

    def peaks(self, rig: RigSettings) -> Peaks:
        """Those of the computed response, or of the sine before."""
        response = self.computed(rig)
        rate = response.velocity.T @ building_of(self.structure).connection(self.storey)
        steps = math.floor(float(response.time[-1]) / self.h)
        during = hermite(response.time, response.stroke[0], rate, np.arange(steps + 1) * self.h)
        sine = 2 * math.pi * self._lead_frequency(rig) * self.lead_amplitude
        return Peaks(
            max(float(np.abs(during).max()), self.lead_amplitude),
            max(float(np.abs(np.diff(during)).max()) / self.period, float(np.abs(rate).max()) / self.clock, sine),
        )

    def remarks(self, rig: RigSettings) -> tuple[str, ...]:
        """What the plan says of the test: the findings of the computed response."""
        return tuple(map(str, self.computed(rig).findings))

    def rehearsal(self, rig: RigSettings) -> str:
        """Why the test would not be stable on this rig, or would not say what it is to say; "" where it would.

        It is computed with the model as the specimen, on an actuator as late as the rig's, whose lag is known with an error of
        `LAG_ERROR` either way.
        """
        if reason := self._describe_range(rig) or self._describe_clock_error(rig):
            return reason
        reserve = self.reserve + (DECIDING if self.control else 0.0)
        steps = round((rig.board.block + reserve + 2 * self.period + TABLE_LAG) / self.period)
        for lag_error in (0.0, LAG_ERROR, -LAG_ERROR):
            part = replace(self.substructure(rig), lag=steps * self.h, adaptive=False)
            run = run_delayed(part, self.damper(rig), steps * self.h + lag_error / self.clock, 0.0)
            if not run.over:
                return self._describe_instability(run, 1e3 * steps * self.period, lag_error, rig)
        return ""

    def _describe_instability(self, run: SubstructureRun, late: float, lag_error: float, rig: RigSettings) -> str:
        error = f" and {1e3 * lag_error:+g} ms that are not known" if lag_error else ""
        return (
            f"the hybrid test would be unstable: with set points that leave {late:.3g} ms ahead{error}, the error of energy "
            f"passes {100 * self.energy_limit:g} % after {run.now * self.h:.2f} s of the building's time. The damper is too "
            "strong for this building at this lag; take a heavier building, a lower voltage, or a shorter board.block than "
            f"{1e3 * rig.board.block:g} ms"
        )

    def _describe_range(self, rig: RigSettings) -> str:
        """Why the model cannot predict the force at this voltage."""
        damper, factor = self.damper(rig), 1.0
        if self.control:
            return ""  # a law is refused by itself where its inputs are outside
        if damper.input == "A":
            factor = rig.supply.resistance
        low, high = (value * factor for value in damper.range)
        if not damper.needs_input or low * (1 - 1e-9) <= self.voltage <= high * (1 + 1e-9):
            return ""
        return (
            f"voltage = {self.voltage:g} V, but the model was calibrated from {low:.4g} to {high:.4g} V; "
            "take a voltage inside, or another model"
        )

    def _describe_clock_error(self, rig: RigSettings) -> str:
        """Why a slower clock would not do for this damper."""
        if self.clock == 1.0:
            return ""
        share = self.rate_error(rig)
        if share <= RATE_ERROR:
            return ""
        return (
            f"clock = {self.clock:g} changes the damper's force by {100 * share:.3g} % of its peak, as it depends on the "
            f"velocity (at most {100 * RATE_ERROR:g} % is allowed); take clock = 1 and a lower scale"
        )

    def rate_error(self, rig: RigSettings) -> float:
        """By how much the slower clock changes the force of the model along the computed response, over its peak."""
        damper, response = self.damper(rig), self.computed(rig)
        t, x = response.time, response.stroke[0]
        rate = response.velocity.T @ building_of(self.structure).connection(self.storey)
        value = response.input[0] if self.control else input_of(damper, self.voltage, rig)
        inputs = input_arguments(damper.input, value)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DampyrWarning)  # as for the computed response
            fast = damper.force_of_motion(t, x, velocity=rate, **inputs)
            slow = damper.force_of_motion(t * self.clock, x, velocity=rate / self.clock, **inputs)
        # over half of the peak to peak, which is the peak of a force without offset
        return float(np.abs(slow - fast).max() / np.ptp(fast) * 2.0)


def heavy_two_storey() -> Building:
    """The building of chapter 5 with ten times its masses, dashpots and springs: without a damper it moves as that does."""
    light = two_storey()
    M, C, K = (HEAVIER * matrix for matrix in (light.M, light.C, light.K))
    return Building(M, C, K, name="heavy two-storey building")


BUILDINGS = {"heavy_two_storey": heavy_two_storey, "two_storey": two_storey}


def building_of(structure: str) -> Building:
    """One of `BUILDINGS`, or that of a file."""
    return BUILDINGS[structure]() if structure in BUILDINGS else load(structure)


def motion_of(step: Hybrid) -> GroundMotion:
    """The scaled ground motion, cut after ``duration``."""
    raw = el_centro() if step.motion == BUILT_IN else read(step.motion)
    a = step.scale * raw.acceleration
    if step.duration:
        a = a[: max(2, math.ceil(step.duration / raw.dt) + 1)]
    return replace(raw, acceleration=a)


def input_of(damper: Damper, voltage: float, rig: RigSettings) -> float:
    """What the model takes for a voltage at the coil: V, or A through the coil's resistance; at most what it was calibrated to.

    A voltage beyond that is refused by the plan, which needs an expected motion to say so.
    """
    value = voltage / rig.supply.resistance if damper.input == "A" else voltage
    return min(max(value, damper.range[0]), damper.range[1])


@lru_cache(maxsize=64)
def _card(model: str, content: str) -> Damper:
    """The damper of a card or a published set; ``content`` tells cards of one name apart.

    Dampers are compared as objects: `_compute` knows the one that it has had.
    """
    return published.card_or_published(model)


@lru_cache(maxsize=64)
def _without_delays(damper: Damper) -> Damper:
    """A damper without what is the rig's own."""
    return damper.without(*(name for name in ("delay", "lag") if name in damper.composition.names))


@lru_cache(maxsize=64)
def _compute(step: Hybrid, damper: Damper, value: Any, contents: tuple[tuple[str, str], ...]) -> Response:
    """The response of a step's building; ``contents`` tells files of one name apart."""
    inputs = input_arguments(damper.input, value)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)  # the response has them as findings, and the plan as remarks
        return respond(building_of(step.structure), motion_of(step), {step.storey: damper}, **inputs)


def hermite(t: Array, x: Array, v: Array, at: Any) -> Array:
    """The cubic through positions and velocities, at the times ``at``; the last one beyond them."""
    h = t[1] - t[0]
    k = np.clip((at / h).astype(int), 0, len(t) - 2)
    s = np.clip((at - t[k]) / h, 0.0, 1.0)
    a, b = s * s * (3 - 2 * s), s * (1 - s)
    return np.asarray(x[k] * (1 - a) + x[k + 1] * a + h * b * (v[k] * (1 - s) - v[k + 1] * s))
