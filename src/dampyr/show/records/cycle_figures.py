"""What the figures of cycles, levels and devices show."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from dampyr.data_frames import column_name
from dampyr.findings import as_dicts
from dampyr.phrases import counted, listing
from dampyr.records.conditioning.velocity import default_bandwidth, differentiate
from dampyr.records.cycle_analysis.cycle_figures import (
    THIRD,
    CycleFigures,
    LevelFigures,
    RecordFigures,
    SpeedForce,
)
from dampyr.records.cycle_analysis.device_figures import DeviceFigures
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.loop_overlay import Loop, Points, curve_overlay, loop_overlay
from dampyr.show.table import Cell, Table
from dampyr.to_json import plain
from dampyr.units import in_system

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Row = dict[str, Any]
WAYS = {True: "extension", False: "compression"}
RECORDS = "Whole records."
SHARED = ("specimen", "input", "device")
NUMBERS = ("number", "level", "in_level")
OF_A_CYCLE = {
    "amplitude": "m",
    "frequency": "Hz",
    "energy": "J",
    "largest_force": "N",
    "peak_out": "N",
    "peak_in": "N",
    "zero_out": "N",
    "zero_in": "N",
    "effective_stiffness": "N/m",
    "damping_ratio": "",
    "loss_factor": "",
    "storage_stiffness": "N/m",
    "loss_stiffness": "N/m",
    "viscous_coefficient": "N s/m",
    "characteristic_strength": "N",
    "second_slope": "N/m",
}
"""The figures of a cycle in JSON and data frames, with their SI units."""


@describe.register
def describe_record_figures(figures: RecordFigures) -> Description:
    """The kind of the device, its cycles, and the means of their energy and stiffness."""
    cycles = figures.cycles
    rows = [
        ("device", figures.device),
        ("cycles", f"{len(cycles)} full, {len(figures.half_cycles)} half ones of a test with rising or falling strokes"
         if figures.half_cycles else f"{len(cycles)} full"),
        ("in all", f"{figures.whole_travel:.4g} m, {figures.whole_energy:.4g} J"),
    ]  # fmt: skip
    if cycles:
        rows.insert(2, ("energy", f"{np.mean([cycle.energy for cycle in cycles]):.4g} J per cycle"))
    return Description(f"RecordFigures {figures.record.name!r}", rows, data=lambda: _record_numbers(figures))


@describe.register
def describe_cycle_figures(result: CycleFigures) -> Description:
    """How many records and cycles; tables of levels, cycles, half cycles, speeds, inputs and steps; loops over one another."""
    cycles = result.cycles
    rows = [("records", str(len(result))), ("full cycles", str(len(cycles)))]
    if cycles:
        energies = [cycle.energy for cycle in cycles]
        rows.append(("energy", f"{min(energies):.4g} to {max(energies):.4g} J per cycle"))
    kinds = dict.fromkeys(figures.device for figures in result)
    rows.append(("device", listing(list(kinds))))
    return Description(
        f"CycleFigures of {listing([figures.record.name for figures in result], 3)}",
        rows,
        tables=[partial(TABLES[name], result) for name in table_names(result)],
        figure=lambda: overlay(result),
        data=lambda: _numbers(result),
        frame=lambda: _columns(result),
    )


def level_table(result: CycleFigures) -> Table:
    """A row for each level of each record: the motion, and the means of its cycles' figures."""
    rows: list[Row] = []
    for figures in result:
        for level in figures.levels:
            cycles = [cycle for cycle in figures.cycles if cycle.level == level.number]
            names = ("energy", "effective_stiffness", "damping_ratio", "loss_factor", "characteristic_strength")
            means = {name: _mean([figures.figure(cycle, name) for cycle in cycles]) for name in names}
            rows.append(
                _of(figures) | {
                    "device": figures.device, "level": level.number, "cycles": level.cycles, "stroke": level.stroke,
                    "frequency": level.frequency, "energy": means["energy"],
                    "effective stiffness": means["effective_stiffness"], "equivalent damping": means["damping_ratio"],
                    "loss factor": means["loss_factor"], "characteristic strength": means["characteristic_strength"],
                }
            )  # fmt: skip
    units = {"stroke": "m", "frequency": "Hz", "energy": "J", "effective stiffness": "N/m", "equivalent damping": "%",
             "characteristic strength": "N"}  # fmt: skip
    return _table(result, "Means of the cycles of each level.", rows, units)


