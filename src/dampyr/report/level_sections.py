"""Sections on levels: how records and sessions differ, and what of a record lies in its predictive band."""

from __future__ import annotations

import numpy as np

from dampyr.figures.band import band as band_figure
from dampyr.identification import Fit, Validated
from dampyr.identification.scoring.validate import bands_in_words
from dampyr.report.blocks import Block, Cell, FigureBlock, Section, Table, Text
from dampyr.representation import percent, sentence


def levels_section(fit: Fit) -> Section | None:
    """The levels of the fitted records by session; None where the fit made no damper."""
    levels = fit.levels
    if levels is None:
        return None
    rows: list[list[Cell]] = []
    for session in levels.sessions:
        own = np.array([levels.level[name] for name, of in levels.session.items() if of == session])
        spread = 100 * float(np.std(np.log(own), ddof=1)) if own.size > 1 else None
        rows.append([session, own.size, 100 * (float(np.exp(np.mean(np.log(own)))) - 1.0), spread])
    words = (
        "The level of a record is a factor on the fitted force, without its offset. Within a session records differ by "
        f"{percent(levels.record_sd)}, sessions by {levels.spread_words}; standard deviations."
    )
    table = Table(
        ("session", "records", "mean level", "spread"),
        rows,
        ("", "", "%", "%"),
        caption="The mean level of the records of each session against the fit, and their standard deviation.",
        digits=3,
    )
    return Section("Levels of records and sessions", [Text(words), table])


def bands_section(result: Validated) -> Section:
    """The level of each record, and how much its predictive band holds of its force, its peak and its energy."""
    if not result.bands:
        return Section(
            "Levels",
            [Text(sentence(result.no_band) if result.no_band else "No bands were asked for."), _levels(result)],
        )
    error = result.damper.prediction_error
    share = f"{100 * next(iter(result.bands.values())).level:g} %"
    words = (
        f"A band holds {share} of what may be measured: the coefficients, the levels of sessions and records, the shape that "
        "the model misses and the noise are drawn together. A record of a session that the card was not fitted on counts as of "
        "a new one."
    )
    if error is not None:
        words += f" {sentence(error.session_source)}"
    rows: list[list[Cell]] = []
    for name, one in result.bands.items():
        energy = one.energy
        rows.append(
            [name, one.session or "new", 100 * one.holds, 100 * one.width, one.peak.measured, one.peak.low, one.peak.high,
             *((None, None, None) if energy is None else (energy.measured, energy.low, energy.high))]
        )  # fmt: skip
    table = Table(
        ("record", "session", "holds", "width ±", "peak", "from", "to", "energy", "from", "to"),
        rows,
        ("", "", "%", "%", "N", "N", "N", "J", "J", "J"),
        caption=sentence(bands_in_words(result.bands)),
        digits=3,
    )
    name = min(result.bands, key=lambda each: result.bands[each].holds)
    record, one = next(each for each in result.records if each.name == name), result.bands[name]
    inside = one.window.slice
    drawn = record.time[inside], record.force[inside], one.low[inside], one.high[inside]
    figure = band_figure(*drawn, one.level, record_origin=record.origin)
    caption = f"{name}, of which the band holds least: {100 * one.holds:.3g} %."
    blocks: list[Block] = [Text(words), table, FigureBlock(figure, caption), _levels(result)]
    return Section("Predictive bands and levels", blocks)


def _levels(result: Validated) -> Table:
    rows: list[list[Cell]] = [
        [record.name, one.level, 100 * one.l1, 100 * one.relevelled_l1]
        for record in result.records
        for one in (result.scores[record.name],)
    ]
    return Table(
        ("record", "level", "L1", "relevelled"),
        rows,
        ("", "", "%", "%"),
        caption="The level that the first cycles of each record put on the predicted force, and the L1 "
        "ratio of the rest with it.",
        digits=3,
    )
