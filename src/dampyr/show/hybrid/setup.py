"""What the set-up of a virtual hybrid test shows."""

from __future__ import annotations

from dampyr.hybrid.setup import HybridSetup
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_setup(setup: HybridSetup) -> Description:
    """Place, specimen, actuator and loop."""
    s, t = setup.specimen, setup.transfer
    return Description(
        f"HybridSetup of {setup.structure.name!r}",
        [
            ("place", setup.structure.place_label(setup.place)),
            ("specimen", f"{s.mass:g} kg, {s.stiffness:g} N/m, {s.damping:.4g} N s/m"),
            ("actuator", f"β1 {t.beta1:g} 1/s, β2 {t.beta2:g} 1/s², a3 {t.pole:g} 1/s, at most {t.max_force:g} N"),
            ("loop", f"{setup.rate:g} Hz, the force {setup.force_delay} samples late"),
        ],
    )
