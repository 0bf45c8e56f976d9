"""What responses at several inputs show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from dampyr.errors import InputError
from dampyr.ground_motions.cutting import end_in_words
from dampyr.input_kinds import NO_INPUT
from dampyr.phrases import sentence
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.building import building_response
from dampyr.show.figures.peaks import peaks_by_floor
from dampyr.show.plots import Plots, plots
from dampyr.show.structures.floor_loads import loads_in_words
from dampyr.show.structures.response import PEAK_AXES, errors_in_words, floor_rows, supports_in_words
from dampyr.show.table import Cell, Table
from dampyr.structures.time_history.response import Response
from dampyr.structures.time_history.responses import Responses
from dampyr.to_json import plain

WIDE = 8  # floors that a table has columns for


@describe.register
def describe_responses(responses: Responses) -> Description:
    """The largest peaks of each case; tables of the peaks by floor and by case, of their intervals and of the energies."""
    cases = responses.cases
    error, first = errors_in_words(cases.values()), next(iter(cases.values()))
    return Description(
        f"Responses {responses.title!r}",
        [
            ("end", end_in_words(first.after)),
            *([("loads", loads_in_words(first.loads))] if first.loads is not None else []),
            *([("supports", supports_in_words(first))] if first.supports else []),
            *(
                (name, f"peak drift {1e3 * max(r.peak_drift):.4g} mm, acceleration {max(r.peak_acceleration):.4g} m/s²")
                for name, r in cases.items()
            ),
            *([("error", error)] if error else []),
        ],
        verdict=outcome(responses),
        tables=[
            lambda: case_table(responses),
            *([lambda: interval_table(responses)] if responses.intervals else []),
            lambda: floor_table(responses),
            lambda: energy_table(responses),
        ],
        figure=lambda: peaks_by_floor(*responses.peaks_by_floor(), axes=PEAK_AXES),
        data=lambda: _numbers(responses),
        frame=lambda: _columns(responses),
    )


def outcome(responses: Responses) -> list[str]:
    """Where the responses end, what a reduced structure leaves out, and the error of the peaks, in sentences."""
    cases = responses.cases
    note, error = truncation_note(cases), errors_in_words(cases.values())
    first = next(iter(cases.values()))
    ends = f"the response {end_in_words(first.after)}"
    loads = f"loads on floors, {loads_in_words(first.loads)}" if first.loads is not None else ""
    supports = f"supports that move: {supports_in_words(first)}" if first.supports else ""
    return [sentence(clause) for clause in (ends, loads, supports, note, f"error: {error}" if error else "") if clause]


def floor_table(responses: Responses) -> Table:
    """The peaks of every floor and of the storey below it, one row a case and floor."""
    return Table(
        ("case", "floor", "peak displacement", "peak drift of its storey", "peak acceleration"),
        [[case, *row] for case, r in responses.cases.items() for row in floor_rows(r)],
        ("", "", "mm", "mm", "m/s²"),
        caption="Peaks of each floor.",
        notes=(f"Peaks inside the step; displacements relative to the {_still(responses)}, accelerations absolute.",),
    )


def _still(responses: Responses) -> str:
    """What displacements are relative to."""
    return "supports" if next(iter(responses.cases.values())).supports else "ground"


def case_table(responses: Responses) -> Table:
    """The peaks of each case, the mean input of its dampers, and how it was computed; of many floors only the largest."""
    floors = list(next(iter(responses.cases.values())).floors)
    columns = [f"largest of {len(floors)} floors"] if len(floors) > WIDE else [floor_name(floor) for floor in floors]
    rows: list[list[Cell]] = [
        [
            name,
            *([1e3 * max(r.peak_displacement)] if len(floors) > WIDE else (1e3 * r.peak_displacement).tolist()),
            1e3 * max(r.peak_drift),
            max(r.peak_acceleration),
            r.peak_base_shear,
            max(r.peak_force, default=None),
            _mean_input(r),
            r.scheme,
        ]
        for name, r in responses.cases.items()
    ]
    units = [kind for r in responses.cases.values() for kind in r.input_units]
    table = Table(
        ("case", *columns, "drift", "acceleration", "base shear", "damper force", "mean input", "scheme"),
        rows,
        ("", *("mm" for _ in columns), "mm", "m/s²", "N", "N", next((u for u in units if u != NO_INPUT), ""), ""),
        caption=f"{responses.title}: peaks." if responses.building else "Peaks.",
    )
    return table.without("mean input") if units and all(kind == NO_INPUT for kind in units) else table


def _mean_input(response: Response) -> float | None:
    """The mean over time and over the dampers that have an input; None without any."""
    means = [mean for mean, kind in zip(response.mean_input, response.input_units, strict=True) if kind != NO_INPUT]
    return float(np.mean(means)) if means else None


def energy_table(responses: Responses) -> Table:
    """Where the energy of each case went."""
    rows: list[list[Cell]] = [
        [name, e.input[-1], e.viscous[-1], e.damper[-1], e.kinetic[-1] + e.strain[-1], e.residual[-1]]
        for name, e in ((name, r.energy) for name, r in responses.cases.items())
    ]
    return Table(
        ("case", "input", "viscous", "dampers", "still in motion", "residual"),
        rows,
        ("", "J", "J", "J", "J", "J"),
        caption="Where the energy went by the end.",
        notes=("The residual is the error of the balance.",),
        digits=4,
    )


def interval_table(responses: Responses) -> Table:
    """The 90 % intervals of the peaks of the cases with a damper; of many floors only the largest."""
    floors = next(iter(responses.cases.values())).floors
    many = len(floors) > WIDE
    rows: list[list[Cell]] = []
    for name, interval in responses.intervals.items():
        peaks = 1e3 * interval["peak_displacement_m"]
        spans = [peaks.max(axis=1)] if many else list(peaks.T)
        spans += [1e3 * interval["peak_drift_m"].max(axis=1), interval["peak_acceleration_m_s2"].max(axis=1)]
        spans.append(interval["peak_force_N"].max(axis=1))
        rows.append([name, *(f"{low:.4g} to {high:.4g}" for low, high in spans)])
    columns = [f"largest of {len(floors)} floors"] if many else [floor_name(floor) for floor in floors]
    return Table(
        ("case", *columns, "drift", "acceleration", "damper force"),
        rows,
        ("", *("mm" for _ in columns), "mm", "m/s²", "N"),
        caption=f"90 % intervals of the peaks, {responses.draws} drawn dampers.",
        notes=(
            "The dampers are drawn from the covariance of the card, with the levels of records and sessions where the card has "
            "them.",
        ),
    )


def floor_name(label: str) -> str:
    """``floor 1`` for a floor called 1; a name of its own, such as roof, stays."""
    return f"floor {label}" if label.isdigit() else label


def truncation_note(cases: Mapping[str, Response]) -> str:
    """What a reduced structure leaves out in each case, in words; empty for a structure that was not reduced."""
    left_out = [f"{name}: {r.truncation.in_words()}" for name, r in cases.items() if r.truncation is not None]
    return "reduced structure; " + "; ".join(left_out) if left_out else ""


def _numbers(responses: Responses) -> dict[str, Any]:
    """The peaks of each case for JSON, SI units."""
    cases = {name: response.as_dict() for name, response in responses.cases.items()}
    for name, interval in responses.intervals.items():
        cases[name] |= {"intervals_90": dict(interval), "draws": responses.draws}
    return dict(plain(cases))


def _columns(responses: Responses) -> DataFrameColumns:
    """The peaks of each case and floor, SI units."""
    rows = [(case, floor, r, k) for case, r in responses.cases.items() for k, floor in enumerate(r.floors)]
    return DataFrameColumns(
        {
            "case": [case for case, *_ in rows],
            "floor": [floor for _, floor, *_ in rows],
            "peak_displacement_m": [r.peak_displacement[k] for *_, r, k in rows],
            "peak_drift_m": [r.peak_drift[k] for *_, r, k in rows],
            "peak_acceleration_m_per_s2": [r.peak_acceleration[k] for *_, r, k in rows],
        }
    )


@dataclass(frozen=True)
class ResponsesPlots(Plots):
    """The figures of all cases: ``responses.plot.peaks()``, which is what ``responses.plot()`` draws, and ``.history()``."""

    result: Responses

    def peaks(self) -> Any:
        """Peak displacement, drift and acceleration by floor."""
        return style.in_pyplot(peaks_by_floor, *self.result.peaks_by_floor(), axes=PEAK_AXES, origin=self.result.origin)

    def history(self, floor: str | None = None) -> Any:
        """The displacement of one floor over time; without ``floor``, its label, of the highest."""
        responses = self.result
        first = next(iter(responses.cases.values()))
        name = first.floors[-1] if floor is None else str(floor)
        if name not in first.floors:
            raise InputError(f"{floor!r} is not a floor of {responses.building}; choose from {', '.join(first.floors)}")
        k = first.floors.index(name)
        cases = {case: response.displacement[k] for case, response in responses.cases.items()}
        return style.in_pyplot(building_response, first.time, cases, title=f"floor {name}", origin=responses.origin)


plots.register(Responses, ResponsesPlots)
