"""Sections on levels: how records and sessions differ, and what of a record lies in its predictive band."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dampyr.identification import Fit
from dampyr.identification.scoring.validate import Validated
from dampyr.phrases import percent, sentence
from dampyr.show.figures.band import band as band_figure
from dampyr.show.identification.validate import bands_in_words, levels_and_bands
from dampyr.show.pages.blocks import FigureBlock, Section, Text
from dampyr.show.table import Cell, Table


def levels_section(fit: Fit) -> Section | None:
    """The levels of the fitted records by session; None where the fit made no damper."""
    levels = fit.levels
    if levels is None:
        return None
    rows: list[list[Cell]] = []
    for session in levels.sessions:
        of_session = np.array([levels.level[name] for name, its in levels.session.items() if its == session])
        spread = 100 * float(np.std(np.log(of_session), ddof=1)) if of_session.size > 1 else None
        # levels are factors, so their mean is the geometric one
        rows.append([session, of_session.size, 100 * (float(np.exp(np.mean(np.log(of_session)))) - 1.0), spread])
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
    table = levels_and_bands(result)
    if not result.bands:
        return Section("Levels", [table] if result.no_band else [Text("No bands were asked for."), table])
    share = f"{100 * next(iter(result.bands.values())).level:g} %"
    words = (
        f"A band holds {share} of what may be measured: the coefficients, the levels of sessions and records, the shape that "
        "the model misses and the noise are drawn together. A record of a session that the card was not fitted on counts as of "
        "a new one."
    )
    name = min(result.bands, key=lambda name: result.bands[name].holds)
    record, band = next(record for record in result.records if record.name == name), result.bands[name]
    inside = band.window.slice
    drawn = record.time[inside], record.force[inside], band.low[inside], band.high[inside]
    figure = band_figure(*drawn, band.level, record_origin=record.origin)
    caption = f"{name}, of which the band holds least: {100 * band.holds:.3g} %."
    table = replace(table, caption=sentence(bands_in_words(result.bands)))
    return Section("Predictive bands and levels", [Text(words), table, FigureBlock(figure, caption)])
