"""What a motion's spectrum beside a design spectrum shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from dampyr.errors import InputError
from dampyr.ground_motions.design_spectra import DesignComparison
from dampyr.phrases import extent
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.response_spectrum import PSEUDO_ACCELERATION, response_spectrum
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Table
from dampyr.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@describe.register
def describe_design_comparison(comparison: DesignComparison) -> Description:
    """Periods, the extents of both spectra and of their ratio, and both over the period."""
    drawable = np.sum(comparison.periods > 0.0) > 1
    return Description(
        f"DesignComparison of {comparison.motion!r} with {comparison.design.name}",
        [
            ("periods", f"{comparison.periods.size}, {extent(comparison.periods, 's')}"),
            ("damping", f"{100 * comparison.design.damping:g} %"),
            ("Sa", f"{extent(comparison.pseudo_acceleration, 'm/s²')} (pseudo-acceleration)"),
            ("design", extent(comparison.design_acceleration, "m/s²")),
            ("ratio", extent(comparison.ratio, "")),
        ],
        tables=[lambda: design_table(comparison)],
        figure=lambda: design_figure(comparison) if drawable else None,
        frame=lambda: DataFrameColumns(_columns(comparison)),
        data=lambda: {"motion": comparison.motion, "design": comparison.design.name, "damping": comparison.design.damping,
                      **_columns(comparison)},
    )  # fmt: skip


def design_table(comparison: DesignComparison) -> Table:
    """One row a period."""
    own, code = comparison.pseudo_acceleration, comparison.design_acceleration
    columns = (comparison.periods, own, code, own / STANDARD_GRAVITY, code / STANDARD_GRAVITY, comparison.ratio)
    return Table(
        ("period", "motion", "design", "motion", "design", "motion / design"),
        [[float(value) for value in row] for row in zip(*columns, strict=True)],
        ("s", "m/s²", "m/s²", "g", "g", ""),
        caption=f"Pseudo-acceleration beside {comparison.design.name}, damping {100 * comparison.design.damping:g} %.",
        digits=4,
    )


def design_figure(comparison: DesignComparison) -> Figure:
    """Both spectra over the period."""
    return response_spectrum(*_drawn(comparison))


def _columns(comparison: DesignComparison) -> dict[str, Any]:
    return {
        "period_s": comparison.periods,
        "pseudo_acceleration_m_per_s2": comparison.pseudo_acceleration,
        "design_acceleration_m_per_s2": comparison.design_acceleration,
    }


def _drawn(comparison: DesignComparison) -> tuple[Any, dict[str, Any]]:
    shown = comparison.periods.argsort()
    shown = shown[comparison.periods[shown] > 0]
    if shown.size < 2:
        raise InputError(f"a figure needs two periods or more greater than 0, not {shown.size}; compute more of them")
    own, code = comparison.pseudo_acceleration[shown], comparison.design_acceleration[shown]
    return comparison.periods[shown], {"motion": own, "design": code}


@dataclass(frozen=True)
class DesignComparisonPlots(Plots):
    """``comparison.plot()``."""

    result: DesignComparison

    def __call__(self) -> Any:
        """Both spectra over the period; the matplotlib axes ``(1,)``."""
        drawn = _drawn(self.result)
        return style.in_pyplot(
            response_spectrum, *drawn, PSEUDO_ACCELERATION, title=f"{self.result.motion}, {self.result.design.name}"
        )


plots.register(DesignComparison, DesignComparisonPlots)
