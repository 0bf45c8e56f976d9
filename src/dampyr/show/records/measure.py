"""What the measured values of a record show."""

from __future__ import annotations

from dampyr.records.cycle_analysis.measure import Measured
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_measured(measured: Measured) -> Description:
    """Motion, speed, energy, mean force, drift, harmonics and cycles."""
    orders = ", ".join(f"{k}: {100 * v:.2g} %" for k, v in measured.harmonics.items())
    return Description(
        "Measured",
        [
            ("motion", f"{measured.frequency_hz:.4g} Hz, {1e3 * measured.peak_to_peak_m:.4g} mm peak to peak"),
            ("peak speed", f"{1e3 * measured.peak_speed:.4g} mm/s"),
            ("energy", f"{measured.energy_per_cycle:.4g} J per cycle"),
            ("mean force", f"{measured.mean_force:.4g} N"),
            ("drift", f"{1e3 * measured.drift_m_per_s:.3g} mm/s"),
            ("harmonics", f"{orders}; distortion {100 * measured.distortion:.2g} %"),
            ("cycles", f"{measured.cycles}, from {measured.motion_start:.4g} s"),
        ],
    )
