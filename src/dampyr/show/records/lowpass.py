"""What the noise of a displacement shows."""

from __future__ import annotations

from dampyr.records.conditioning.lowpass import DisplacementNoise
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_noise(noise: DisplacementNoise) -> Description:
    """The noise, how often it goes against the motion, and the low-pass that is proposed."""
    return Description(
        "DisplacementNoise",
        [
            ("noise", f"{1e6 * noise.rms:.3g} um rms"),
            ("against the motion", f"{100 * noise.backward:.2g} % of the samples"),
            ("low-pass", f"{noise.lowpass_hz:.3g} Hz leaves {1e6 * noise.rms_after:.3g} um"),
        ],
    )
