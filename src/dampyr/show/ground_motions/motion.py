"""What a ground motion shows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from dampyr.ground_motions.intensity_measures import measures
from dampyr.ground_motions.motion import GroundMotion
from dampyr.phrases import sentence
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.ground_histories import ground_histories
from dampyr.show.figures.ground_motion import ground_motion
from dampyr.show.ground_motions.intensity_measures import measures_table
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Table
from dampyr.units import STANDARD_GRAVITY


@describe.register
def describe_motion(motion: GroundMotion) -> Description:
    """Samples, peak, source and history, the intensity measures, and the acceleration over time."""
    rows = [
        ("samples", f"{motion.n}, every {1e3 * motion.dt:.4g} ms, {motion.duration:.4g} s"),
        ("peak", f"{motion.pga:.4g} m/s² ({motion.pga / STANDARD_GRAVITY:.3g} g)"),
        ("source", motion.source),
        ("history", "; ".join(motion.history)),
    ]
    drift = drift_in_words(motion)
    return Description(
        f"GroundMotion {motion.name!r}",
        [row for row in rows if row[1]],
        verdict=[*map(sentence, motion.history), *([sentence(drift)] if drift else [])],
        tables=[lambda: motion_table(motion)],
        figure=lambda: ground_motion(motion.time, motion.acceleration),
        frame=lambda: DataFrameColumns({"time_s": motion.time, "acceleration_m_per_s2": motion.acceleration}),
    )


def motion_table(motion: GroundMotion) -> Table:
    """The intensity measures under the name and the length of the motion."""
    return replace(measures_table(measures(motion)), caption=f"{motion.name}: {samples_in_words(motion)}.")


def samples_in_words(motion: GroundMotion) -> str:
    """How many samples it has, and how long it lasts."""
    return f"{motion.n} samples every {motion.dt:g} s, {motion.duration:g} s"


def drift_in_words(motion: GroundMotion) -> str:
    """That the displacement drifts, where it ends far from where it began; else nothing."""
    d = motion.displacement
    if abs(d[-1]) <= 0.25 * np.abs(d).max() or d[-1] == 0:
        return ""
    return (
        f"the displacement ends at {1e3 * d[-1]:.4g} mm: a raw record drifts, and a baseline correction takes that off "
        "(dampyr motion --baseline)"
    )


@dataclass(frozen=True)
class MotionPlots(Plots):
    """``motion.plot()``."""

    result: GroundMotion

    def __call__(self) -> Any:
        """Acceleration, velocity and displacement over time; the matplotlib axes (3,)."""
        motion = self.result
        return style.in_pyplot(ground_histories, motion.time, motion.acceleration, motion.velocity, motion.displacement)


plots.register(GroundMotion, MotionPlots)
