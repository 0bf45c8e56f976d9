"""What several specimens of a damper type show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from dampyr.errors import InputError
from dampyr.findings import as_dicts
from dampyr.identification.parameter_uncertainty.specimens import Specimens, SpecimenSpread
from dampyr.phrases import listing
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.specimens import Estimates, specimen_estimates
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Cell, Table
from dampyr.to_json import plain
from dampyr.units import for_people

SHOWN = 6  # parameters that a short text lists, and panels of a figure


@describe.register
def describe_spread(number: SpecimenSpread) -> Description:
    """The mean, the spread and the interval of a new specimen, with their specimens and those left out."""
    shown, factor = for_people(number.unit)
    (low, high), (bottom, top) = (
        tuple(factor * end for end in interval) for interval in (number.mean_interval, number.new_specimen)
    )
    spread, of_spread = _spread(number)
    rows = [
        ("mean", f"{factor * number.mean:.4g} {shown}, {100 * number.level:g} % interval {low:.4g} … {high:.4g}"),
        ("spread", f"{spread}, interval {of_spread}"),
        ("new specimen", f"{bottom:.4g} … {top:.4g} {shown}".rstrip()),
        ("specimens", listing(list(number.estimates), 6)),
    ]
    without = [(f"without {name}", why) for name, why in number.left_out.items()]
    return Description(f"SpecimenSpread {number.label!r}", [*rows, *without])


@describe.register
def describe_specimens(specimens: Specimens) -> Description:
    """The specimens, mean and spread of the first numbers; a table of all and a figure of the estimates."""
    rows = [("specimens", f"{len(specimens.fits)}: {listing(list(specimens.fits), 6)}")]
    for number in list(specimens.spreads.values())[:SHOWN]:
        shown, factor = for_people(number.unit)
        spread, of_spread = _spread(number)
        rows.append(
            (number.label, f"{factor * number.mean:.4g} {shown}, spread {spread} ({of_spread})".replace(" ,", ","))
        )
    if len(specimens.spreads) > SHOWN:
        rows.append(("", f"and {len(specimens.spreads) - SHOWN} more"))
    return Description(
        f"Specimens {_model(specimens)!r}",
        rows,
        tables=[lambda: mean_and_spread(specimens)],
        figure=lambda: specimen_estimates(_panels(specimens, ())),
        data=lambda: _numbers(specimens),
        frame=lambda: _columns(specimens),
    )


def _model(specimens: Specimens) -> str:
    return str(next(iter(specimens.fits.values())).problem.composition)


def mean_and_spread(specimens: Specimens) -> Table:
    """One row a number, in units that people read: mean, spread, both with their intervals, and that of a new specimen."""
    level = f"{100 * specimens.level:g} %"
    rows: list[list[Cell]] = []
    for number in specimens.spreads.values():
        shown, factor = for_people(number.unit)
        spread, of_spread = _spread(number)
        mean, new = (
            f"{factor * low:.4g} … {factor * high:.4g}" for low, high in (number.mean_interval, number.new_specimen)
        )
        rows.append(
            [
                number.label,
                shown or "1",
                f"{factor * number.mean:.4g}",
                mean,
                spread,
                of_spread,
                new,
                len(number.estimates),
            ]
        )
    names = list(specimens.fits)
    return Table(
        ("parameter", "unit", "mean", level, "spread", f"{level} of it", "new specimen", "specimens"),
        rows,
        caption=f"{_model(specimens)}, {len(names)} specimens ({', '.join(names)}): mean and spread between them.",
    )


def _spread(number: SpecimenSpread) -> tuple[str, str]:
    """The spread and its interval: in percent where it is relative, else in the unit for people."""
    shown, factor = ("%", 100.0) if number.relative else for_people(number.unit)
    low, high = (factor * end for end in number.spread_interval)
    return f"{factor * number.spread:.3g} {shown}".rstrip(), f"{low:.2g} … {high:.2g} {shown}".rstrip()


def _numbers(specimens: Specimens) -> dict[str, Any]:
    """Means, spreads, intervals, estimates by specimen and what is missing, for `dampyr.to_json`, SI units."""
    return dict(
        plain(
            {
                "model": _model(specimens),
                "origin": specimens.origin.as_dict(),
                "level": specimens.level,
                "specimens": {
                    name: [record.name for record in number.records] for name, number in specimens.fits.items()
                },
                "parameters": dict(specimens.spreads),
                "left_out": specimens.left_out,
                "not_estimated": specimens.not_estimated,
                "findings": as_dicts(specimens.findings),
            }
        )
    )


def _columns(specimens: Specimens) -> DataFrameColumns:
    """Mean, spread and their intervals, SI units: a row a number."""
    numbers = list(specimens.spreads.values())
    columns = {
        "mean": [number.mean for number in numbers],
        "mean_low": [number.mean_interval[0] for number in numbers],
        "mean_high": [number.mean_interval[1] for number in numbers],
        "spread": [number.spread for number in numbers],
        "spread_low": [number.spread_interval[0] for number in numbers],
        "spread_high": [number.spread_interval[1] for number in numbers],
        "relative": [number.relative for number in numbers],
        "specimens": [len(number.estimates) for number in numbers],
        "unit": [number.unit for number in numbers],
    }
    return DataFrameColumns(columns, list(specimens.spreads), "parameter")


def _panels(specimens: Specimens, labels: Sequence[str]) -> list[Estimates]:
    from scipy.stats import t

    unknown = [label for label in labels if label not in specimens.spreads]
    if unknown:
        raise InputError(f"{unknown[0]!r} has no spread; choose from {listing(list(specimens.spreads), 8)}")
    panels = []
    for label in labels or list(specimens.spreads)[:SHOWN]:
        number = specimens.spreads[label]
        bars = {
            name: float(t.ppf(0.5 + 0.5 * specimens.level, specimens.fits[name].freedom[label])) * error
            for name, error in number.errors.items()
        }
        panels.append(
            Estimates(
                style.parameter_axis(label, number.unit),
                number.estimates,
                bars,
                number.shrunken,
                number.mean_interval,
                number.new_specimen,
            )
        )
    return panels


@dataclass(frozen=True)
class SpecimensPlots(Plots):
    """``specimens.plot()``."""

    result: Specimens

    def __call__(self, labels: Sequence[str] = ()) -> Any:
        """Each specimen's estimate with its interval, the mean and the interval of a new one: axes ``(k,)``, a panel a number.

        ``labels`` are by default the first six.
        """
        return style.in_pyplot(specimen_estimates, _panels(self.result, labels), origin=self.result.origin)


plots.register(Specimens, SpecimensPlots)
