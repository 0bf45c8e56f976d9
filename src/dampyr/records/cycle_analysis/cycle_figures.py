"""Figures of every cycle, level and record, and of a device by several records: what a laboratory puts in its tables.

A cycle has the figures of its device: one whose force follows the displacement has all, a viscous one and one that is switched
by a voltage or a current have neither equivalent damping nor loss factor nor second slope, since their stiffness may go to
zero (`dampyr.records.cycle_analysis.device_figures`). docs/reference/cycle-figures.md defines all figures, with their sources.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import Annotated, Any, Literal

import numpy as np

from dampyr.argument_kinds import RECORDS, Argument, check_kinds
from dampyr.config import Choices
from dampyr.errors import InputError
from dampyr.findings import Finding, handed_on, worst_first
from dampyr.input_kinds import INPUTS, input_text
from dampyr.options import Options, ShownIn, Terminal, takes
from dampyr.origin import Origin, combined
from dampyr.records.conditioning.nominal_input import nominal_inputs
from dampyr.records.cycle_analysis.cycle_table import cycle_table
from dampyr.records.cycle_analysis.cycles import Cut, CutCycle, cut_cycles, fine_turning_points
from dampyr.records.cycle_analysis.device_figures import DeviceFigures, device_figures, loop_between
from dampyr.records.cycle_analysis.mid_stroke_force import gas_force_curve
from dampyr.records.cycle_analysis.path_work import path_work, work_of_steps
from dampyr.records.cycle_analysis.step_response import StepResponse, response_times
from dampyr.records.files.campaign_folder import RecordsOrPaths, as_records
from dampyr.records.record import Array, Record
from dampyr.shown import Shown
from dampyr.units import UNIT_SYSTEMS, Quantity

Device = Literal["displacement", "viscous", "switched"]
DEVICES = {
    "auto": "by its input and its loops",
    "displacement": "the force follows the displacement, as of friction, metal and rubber",
    "viscous": "the force follows the velocity, as of oil",
    "switched": "a voltage or a current sets the force, as of a magnetorheological fluid",
}
OF_ALL = frozenset({"displacement", "viscous", "switched"})
DEVICES_WITH = {
    "damping_ratio": frozenset({"displacement"}),
    "loss_factor": frozenset({"displacement"}),
    "second_slope": frozenset({"displacement"}),
    "characteristic_strength": frozenset({"displacement", "switched"}),
    "storage_stiffness": frozenset({"displacement", "switched"}),
    "viscous_coefficient": frozenset({"viscous", "switched"}),
}
"""The figures that not every kind of device has, and the kinds that have them."""
THIRD = 3  # the cycle with which the others of a level are compared
FURTHER = (
    0.02  # of the largest displacement: a turning point that goes so much further than all before is on the backbone
)
SAME_SPEED = 0.02  # relative: points of a force-speed curve that are one


@dataclass(frozen=True)
class CycleOptions(Options):
    """Options of `cycles`."""

    device: Annotated[str, Choices(DEVICES), "Kind of the device, which decides what figures it has"] = "auto"
    # below a fifth the equivalent damping is above 2.5 and tells nothing
    least_stiffness: Annotated[
        float,
        Quantity("", low=0, high=1),
        ShownIn("%"),
        "Force at the largest displacements, of the largest force, below which a device without an input counts as viscous",
    ] = 0.2
    # pi times a stroke of 100 mm at 10, 25, 50, 100 and 200 turns a minute
    speeds: Annotated[
        tuple[float, ...],
        Quantity("m/s", low=0, open_low=True),
        ShownIn("mm/s"),
        Terminal("--speed"),
        "Speeds at which forces are told, between those that were measured; may be given several times",
    ] = (0.052, 0.131, 0.262, 0.524, 1.047)
    gas_force: Annotated[
        float | None,
        Quantity("N"),
        "Gas force at mid-stroke, taken from forces at a speed; without it that of a record of rests, where there is one",
    ] = None
    unit_system: Annotated[
        str, Choices(UNIT_SYSTEMS), Terminal("--units"), "Units of the tables and of the axes of figures"
    ] = "mm-N"


@dataclass(frozen=True)
class HalfCycleFigures:
    """Of a half cycle, SI: from its ``start`` to its ``stop`` (s) the motion goes out to its furthest point, and back where
    cycles are cut at the position in which the motion began.

    ``displacement`` is that of the furthest point from the middle of the motion, with the force there; ``largest_force`` is the
    largest in the direction of the way out; both as recorded. ``secant_stiffness`` is by the force from the middle between the
    record's largest and least, ``energy`` the work of that force over the half cycle, stored energy included.
    """

    number: int
    level: int
    extension: bool
    start: float
    stop: float
    displacement: float
    force_at_displacement: float
    largest_force: float
    secant_stiffness: float
    energy: float


@dataclass(frozen=True)
class LevelFigures:
    """Means over the cycles of a level, SI: the motion and the peak-velocity pick-up (`dampyr.records.cycle_table`), forces as
    recorded."""

    number: int
    cycles: int
    stroke: float
    frequency: float
    speed_out: float
    force_out: float
    speed_in: float
    force_in: float


@dataclass(frozen=True, repr=False)
class RecordFigures(Shown):
    """What a record shows, SI.

    ``device`` is the kind that decides on figures; ``travel`` (m) and ``total_energy`` (J) count from the start of the record
    to the end of each cycle, ``whole_travel`` and ``whole_energy`` to its end. A test with rising or falling strokes has
    ``half_cycles`` and a ``backbone``, displacements in m and forces in N ``(k, 2)``, others have none. ``switches`` are
    the responses to steps of the input; ``gas_force``, N, of a record of rests is that at the middle of its stroke.
    """

    record: Record
    device: Device
    cycles: tuple[DeviceFigures, ...]
    levels: tuple[LevelFigures, ...]
    travel: tuple[float, ...]
    total_energy: tuple[float, ...]
    whole_travel: float
    whole_energy: float
    half_cycles: tuple[HalfCycleFigures, ...]
    backbone: Array
    switches: tuple[StepResponse, ...]
    gas_force: float | None

    @property
    def setting(self) -> str:
        """The input, such as "1.98 V"; empty where it varies or there is none."""
        value = self.record.input_channel
        return input_text(value, str(self.record.input)) if isinstance(value, float) else ""

    def figure(self, cycle: DeviceFigures, name: str) -> float | None:
        """A figure of a cycle by its name; None where this kind of device, or this cycle, does not have it."""
        value = float(getattr(cycle, name))
        return value if self.device in DEVICES_WITH.get(name, OF_ALL) and np.isfinite(value) else None

    def fade(self, cycle: DeviceFigures, name: str) -> float | None:
        """How far a figure of a cycle is from that of the third one of its level, relative to it; None without a third."""
        thirds = [c for c in self.cycles if c.level == cycle.level and c.in_level == THIRD]
        return float(getattr(cycle, name) / getattr(thirds[0], name) - 1.0) if thirds else None

    def loop(self, cycle: DeviceFigures) -> tuple[Array, Array]:
        """Displacement and force of a cycle, from its start to its end."""
        return loop_between(self.record, cycle.start, cycle.stop)


@dataclass(frozen=True)
class SpeedForce:
    """The force of a specimen at one setting and one ``speed`` (m/s, positive) in each direction, N: as recorded, the ones in
    compression negative. None where no slower or no faster motion was measured."""

    specimen: str
    setting: str
    speed: float
    extension: float | None
    compression: float | None
    gas_force: float | None

    @property
    def ratio(self) -> float | None:
        """The asymmetry: extension over compression without the gas force; None where that is not known."""
        if self.extension is None or self.compression is None or self.gas_force is None:
            return None
        out, back = self.extension - self.gas_force, self.gas_force - self.compression
        return out / back if out > 0.0 and back > 0.0 else None


@dataclass(frozen=True)
class SettingForce:
    """The force of a specimen at one ``speed`` (m/s) and one input ``value`` among others, N.

    ``direction`` is "extension" or "compression" where the gas force is known, which is taken off, else "both": half of the
    difference, in which it cancels. ``share`` is that of the way from the force at the lowest input to that at the highest,
    ``dynamic_range`` the force over that at the lowest.
    """

    specimen: str
    speed: float
    direction: Literal["extension", "compression", "both"]
    input: str
    value: float
    force: float
    share: float
    dynamic_range: float


@dataclass(frozen=True, repr=False)
class CycleFigures(Shown):
    """The figures of records, in their order, and of the devices that they are of."""

    records: tuple[RecordFigures, ...]
    options: CycleOptions
    origin: Origin
    findings: tuple[Finding, ...]

    def __len__(self) -> int:
        return len(self.records)

    def __iter__(self) -> Iterator[RecordFigures]:
        return iter(self.records)

    def __getitem__(self, k: int) -> RecordFigures:
        return self.records[k]

    @property
    def cycles(self) -> list[DeviceFigures]:
        """The full cycles of all records."""
        return [cycle for figures in self.records for cycle in figures.cycles]

    @cached_property
    def gas_forces(self) -> dict[str, float]:
        """Specimen -> gas force at mid-stroke, N: that of the options, else that of the specimen's record of rests."""
        names = dict.fromkeys(_specimen(figures) for figures in self.records)
        if self.options.gas_force is not None:
            return dict.fromkeys(names, self.options.gas_force)
        return {_specimen(figures): figures.gas_force for figures in self.records if figures.gas_force is not None}

    @cached_property
    def measured_speeds(self) -> tuple[SpeedForce, ...]:
        """The force at the peak velocities of every level, by specimen and setting in the order of speeds; none of records of
        rests, nor of an input that varies."""
        found = [
            SpeedForce(
                _specimen(figures), figures.setting, 0.5 * (level.speed_out - level.speed_in), level.force_out, level.force_in,
                self.gas_forces.get(_specimen(figures)),
            )
            for figures in self.records
            if figures.setting or figures.record.input not in INPUTS
            for level in figures.levels
        ]  # fmt: skip
        order = list(dict.fromkeys((force.specimen, force.setting) for force in found))
        return tuple(sorted(found, key=lambda force: (order.index((force.specimen, force.setting)), force.speed)))

    @cached_property
    def standard_speeds(self) -> tuple[SpeedForce, ...]:
        """The force at the speeds of the options, by straight lines between measured ones; never beyond them."""
        groups = groupby(self.measured_speeds, key=lambda force: (force.specimen, force.setting))
        return tuple(
            SpeedForce(specimen, setting, speed, *_between(points, speed), self.gas_forces.get(specimen))
            for (specimen, setting), group in groups
            for points in [list(group)]
            for speed in self.options.speeds
        )

    @cached_property
    def settings(self) -> tuple[SettingForce, ...]:
        """The force over the input, at each speed of the options that was met at two inputs or more; where there is none, at
        the middle of the speeds that were met at all inputs."""
        found: list[SettingForce] = []
        inputs = {
            (_specimen(figures), figures.setting): (str(figures.record.input), float(figures.record.input_value or 0.0))
            for figures in self.records
            if figures.setting
        }
        for specimen in dict.fromkeys(name for name, _ in inputs):
            curves = {
                inputs[specimen, setting]: list(group)
                for (name, setting), group in groupby(
                    self.measured_speeds, key=lambda force: (force.specimen, force.setting)
                )
                if name == specimen and setting
            }
            if len({kind for kind, _ in curves}) != 1 or len(curves) < 2:
                continue
            low, high = max(c[0].speed for c in curves.values()), min(c[-1].speed for c in curves.values())
            speeds = [s for s in self.options.speeds if sum(_between(c, s)[0] is not None for c in curves.values()) > 1]
            for speed in speeds or ([0.5 * (low + high)] if low <= high else []):
                met = {
                    known: both for known, c in sorted(curves.items()) if (both := _between(c, speed))[0] is not None
                }
                found += _over_input(specimen, speed, met, self.gas_forces.get(specimen))
        return tuple(found)


