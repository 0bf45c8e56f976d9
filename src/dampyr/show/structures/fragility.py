"""What fragility curves show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from dampyr.errors import InputError
from dampyr.phrases import counted, listing, sentence
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.fragility import MAX_CURVES, Fragile, axis_of, fragility_curves
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Cell, Table
from dampyr.structures.ensembles.fragility import Fragility, FragilityCurve
from dampyr.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEVEL = 0.9  # of the bands
DETERMINED, UNDETERMINED = 4, 2  # digits of a curve's numbers
FULL = 3.3  # standard deviations above the median: how far a figure goes


@describe.register
def describe_curve(curve: FragilityCurve) -> Description:
    """What was counted, the curve with the band of its median, or why there is none."""
    title = f"FragilityCurve {curve.name!r}"
    rows = [
        ("cases", f"{int(curve.of.sum())}, {int(curve.exceeding.sum())} exceed the limit, {curve.unbounded} unbounded")
    ]
    if not curve.exists:
        return Description(title, [*rows, ("no curve", curve.reason)])
    digits = UNDETERMINED if curve.no_band else DETERMINED
    rows += [
        ("theta", f"{curve.theta:.{digits}g} (SI, the median intensity)"),
        ("beta", f"{curve.beta:.{digits}g}"),
    ]
    if curve.no_band:
        rows.append(("no band", curve.no_band))
    else:
        low, high = curve.theta_band(LEVEL)
        rows.append(("band", f"{low:.4g} … {high:.4g}, {100 * LEVEL:g} % of {len(curve.draws)} draws"))
    return Description(title, rows)


@describe.register
def describe_fragility(fragility: Fragility) -> Description:
    """The limit, the intensity and the medians; a table of the curves and their figure."""
    unit, factor = ("g", 1.0 / STANDARD_GRAVITY) if fragility.unit == "m/s^2" else (fragility.unit, 1.0)
    medians = [
        f"{c.name}: {factor * c.theta:.{UNDETERMINED if c.no_band else 3}g} {unit}".rstrip()
        if c.exists
        else f"{c.name}: none"
        for c in fragility.curves
    ]
    return Description(
        "Fragility",
        [
            ("limit", limit_in_words(fragility)),
            ("over", f"{fragility.intensity}, {counted(fragility.motions, 'motion')}"),
            ("medians", listing(medians)),
        ],
        verdict=comparisons(fragility),
        tables=[lambda: curve_table(fragility)],
        figure=lambda: first_curves(fragility),
        frame=lambda: _columns(fragility),
    )


def limit_in_words(fragility: Fragility) -> str:
    """Such as ``drift above 12 mm``, ``drift above 1 % of the height``."""
    limit = fragility.limit
    value, unit = {
        "m": (1e3 * limit, "mm"),
        "": (100 * limit, "% of the height"),
        "m/s^2": (limit, "m/s²"),
    }.get(fragility.limit_unit, (limit, fragility.limit_unit))
    return f"{fragility.quantity} above {value:.4g} {unit}"


def first_curves(fragility: Fragility) -> Figure:
    """As many of the curves as a figure has colours."""
    return fragility_curves(drawn_curves(fragility.curves[:MAX_CURVES]), axis_of(fragility.intensity))


def curve_table(fragility: Fragility) -> Table:
    """One row a curve: its median with the band, beta, the direct estimate, and what was counted."""
    axis = axis_of(fragility.intensity)
    rows: list[list[Cell]] = []
    for c in fragility.curves:
        numbers = [float(axis.of(v)) for v in (c.theta, *c.theta_band(LEVEL))]
        direct = [float(axis.of(c.direct.theta)), c.direct.beta]
        digits = UNDETERMINED if c.no_band else DETERMINED
        cells: list[Cell] = [None if np.isnan(v) else float(f"{v:.{digits}g}") for v in (*numbers, c.beta, *direct)]
        rows.append([c.name, *cells, int(c.of.sum()), int(c.exceeding.sum()), c.unbounded])
    percent = f"{100 * LEVEL:g} %"
    return Table(
        ("case", "median", f"{percent} from", "to", "beta", "direct median", "direct beta", "cases", "exceed",
         "without bound"),
        rows,
        ("", axis.unit, axis.unit, axis.unit, "", axis.unit, "", "", "", ""),
        caption=f"Fragility over {fragility.intensity}: {limit_in_words(fragility)}; {percent} bands over "
        f"{fragility.motions} motions.",
        notes=(
            f"Median with its {percent} band, and beta, the standard deviation of the logarithm.",
            "Direct: from the intensity at which each motion first exceeds the limit, linear between its scales; motions "
            "that never exceed it, or do so at the weakest scale already, enter the likelihood as censored.",
        ),
        digits=4,
    )  # fmt: skip


def comparisons(fragility: Fragility) -> list[str]:
    """What the cases cannot determine, and how curves compare, in sentences."""
    notes = [f"{c.name}: no curve; {c.reason}" for c in fragility.curves if not c.exists]
    notes += [
        f"{c.name}: not determined, so its curve is dashed and its numbers have two digits: {c.no_band}"
        for c in fragility.curves
        if c.exists and c.no_band
    ]
    notes += [
        f"{c.name}: no direct estimate; {c.direct.reason}" for c in fragility.curves if c.exists and c.direct.reason
    ]
    notes += [_censored(c) for c in fragility.curves if c.capacities.above or c.capacities.below]
    first = fragility.curves[0]
    for c in fragility.curves[1:]:
        if first.exists and c.exists:
            ratio, low, high = fragility.ratio(c.name, first.name, LEVEL)
            band = "" if np.isnan(low) else f" (90 % band {low:.3g} to {high:.3g})"
            digits = UNDETERMINED if c.no_band or first.no_band else 3
            notes.append(f"{c.name}: its median is {ratio:.{digits}g} times that of {first.name}{band}")
    return [sentence(note) for note in notes]


def _censored(c: FragilityCurve) -> str:
    capacities = c.capacities
    parts = [f"{capacities.above} never exceed the limit"] * bool(capacities.above)
    parts += [f"{capacities.below} do at the weakest scale already"] * bool(capacities.below)
    return f"{c.name}: of {capacities.value.size} sweeps {' and '.join(parts)}"


def _columns(fragility: Fragility) -> DataFrameColumns:
    """One row a curve: theta and its 90 % band in SI, beta, and what was counted."""
    curves = fragility.curves
    bands = [curve.theta_band(LEVEL) for curve in curves]
    columns = {
        "theta": [curve.theta for curve in curves],
        "theta_low": [low for low, _ in bands],
        "theta_high": [high for _, high in bands],
        "beta": [curve.beta for curve in curves],
        "cases": [int(curve.of.sum()) for curve in curves],
        "exceeding": [int(curve.exceeding.sum()) for curve in curves],
        "unbounded": [curve.unbounded for curve in curves],
        "reason": [curve.reason for curve in curves],
    }
    return DataFrameColumns(columns, [curve.name for curve in curves], "curve")


def drawn_curves(curves: Sequence[FragilityCurve]) -> dict[str, Fragile]:
    """Curves, bands and counted shares as `dampyr.show.figures.fragility.fragility_curves` draws them, over one range."""
    # to where the last curve is nearly 1, at most as far as the motions
    max_level = max(float(curve.levels.max()) for curve in curves)
    full = [curve.theta * np.exp(FULL * curve.beta) for curve in curves]
    reach = max_level if np.isnan(full).any() else float(min(max_level, max(full)))
    return {curve.name: _fragile(curve, reach) for curve in curves}


def _fragile(c: FragilityCurve, reach: float) -> Fragile:
    x = np.linspace(0.0, reach, 301)[1:]
    intensity, share, _ = c.shares()
    near = intensity <= reach
    curve = c.at(x) if c.exists else None
    return Fragile(x, curve, c.band(x, LEVEL), (intensity[near], share[near]), determined=not c.no_band)


@dataclass(frozen=True)
class FragilityPlots(Plots):
    """``fragility.plot()``."""

    result: Fragility

    def __call__(self, names: Sequence[str] | None = None) -> Any:
        """The curves over the intensity with their bands and the counted shares; the matplotlib axes ``(1,)``.

        ``names`` chooses up to six curves; without it the first six are drawn.
        """
        result = self.result
        chosen = result.curves[:MAX_CURVES] if names is None else [result[name] for name in names]
        if not 1 <= len(chosen) <= MAX_CURVES:
            raise InputError(
                f"names has {len(chosen)} curves; a figure shows 1 to {MAX_CURVES}, so draw several figures"
            )
        axis = axis_of(result.intensity)
        return style.in_pyplot(
            fragility_curves, drawn_curves(chosen), axis, limit_in_words(result), origin=result.origin
        )


plots.register(Fragility, FragilityPlots)
