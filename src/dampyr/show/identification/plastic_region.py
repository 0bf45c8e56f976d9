"""What the plastic-region method shows."""

from __future__ import annotations

from dampyr.identification.limit_cycle_methods.plastic_region import PlasticRegion
from dampyr.phrases import percent
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_plastic_region(region: PlasticRegion) -> Description:
    """The parameters, and of how many samples and turning points they were made."""
    return Description(
        "PlasticRegion",
        [
            ("kx", f"{1e-3 * region.kx:.4g} N s/mm"),
            ("kw", f"{region.kw:.4g} N"),
            ("rho", f"{1e-3 * region.rho:.4g} 1/mm, standard deviation {1e-3 * region.rho_spread:.3g} 1/mm"),
            ("a", f"{1e-3 * region.a:.4g} N/mm"),
            ("offset", f"{region.offset:.4g} N"),
            ("used", f"{percent(region.share)} of the samples, {region.turning_points} turning points"),
        ],
    )