@takes(CycleOptions)
def cycles(records: RecordsOrPaths, options: CycleOptions | None = None, **keywords: Any) -> CycleFigures:
    """The figures of every full cycle of records, or of those in files and folders, and what they say of the device.

    Measured inputs that are constant but for noise count as constants (`dampyr.records.nominal_inputs`).

    Raises
    ------
    InputError
        There is no record, or an option is wrong. A record without a full cycle has none, and a finding says so.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> t = np.linspace(0.0, 3.0, 1201)
    >>> x = 0.01 * np.sin(2 * np.pi * t)
    >>> bilinear = dp.models.Damper("bilinear", {"Q": 900.0, "uy": 0.001, "k2": 1e5})
    >>> record = dp.records.Record(t, x, bilinear.force(t, x), no_input=True)
    >>> cycle = dp.records.cycles(record)[0].cycles[-1]
    >>> print(f"{cycle.energy:.3g} J, {cycle.effective_stiffness:.3g} N/m, {100 * cycle.damping_ratio:.3g} %")
    32.4 J, 1.9e+05 N/m, 27.1 %
    """
    chosen = CycleOptions.of("cycles", options, keywords)
    given = as_records(records)
    check_kinds("cycles", Argument("records", given, (Record,), RECORDS, several=True))
    tested = list(given)
    if not tested:
        raise InputError("cycles() needs a record; give one or several")
    if len({record.input for record in tested}) == 1:  # those of one kind alone can be compared
        tested = nominal_inputs(tested)
    figures = tuple(_figures(record, chosen) for record in tested)
    found = worst_first(handed_on(tested), (finding for each in figures for finding in _notes(each, chosen)))
    return CycleFigures(figures, chosen, combined(record.origin for record in tested), found)


