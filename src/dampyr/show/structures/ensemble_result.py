"""What an ensemble shows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from dampyr.data_frames import column_name
from dampyr.errors import InputError
from dampyr.findings import as_dicts
from dampyr.ground_motions.cutting import end_in_words
from dampyr.phrases import counted, listing
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.plots import Plots, plots
from dampyr.show.structures.fragility import comparisons, curve_table, first_curves, limit_in_words
from dampyr.show.table import Cell, Table
from dampyr.structures.ensembles.ensemble_accuracy import BOUNDS, FLOOR, truncation_in_words
from dampyr.structures.ensembles.ensemble_result import EnsembleResult
from dampyr.structures.ensembles.fragility import Fragility, FragilityCurve
from dampyr.structures.ensembles.incremental import incremental
from dampyr.structures.ensembles.peak_limits import UNITS
from dampyr.structures.ensembles.summary import summary
from dampyr.to_json import plain

SHOWN = {
    "drift": ("drift", "mm", 1e3),
    "displacement": ("displacement", "mm", 1e3),
    "acceleration": ("acceleration", "m/s²", 1.0),
    "force": ("damper force", "N", 1.0),
}


@describe.register
def describe_ensemble(result: EnsembleResult) -> Description:
    """The cases, their accuracy and what is without bound; tables of the peaks and of the fragility curves."""
    attributes = result.dataset.attrs
    rows = [
        ("building", listing([str(name) for name in result.dataset.building_name.values])),
        ("cases", f"{attributes['cases']}: {cases_in_words(result.dataset)}"),
        (
            "accuracy",
            f"{attributes['accuracy']}, largest change on halving the step {100 * attributes['error_estimate']:.2g} %"
            if attributes["judged"]
            else attributes["accuracy"],
        ),
        ("end", end_in_words(attributes.get("after_s", 0.0))),
        ("without bound", f"{attributes['unbounded']} cases"),
        *(("left out", words) for words in (truncation_in_words(attributes),) if words),
    ]
    rows += [("fragility", f"{limit_in_words(curve)}, over {curve.intensity}") for curve in result.curves[:4]]
    return Description(
        "EnsembleResult",
        rows,
        verdict=trust(result.dataset),
        tables=[
            lambda: peak_table(result.dataset),
            *(partial(_fragility_table, fragility) for fragility in result.curves),
        ],
        figure=lambda: first_curves(result.curves[0]) if result.curves else None,
        data=lambda: _numbers(result),
        frame=lambda: _peaks(result),
    )


def cases_in_words(dataset: Any) -> str:
    """What the cases are made of, such as ``2 damper cases, 1 input, 20 motions, 8 scales``."""
    nouns = {"damper": "damper case", "input": "input", "motion": "motion", "scale": "scale"}
    if not dataset.input.attrs.get("units"):
        del nouns["input"]
    return ", ".join(counted(dataset.sizes[dimension], noun) for dimension, noun in nouns.items())


def peak_table(dataset: Any) -> Table:
    """Median and 84 % fractile of the peaks of the worst storey, floor and damper: one row a case and scale."""
    quantities = [quantity for quantity in SHOWN if quantity in dataset and dataset[quantity].shape[-1]]
    rows: list[list[Cell]] = []
    for row in summary(dataset):
        pairs = [(row.peaks[quantity] or (None, None), SHOWN[quantity][2]) for quantity in quantities]
        rows.append([row.name, row.scale, *(None if v is None else factor * v for pair, factor in pairs for v in pair)])
    names = ", ".join(str(name) for name in dataset.building_name.values)
    return Table(
        ("case", "scale", *(f"{SHOWN[quantity][0]}, {part}" for quantity in quantities for part in ("median", "84 %"))),
        rows,
        ("", "", *(SHOWN[quantity][1] for quantity in quantities for _ in range(2))),
        caption=f"{names}: peaks of {dataset.attrs['cases']} cases.",
        notes=(
            "Across motions and draws of the damper, of the worst storey, floor and damper of each case; displacements "
            "relative to the ground, accelerations absolute.",
        ),
        digits=4,
    )


def _fragility_table(fragility: Fragility) -> Table:
    """The curves of one limit, and below them how they compare."""
    table = curve_table(fragility)
    return replace(table, notes=(*comparisons(fragility), *table.notes))


def trust(dataset: Any) -> list[str]:
    """What was measured of the error, and what it does not cover; sentences."""
    attributes = dataset.attrs
    error = f"{100 * attributes['error_estimate']:.2g} %"
    moving = attributes.get("error_estimate_moving")
    among = f" ({100 * moving:.2g} % among {FLOOR})" if moving is not None else ""
    measured = (
        ""
        if not attributes["judged"]
        else (
            f"The largest change of a peak displacement or drift on halving the step was {error}{among}, measured on "
            f"{attributes['judged']} of {attributes['cases']} cases, the hardest and others at random."
        )
    )
    bound = f"{100 * BOUNDS[attributes['accuracy']]:.2g} %"
    at_high = " at a high input" if dataset.input.attrs.get("units") else ""
    fast = (
        f"The accuracy is “fast”: about 0.1 % of the peak in strong motion, at most {bound} of {FLOOR}; smaller ones have no "
        f"bound. Accelerations are less sharp, a few per cent{at_high}, rarely ten. Accuracy “strict” takes 0.4 of the step."
    )
    strict = f"The accuracy is “strict”: at most {bound} of {FLOOR}; smaller ones have no bound. Accelerations are less sharp."
    lost = [] if attributes["unbounded"] else ["No case grew without bound."]
    end = f"Each case {end_in_words(attributes.get('after_s', 0.0))}."
    left_out = truncation_in_words(attributes)
    reduced = [f"{left_out[0].upper()}{left_out[1:]}."] if left_out else []
    return [
        *([measured] if measured else []),
        fast if attributes["accuracy"] == "fast" else strict,
        *reduced,
        end,
        *lost,
    ]


def _peaks(result: EnsembleResult) -> DataFrameColumns:
    """Medians and 84 % fractiles of the peaks, SI units: one row a case and scale."""
    rows = summary(result.dataset)
    columns: dict[str, Any] = {"case": [row.name for row in rows], "scale": [row.scale for row in rows]}
    for quantity in rows[0].peaks:
        pairs = [row.peaks[quantity] or (None, None) for row in rows]
        for k, part in enumerate(("median", "fractile_84")):
            columns[column_name(f"{quantity}_{part}", UNITS[quantity])] = [pair[k] for pair in pairs]
    return DataFrameColumns(columns)


def _numbers(result: EnsembleResult) -> dict[str, Any]:
    """Peaks and curves for JSON, SI units."""
    curves = [
        {
            "quantity": fragility.quantity, "limit": fragility.limit, "limit_unit": fragility.limit_unit,
            "intensity": fragility.intensity, "intensity_unit": fragility.unit, "motions": fragility.motions,
            "curves": [_curve_as_dict(curve) for curve in fragility.curves],
        }
        for fragility in result.curves
    ]  # fmt: skip
    of_all = {"damper_origin": result.origin.as_dict(), "findings": as_dicts(result.findings)}
    attributes = result.dataset.attrs | of_all
    return dict(plain({**attributes, "peaks": summary(result.dataset), "fragility": curves}))


def _curve_as_dict(curve: FragilityCurve) -> dict[str, Any]:
    return {
        "name": curve.name,
        "theta": curve.theta,
        "theta_band_90": curve.theta_band(),
        "beta": curve.beta,
        "reason": curve.reason,
        "no_band": curve.no_band,
        "direct": curve.direct,
        "never_exceeded": curve.capacities.above,
        "exceeded_at_once": curve.capacities.below,
        "cases": int(curve.of.sum()),
        "exceeding": int(curve.exceeding.sum()),
        "unbounded": curve.unbounded,
    }


@dataclass(frozen=True)
class EnsemblePlots(Plots):
    """``result.plot.fragility()`` and ``result.plot.incremental()``; ``result.plot()`` draws the curves of the first limit."""

    result: EnsembleResult

    def fragility(self, number: int = 0) -> Any:
        """The fragility curves of one limit, counted from 0 in the order of the options."""
        if not 0 <= number < len(self.result.curves):
            raise InputError(
                f"number = {number} is not allowed; there are {len(self.result.curves)} limits, counted from 0"
            )
        return self.result.curves[number].plot()

    def incremental(self, name: str | None = None, quantity: str = "drift") -> Any:
        """Peaks over the intensity for each motion, with fractiles; of one case, by default the first."""
        return incremental(self.result.dataset, quantity, self.result.intensity).plot(name)


plots.register(EnsembleResult, EnsemblePlots)
