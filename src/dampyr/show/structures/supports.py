"""What motions of several supports show."""

from __future__ import annotations

from typing import Any

from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures.building import building_response
from dampyr.show.figures.style import ACCELERATION
from dampyr.structures.supports import SupportMotions


@describe.register
def describe_support_motions(motions: SupportMotions) -> Description:
    """Samples, the peak of each support, and the accelerations over time."""
    several = motions.motions
    first = next(iter(several.values()))
    return Description(
        f"SupportMotions {motions.name!r}",
        [
            ("samples", f"{motions.n}, every {1e3 * motions.dt:.4g} ms, {motions.duration:.4g} s"),
            *((support, f"peak {motion.pga:.4g} m/s², {motion.name}") for support, motion in several.items()),
        ],
        figure=lambda: building_response(
            first.time, {name: motion.acceleration for name, motion in several.items()}, axis=ACCELERATION
        ),
        data=lambda: _numbers(motions),
        frame=lambda: DataFrameColumns(
            {"time_s": first.time, **{f"{name}_m_per_s2": motion.acceleration for name, motion in several.items()}}
        ),
    )


def _numbers(motions: SupportMotions) -> dict[str, Any]:
    return {
        "name": motions.name,
        "samples": motions.n,
        "dt_s": motions.dt,
        "peak_acceleration_m_s2": {name: motion.pga for name, motion in motions.motions.items()},
    }
