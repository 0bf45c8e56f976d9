"""What an incremental dynamic analysis shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dampyr.phrases import counted, extent, listing
from dampyr.show.descriptions import Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.fragility import axis_of
from dampyr.show.figures.incremental import incremental_curves
from dampyr.show.plots import Plots, plots
from dampyr.structures.ensembles.incremental import Incremental, IncrementalCurves
from dampyr.units import for_people


@describe.register
def describe_sweep(sweep: IncrementalCurves) -> Description:
    """How many curves there are, the extents of intensity and peaks, and what is unusual of them."""
    return Description(
        f"IncrementalCurves {sweep.name!r}, SI",
        [
            ("curves", f"{sweep.peaks.shape[0]} of {counted(sweep.peaks.shape[1], 'scale')}"),
            ("intensity", extent(sweep.intensity, "")),
            ("peaks", extent(sweep.peaks, "")),
            ("bent back", counted(sweep.bent_back, "curve")),
            ("without bound", counted(sweep.unbounded, "case")),
        ],
    )


@describe.register
def describe_incremental(incremental: Incremental) -> Description:
    """The quantity, the intensity, the sweeps and the fractiles; the curves of the first sweep."""
    i = incremental
    return Description(
        "Incremental",
        [
            ("quantity", f"{i.quantity} [{i.quantity_unit or '1'}] over {i.intensity} [{i.unit or '1'}]"),
            ("sweeps", listing([sweep.name for sweep in i.sweeps])),
            ("fractiles", ", ".join(f"{100 * p:g} %" for p in i.fractions)),
        ],
        figure=lambda: incremental_curves(**_drawn(incremental, incremental.sweeps[0])),
    )


def _drawn(incremental: Incremental, sweep: IncrementalCurves) -> dict[str, Any]:
    fractiles = {f"{100 * p:g} %": sweep.fractiles[k] for k, p in enumerate(incremental.fractions)}
    unit, factor = for_people(incremental.quantity_unit)
    peak = style.Axis(f"largest {incremental.quantity}", unit.replace("^2", "²"), factor)
    if not unit:
        peak = style.Axis(f"largest {incremental.quantity} of the height", "%", 100.0)
    return {
        "intensity": sweep.intensity, "peaks": sweep.peaks, "levels": sweep.levels, "fractiles": fractiles,
        "axis": axis_of(incremental.intensity), "peak": peak,
    }  # fmt: skip


@dataclass(frozen=True)
class IncrementalPlots(Plots):
    """``incremental.plot()``."""

    result: Incremental

    def __call__(self, name: str | None = None) -> Any:
        """The curves of one sweep, by default the first, and their fractiles; the matplotlib axes ``(1,)``."""
        result = self.result
        sweep = result.sweeps[0] if name is None else result[name]
        return style.in_pyplot(incremental_curves, **_drawn(result, sweep), title=sweep.name, origin=result.origin)


plots.register(Incremental, IncrementalPlots)
