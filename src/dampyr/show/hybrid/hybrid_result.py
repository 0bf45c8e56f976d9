"""What a hybrid test shows."""

from __future__ import annotations

from typing import Any

import numpy as np

from dampyr.findings import as_dicts
from dampyr.hybrid.hybrid_result import HybridResult
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures.building import building_response
from dampyr.show.table import Cell, Table


@describe.register
def describe_result(result: HybridResult) -> Description:
    """Motion, damper, peaks against the computed ones, tracking and energy, in rows and sentences; the top floor over time."""
    pairs = zip(result.peaks, result.differences, strict=True)
    length = f"{result.time[-1]:.4g} s on a clock {result.clock:g} times slower"
    return Description(
        f"HybridResult of {result.title}",
        [
            ("ground motion", f"scaled to {result.scale:g}, {length}"),
            ("damper", f"{result.input_words}, {np.abs(result.force).max():.4g} N at most"),
            ("peaks", ", ".join(f"{1e3 * peak:.4g} mm ({100 * by:+.2g} %)" for peak, by in pairs)),
            *([] if result.inputs is None else [("input", decided(result))]),
            ("tracking", f"{100 * result.tracking_error:.2g} % rms, {1e3 * result.lag:.2g} ms late"),
            ("energy error", f"{100 * result.energy_error:.2g} % of what the ground put in"),
        ],
        verdict=outcome(result),
        tables=[lambda: peaks_table(result)],
        figure=lambda: building_response(result.time, result.histories(result.displacement.shape[0] - 1)),
        data=lambda: _numbers(result),
        frame=lambda: _histories(result),
    )


def peaks_table(result: HybridResult) -> Table:
    """The peak displacement of each floor, in the test and computed."""
    rows: list[list[Cell]] = [
        [name, 1e3 * hybrid, 1e3 * computed, 100 * difference]
        for name, hybrid, computed, difference in zip(
            result.computed.floors, result.peaks, result.computed.peak_displacement, result.differences, strict=True
        )
    ]
    inputs = f"scaled to {result.scale:g}, {result.input_words}"
    return Table(
        ("floor", result.tested, "computed", "difference"),
        rows,
        ("", "mm", "mm", "%"),
        caption=f"{result.tested.capitalize()} of {result.title}, {inputs}: peak displacements relative to the ground.",
        digits=4,
    )


def decided(result: HybridResult) -> str:
    """What a law asked for, in words."""
    inputs, unit = np.asarray(result.inputs)[:-1], result.input_unit
    changes = int(np.count_nonzero(np.diff(inputs)))
    return f"{inputs.min():.4g} to {inputs.max():.4g} {unit}, {inputs.mean():.4g} {unit} in the mean, {changes} changes"


def outcome(result: HybridResult) -> list[str]:
    """How far the peaks are from the computed ones, and how well the table, or the computed actuator, followed."""
    virtual = result.origin.kind == "virtual"
    worst = int(np.argmax(np.abs(result.differences)))
    name = result.computed.floors[worst]
    floor = f"floor {name}" if name.isdigit() else name
    errors = "the actuator's error and the loop's" if virtual else "the model's error, the table's and the loop's"
    return [
        f"The peaks differ by up to {100 * result.differences[worst]:+.2g} % ({floor}) from the response with the damper's "
        f"model in its place: this is {errors} together.",
        f"The {'computed actuator' if virtual else 'table'} followed what the building wanted to "
        f"{100 * result.tracking_error:.2g} % rms, {1e3 * result.lag:.2g} ms late in the building's time after compensation; "
        f"its errors put {100 * result.energy_error:.2g} % of the ground's energy into the building.",
    ]


def _numbers(result: HybridResult) -> dict[str, Any]:
    """The figures, for JSON; SI units."""
    return {
        "title": result.title,
        "origin": result.origin.as_dict(),
        "scale": result.scale,
        "clock": result.clock,
        "voltage_V": result.voltage,
        "law": result.law,
        "peaks_m": result.peaks.tolist(),
        "computed_peaks_m": result.computed.peak_displacement.tolist(),
        "differences": result.differences.tolist(),
        "peak_force_N": float(np.abs(result.force).max()),
        "computed_peak_force_N": float(result.computed.peak_force[0]),
        "tracking_error": result.tracking_error,
        "lag_s": result.lag,
        "energy_error": result.energy_error,
        "static_force_N": result.static_force,
        "findings": as_dicts(result.findings),
    }


def _histories(result: HybridResult) -> DataFrameColumns:
    """The histories in SI units, one row a step."""
    floors = {f"floor_{name}_m": row for name, row in zip(result.computed.floors, result.displacement, strict=True)}
    return DataFrameColumns(
        {
            "time_s": result.time,
            **floors,
            "target_m": result.target,
            "achieved_m": result.achieved,
            "force_N": result.force,
            **({} if result.inputs is None else {f"input_{result.input_unit}": result.inputs}),
        }
    )
