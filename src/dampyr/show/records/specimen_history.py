"""What the history of specimens shows."""

from __future__ import annotations

from datetime import datetime
from typing import TYPE_CHECKING, Any

from dampyr.findings import as_dicts
from dampyr.phrases import counted, listing
from dampyr.records.specimen_history import SpecimenHistories
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.table import Cell, Table
from dampyr.to_json import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FEW = 3  # names that a cell lists


@describe.register
def describe_histories(result: SpecimenHistories) -> Description:
    """How many specimens and tests; a table of them, one of the trends, and forces and energies over the days."""
    tests = sum(history.complete + history.incomplete for history in result)
    return Description(
        f"SpecimenHistories in {listing(list(result.folders), FEW)}",
        [("specimens", str(len(result))), ("tests", counted(tests, "record"))],
        tables=[lambda: history_table(result), lambda: trend_table(result)],
        figure=lambda: trend_figure(result),
        data=lambda: _numbers(result),
        frame=lambda: _columns(result),
    )


def history_table(result: SpecimenHistories) -> Table:
    """A row for each specimen."""
    rows: list[list[Cell]] = [
        [
            history.specimen,
            history.laboratory,
            history.complete,
            history.incomplete,
            history.dates[0] if history.dates else None,
            history.dates[-1] if history.dates else None,
            listing(list(history.operators), FEW) or None,
            listing(list(history.cards), FEW) or None,
            listing(list(history.verdicts), FEW) or None,
        ]
        for history in result
    ]
    heads = ("specimen", "rig", "complete", "incomplete", "first", "last", "operators", "cards", "verdicts")
    return Table(heads, rows, caption="Specimens.")


def trend_table(result: SpecimenHistories) -> Table:
    """A row for each kind of test that a specimen was given several times."""
    rows: list[list[Cell]] = [
        [
            history.specimen, trend.test, len(trend.points), trend.points[0].started[:10], trend.points[-1].started[:10],
            trend.points[-1].force, 100.0 * trend.force_change, trend.points[-1].energy, 100.0 * trend.energy_change,
        ]
        for history in result
        for trend in history.trends
    ]  # fmt: skip
    heads = ("specimen", "test", "times", "first", "last", "force", "change", "energy", "its change")
    note = "force at peak velocity, half of the difference of both ways, and energy of a cycle: the last, and against the first"
    return Table(heads, rows, ("", "", "", "", "", "N", "%", "J", "%"), caption="Trends.", notes=[note])


def trend_figure(result: SpecimenHistories) -> Figure | None:
    """Force at peak velocity and energy of equal tests over the days since the first of them; None where there are none."""
    trends = [(history.specimen, trend) for history in result for trend in history.trends]
    if not trends:
        return None
    first = min(_time(trend.points[0].started) for _, trend in trends)
    with style.panels(2.6, 1, 2) as (fig, panels):
        for specimen, trend in trends:
            days = [(_time(point.started) - first) / 86400.0 for point in trend.points]
            for panel, values in zip(panels[0], ("force", "energy"), strict=True):
                numbers = [getattr(point, values) for point in trend.points]
                panel.plot(days, numbers, "o-", ms=4, lw=1.0, label=f"{specimen}: {trend.test}")
        for panel, name in zip(panels[0], ("force at peak velocity [N]", "energy of a cycle [J]"), strict=True):
            panel.set_xlabel("time [days]")
            panel.set_ylabel(name)
            panel.set_ylim(bottom=0.0)
        style.legend(fig, panels[0, 0], columns=2, min_entries=1)
    return fig


def _time(started: str) -> float:
    """s of the clock."""
    return datetime.fromisoformat(started).timestamp()


def _numbers(result: SpecimenHistories) -> dict[str, Any]:
    answer = {
        "folders": result.folders,
        "origin": result.origin.as_dict(),
        "findings": as_dicts(result.findings),
        "specimens": [
            plain(history) | {
                "trends": [
                    plain(trend) | {"force_change": trend.force_change, "energy_change": trend.energy_change}
                    for trend in history.trends
                ]
            }
            for history in result
        ],
    }  # fmt: skip
    return dict(plain(answer))


def _columns(result: SpecimenHistories) -> DataFrameColumns:
    points = [(history, trend, point) for history in result for trend in history.trends for point in trend.points]
    if not points:
        names = ("laboratory", "complete", "incomplete")
        columns = {name: [getattr(history, name) for history in result] for name in names}
        return DataFrameColumns(columns, [history.specimen for history in result], "specimen")
    columns = {
        "laboratory": [history.laboratory for history, _, _ in points],
        "test": [trend.test for _, trend, _ in points],
        "started": [point.started for _, _, point in points],
        "record": [point.record for _, _, point in points],
        "force_n": [point.force for _, _, point in points],
        "energy_j": [point.energy for _, _, point in points],
    }
    return DataFrameColumns(columns, [history.specimen for history, _, _ in points], "specimen")