def _figures(record: Record, options: CycleOptions) -> RecordFigures:
    cut, gas_force = cut_cycles(record), _gas_force(record)
    whole: tuple[DeviceFigures, ...] = ()
    if gas_force is None:  # else a staircase from rest to rest
        with suppress(InputError):  # without a cycle
            whole = tuple(device_figures(record))
    ends = np.array([cycle.stop for cycle in whole])
    travel, energy = _cumulative(record)
    return RecordFigures(
        record=record,
        device=_device(record, whole, options),
        cycles=whole,
        levels=_level_figures(record, cut) if whole else (),
        travel=tuple(np.interp(ends, record.time, travel).tolist()),
        total_energy=tuple(np.interp(ends, record.time, energy).tolist()),
        whole_travel=float(travel[-1]),
        whole_energy=float(energy[-1]),
        half_cycles=_half_cycles(record, cut) if whole and cut.graded else (),
        backbone=_backbone(record, cut) if whole and cut.graded else np.zeros((0, 2)),
        switches=_switches(record),
        gas_force=gas_force,
    )


def _device(record: Record, cycles: Sequence[DeviceFigures], options: CycleOptions) -> Device:
    if options.device != "auto":
        return options.device  # type: ignore[return-value]
    if record.input in INPUTS:
        return "switched"
    stiff = not cycles or np.median([cycle.stiffness_share for cycle in cycles]) >= options.least_stiffness
    return "displacement" if stiff else "viscous"


