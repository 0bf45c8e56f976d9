"""What a rig and its armed table show."""

from __future__ import annotations

from dampyr.rig.session import ArmedRig, Rig
from dampyr.show.descriptions import Description, describe
from dampyr.show.rig.settings import limits_of_motion


@describe.register
def describe_rig(rig: Rig) -> Description:
    """How it is connected, how its time passes, its limits, calibration and interlock."""
    calibration = rig.calibration
    process = "this process" if rig.clocked_by_reads else "a process of its own"
    return Description(
        f"Rig {rig.settings.name!r}",
        [
            ("connection", rig.settings.wires.serial or f"simulated in {process}"),
            ("time", "passes while it is read" if rig.clocked_by_reads else "passes by itself"),
            ("limits", limits_of_motion(rig.settings.limits)),
            ("calibration", "none" if calibration is None else f"{calibration.scale:.6g} N/V, {calibration.how}"),
            ("interlock", "on" if rig.interlocked else "off"),
        ],
    )


@describe.register
def describe_table(table: ArmedRig) -> Description:
    """Position and temperature of an armed table."""
    return Description(
        f"ArmedRig {table.rig.settings.name!r}, armed",
        [
            ("position", f"{1e3 * table.position:.4g} mm, {'homed' if table.homed else 'not homed'}"),
            (
                "temperature",
                f"{table.temperature:.4g} °C, {'estimated' if table.rig.warmth.reading is None else 'measured'}",
            ),
        ],
    )
