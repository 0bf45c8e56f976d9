"""What a spectrum over all angles shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dampyr.errors import InputError
from dampyr.ground_motions.rotated_components import RotatedSpectrum
from dampyr.phrases import extent
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.response_spectrum import PSEUDO_ACCELERATION, response_spectrum
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Table


@describe.register
def describe_rotated_spectrum(spectrum: RotatedSpectrum) -> Description:
    """Periods, the extents of RotD50 and RotD100, and these over the period."""
    return Description(
        f"RotatedSpectrum of {' and '.join(spectrum.motions)}",
        [
            ("periods", f"{spectrum.periods.size}, {extent(spectrum.periods, 's')}"),
            ("damping", f"{100 * spectrum.damping:g} %"),
            ("RotD50", f"{extent(spectrum.rotd50, 'm/s²')} (pseudo-acceleration, median over all angles)"),
            ("RotD100", f"{extent(spectrum.rotd100, 'm/s²')} (largest)"),
        ],
        tables=[lambda: rotated_table(spectrum)],
        figure=lambda: response_spectrum(*_drawn(spectrum)) if (spectrum.periods > 0).sum() > 1 else None,
        frame=lambda: DataFrameColumns(_columns(spectrum)),
        data=lambda: {"motions": spectrum.motions, "damping": spectrum.damping, **_columns(spectrum)},
    )  # fmt: skip


def rotated_table(spectrum: RotatedSpectrum) -> Table:
    """One row a period."""
    columns = (spectrum.periods, spectrum.rotd50, spectrum.rotd100, spectrum.angle)
    return Table(
        ("period", "RotD50", "RotD100", "at"),
        [[float(value) for value in row] for row in zip(*columns, strict=True)],
        ("s", "m/s²", "m/s²", "°"),
        caption=f"Pseudo-acceleration over all angles, {' and '.join(spectrum.motions)}, damping {100 * spectrum.damping:g} %.",
        notes=(
            "Angles from the first component to the second, in steps of one degree; period 0 is the ground itself.",
        ),
        digits=4,
    )


def _columns(spectrum: RotatedSpectrum) -> dict[str, Any]:
    """The pseudo-accelerations in SI units, one row a period."""
    return {
        "period_s": spectrum.periods, "rotd00_m_per_s2": spectrum.rotd00, "rotd50_m_per_s2": spectrum.rotd50,
        "rotd100_m_per_s2": spectrum.rotd100, "angle_deg": spectrum.angle,
    }  # fmt: skip


def _drawn(spectrum: RotatedSpectrum) -> tuple[Any, dict[str, Any]]:
    shown = spectrum.periods.argsort()
    shown = shown[spectrum.periods[shown] > 0]
    if shown.size < 2:
        raise InputError(f"a figure needs two periods or more greater than 0, not {shown.size}; compute more of them")
    return spectrum.periods[shown], {"RotD50": spectrum.rotd50[shown], "RotD100": spectrum.rotd100[shown]}


@dataclass(frozen=True)
class RotatedSpectrumPlots(Plots):
    """``rotated.plot()``."""

    result: RotatedSpectrum

    def __call__(self) -> Any:
        """RotD50 and RotD100 over the period; the matplotlib axes ``(1,)``."""
        drawn, title = _drawn(self.result), " and ".join(self.result.motions)
        return style.in_pyplot(response_spectrum, *drawn, PSEUDO_ACCELERATION, title=title)


plots.register(RotatedSpectrum, RotatedSpectrumPlots)