def cycle_table(result: CycleFigures) -> Table:
    """A row for each full cycle: energy, stiffnesses, damping."""
    rows = [
        _of(figures) | _place(cycle) | {
            "stroke": 2.0 * cycle.amplitude,
            "frequency": cycle.frequency,
            "energy": cycle.energy,
            "effective stiffness": cycle.effective_stiffness,
            "equivalent damping": figures.figure(cycle, "damping_ratio"),
            "storage stiffness": figures.figure(cycle, "storage_stiffness"),
            "loss factor": figures.figure(cycle, "loss_factor"),
            "characteristic strength": figures.figure(cycle, "characteristic_strength"),
            "second slope": figures.figure(cycle, "second_slope"),
        }
        for figures in result
        for cycle in figures.cycles
    ]  # fmt: skip
    units = {"stroke": "m", "frequency": "Hz", "energy": "J", "effective stiffness": "N/m", "equivalent damping": "%",
             "storage stiffness": "N/m", "characteristic strength": "N", "second slope": "N/m"}  # fmt: skip
    return _table(result, "Every full cycle.", rows, units)


def force_table(result: CycleFigures) -> Table:
    """A row for each full cycle: forces as recorded, against the third of its level, and what adds up."""
    rows = [
        _of(figures) | _place(cycle) | {
            "largest force": cycle.peak_out,
            "least force": cycle.peak_in,
            "at middle, extension": figures.figure(cycle, "zero_out"),
            "at middle, compression": figures.figure(cycle, "zero_in"),
            "energy against third": _rounded(figures.fade(cycle, "energy")),
            "force against third": _rounded(figures.fade(cycle, "largest_force")),
            "travel": travel,
            "energy so far": energy,
        }
        for figures in result
        for cycle, travel, energy in zip(figures.cycles, figures.travel, figures.total_energy, strict=True)
    ]  # fmt: skip
    units = {"largest force": "N", "least force": "N", "at middle, extension": "N", "at middle, compression": "N",
             "energy against third": "%", "force against third": "%", "travel": "m", "energy so far": "J"}  # fmt: skip
    notes = [
        "Forces as recorded; travel and energy from the start of the record to the end of the cycle, run-in included."
    ]
    return _table(result, "Forces of every full cycle.", rows, units, notes)


def stiffness_table(result: CycleFigures) -> Table:
    """A row for each level: the complex stiffness, the median of its cycles."""
    rows: list[Row] = []
    for figures in result:
        for level in figures.levels:
            cycles = [cycle for cycle in figures.cycles if cycle.level == level.number]
            storage, loss, dynamic, viscous = (
                float(np.median([getattr(cycle, name) for cycle in cycles]))
                for name in ("storage_stiffness", "loss_stiffness", "dynamic_stiffness", "viscous_coefficient")
            )
            rows.append(
                _of(figures) | {
                    "level": level.number, "frequency": level.frequency, "amplitude": 0.5 * level.stroke,
                    "dynamic stiffness": dynamic, "storage": storage, "loss": loss,
                    "loss angle": float(np.degrees(np.arctan2(loss, storage))), "viscous coefficient": viscous,
                }
            )  # fmt: skip
    units = {"frequency": "Hz", "amplitude": "m", "dynamic stiffness": "N/m", "storage": "N/m", "loss": "N/m",
             "loss angle": "°", "viscous coefficient": "N s/m"}  # fmt: skip
    note = "By first harmonics, the median of the cycles of a level; the loss angle of a spring is 0°, that of a dashpot 90°."
    return _table(result, "Complex stiffness.", rows, units, [note])


def half_cycle_table(result: CycleFigures) -> Table:
    """A row for each half cycle of tests with rising or falling strokes."""
    rows = [
        _of(figures) | {
            "half cycle": half.number, "level": half.level or None, "direction": WAYS[half.extension],
            "displacement": half.displacement, "force there": half.force_at_displacement, "largest force": half.largest_force,
            "secant stiffness": half.secant_stiffness, "work": half.energy,
        }
        for figures in result
        for half in figures.half_cycles
    ]  # fmt: skip
    units = {"displacement": "m", "force there": "N", "largest force": "N", "secant stiffness": "N/m", "work": "J"}
    note = "The work of a half cycle holds what is stored at its end: only that of a full cycle is dissipated."
    return _table(result, "Half cycles.", rows, units, [note])


