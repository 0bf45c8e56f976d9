"""What the validation of a card shows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from dampyr.findings import as_dicts
from dampyr.identification.scoring.prediction_band import Band
from dampyr.identification.scoring.validate import Validated
from dampyr.phrases import counted, percent, sentence
from dampyr.records import Record
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.history import history
from dampyr.show.figures.loops import loops
from dampyr.show.figures.scores import scores
from dampyr.show.identification.score import group_by_input
from dampyr.show.identification.score_groups import scores_by_input
from dampyr.show.identification.validation import score_columns, score_table
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Cell, Table
from dampyr.to_json import plain

FITTED: Mapping[bool | None, str] = {True: "yes", False: "no", None: "unknown"}


@describe.register
def describe_validated(validated: Validated) -> Description:
    """Model, records and mean scores, what the bands hold; tables of scores and bands by record, and of scores by input."""
    l1 = {name: score.l1 for name, score in validated.scores.items()}
    worst = max(l1, key=lambda name: l1[name])
    seen = list(validated.fitted_on.values()).count(True)
    return Description(
        f"Validated {validated.card!r}",
        [
            ("model", str(validated.damper.composition)),
            ("records", f"{counted(len(validated.records), 'record')}, of which the damper was fitted on {seen}"),
            ("L1", f"{percent(sum(l1.values()) / len(l1))} on average, {percent(l1[worst])} in {worst}"),
            (
                "relevelled",
                f"L1 {percent(validated.relevelled_l1)} on average, with the level of each record's first cycles",
            ),
            *([("bands", bands_in_words(validated.bands))] if validated.bands else []),
        ],
        verdict=[
            f"Mean L1 {100 * sum(l1.values()) / len(l1):.2f} % over {counted(len(l1), 'record')}.",
            *([sentence(bands_in_words(validated.bands))] if validated.bands else []),
        ],
        tables=[
            lambda: validated_scores(validated),
            lambda: levels_and_bands(validated),
            *([lambda: by_input(validated)] if len(validated.by_input) > 1 else []),
        ],
        figure=lambda: scores(_l1_by_input(validated)),
        data=lambda: _numbers(validated),
        frame=lambda: _columns(validated),
    )


def _l1_by_input(validated: Validated) -> dict[str, list[float]]:
    """The L1 ratio of each record, by its input in words."""
    return group_by_input(validated.records, {name: score.l1 for name, score in validated.scores.items()})


def validated_scores(validated: Validated) -> Table:
    """The errors of the prediction of each record, and whether the damper was fitted on it."""
    table, fitted_on = score_table(validated.scores), validated.fitted_on
    of_record = {record.name: (record.input_value, FITTED[fitted_on[record.name]]) for record in validated.records}
    shown = replace(
        table,
        columns=("record", "input", "fitted on", *table.columns[1:]),
        rows=[(row[0], *of_record[str(row[0])], *row[1:]) for row in table.rows],
        units=("", validated.damper.input, "", *table.units[1:]),
        caption=f"{validated.card}: {validated.damper.composition}.",
        notes=[
            "Fitted on: by the names and the files of the records that the card lists. Relevelled: the L1 with the level of "
            "the record's first cycles. The offset was taken from the record.",
            *table.notes,
        ],
    )
    return shown if validated.damper.has_input else shown.without("input")


def levels_and_bands(validated: Validated) -> Table:
    """Window and level of each record; where there are bands, its session, and how much its band holds of the force, the peak
    and the energy."""
    columns, units = ["record", "window", "level"], ["", "s", ""]
    notes = [
        "The window of each score starts after the run-in. Level: the factor that the first cycles put on the predicted force."
    ]
    bands = validated.bands
    if bands:
        share = f"{100 * next(iter(bands.values())).level:g} % band"
        columns += ["session", f"{share} holds", "width ±", "peak", "expected", "energy", "expected"]
        units += ["", "%", "%", "N", "N", "J", "J"]
        sessions = sorted({band.session for band in bands.values() if band.session is not None})
        of_fitted = f"; those of {', '.join(sessions)} have the level of that session" if sessions else ""
        notes.append(f"Width: of the mean force. Records count as of a new measurement session{of_fitted}.")
        error = validated.damper.prediction_error
        if error is not None:
            notes.append(sentence(error.session_source))
            if not error.session_estimated:
                notes.append(
                    "Another level between sessions may be stated: --session-prior, or session_prior in Python."
                )
    elif validated.no_band:
        notes.append(sentence(validated.no_band))
    return Table(
        columns,
        [_level_and_band(validated, record.name) for record in validated.records],
        units,
        caption="Level of each record, and predictive bands." if bands else "Level of each record.",
        notes=notes,
        digits=3,
    )


def _level_and_band(validated: Validated, name: str) -> list[Cell]:
    score, band = validated.scores[name], validated.bands.get(name)
    level = None if math.isnan(score.level) else score.level
    row: list[Cell] = [name, f"{score.window.start:.2f}–{score.window.end:.2f}", level]
    if band is None:
        return row + [None] * 7 * bool(validated.bands)
    peak, energy = band.peak, band.energy
    row += [
        band.session or "new",
        100 * band.holds,
        100 * band.width,
        peak.measured,
        f"{peak.low:.4g} to {peak.high:.4g}",
    ]
    return row + ([None, None] if energy is None else [energy.measured, f"{energy.low:.3g} to {energy.high:.3g}"])


def by_input(validated: Validated) -> Table:
    """Mean and worst L1 of the records of each input."""
    return replace(scores_by_input(validated.records, validated.scores, "By input"), notes=())


def bands_in_words(bands: Mapping[str, Band]) -> str:
    """How much the bands hold of the records, and of how many the peak."""
    all_bands = list(bands.values())
    holds = sum(band.holds for band in all_bands) / len(all_bands)
    peaks = sum(band.peak.holds for band in all_bands)
    words = (
        f"the {percent(all_bands[0].level)} bands hold {percent(holds)} of the samples and the peaks of {peaks} of "
        f"{counted(len(all_bands), 'record')}"
    )
    return f"{words}, {all_bands[0].prior}" if all_bands[0].prior else words


def _numbers(validated: Validated) -> dict[str, Any]:
    """All results for JSON, SI units."""
    fitted_on = validated.fitted_on
    scores = {name: score.as_dict() | {"fitted_on": fitted_on[name]} for name, score in validated.scores.items()}
    bands = {name: band.as_dict() for name, band in validated.bands.items()}
    more = {"no_band": validated.no_band} if validated.no_band else {}
    answer = {
        "card": validated.card,
        "origin": validated.origin.as_dict(),
        "findings": as_dicts(validated.findings),
        "scores": scores,
        **({"by_input": validated.by_input} if validated.damper.has_input else {}),
        "bands": bands,
    }
    return dict(plain(answer | more))


def _columns(validated: Validated) -> DataFrameColumns:
    """The score of each record: ratios, and the offset in N."""
    columns: dict[str, Any] = {}
    if validated.damper.has_input:
        columns = {f"input_{validated.damper.input}": [record.input_value for record in validated.records]}
    return DataFrameColumns(columns | score_columns(validated.scores), list(validated.scores), "record")


@dataclass(frozen=True)
class ValidatedPlots(Plots):
    """``validated.plot.history(record)``, ``.loops(record)`` and ``.scores()``, which is what ``validated.plot()`` draws.

    ``record`` is one of the records, or its name.
    """

    result: Validated

    def history(self, record: str | Record) -> Any:
        """Measured and predicted force over time, the record's offset taken, and the residual below."""
        measured, predicted = self.result.measured_and_predicted(record)
        drawn, origin = (measured.time, measured.force, predicted), self.result.origin
        named = {"name": "predicted", "title": measured.name, "record_origin": measured.origin}
        return style.in_pyplot(history, *drawn, **named, origin=origin)

    def loops(self, record: str | Record) -> Any:
        """Measured and predicted force over displacement, and over velocity where the record has it."""
        measured, predicted = self.result.measured_and_predicted(record)
        drawn = measured.displacement, measured.velocity, measured.force, {"predicted": predicted}
        return style.in_pyplot(
            loops, *drawn, title=measured.name, record_origin=measured.origin, origin=self.result.origin
        )

    def scores(self) -> Any:
        """The L1 ratio of each record, by input."""
        return style.in_pyplot(scores, _l1_by_input(self.result), origin=self.result.origin)


plots.register(Validated, ValidatedPlots)