def _notes(figures: RecordFigures, options: CycleOptions) -> list[Finding]:
    """What a person should know of the figures of a record."""
    about = (figures.record.name,)
    if figures.gas_force is not None:
        words = f"a record of rests: it gives a gas force of {figures.gas_force:.4g} N and no figures of cycles"
        return [Finding("note", words, about)]
    if not figures.cycles:
        return [Finding("note", "no full cycle, so that there are no figures of cycles", about)]
    share = float(np.median([cycle.stiffness_share for cycle in figures.cycles]))
    if figures.device == "displacement" and share < options.least_stiffness:
        words = f"the force at the largest displacements is {100 * share:.2g} % of the largest force, less than "
        return [
            Finding(
                "doubt", f"{words}{100 * options.least_stiffness:.2g} %: an equivalent damping tells nothing", about
            )
        ]
    return []


def _cumulative(record: Record) -> tuple[Array, Array]:
    """The way, m, and the work of the force about its mean, J, up to every sample. The way counts between turning points: noise
    and the steps of an encoder add none."""
    x = record.displacement
    corners = np.unique(np.r_[0, fine_turning_points(record), record.n - 1])
    legs = np.r_[0.0, np.cumsum(np.abs(np.diff(x[corners])))]
    last = np.searchsorted(corners, np.arange(record.n), side="right") - 1
    way = legs[last] + np.abs(x - x[corners[last]])
    return way, np.r_[0.0, np.cumsum(work_of_steps(x, record.force - np.mean(record.force)))]


def _level_figures(record: Record, cut: Cut) -> tuple[LevelFigures, ...]:
    table = [cycle for cycle in cycle_table(record, 0.0, cut) if cycle.level]
    found = []
    for number, group in groupby(table, key=lambda cycle: cycle.level):
        level = list(group)
        names = ("stroke_m", "period_s", "speed_out", "force_out", "speed_in", "force_in")
        means = {name: float(np.mean([getattr(cycle, name) for cycle in level])) for name in names}
        stroke, period = means.pop("stroke_m"), means.pop("period_s")
        found.append(LevelFigures(number, len(level), stroke, 1.0 / period, **means))
    return tuple(found)


