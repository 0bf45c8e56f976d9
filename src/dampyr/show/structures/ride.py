"""What the figures of a ride show."""

from __future__ import annotations

from dataclasses import asdict

from dampyr.findings import as_dicts
from dampyr.show.descriptions import Description, describe
from dampyr.structures.ride import RideFigures


@describe.register
def describe_ride_figures(figures: RideFigures) -> Description:
    """What passengers feel, the travel of the suspension, and how the tyre holds to the road."""
    f = figures
    return Description(
        "RideFigures",
        [
            (
                "weighted acceleration",
                f"{f.weighted_acceleration:.3g} m/s² rms by W_k, at most {f.transient:.3g} over 1 s",
            ),
            ("acceleration", f"{f.acceleration:.3g} m/s² rms, peak {f.peak_acceleration:.3g} m/s²"),
            ("vibration dose", f"{f.vibration_dose:.3g} m/s^1.75"),
            ("travel", f"{1e3 * f.travel:.3g} mm rms, peak {1e3 * f.peak_travel:.3g} mm"),
            ("tyre load", f"{f.tyre_load:.4g} N rms, peak {f.peak_tyre_load:.4g} N; static {f.static_load:.4g} N"),
            ("off the road", f"{100.0 * f.off_road:.3g} % of the time"),
        ],
        data=lambda: asdict(f) | {"findings": as_dicts(f.findings)},
    )
