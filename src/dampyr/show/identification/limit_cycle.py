"""What the limit-cycle method shows."""

from __future__ import annotations

from dampyr.identification.limit_cycle_methods.limit_cycle import LimitCycle
from dampyr.phrases import extent
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_limit_cycle(cycle: LimitCycle) -> Description:
    """The parameters, at which points of the loop they were taken, and the loading branch."""
    return Description(
        "LimitCycle, SI where the arguments were",
        [
            ("kx", f"{cycle.kx:.6g} N s/m"),
            ("kw", f"{cycle.kw:.6g} N"),
            ("rho", f"{cycle.rho:.6g} 1/m, {extent(cycle.rho_range, '1/m')} by the choice of x*1"),
            ("a", f"{cycle.a:.6g} N/m"),
            ("x*", f"{cycle.x_star:.4g} m, x*1 {cycle.x_star1:.4g} m"),
            ("branch", f"{len(cycle.x)} samples, {extent(cycle.x, 'm')}, theta {extent(cycle.theta, 'N')}"),
        ],
    )