def _middle(record: Record, cut: Cut) -> float:
    """The position in which a motion began, or the middle of one that began at a turning point, m."""
    x = record.displacement
    if cut.begins_in_the_middle and cut.half_cycles:
        return float(np.interp(cut.half_cycles[0].start_s, record.time, x))
    turns = x[fine_turning_points(record)]
    return 0.5 * float(turns.max() + turns.min())


def _half_cycles(record: Record, cut: Cut) -> tuple[HalfCycleFigures, ...]:
    middle, mean = _middle(record, cut), 0.5 * float(record.force.max() + record.force.min())
    return tuple(
        _half_cycle(half, *loop_between(record, half.start_s, half.stop_s), middle, mean) for half in cut.half_cycles
    )


def _half_cycle(half: CutCycle, x: Array, force: Array, middle: float, mean: float) -> HalfCycleFigures:
    furthest = int(np.argmax(np.abs(x - x[0])))
    extension = bool(x[furthest] > x[0])
    displacement, at = float(x[furthest]) - middle, float(force[furthest])
    return HalfCycleFigures(
        number=half.number,
        level=half.level,
        extension=extension,
        start=half.start_s,
        stop=half.stop_s,
        displacement=displacement,
        force_at_displacement=at,
        largest_force=float(force.max() if extension else force.min()),
        secant_stiffness=(at - mean) / displacement,
        energy=path_work(x, force - mean),
    )


def _backbone(record: Record, cut: Cut) -> Array:
    """Displacement from the middle and force, as recorded, of the turning points that go further than all before in their
    direction, and of the end of the motion where that does; from the least displacement to the largest."""
    middle, x = _middle(record, cut), record.displacement
    furthest = {1.0: 0.0, -1.0: 0.0}
    further = FURTHER * float(np.max(np.abs(x - middle)))
    points = []
    for k in (*fine_turning_points(record), record.n - 1):
        away = float(x[k]) - middle
        side = 1.0 if away > 0.0 else -1.0
        if abs(away) > furthest[side] + further:
            furthest[side] = abs(away)
            points.append((away, float(record.force[k])))
    return np.array(sorted(points)).reshape(-1, 2)


def _switches(record: Record) -> tuple[StepResponse, ...]:
    try:
        return tuple(response_times(record))
    except InputError:  # the input has no step
        return ()


def _gas_force(record: Record) -> float | None:
    try:
        curve = gas_force_curve(record)
    except InputError:  # no record of rests
        return None
    return curve.at(0.5 * float(record.displacement.max() + record.displacement.min()))


def _specimen(figures: RecordFigures) -> str:
    return figures.record.specimen or ""


def _between(points: Sequence[SpeedForce], speed: float) -> tuple[float | None, float | None]:
    """The forces in extension and compression at a speed, by straight lines; those at one speed are averaged."""
    groups: list[list[SpeedForce]] = []
    for point in points:
        if groups and point.speed <= (1.0 + SAME_SPEED) * groups[-1][0].speed:
            groups[-1].append(point)
        else:
            groups.append([point])
    speeds = np.array([np.mean([point.speed for point in group]) for group in groups])
    if not (1.0 - SAME_SPEED) * speeds[0] <= speed <= (1.0 + SAME_SPEED) * speeds[-1]:
        return None, None
    out, back = (
        np.array([np.mean([getattr(point, way) for point in group]) for group in groups])
        for way in ("extension", "compression")
    )
    return float(np.interp(speed, speeds, out)), float(np.interp(speed, speeds, back))


def _over_input(
    specimen: str, speed: float, forces: Mapping[tuple[str, float], tuple[Any, Any]], gas: float | None
) -> list[SettingForce]:
    """The rows of one speed: (kind, value) of the inputs in rising order -> forces in extension and compression."""
    ways: dict[Any, list[float]] = (
        {"both": [0.5 * (out - back) for out, back in forces.values()]}
        if gas is None
        else {
            "extension": [out - gas for out, _ in forces.values()],
            "compression": [gas - back for _, back in forces.values()],
        }
    )
    return [
        SettingForce(
            specimen, speed, way, kind, value, force,
            _ratio(force - values[0], values[-1] - values[0]), _ratio(force, values[0]),
        )
        for way, values in ways.items()
        for (kind, value), force in zip(forces, values, strict=True)
    ]  # fmt: skip


def _ratio(part: float, whole: float) -> float:
    """NaN where the whole is 0, as of a damper that its input does not change."""
    return part / whole if whole else math.nan
