"""What the drive of a test shows."""

from __future__ import annotations

from dampyr.phrases import extent
from dampyr.rig.drive import Drive
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures.planned_drive import planned_drive


@describe.register
def describe_drive(drive: Drive) -> Description:
    """Set points, their extents, what is recorded; displacement, velocity and voltage over time."""
    rows = [
        ("set points", f"{drive.n}, every {1e3 * drive.period:.4g} ms, {drive.duration:.4g} s"),
        ("displacement", extent(drive.displacement, "mm", 1e3)),
        ("voltage", extent(drive.voltage, "V")),
    ]
    first, last = drive.record_from, drive.n if drive.record_to is None else drive.record_to
    rows.append(("recorded", f"{first * drive.period:.4g} … {(last - 1) * drive.period:.4g} s"))
    if drive.reversals is not None:
        strokes = f"{drive.reversals.count} strokes of {drive.reversals.half_period:.4g} s"
        rows.append(("reversals", f"{strokes}, duty {drive.reversals.duty:.3g}"))
    if drive.until_temperature is not None:
        rows.append(("until", f"{drive.until_temperature:.4g} °C"))
    return Description(
        "Drive",
        rows,
        figure=lambda: planned_drive(drive.time, drive.displacement, drive.voltage),
        frame=lambda: DataFrameColumns(
            {"time_s": drive.time, "displacement_m": drive.displacement, "voltage_V": drive.voltage}
        ),
    )
