"""What several specimens of a damper type show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from dampyr.errors import InputError
from dampyr.findings import as_dicts
from dampyr.identification.parameter_uncertainty.specimens import Specimens, Spread
from dampyr.phrases import listing
from dampyr.show.descriptions import Description, Frame, describe
from dampyr.show.figures import style
from dampyr.show.figures.specimens import Estimates, specimen_estimates
from dampyr.show.figures.symbols import label_as_mathtext
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Cell, Table
from dampyr.to_json import plain
from dampyr.units import for_people

SHOWN = 6  # parameters that a short text lists, and panels of a figure


@describe.register
def describe_spread(one: Spread) -> Description:
    """The mean, the spread and the interval of a new specimen, with their specimens and those left out."""
    shown, factor = for_people(one.unit)
    (low, high), (bottom, top) = (tuple(factor * end for end in each) for each in (one.mean_interval, one.new_specimen))
    spread, interval = _spread(one)
    rows = [
        ("mean", f"{factor * one.mean:.4g} {shown}, {100 * one.level:g} % interval {low:.4g} … {high:.4g}"),
        ("spread", f"{spread}, interval {interval}"),
        ("new specimen", f"{bottom:.4g} … {top:.4g} {shown}".rstrip()),
        ("specimens", listing(list(one.estimates), 6)),
    ]
    without = [(f"without {name}", why) for name, why in one.left_out.items()]
    return Description(f"Spread {one.label!r}", [*rows, *without])


@describe.register
def describe_specimens(specimens: Specimens) -> Description:
    """The specimens, mean and spread of the first numbers; a table of all and a figure of the estimates."""
    rows = [("specimens", f"{len(specimens.fits)}: {listing(list(specimens.fits), 6)}")]
    for one in list(specimens.spreads.values())[:SHOWN]:
        shown, factor = for_people(one.unit)
        spread, interval = _spread(one)
        rows.append((one.label, f"{factor * one.mean:.4g} {shown}, spread {spread} ({interval})".replace(" ,", ",")))
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
    for one in specimens.spreads.values():
        shown, factor = for_people(one.unit)
        spread, of_spread = _spread(one)
        mean, new = (f"{factor * low:.4g} … {factor * high:.4g}" for low, high in (one.mean_interval, one.new_specimen))
        rows.append(
            [one.label, shown or "1", f"{factor * one.mean:.4g}", mean, spread, of_spread, new, len(one.estimates)]
        )
    names = list(specimens.fits)
    return Table(
        ("parameter", "unit", "mean", level, "spread", f"{level} of it", "new specimen", "specimens"),
        rows,
        caption=f"{_model(specimens)}, {len(names)} specimens ({', '.join(names)}): mean and spread between them.",
    )


def _spread(one: Spread) -> tuple[str, str]:
    """The spread and its interval: in percent where it is relative, else in the unit for people."""
    shown, factor = ("%", 100.0) if one.relative else for_people(one.unit)
    low, high = (factor * each for each in one.spread_interval)
    return f"{factor * one.spread:.3g} {shown}".rstrip(), f"{low:.2g} … {high:.2g} {shown}".rstrip()


def _numbers(specimens: Specimens) -> dict[str, Any]:
    """Means, spreads, intervals, estimates by specimen and what is missing, for `dampyr.to_json`, SI units."""
    return dict(
        plain(
            {
                "model": _model(specimens),
                "origin": specimens.origin.as_dict(),
                "level": specimens.level,
                "specimens": {name: [record.name for record in one.records] for name, one in specimens.fits.items()},
                "parameters": dict(specimens.spreads),
                "left_out": specimens.left_out,
                "not_estimated": specimens.not_estimated,
                "findings": as_dicts(specimens.findings),
            }
        )
    )


def _columns(specimens: Specimens) -> Frame:
    """Mean, spread and their intervals, SI units: a row a number."""
    each = list(specimens.spreads.values())
    columns = {
        "mean": [one.mean for one in each],
        "mean_low": [one.mean_interval[0] for one in each],
        "mean_high": [one.mean_interval[1] for one in each],
        "spread": [one.spread for one in each],
        "spread_low": [one.spread_interval[0] for one in each],
        "spread_high": [one.spread_interval[1] for one in each],
        "relative": [one.relative for one in each],
        "specimens": [len(one.estimates) for one in each],
        "unit": [one.unit for one in each],
    }
    return Frame(columns, list(specimens.spreads), "parameter")


def _panels(specimens: Specimens, labels: Sequence[str]) -> list[Estimates]:
    from scipy.stats import t

    unknown = [label for label in labels if label not in specimens.spreads]
    if unknown:
        raise InputError(f"{unknown[0]!r} has no spread; choose from {listing(list(specimens.spreads), 8)}")
    panels = []
    for label in labels or list(specimens.spreads)[:SHOWN]:
        one = specimens.spreads[label]
        shown, factor = for_people(one.unit)
        bars = {
            name: float(t.ppf(0.5 + 0.5 * specimens.level, specimens.fits[name].freedom[label])) * error
            for name, error in one.errors.items()
        }
        panels.append(
            Estimates(
                style.Axis(label_as_mathtext(label), shown or "1", factor),
                one.estimates,
                bars,
                one.shrunken,
                one.mean_interval,
                one.new_specimen,
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