def backbone_table(result: CycleFigures) -> Table:
    """The points of the backbone of tests with rising strokes."""
    rows = [
        _of(figures) | {"displacement": displacement, "force": force}
        for figures in result
        for displacement, force in figures.backbone.tolist()
    ]
    note = "The turning points that go further than all before in their direction: the first cycle of each level."
    return _table(result, "Backbone.", rows, {"displacement": "m", "force": "N"}, [note])


def measured_speed_table(result: CycleFigures) -> Table:
    """The force at the peak velocities that were measured."""
    return _speed_table(result, result.measured_speeds, "Force at peak velocity, mean of the cycles of a level.")


def standard_speed_table(result: CycleFigures) -> Table:
    """The force at the speeds that are asked for."""
    note = "By straight lines between measured speeds; speeds that are lower or higher than all measured ones are left out."
    return _speed_table(
        result,
        [point for point in result.standard_speeds if point.extension is not None],
        "Force at standard speeds.",
        [note],
    )


def _speed_table(result: CycleFigures, points: Sequence[SpeedForce], caption: str, notes: Sequence[str] = ()) -> Table:
    rows: list[Row] = []
    for point in points:
        row = {"specimen": point.specimen, "input": point.setting, "speed": point.speed, "extension": point.extension,
               "compression": point.compression}  # fmt: skip
        gas = point.gas_force
        if gas is not None:
            row |= {
                "gas force": gas,
                "extension without": None if point.extension is None else point.extension - gas,
                "compression without": None if point.compression is None else point.compression - gas,
            }
        rows.append(row | {"extension over compression": point.ratio})
    forces = ("extension", "compression", "gas force", "extension without", "compression without")
    units = {"speed": "m/s"} | dict.fromkeys(forces, "N")
    ratio = "The ratio is that of the magnitudes without the gas force."
    if not result.gas_forces:
        ratio = (
            "No gas force is known, so that there is no ratio: add a record of rests at several places, or give one."
        )
    return _table(result, caption, rows, units, [*notes, ratio])


def setting_table(result: CycleFigures) -> Table:
    """The force over the input at one speed, its share of the way from softest to hardest, and the dynamic range."""
    rows = [
        {
            "specimen": force.specimen, "speed": force.speed, "direction": force.direction,
            f"input [{force.input}]": force.value, "force": force.force, "share of range": force.share,
            "over softest": force.dynamic_range,
        }
        for force in result.settings
    ]  # fmt: skip
    units = {"speed": "m/s", "force": "N", "share of range": "%"}
    notes = [
        "Over softest: over the force at the lowest input; at the highest one it is the dynamic range.",
        "Both: half of the difference between extension and compression, since no gas force is known.",
    ]
    return _table(result, "Force over the input.", rows, units, notes[: 1 if result.gas_forces else 2])


def switch_table(result: CycleFigures) -> Table:
    """The response to each step of the input."""
    rows = [
        _of(figures) | {
            "step": switch.step, "direction": WAYS[switch.extension], "speed": switch.speed, "from": switch.force_before,
            "to": switch.force_after, "dead time": _ms(switch.dead_time), "t63": _ms(switch.t63), "t90": _ms(switch.t90),
            "settled": _ms(switch.settled), "why not": switch.reason,
        }
        for figures in result
        for switch in figures.switches
    ]  # fmt: skip
    units = {"speed": "m/s", "from": "N", "to": "N"} | dict.fromkeys(("dead time", "t63", "t90", "settled"), "ms")
    return _table(result, "Responses to steps of the input.", rows, units)


def record_table(result: CycleFigures) -> Table:
    """What adds up over whole records, and the gas force of those of rests."""
    rows = [
        _of(figures) | {
            "device": figures.device, "full cycles": len(figures.cycles), "travel": figures.whole_travel,
            "energy": figures.whole_energy, "gas force": figures.gas_force,
        }
        for figures in result
    ]  # fmt: skip
    return _table(result, RECORDS, rows, {"travel": "m", "energy": "J", "gas force": "N"})


TABLES: Mapping[str, Callable[[CycleFigures], Table]] = {
    "records": record_table,
    "levels": level_table,
    "cycles": cycle_table,
    "forces": force_table,
    "complex-stiffness": stiffness_table,
    "half-cycles": half_cycle_table,
    "backbone": backbone_table,
    "speeds": measured_speed_table,
    "standard-speeds": standard_speed_table,
    "inputs": setting_table,
    "steps": switch_table,
}
"""The tables by the names that files and sheets of them have."""


