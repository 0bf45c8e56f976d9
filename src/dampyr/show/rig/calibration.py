"""What a calibration shows."""

from __future__ import annotations

from dampyr.rig.calibration import Calibration
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_calibration(calibration: Calibration) -> Description:
    """Scales and zeros of force, displacement and temperature, and where they come from."""
    return Description(
        "Calibration",
        [
            ("force", f"{calibration.scale:.6g} N/V, zero at {calibration.zero:.4g} V"),
            ("displacement", f"{1e6 * calibration.count:.4g} µm a count, middle at {calibration.middle:.6g} counts"),
            ("temperature", f"{calibration.slope:.4g} K/V, {calibration.base:.4g} °C at 0 V"),
            ("from", calibration.how.removeprefix("from ")),
        ],
    )
