"""What the figures of a ride show."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from dampyr.findings import as_dicts
from dampyr.show.descriptions import Description, describe
from dampyr.structures.ride import AxleFigures, RideFigures


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
            *([("pitch", f"{f.pitch_acceleration:.3g} rad/s² rms")] if f.pitch_acceleration is not None else []),
            ("vibration dose", f"{f.vibration_dose:.3g} m/s^1.75"),
            ("travel", f"{1e3 * f.travel:.3g} mm rms, peak {1e3 * f.peak_travel:.3g} mm"),
            ("tyre load", f"{f.tyre_load:.4g} N rms, peak {f.peak_tyre_load:.4g} N; static {f.static_load:.4g} N"),
            ("off the road", f"{100.0 * f.off_road:.3g} % of the time"),
            *((f"{name} axle", _axle_in_words(axle)) for name, axle in f.axles.items()),
        ],
        data=lambda: figures_as_dict(f) | {"findings": as_dicts(f.findings)},
    )


def _axle_in_words(axle: AxleFigures) -> str:
    share = 100.0 * axle.tyre_load / axle.static_load
    return f"travel {1e3 * axle.travel:.3g} mm rms; tyre load {axle.tyre_load:.4g} N rms, {share:.3g} % of its weight"


def figures_as_dict(figures: RideFigures) -> dict[str, Any]:
    """The figures by name, SI, without the findings; what is of a half car only where it is one."""
    left_out = ("findings",) if figures.axles else ("findings", "axles", "pitch_acceleration")
    return {name: value for name, value in asdict(figures).items() if name not in left_out}
