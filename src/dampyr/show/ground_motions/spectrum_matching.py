"""What a motion whose spectrum was matched shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from dampyr.ground_motions.integrals import peak_velocity
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.spectrum_matching import MatchedMotion
from dampyr.phrases import extent
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.response_spectrum import PSEUDO_ACCELERATION, response_spectrum
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEIGHT = 3.7  # inches: the legend has three lines
ROWS = 12  # of the table, evenly spaced among the periods


@describe.register
def describe_matched_motion(matched: MatchedMotion) -> Description:
    """How near the spectrum came, what became of the peaks of the ground, and the spectra before and after."""
    return Description(
        f"MatchedMotion {matched.motion.name!r}",
        [
            ("spectrum", f"{matched.design.name}, {100 * matched.design.damping:g} % damping"),
            ("periods", extent(matched.periods, "s")),
            ("deviation", f"{_percent(matched.residual)} at most, {_percent(matched.mean_residual)} in the mean"),
            ("only scaled", f"{_percent(matched.residual_before)} at most"),
            ("peaks", f"PGA {_change(matched, _pga)}, PGV {_change(matched, _pgv)}"),
            ("Arias", f"{matched.arias_ratio:.3g} times that of the motion that was only scaled"),
            ("steps", str(matched.iterations)),
        ],
        tables=[lambda: matched_table(matched)],
        figure=lambda: matched_figure(matched),
        frame=lambda: DataFrameColumns(_columns(matched)),
        data=lambda: {
            "motion": matched.motion.name,
            "design": matched.design.name,
            "damping": matched.design.damping,
            "converged": matched.converged,
            "tolerance": matched.tolerance,
            "residual": matched.residual,
            "mean_residual": matched.mean_residual,
            "residual_before": matched.residual_before,
            "arias_ratio": matched.arias_ratio,
            "iterations": matched.iterations,
            "dt_s": matched.motion.dt,
            "acceleration_m_per_s2": matched.motion.acceleration,
            **_columns(matched),
        },
    )


def matched_table(matched: MatchedMotion) -> Table:
    """Some of the periods, the spectrum before and after, and the wanted one."""
    chosen = np.unique(np.linspace(0, len(matched.periods) - 1, ROWS).round().astype(int))
    columns = (
        matched.periods,
        matched.before,
        matched.after,
        matched.wanted,
        100 * (matched.after / matched.wanted - 1),
    )
    return Table(
        ("period", "only scaled", "matched", "wanted", "deviation"),
        [[float(column[k]) for column in columns] for k in chosen],
        ("s", "m/s²", "m/s²", "m/s²", "%"),
        caption=f"Pseudo-acceleration beside {matched.design.name}, damping {100 * matched.design.damping:g} %.",
        notes=(f"Some of the {len(matched.periods)} periods that were checked.",),
        digits=3,
    )


def matched_figure(matched: MatchedMotion) -> Figure:
    """The spectra before and after, and the wanted one, over the period."""
    return response_spectrum(matched.periods, _drawn(matched), height=HEIGHT)


def _drawn(matched: MatchedMotion) -> dict[str, Any]:
    return {"only scaled": matched.before, "matched": matched.after, "wanted": matched.wanted}


def _columns(matched: MatchedMotion) -> dict[str, Any]:
    return {
        "period_s": matched.periods,
        "scaled_pseudo_acceleration_m_per_s2": matched.before,
        "pseudo_acceleration_m_per_s2": matched.after,
        "design_acceleration_m_per_s2": matched.wanted,
    }


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"


def _change(matched: MatchedMotion, peak: Any) -> str:
    unit, factor, of = peak
    before, after = (factor * of(motion) for motion in (matched.scaled, matched.motion))
    return f"{after:.3g} {unit} ({before:.3g} only scaled)"


_pga = ("m/s²", 1.0, lambda motion: motion.pga)


def _peak_velocity(motion: GroundMotion) -> float:
    return peak_velocity(np.asarray(motion.acceleration), motion.dt)


_pgv = ("mm/s", 1e3, _peak_velocity)


@dataclass(frozen=True)
class MatchedMotionPlots(Plots):
    """``matched.plot()``."""

    result: MatchedMotion

    def __call__(self) -> Any:
        """The spectra before and after, and the wanted one, over the period; the matplotlib axes ``(1,)``."""
        title = f"{self.result.motion.name}, {self.result.design.name}"
        return style.in_pyplot(
            response_spectrum, self.result.periods, _drawn(self.result), PSEUDO_ACCELERATION, title, HEIGHT
        )


plots.register(MatchedMotion, MatchedMotionPlots)
