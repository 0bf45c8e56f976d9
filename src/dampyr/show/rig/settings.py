"""What the settings of a rig show."""

from __future__ import annotations

from dampyr.rig.settings import Limits, RigSettings
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_settings(settings: RigSettings) -> Description:
    """How the rig is reached, its limits, its parts and the specimen."""
    limits, specimen = settings.limits, settings.specimen
    return Description(
        f"RigSettings {settings.name!r}",
        [
            ("wires", settings.wires.serial or "none: it can only be simulated"),
            ("limits", limits_of_motion(limits)),
            ("", f"{limits.voltage:.4g} V, {limits.temperature:.4g} °C"),
            ("board", f"{settings.board.rate:.6g} Hz in blocks of {1e3 * settings.board.block:.4g} ms"),
            ("load cell", f"{settings.load_cell.capacity:.5g} N, {settings.load_cell.scale:.5g} N/V"),
            ("encoder", f"{1e6 * settings.encoder.count:.4g} µm a count"),
            (
                "actuator",
                f"{1e3 * settings.actuator.free_speed:.4g} mm/s free, {settings.actuator.max_load:.5g} N",
            ),
            (
                "specimen",
                specimen.name or specimen.card or f"the original damper, {specimen.data_sheet or 'no data sheet'}",
            ),
        ],
    )


def limits_of_motion(limits: Limits) -> str:
    """The limits of stroke, speed and force."""
    return f"{1e3 * limits.stroke:.4g} mm peak to peak, {1e3 * limits.speed:.4g} mm/s, {limits.force:.4g} N"
