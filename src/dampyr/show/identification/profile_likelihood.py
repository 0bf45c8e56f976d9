"""What the profile of a coefficient shows."""

from __future__ import annotations

import math
from typing import Any

from dampyr.identification.parameter_uncertainty.profile_likelihood import Profile
from dampyr.show.descriptions import Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.profile import profile_curve
from dampyr.to_json import plain
from dampyr.units import for_people


@describe.register
def describe_profile(profile: Profile) -> Description:
    """The value and its interval; the rise over the value, the parabola of the standard error, the threshold."""
    shown, factor = for_people(profile.unit)
    low, high = (factor * end for end in profile.interval)
    return Description(
        f"Profile {profile.label!r}",
        [
            ("value", f"{factor * profile.value:.4g} {shown}".rstrip()),
            (f"{100 * profile.level:g} % interval", f"{low:.4g} … {high:.4g} {shown}".rstrip()),
            ("sides", profile.reason),
            ("freedom", f"{profile.freedom:.3g}"),
        ],
        figure=lambda: profile_curve(*_drawn(profile)),
        data=lambda: dict(plain(profile)),
    )


def _drawn(profile: Profile) -> tuple[Any, ...]:
    axis = style.parameter_axis(profile.label, profile.unit)
    parabola = (profile.value, profile.standard_error) if math.isfinite(profile.standard_error) else None
    return axis, profile.values, profile.rise, profile.threshold, profile.interval, parabola
