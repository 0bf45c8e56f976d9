"""What the screening of a model shows."""

from __future__ import annotations

from dampyr.identification.model_choice.screening import Screened
from dampyr.phrases import counted, percent
from dampyr.show.descriptions import Description, describe
from dampyr.show.table import Cell, Table


@describe.register
def describe_screened(screened: Screened) -> Description:
    """The errors bare and at best, and a table of the trials."""
    return Description(
        f"Screened {screened.base!r}",
        [
            ("bare", percent(screened.bare.error)),
            ("best", f"{percent(screened.best.error)}, {screened.best.model}"),
            ("tried", counted(len(screened.trials), "composition")),
        ],
        tables=[lambda: _trials(screened)],
    )


def _trials(screened: Screened) -> Table:
    """One row a trial: its error, its time, and why there is none."""
    rows: list[list[Cell]] = [
        [trial.model, 100 * trial.error, trial.seconds, trial.reason] for trial in screened.trials
    ]
    return Table(("model", "validation error", "time", "reason"), rows, ("", "%", "s", ""))
