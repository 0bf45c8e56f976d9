"""What a response spectrum shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.data_frames import column_name
from dampyr.errors import InputError
from dampyr.ground_motions.response_spectrum import UNITS, Spectrum
from dampyr.phrases import extent, listing
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.response_spectrum import PSEUDO_ACCELERATION, SPECTRAL_DISPLACEMENT, response_spectrum
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Cell, Table
from dampyr.units import STANDARD_GRAVITY

Array = NDArray[np.float64]
AXES = {
    "displacement": SPECTRAL_DISPLACEMENT,
    "velocity": style.VELOCITY,
    "acceleration": style.ACCELERATION,
    "pseudo_velocity": style.Axis("pseudo-velocity", "mm/s", 1e3),
    "pseudo_acceleration": PSEUDO_ACCELERATION,
}


@describe.register
def describe_spectrum(spectrum: Spectrum) -> Description:
    """Periods and dampings, the extents of Sa and Sd, how peaks were taken, the peaks, and Sa over the period."""
    dampings = [f"{100 * ratio:g} %" for ratio in np.atleast_1d(spectrum.damping)]
    periods = np.atleast_1d(spectrum.periods)
    drawable = np.sum(spectrum.periods > 0.0) > 1
    return Description(
        f"Spectrum of {spectrum.motion!r}" if spectrum.motion else "Spectrum",
        [
            ("periods", f"{periods.size}, {extent(periods, 's')}"),
            ("damping", listing(dampings)),
            ("Sa", f"{extent(spectrum.pseudo_acceleration, 'm/s²')} (pseudo-acceleration)"),
            ("Sd", extent(spectrum.displacement, "mm", 1e3)),
            ("peaks", "largest samples" if spectrum.sampled else "of the motion itself, between samples too"),
        ],
        tables=[lambda: spectrum_table(spectrum)],
        figure=lambda: response_spectrum(*_drawn(spectrum, "pseudo_acceleration")) if drawable else None,
        frame=lambda: _peaks(spectrum),
    )


def spectrum_table(spectrum: Spectrum) -> Table:
    """The spectrum in numbers: one row a damping and period."""
    dampings, periods = np.atleast_1d(spectrum.damping), np.atleast_1d(spectrum.periods)
    peaks = (1e3 * spectrum.displacement, 1e3 * spectrum.pseudo_velocity, spectrum.pseudo_acceleration)
    columns = [np.repeat(100 * dampings, periods.size), np.tile(periods, dampings.size), *map(np.ravel, peaks)]
    rows: list[list[Cell]] = [
        [*map(float, row), float(row[-1] / STANDARD_GRAVITY)] for row in zip(*columns, strict=True)
    ]
    taken = "Largest samples" if spectrum.sampled else "Peaks inside the step, up to the last sample"
    return Table(
        ("damping", "period", "displacement", "pseudo-velocity", "pseudo-acceleration", "pseudo-acceleration"),
        rows,
        ("%", "s", "mm", "mm/s", "m/s²", "g"),
        caption="Response spectrum.",
        notes=(f"{taken}; displacement relative to the ground.",),
        digits=4,
    )


def _peaks(spectrum: Spectrum) -> DataFrameColumns:
    """All peaks: one row a damping and period."""
    dampings, periods = np.atleast_1d(spectrum.damping), np.atleast_1d(spectrum.periods)
    columns = {"damping": np.repeat(dampings, periods.size), "period_s": np.tile(periods, dampings.size)}
    peaks = {column_name(name, unit): np.ravel(getattr(spectrum, name)) for name, unit in UNITS.items()}
    return DataFrameColumns(columns | peaks)


def _drawn(spectrum: Spectrum, quantity: str) -> tuple[Array, dict[str, Array]]:
    """Periods greater than 0, s, and for each damping the peaks, SI."""
    periods, dampings = np.atleast_1d(spectrum.periods), np.atleast_1d(spectrum.damping)
    order = np.argsort(periods)
    shown = order[periods[order] > 0.0]
    if shown.size < 2:
        raise InputError(f"a figure needs two periods or more greater than 0, not {shown.size}; compute more of them")
    rows = np.reshape(getattr(spectrum, quantity), (dampings.size, periods.size))[:, shown]
    return periods[shown], {f"{100 * ratio:g} %": row for ratio, row in zip(dampings, rows, strict=True)}


@dataclass(frozen=True)
class SpectrumPlots(Plots):
    """``spectrum.plot("displacement")``."""

    result: Spectrum

    def __call__(self, quantity: str = "pseudo_acceleration") -> Any:
        """A quantity over the period, one line a damping; the matplotlib axes ``(1,)``.

        ``displacement``, ``velocity``, ``acceleration``, ``pseudo_velocity`` or ``pseudo_acceleration``.
        """
        if quantity not in AXES:
            raise InputError(f"{quantity!r} is not a quantity of a spectrum; choose from {', '.join(AXES)}")
        drawn = _drawn(self.result, quantity)
        return style.in_pyplot(response_spectrum, *drawn, AXES[quantity], title=self.result.motion)


plots.register(Spectrum, SpectrumPlots)