HAS_ROWS: Mapping[str, Callable[[CycleFigures], Any]] = {
    "records": lambda result: True,
    "half-cycles": lambda result: any(figures.half_cycles for figures in result),
    "backbone": lambda result: any(len(figures.backbone) for figures in result),
    "speeds": lambda result: result.measured_speeds,
    "standard-speeds": lambda result: any(point.extension is not None for point in result.standard_speeds),
    "inputs": lambda result: result.settings,
    "steps": lambda result: any(figures.switches for figures in result),
}
"""Whether a table has something to say; those that are not here have it where there is a full cycle."""


def table_names(result: CycleFigures) -> list[str]:
    """The names of the tables that have something to say."""
    return [name for name in TABLES if HAS_ROWS.get(name, lambda result: result.cycles)(result)]


def named_tables(result: CycleFigures) -> dict[str, Table]:
    """The tables that have something to say, by their names."""
    return {name: TABLES[name](result) for name in table_names(result)}


def _of(figures: RecordFigures) -> Row:
    record = figures.record
    return {"record": record.name, "specimen": record.specimen, "input": figures.setting}


def _place(cycle: DeviceFigures) -> Row:
    return {"level": cycle.level, "cycle": cycle.number}


def _mean(values: Sequence[float | None]) -> float | None:
    numbers = [value for value in values if value is not None]
    return float(np.mean(numbers)) if numbers else None


def _rounded(fade: float | None) -> float | None:
    """Without what arithmetic leaves of none."""
    return None if fade is None else round(fade, 6)


def _ms(seconds: float | None) -> float | None:
    return None if seconds is None else 1e3 * seconds


def _table(
    result: CycleFigures, caption: str, rows: Sequence[Row], units: Mapping[str, str], notes: Sequence[str] = ()
) -> Table:
    """A table of rows in SI, in the units of the result's options; a column that holds nothing is left out."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    filled = [name for name in names if any(row.get(name) not in (None, "") for row in rows)]
    if caption != RECORDS:  # what all records have in common need not stand in every row
        alike = [name for name in SHARED if len({row.get(name) for row in rows}) == 1]
        filled = [name for name in filled if name not in alike and (name != "record" or len(result) > 1)]
    shown = {name: _unit(units.get(name, ""), result.options.unit_system) for name in filled}

    def cell(row: Row, name: str) -> Cell:
        value: Cell = row.get(name)
        return shown[name][1] * value if isinstance(value, float) else None if value == "" else value

    return Table(
        filled,
        [[cell(row, name) for name in filled] for row in rows],
        [shown[name][0] for name in filled],
        caption=caption,
        notes=notes,
        digits=5,
    )


def _unit(unit: str, system: str) -> tuple[str, float]:
    return ("%", 100.0) if unit == "%" else in_system(unit, system)


def axis(words: str, unit: str, result: CycleFigures) -> style.Axis:
    """An axis in the units of the result's options."""
    return style.Axis(words, *in_system(unit, result.options.unit_system))


def overlay(result: CycleFigures) -> Figure | None:
    """The third cycle of each level of each record, or its last one; a colour for each setting, specimen or record."""
    loops: dict[str, list[Loop]] = {}
    for figures in result:
        cycles = [c for level in figures.levels if (c := _shown_cycle(figures, level))]
        if not cycles:
            continue
        record = figures.record
        velocity = differentiate(record.time, record.displacement, default_bandwidth(record))
        for cycle in cycles:
            x, force = figures.loop(cycle)
            inside = (record.time > cycle.start) & (record.time < cycle.stop)
            times = np.r_[cycle.start, record.time[inside], cycle.stop]
            loops.setdefault(label(result, figures), []).append((x, np.interp(times, record.time, velocity), force))
    if not loops:
        return None
    return loop_overlay(
        loops, axis("displacement", "m", result), axis("velocity", "m/s", result), axis("force", "N", result)
    )


def _shown_cycle(figures: RecordFigures, level: LevelFigures) -> DeviceFigures | None:
    cycles = [cycle for cycle in figures.cycles if cycle.level == level.number]
    return cycles[min(THIRD, len(cycles)) - 1] if cycles else None


def label(result: CycleFigures, figures: RecordFigures) -> str:
    """What tells a record from the others: specimen and setting where these differ, else its name."""
    specimens = {other.record.specimen for other in result}
    settings = {other.setting for other in result}
    parts = [
        part
        for part, several in ((figures.record.specimen, len(specimens) > 1), (figures.setting, len(settings) > 1))
        if part and several
    ]
    return ", ".join(parts) or figures.record.name


