"""What an analysis of residuals shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.identification.fits.residuals import ResidualGroup, Residuals, Trace
from dampyr.input_kinds import ALL_RECORDS, INPUTS, group_name, unit_of
from dampyr.phrases import counted, extent, percent
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.autocorrelation import memory
from dampyr.show.figures.residual_sizes import residual_sizes
from dampyr.show.figures.residual_velocity import residual_velocity
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Table

Array = NDArray[np.float64]
MAX_PANELS = 6  # inputs of a figure: more panels cannot be read


@describe.register
def describe_trace(trace: Trace) -> Description:
    """Samples, extents of the channels and of the residual, and the motion."""
    return Description(
        f"Trace {trace.name!r}",
        [
            ("samples", f"{trace.time.size}, every {1e3 * trace.dt:.4g} ms, input {trace.input_value:.4g} (V or A)"),
            ("displacement", extent(trace.displacement, "mm", 1e3)),
            ("velocity", extent(trace.velocity, "mm/s", 1e3)),
            ("force", extent(trace.force, "N")),
            ("residual", extent(trace.residual, "N")),
            ("motion", f"{1e3 * trace.stroke:.4g} mm peak to peak, {trace.frequency:.4g} Hz"),
        ],
    )


@describe.register
def describe_residuals(residuals: Residuals) -> Description:
    """Size, noise, correlation time and asymmetry of all records, the numbers of each, and the residual over velocity."""
    relative = [record.relative for record in residuals.records]
    return Description(
        "Residuals",
        [
            ("records", f"{len(residuals.records)}, {residuals.samples} samples, effective {residuals.effective:.4g}"),
            ("rms", f"{residuals.whole.rms:.4g} N, of that {residuals.noise:.4g} N noise"),
            ("relative", f"{percent(min(relative))} … {percent(max(relative))} of the force's standard deviation"),
            ("correlation time", f"{residuals.correlation_time:.3g} s"),
            ("asymmetry", f"{residuals.whole.asymmetry:.3g} N"),
            (
                "misfit",
                f"{counted(len(residuals.misfits), 'record')} of {len(residuals.records)}: not noise alone",
            ),
        ],
        tables=[lambda: _table(residuals)],
        figure=lambda: residual_velocity(velocity_bands(residuals)),
        frame=lambda: _columns(residuals),
    )


def _table(residuals: Residuals) -> Table:
    table = Table(
        ("record", "input", "rms", "relative", "noise", "correlation time", "misfit"),
        [
            [r.name, r.input_value, r.rms, 100 * r.relative, r.noise, r.correlation_time, r.misfit]
            for r in residuals.records
        ],
        ("", unit_of(residuals.unit), "N", "%", "N", "s", ""),
    )
    return table if residuals.unit in INPUTS else table.without("input")


def _columns(residuals: Residuals) -> DataFrameColumns:
    """The numbers of each record, SI units."""
    names = {
        "input_value": f"input_{residuals.unit}", "stroke": "stroke_m", "frequency": "frequency_Hz", "samples": "samples",
        "rms": "rms_N", "relative": "relative", "noise": "noise_N", "correlation_time": "correlation_time_s",
        "effective": "effective_samples", "repeats": "repeats", "misfit": "misfit",
    }  # fmt: skip
    if residuals.unit not in INPUTS:
        del names["input_value"]
    columns = {head: [getattr(record, name) for record in residuals.records] for name, head in names.items()}
    return DataFrameColumns(columns, [record.name for record in residuals.records], "record")


def groups_of_a_figure(residuals: Residuals) -> dict[str, ResidualGroup]:
    """The groups by their input while a figure can show that many, else all records as one."""
    if len(residuals.groups) > MAX_PANELS:
        return {ALL_RECORDS: residuals.whole}
    return {group_name(group.input_value, residuals.unit): group for group in residuals.groups}


def velocity_bands(residuals: Residuals) -> dict[str, dict[str, tuple[Array, Array, Array, Array]]]:
    """For each group and branch: velocity m/s, lower quartile, median and upper quartile of the residual N."""
    return {
        name: {branch: (c.velocity, c.lower, c.median, c.upper) for branch, c in group.curves.items()}
        for name, group in groups_of_a_figure(residuals).items()
    }


def sizes_by_input(residuals: Residuals) -> dict[str, tuple[Array, Array, Array, Array]]:
    """For each input the records' inputs, strokes m, frequencies Hz and relative residuals."""
    shown = {}
    for group in residuals.groups:
        members = [r for r in residuals.records if r.name in group.records]
        input_value, stroke, frequency, relative = np.array(
            [(r.input_value, r.stroke, r.frequency, r.relative) for r in members]
        ).T
        shown[group_name(group.input_value, residuals.unit)] = input_value, stroke, frequency, relative
    return shown


@dataclass(frozen=True)
class ResidualPlots(Plots):
    """``residuals.plot.velocity()``, which is what ``residuals.plot()`` draws, ``.memory()`` and ``.sizes()``."""

    result: Residuals

    def velocity(self) -> Any:
        """The residual over the velocity, a panel an input: median and quartiles, before and beyond the stroke's middle."""
        return style.in_pyplot(residual_velocity, velocity_bands(self.result), origin=self.result.origin)

    def memory(self) -> Any:
        """The autocorrelation of each record's residual and their mean, with the correlation time."""
        records = [(record.lags, record.autocorrelation) for record in self.result.records]
        return style.in_pyplot(memory, records, self.result.correlation_time, origin=self.result.origin)

    def sizes(self) -> Any:
        """The residual's rms over the force's spread, over input, stroke and frequency; one point a record."""
        axis = style.input_axis(self.result.unit) if self.result.unit in INPUTS else None
        return style.in_pyplot(residual_sizes, sizes_by_input(self.result), axis, origin=self.result.origin)


plots.register(Residuals, ResidualPlots)
