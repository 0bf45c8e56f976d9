"""What a record shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from dampyr.data_frames import column_name
from dampyr.errors import InputError
from dampyr.input_kinds import INPUTS
from dampyr.phrases import extent
from dampyr.records.record import CHANNELS, GROUPS, Record
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.history import history
from dampyr.show.figures.loops import loops
from dampyr.show.plots import Plots, plots

AXES = {
    "displacement": style.DISPLACEMENT,
    "force": style.FORCE,
    "velocity": style.VELOCITY,
    "voltage": style.VOLTAGE,
    "current": style.CURRENT,
    "temperature": style.Axis("temperature", "°C"),
}


@describe.register
def describe_record(record: Record) -> Description:
    """Samples, extents of the channels, input, and what is stated of it."""
    rows = [
        ("samples", f"{record.n}, {record.time[0]:.4g} … {record.time[-1]:.4g} s, every {1e3 * record.dt:.4g} ms"),
        ("displacement", extent(record.displacement, "mm", 1e3)),
    ]
    if record.velocity is not None:
        rows.append(("velocity", extent(record.velocity, "mm/s", 1e3)))
    rows.append(("force", extent(record.force, "N")))
    if record.input in INPUTS:
        rows.append((INPUTS[record.input], extent(record.input_channel, record.input)))
    if record.temperature is not None:
        rows.append(("temperature", extent(record.temperature, "°C")))
    if record.role != "fit":
        rows.append(("role", record.role))
    rows += [(GROUPS[name], getattr(record, name)) for name in GROUPS if getattr(record, name) is not None]
    if record.smoothed is not None:
        rows.append(("smoothed", f"{', '.join(record.smoothed.channels)}, over {record.smoothed.window:.4g} s"))
    if "force" in record.uncertainty:
        force, stroke = record.uncertainty["force"], record.uncertainty.get("displacement")
        words = f"force {force.standard:.2g} N" + (f", displacement {1e6 * stroke.standard:.2g} µm" if stroke else "")
        rows.append(("uncertainty", f"{words} (one sigma)"))
    return Description(
        f"Record {record.name!r}",
        rows,
        figure=lambda: loops(record.displacement, record.velocity, record.force),
        frame=lambda: _channels(record),
    )


def _channels(record: Record) -> DataFrameColumns:
    """One row a sample, one column a channel, named as ``displacement_m``."""
    channels = {name: getattr(record, name) for name in CHANNELS if getattr(record, name) is not None}
    return DataFrameColumns(
        {column_name(name, CHANNELS[name]): np.broadcast_to(v, (record.n,)) for name, v in channels.items()}
    )


@dataclass(frozen=True)
class RecordPlots(Plots):
    """``record.plot.history("force")`` and ``record.plot.loops()``, which is what ``record.plot()`` draws."""

    result: Record

    def history(self, channel: str = "force") -> Any:
        """A channel over time: ``displacement``, ``force``, ``velocity``, ``voltage``, ``current`` or ``temperature``."""
        record = self.result
        values = getattr(record, channel, None) if channel in AXES else None
        if values is None:
            recorded = [name for name in AXES if getattr(record, name) is not None]
            raise InputError(f"{record.name} has no channel {channel!r} to draw; choose from {', '.join(recorded)}")
        samples = np.broadcast_to(values, record.time.shape)
        return style.in_pyplot(
            history, record.time, samples, axis=AXES[channel], title=record.name, origin=record.origin
        )

    def loops(self) -> Any:
        """Force over displacement, and over velocity where the record has one; `dampyr.records.with_velocity` derives one."""
        r = self.result
        return style.in_pyplot(loops, r.displacement, r.velocity, r.force, title=r.name, origin=r.origin)


plots.register(Record, RecordPlots)