def speed_figure(result: CycleFigures) -> Figure | None:
    """The force over the speed of each specimen and setting, where two speeds or more were measured."""
    curves: dict[str, list[tuple[list[float], list[float]]]] = {}
    for point in result.measured_speeds:
        name = ", ".join(filter(None, (point.specimen, point.setting))) or "measured"
        out, back = curves.setdefault(name, [([], []), ([], [])])
        for (speeds, forces), sign, force in ((out, 1.0, point.extension), (back, -1.0, point.compression)):
            if force is not None:
                speeds.append(sign * point.speed)
                forces.append(force)
    if not any(len(out) > 1 for (out, _), _ in curves.values()):
        return None
    return curve_overlay(curves, axis("velocity", "m/s", result), axis("force", "N", result))


def energy_figure(result: CycleFigures) -> Figure | None:
    """The energy of each cycle by its number."""
    curves: dict[str, list[Points]] = {}
    for figures in result:
        if len(figures.cycles) > 1:
            points = [cycle.number for cycle in figures.cycles], [cycle.energy for cycle in figures.cycles]
            curves.setdefault(label(result, figures), []).append(points)
    energy = axis("energy", "J", result)
    return curve_overlay(curves, style.Axis("cycle", "number"), energy, zero=True) if curves else None


def backbone_figure(result: CycleFigures) -> Figure | None:
    """The backbones of tests with rising strokes."""
    curves: dict[str, list[Points]] = {}
    for figures in result:
        if len(figures.backbone):
            curves.setdefault(label(result, figures), []).append((figures.backbone[:, 0], figures.backbone[:, 1]))
    return curve_overlay(curves, axis("displacement", "m", result), axis("force", "N", result)) if curves else None


def _cycle_numbers(figures: RecordFigures) -> list[Row]:
    return [
        {name: getattr(cycle, name) for name in NUMBERS}
        | {"start": cycle.start, "stop": cycle.stop}
        | {name: figures.figure(cycle, name) for name in OF_A_CYCLE}
        | {"energy_fade": figures.fade(cycle, "energy"), "force_fade": figures.fade(cycle, "largest_force")}
        | {"travel": travel, "total_energy": energy}
        for cycle, travel, energy in zip(figures.cycles, figures.travel, figures.total_energy, strict=True)
    ]


def _record_numbers(figures: RecordFigures) -> dict[str, Any]:
    record = figures.record
    answer = {
        "record": record.name, "specimen": record.specimen, "input": record.input, "input_value": record.input_value,
        "device": figures.device, "travel": figures.whole_travel, "energy": figures.whole_energy,
        "gas_force": figures.gas_force, "levels": [asdict(level) for level in figures.levels],
        "cycles": _cycle_numbers(figures), "half_cycles": [asdict(half) for half in figures.half_cycles],
        "backbone": figures.backbone, "switches": [asdict(switch) for switch in figures.switches],
    }  # fmt: skip
    return dict(plain(answer))


def _numbers(result: CycleFigures) -> dict[str, Any]:
    """All for JSON, SI units."""
    answer = {
        "origin": result.origin.as_dict(),
        "findings": as_dicts(result.findings),
        "options": result.options.as_keywords(),
        "records": [_record_numbers(figures) for figures in result],
        "gas_forces": result.gas_forces,
        "measured_speeds": [asdict(point) | {"ratio": point.ratio} for point in result.measured_speeds],
        "standard_speeds": [asdict(point) | {"ratio": point.ratio} for point in result.standard_speeds],
        "settings": [asdict(force) for force in result.settings],
    }
    return dict(plain(answer))


def _columns(result: CycleFigures) -> DataFrameColumns:
    """A row for each full cycle, SI units."""
    rows = [{"record": figures.record.name} | row for figures in result for row in _cycle_numbers(figures)]
    units = OF_A_CYCLE | {"start": "s", "stop": "s", "travel": "m", "total_energy": "J"}
    names = list(rows[0]) if rows else ["record", *NUMBERS, *OF_A_CYCLE]
    columns = {column_name(name, units.get(name, "")): [row[name] for row in rows] for name in names}
    return DataFrameColumns(columns)


def in_short(result: CycleFigures) -> str:
    """How many cycles of how many records, and of which devices."""
    kinds = listing(list(dict.fromkeys(figures.device for figures in result)))
    return f"{counted(len(result.cycles), 'full cycle')} of {counted(len(result), 'record')}; device: {kinds}."
