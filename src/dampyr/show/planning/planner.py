"""What a plan that was performed and its rounds show."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dampyr.findings import as_dicts
from dampyr.phrases import counted, sentence
from dampyr.planning.planner import Planned, Round
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures.expected_widths import expected_widths
from dampyr.show.planning.proposal import half_width
from dampyr.show.table import Cell, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@describe.register
def describe_round(planned_round: Round) -> Description:
    """Its tests, and how its intervals compare with the expected ones."""
    ratios = list(planned_round.ratios.values())
    rows = [("tests", f"{len(planned_round.tests)}, {planned_round.duration / 60:.3g} min")]
    if ratios:
        rows.append(("intervals", f"{np.exp(np.mean(np.log(ratios))):.2f} of what was expected, in the geometric mean"))
    return Description(f"Round {planned_round.number}", rows)


@describe.register
def describe_planned(planned: Planned) -> Description:
    """Why it stopped, its tests and the intervals that were achieved; expected against achieved half widths."""
    rows = [
        ("stopped", planned.reason),
        ("tests", f"{_number_of_tests(planned)} in {counted(len(planned.rounds), 'round')}"),
        ("goal", planned.goal),
        *[(label, f"± {100 * half:.2g} %") for label, half in planned.rounds[-1].achieved.items() if np.isfinite(half)],
    ]
    return Description(
        f"Planned in {planned.folder}",
        rows,
        verdict=[sentence(planned.reason)],
        tables=[lambda: round_table(planned)],
        figure=lambda: widths_figure(planned),
        data=lambda: _numbers(planned),
        frame=lambda: _columns(planned),
    )


def widths_figure(planned: Planned) -> Figure:
    """Expected against achieved half widths of every round, one marker a coefficient."""
    pairs = {
        f"round {planned_round.number}": [
            (planned_round.expected[label], planned_round.achieved[label]) for label in planned_round.ratios
        ]
        for planned_round in planned.rounds
    }
    return expected_widths({name: widths for name, widths in pairs.items() if widths})


def round_table(planned: Planned) -> Table:
    """Expected and achieved half widths of the intervals, one row a coefficient of a round, and the peak's."""
    rows: list[list[Cell]] = [
        [planned_round.number, label, half_width(planned_round.expected.get(label)), half_width(half)]
        for planned_round in planned.rounds
        for label, half in planned_round.achieved.items()
    ]
    rows += [
        [
            planned_round.number,
            planned.goal,
            half_width(planned_round.peak_expected),
            half_width(planned_round.peak_achieved),
        ]
        for planned_round in planned.rounds
        if planned_round.peak_expected is not None
    ]
    return Table(
        ("round", "95 % interval over the value", "expected", "achieved"),
        rows,
        caption=f"{counted(_number_of_tests(planned), 'test')} in {planned.folder}.",
    )


def _number_of_tests(planned: Planned) -> int:
    return sum(len(planned_round.tests) for planned_round in planned.rounds)


def _columns(planned: Planned) -> DataFrameColumns:
    """Expected and achieved half widths in percent, one row a coefficient of a round."""
    pairs = [(planned_round, label) for planned_round in planned.rounds for label in planned_round.achieved]
    columns = {
        "round": [planned_round.number for planned_round, _ in pairs],
        "coefficient": [label for _, label in pairs],
        "expected [%]": [100 * planned_round.expected.get(label, np.nan) for planned_round, label in pairs],
        "achieved [%]": [100 * planned_round.achieved[label] for planned_round, label in pairs],
    }
    return DataFrameColumns(columns)


def _numbers(planned: Planned) -> dict[str, Any]:
    """Rounds, fit and reason by name, for `dampyr.to_json`, SI units."""
    return {
        "folder": str(planned.folder),
        "origin": planned.origin.as_dict(),
        "goal": planned.goal,
        "reached": planned.reached,
        "reason": planned.reason,
        "findings": as_dicts(planned.findings),
        "rounds": [
            {
                "number": planned_round.number,
                "folder": str(planned_round.folder),
                "tests": planned_round.tests,
                "duration_s": planned_round.duration,
                "half_width_expected": dict(planned_round.expected),
                "half_width_achieved": dict(planned_round.achieved),
                "peak_half_width_expected": planned_round.peak_expected,
                "peak_half_width_achieved": planned_round.peak_achieved,
            }
            for planned_round in planned.rounds
        ],
        "parameters": planned.fit.parameters,
        "stderr": planned.fit.stderr,
    }
