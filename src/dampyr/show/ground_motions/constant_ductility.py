"""What a spectrum of constant ductility shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from dampyr.errors import InputError
from dampyr.ground_motions.constant_ductility import InelasticSpectrum
from dampyr.phrases import extent, listing
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.response_spectrum import SPECTRAL_DISPLACEMENT, response_spectrum
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Cell, Table
from dampyr.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEIGHT = 3.6  # inches: a legend has several lines
STRENGTH = style.Axis("strength over mass", "m/s²")
AXES = {"strength": STRENGTH, "displacement": SPECTRAL_DISPLACEMENT, "reduction": style.Axis("reduction factor", "1")}


@describe.register
def describe_inelastic_spectrum(spectrum: InelasticSpectrum) -> Description:
    """Periods, ductilities, the extent of the strengths, and these over the period."""
    kind = (
        f"bilinear, {100 * spectrum.hardening:g} % hardening" if spectrum.hardening else "elastic and perfectly plastic"
    )
    return Description(
        f"InelasticSpectrum of {spectrum.motion!r}" if spectrum.motion else "InelasticSpectrum",
        [
            ("periods", f"{spectrum.periods.size}, {extent(spectrum.periods, 's')}"),
            ("ductility", listing([f"{mu:g}" for mu in spectrum.ductility])),
            ("spring", kind),
            ("damping", f"{100 * spectrum.damping:g} % of the elastic oscillator"),
            ("strength", f"{extent(spectrum.strength, 'm/s²')} (over the mass)"),
        ],
        tables=[lambda: inelastic_table(spectrum)],
        figure=lambda: inelastic_figure(spectrum) if spectrum.periods.size > 1 else None,
        frame=lambda: DataFrameColumns(_columns(spectrum)),
        data=lambda: {
            "motion": spectrum.motion,
            "ductility": spectrum.ductility,
            "damping": spectrum.damping,
            "hardening": spectrum.hardening,
            "period_s": spectrum.periods,
            "strength_m_per_s2": spectrum.strength,
            "displacement_m": spectrum.displacement,
            "reduction": spectrum.reduction,
            "elastic_pseudo_acceleration_m_per_s2": spectrum.elastic,
            "several": spectrum.several,
        },
    )


def inelastic_table(spectrum: InelasticSpectrum) -> Table:
    """One row a ductility and period."""
    rows: list[list[Cell]] = [
        [
            float(mu), float(T), float(strength), float(strength / STANDARD_GRAVITY), float(factor), float(1e3 * largest),
            "yes" if several else None,
        ]
        for mu, *lines in zip(
            spectrum.ductility, spectrum.strength, spectrum.reduction, spectrum.displacement, spectrum.several, strict=True
        )
        for T, strength, factor, largest, several in zip(spectrum.periods, *lines, strict=True)
    ]  # fmt: skip
    return Table(
        ("ductility", "period", "strength", "strength", "reduction", "displacement", "several"),
        rows,
        ("", "s", "m/s²", "g", "", "mm", ""),
        caption="Spectrum of constant ductility.",
        notes=(
            "Strength: the force at which it yields, over its mass. Several: weaker ones have this ductility, too.",
        ),
        digits=4,
    )


def inelastic_figure(spectrum: InelasticSpectrum) -> Figure:
    """The strengths over the period, one line a ductility."""
    return response_spectrum(*_drawn(spectrum, "strength"), STRENGTH, height=HEIGHT)


def _columns(spectrum: InelasticSpectrum) -> dict[str, Any]:
    d, p = spectrum.strength.shape
    return {
        "ductility": np.repeat(spectrum.ductility, p),
        "period_s": np.tile(spectrum.periods, d),
        "strength_m_per_s2": spectrum.strength.ravel(),
        "displacement_m": spectrum.displacement.ravel(),
        "reduction": spectrum.reduction.ravel(),
        "several": spectrum.several.ravel(),
    }


def _drawn(spectrum: InelasticSpectrum, quantity: str) -> tuple[Any, dict[str, Any]]:
    if spectrum.periods.size < 2:
        raise InputError("a figure needs two periods or more, not 1; compute more of them")
    order = np.argsort(spectrum.periods)
    rows = np.nan_to_num(getattr(spectrum, quantity))[:, order]
    return spectrum.periods[order], {f"ductility {mu:g}": row for mu, row in zip(spectrum.ductility, rows, strict=True)}


@dataclass(frozen=True)
class InelasticSpectrumPlots(Plots):
    """``spectrum.plot("displacement")``."""

    result: InelasticSpectrum

    def __call__(self, quantity: str = "strength") -> Any:
        """A quantity over the period, one line a ductility; the matplotlib axes ``(1,)``.

        ``strength``, ``displacement`` or ``reduction``.
        """
        if quantity not in AXES:
            raise InputError(f"{quantity!r} is not a quantity of an inelastic spectrum; choose from {', '.join(AXES)}")
        drawn = _drawn(self.result, quantity)
        return style.in_pyplot(response_spectrum, *drawn, AXES[quantity], self.result.motion, HEIGHT)


plots.register(InelasticSpectrum, InelasticSpectrumPlots)
