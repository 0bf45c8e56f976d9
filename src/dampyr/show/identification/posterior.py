"""What samples of a posterior show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dampyr.errors import InputError
from dampyr.identification.parameter_uncertainty.posterior import Posterior
from dampyr.phrases import listing
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.corner import corner
from dampyr.show.figures.sample_pairs import sample_pairs
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Cell, Table
from dampyr.to_json import plain
from dampyr.units import for_people

LEGIBLE = 4  # numbers of a corner plot on a page: the labels of more overlap
CORNER = 8  # numbers of a corner plot: the panels of more are too small to read
PRIOR = "flat in the coordinates of the search, inside the allowed values"


@describe.register
def describe_posterior(posterior: Posterior) -> Description:
    """The draws, the state of the chains, density and prior; a table of the intervals and the strongest pairs."""
    time, r_hat = max(posterior.autocorrelation_time.values()), max(posterior.r_hat.values())
    return Description(
        f"Posterior {str(posterior.fit.problem.composition)!r}",
        [
            ("draws", f"{posterior.size} of {len(posterior.samples)} numbers, seed {posterior.seed}"),
            ("chains", ("" if posterior.converged else "not converged: ") + posterior.reason),
            ("mixing", f"autocorrelation {time:.3g} steps, R-hat {r_hat:.3f} at worst"),
            ("density", "normal" if posterior.tails == "normal" else "Student's t"),
            ("prior", PRIOR),
        ],
        tables=[lambda: intervals_table(posterior), lambda: chains_table(posterior)],
        figure=lambda: sample_pairs(*_drawn(posterior, 2)),
        data=lambda: _numbers(posterior),
        frame=lambda: DataFrameColumns(posterior.samples),
    )


def intervals_table(posterior: Posterior) -> Table:
    """One row a number: its median and 95 % interval, and the interval of the fit, in the units that people read."""
    spans, of_fit, rows = posterior.intervals(), posterior.fit.intervals(), list[list[Cell]]()
    for label, values in posterior.samples.items():
        shown, factor = for_people(posterior.units[label])
        ends = [factor * end if np.isfinite(end) else None for end in (*spans[label], *of_fit[label])]
        rows.append([label, shown or "1", factor * float(np.median(values)), *ends])
    columns = ("parameter", "unit", "median", "2.5 %", "97.5 %", "fit, from", "to")
    caption = "Median and 95 % interval of the samples, and the 95 % interval of the fit."
    return Table(columns, rows, caption=caption, notes=(f"Prior: {PRIOR}.",))


def chains_table(posterior: Posterior) -> Table:
    """One row a number: how long its chain is in its own time, and how well halves of all chains agree."""
    rows: list[list[Cell]] = [
        [label, posterior.autocorrelation_time[label], posterior.r_hat[label], 100.0 * posterior.acceptance[label]]
        for label in posterior.samples
    ]
    columns, units = ("parameter", "autocorrelation time", "R-hat", "accepted"), ("", "steps", "", "%")
    return Table(columns, rows, units=units, caption=f"Chains of {posterior.steps} steps of each walker.")


def corner_figures(posterior: Posterior) -> dict[str, Any]:
    """Corner plots by title: of the numbers of each input, which alone hang together, at most `LEGIBLE` in one."""
    samples, _, estimates, _ = _drawn(posterior, 1)
    axes = {label: style.parameter_axis(label.partition(" @ ")[0], posterior.units[label]) for label in samples}
    groups: dict[str, list[str]] = {}
    for label in samples:
        groups.setdefault(label.partition(" @ ")[2], []).append(label)
    figures = {}
    for at, labels in groups.items():
        for k in range(0, len(labels), LEGIBLE):
            chosen = {label: samples[label] for label in labels[k : k + LEGIBLE]}
            title = f"At {at}" if at else "At all inputs"
            figures[f"{title}, part {k // LEGIBLE + 1}" if k else title] = corner(chosen, axes, estimates)
    return figures


def _numbers(posterior: Posterior) -> dict[str, Any]:
    """Medians, intervals, correlation and the state of the chains for `dampyr.to_json`, SI units; not the samples."""
    names = (
        "origin",
        "held",
        "converged",
        "reason",
        "findings",
        "autocorrelation_time",
        "r_hat",
        "acceptance",
        "steps",
        "tails",
        "seed",
    )
    data = {name: getattr(posterior, name) for name in names}
    data |= {
        "draws": posterior.size,
        "median": {label: float(np.median(values)) for label, values in posterior.samples.items()},
        "standard_deviation": {label: float(np.std(values)) for label, values in posterior.samples.items()},
        "intervals_95": posterior.intervals(),
        "units": {label: posterior.units[label] for label in posterior.samples},
        "correlation": posterior.correlation,
        "prior": PRIOR,
    }
    return dict(plain(data))


def _drawn(posterior: Posterior, pairs: int) -> tuple[Any, ...]:
    if pairs < 1:
        raise InputError(f"pairs = {pairs} is not allowed; give 1 or more")
    labels = list(posterior.samples)
    axes = {label: style.parameter_axis(label, posterior.units[label]) for label in labels}
    estimates = {label: posterior.fit.parameters[label] for label in labels}
    r = np.abs(posterior.correlation)
    order = sorted(((float(r[i, j]), i, j) for j in range(len(labels)) for i in range(j)), reverse=True)
    strongest = [(labels[i], labels[j]) for _, i, j in order[:pairs]] or [(labels[0], labels[0])]
    return posterior.samples, axes, estimates, strongest


@dataclass(frozen=True)
class PosteriorPlots(Plots):
    """``posterior.plot()`` and ``posterior.plot.corner()``."""

    result: Posterior

    def __call__(self, pairs: int = 4) -> Any:
        """The most correlated ``pairs`` of numbers as clouds with the fit's estimates, as axes ``(k,)``."""
        return style.in_pyplot(sample_pairs, *_drawn(self.result, pairs), origin=self.result.origin)

    def corner(self, labels: Sequence[str] = ()) -> Any:
        """Each number by itself and each pair of them, as axes ``(k,)``; ``labels`` are at most 8, by default the first."""
        known = list(self.result.samples)
        chosen = list(labels) or known[:CORNER]
        unknown = [label for label in chosen if label not in known]
        if unknown or len(chosen) > CORNER:
            wrong = (
                f"labels: {unknown[0]!r} is no number of the posterior"
                if unknown
                else f"{len(chosen)} labels are too many"
            )
            raise InputError(f"corner: {wrong}; give at most {CORNER} of {listing(known)}")
        samples, axes, estimates, _ = _drawn(self.result, 1)
        return style.in_pyplot(
            corner, {label: samples[label] for label in chosen}, axes, estimates, origin=self.result.origin
        )


plots.register(Posterior, PosteriorPlots)
