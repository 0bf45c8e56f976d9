"""The page of a validation: how well a card predicts records."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrWarning, InputError
from dampyr.identification import Score
from dampyr.identification.fits.residuals import motion
from dampyr.identification.scoring.score import prediction
from dampyr.identification.scoring.validate import Validated
from dampyr.input_kinds import INPUTS
from dampyr.models import Damper
from dampyr.origin import combined
from dampyr.records import Record, with_velocity
from dampyr.show.figures.calibration_range import calibrated
from dampyr.show.figures.scores import scores as scores_figure
from dampyr.show.identification.score import group_by_input, input_words
from dampyr.show.identification.validate import by_input, validated_scores
from dampyr.show.pages.best_and_worst import extremes, record_section
from dampyr.show.pages.blocks import Block, FigureBlock, Section, Text, to_look_at
from dampyr.show.pages.html_page import page
from dampyr.show.pages.level_sections import bands_section
from dampyr.show.pages.range_section import SHOWN, range_table
from dampyr.show.table import Cell, Table

Array = NDArray[np.float64]
SLACK = 1.01  # a record that reaches 1 % beyond the range, as noise does, is still inside
OF_ONE = {
    True: "The card was fitted on this record, so its score describes the fit and predicts nothing.",
    False: "The card was not fitted on this record: the score is a prediction.",
    None: "The card does not say whether this record was fitted, so this score may be no prediction.",
}
SEEN = {True: "fitted", False: "unseen", None: "unknown"}


def html(result: Validated, *, call: str = "") -> str:
    """The page of the result of `dampyr.identification.validate`.

    It shows scores, which records the card was fitted on, what lies outside its range, and the best and the worst record.
    Raises :class:`~dampyr.errors.InputError` where a record has no score.
    """
    damper, records, card = result.damper, result.records, result.card
    _check(records, result.scores)
    record_scores = {record.name: result.scores[record.name] for record in records}
    fitted_on = result.fitted_on
    stated = {name: text for name, text in damper.provenance.items() if name != "dampyr"}  # of cards up to 0.3.0
    of_card = damper.origin.facts() | stated
    along = f"each of {len(records)} records" if len(records) > 1 else "one record"
    return page(
        f"Validated: {Path(card).name}",
        [
            Section("In short", [*_short(records, record_scores, fitted_on), *to_look_at(result.findings)]),
            Section("Scores", _scores(result)),
            bands_section(result),
            Section("Outside the calibrated range", _outside(damper, records)),
            *(_record(damper, records, record_scores, words, name) for words, name in extremes(record_scores)),
        ],
        subtitle=f"{damper.composition}: a free run along {along}, of which only the offset is taken.",
        provenance={"card": card, **{f"{name} of the card": text for name, text in of_card.items()}},
        call=call,
        origin=replace(combined(record.origin for record in records), kind=result.origin.kind),
    )


def _check(records: Sequence[Record], scores: Mapping[str, Score]) -> None:
    if not records:
        raise InputError("there are no records to show; give one or more")
    missing = [record.name for record in records if record.name not in scores]
    if missing:
        raise InputError(f"{missing[0]} has no score; score every record that is shown")


def _short(records: Sequence[Record], scores: Mapping[str, Score], fitted_on: Mapping[str, bool | None]) -> list[Block]:
    rows: list[list[Cell]] = []
    for state, words in SEEN.items():
        values = [scores[r.name] for r in records if fitted_on[r.name] is state]
        if values:
            rows.append(
                [words, len(values), 100 * float(np.mean([s.l1 for s in values])), 100 * max(s.l1 for s in values),
                 100 * float(np.mean([s.nrmse for s in values]))]
            )  # fmt: skip
    hint = {
        True: "These records were fitted, so their scores describe the fit and predict nothing.",
        False: "None of these records was fitted: the scores are predictions.",
        None: "The card does not say whether these records were fitted, so these scores may be no predictions.",
    }
    if len(records) == 1:
        name, score = next(iter(scores.items()))
        [state] = fitted_on.values()
        return [Text(f"{name}: L1 {100 * score.l1:.3g} %, NRMSE {100 * score.nrmse:.3g} %.\n\n{OF_ONE[state]}")]
    states = set(fitted_on.values())
    text = hint[states.pop()] if len(states) == 1 else "Only the scores of unseen records are predictions."
    table = Table(
        ("by the card", "records", "mean L1", "worst L1", "mean NRMSE"), rows, ("", "", "%", "%", "%"), digits=3
    )
    return [Text(text), table]


def _scores(result: Validated) -> list[Block]:
    records, scores, fitted_on = result.records, result.scores, result.fitted_on
    table = replace(validated_scores(result), caption="The scores by record.")
    if len(records) == 1:
        return [table]
    groups: dict[str, list[float]] = {}
    for state, words in SEEN.items():
        l1 = {r.name: scores[r.name].l1 for r in records if fitted_on[r.name] is state}
        groups |= {f"{name}, {words}": values for name, values in group_by_input(records, l1).items()}
    return [
        FigureBlock(
            scores_figure(groups),
            f"L1 ratio of each record, {'by input and ' * result.damper.has_input}by whether the card was fitted on it.",
        ),
        table,
        *([by_input(result)] if len(result.by_input) > 1 else []),
    ]


def _outside(damper: Damper, records: Sequence[Record]) -> list[Block]:
    rows: list[list[Cell]] = []
    groups: dict[str, tuple[list[float], list[float]]] = {}
    for record in sorted(records, key=lambda r: -np.inf if r.input_value is None else r.input_value):
        stroke, frequency = motion(record)
        group = groups.setdefault(input_words(record), ([], []))
        group[0].append(frequency)
        group[1].append(0.5 * stroke)
        rows += [[record.name, *row] for row in beyond(damper, record)]
    blocks: list[Block] = [range_table(damper)]
    if rows:
        columns = ("record", "quantity", "reaches", "calibrated from", "to", "unit")
        blocks.append(
            Table(columns, rows, caption="Outside the calibrated range the damper is extrapolated.", digits=4)
        )
    else:
        which = "Every record lies" if len(records) > 1 else "The record lies"
        blocks.append(Text(f"{which} inside the calibrated range of the card."))
    if len(records) > 1 and any(np.any(np.isfinite(frequencies)) for frequencies, _ in groups.values()):
        caption = "The records by the frequency and the amplitude (half of peak to peak, per cycle) that were measured."
        blocks.append(FigureBlock(calibrated(groups, damper.ranges), caption))
    return blocks


def beyond(damper: Damper, record: Record) -> list[list[Cell]]:
    """What of a record lies outside the damper's range: quantity, what it reaches, from, to, unit; a row for each."""
    rows: list[list[Cell]] = []
    u = record.input_channel
    low, high = damper.range
    for value in sorted({float(np.min(u)), float(np.max(u))}) if u is not None else []:
        if not low - 1e-9 <= value <= high + 1e-9:
            rows.append([INPUTS[damper.input], value, low, high, damper.input])
    reached = {
        "displacement": 0.5 * float(np.ptp(record.displacement)),
        "velocity": float(np.max(np.abs(_velocity(damper, record)))),
        "frequency": motion(record)[1],
    }
    for name, (low, high) in damper.ranges.items():
        value = reached.get(name, float("nan"))
        if value > SLACK * high or value < low / SLACK:
            words, unit, factor = SHOWN[name]
            rows.append([words, value * factor, low * factor, high * factor, unit])
    return rows


def _velocity(damper: Damper, record: Record) -> Array:
    if record.velocity is None or damper.bandwidth is not None:
        record = with_velocity(record, damper.bandwidth)
    assert record.velocity is not None
    return record.velocity


def _record(damper: Damper, records: Sequence[Record], scores: Mapping[str, Score], words: str, name: str) -> Section:
    record = next(r for r in records if r.name == name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)  # what they say stands in the table of what lies outside
        force = prediction(damper, record, allow_extrapolation=True)
    scored = scores[name].window.slice
    channels = (
        record.time[scored],
        record.displacement[scored],
        _velocity(damper, record)[scored],
        record.force[scored],
        force[scored] + scores[name].offset,
    )
    return record_section(words, name, channels, "card", record.origin)
