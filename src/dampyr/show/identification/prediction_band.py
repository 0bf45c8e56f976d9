"""What a predictive band shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dampyr.identification.scoring.prediction_band import Band, Interval
from dampyr.phrases import percent
from dampyr.show.descriptions import Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.band import band as band_of_a_force
from dampyr.show.plots import Plots, plots


@describe.register
def describe_band(band: Band) -> Description:
    """What the band holds of the force, its width, the intervals of peak and energy, and the session."""
    where = "a new session" if band.session is None else f"the session {band.session}"
    rows = [
        ("holds", f"{percent(band.holds)} of the samples"),
        ("width", f"± {percent(band.width)} of the mean force"),
        ("peak", _in_words(band.peak, "N")),
        ("record", f"of {where}" + (f", {band.prior}" if band.prior else "")),
    ]
    if band.energy is not None:
        rows.insert(3, ("energy", f"{_in_words(band.energy, 'J')} per cycle"))
    return Description(f"Band, {percent(band.level)}", rows, data=lambda: _numbers(band))


def _in_words(interval: Interval, unit: str) -> str:
    return f"{interval.low:.4g} to {interval.high:.4g} {unit}, measured {interval.measured:.4g} {unit}"


def _numbers(band: Band) -> dict[str, Any]:
    """Plain numbers, for JSON; the limits sample by sample are left out."""
    return {
        "level": band.level,
        "holds": band.holds,
        "width": band.width,
        "peak": band.peak.as_dict(),
        "energy": None if band.energy is None else band.energy.as_dict(),
        "session": band.session,
        "prior": band.prior,
    }


@dataclass(frozen=True)
class BandPlots(Plots):
    """``band.plot()``."""

    result: Band

    def __call__(self) -> Any:
        """The measured force in its band over the window; the matplotlib axes ``(1,)``."""
        band = self.result
        inside = band.window.slice
        drawn = band.time[inside], band.measured[inside], band.low[inside], band.high[inside]
        return style.in_pyplot(
            band_of_a_force, *drawn, level=band.level, record_origin=band.record_origin, origin=band.origin
        )


plots.register(Band, BandPlots)
