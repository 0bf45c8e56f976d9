"""Section on the residuals of a fit."""

from __future__ import annotations

from dampyr.identification.fits.diagnostics import findings
from dampyr.identification.fits.residuals import SIDES, Residuals
from dampyr.input_kinds import INPUTS, unit_of
from dampyr.phrases import sentence
from dampyr.show.figures.autocorrelation import memory
from dampyr.show.figures.residual_sizes import residual_sizes
from dampyr.show.figures.residual_velocity import residual_velocity
from dampyr.show.figures.style import case_colours, input_axis
from dampyr.show.identification.residuals import groups_of_a_figure, sizes_by_input, velocity_bands
from dampyr.show.pages.blocks import FigureBlock, Section, Text
from dampyr.show.table import Cell, Table


def residual_section(residuals: Residuals) -> Section:
    """The analysis in words, figures and tables."""
    by_input = sizes_by_input(residuals)
    explanation = (
        "The residual is the measured minus the modelled force, over every sample that was fitted. A complete model leaves "
        "only noise: equal in both directions, uncorrelated in time, and of one size everywhere.\n\n"
        + " ".join(sentence(text) for text in findings(residuals))
    )
    limits = residuals.thresholds
    criterion = (
        f"A record counts as misfit where its residual's correlation time exceeds {limits.correlated:g} sampling intervals, or "
        f"its rms exceeds {limits.beyond_noise:g} times the noise, that is the rms of the differences of successive residuals "
        "over √2."
    )
    return Section(
        "Residuals",
        [
            Text(explanation),
            Text(criterion),
            FigureBlock(
                residual_velocity(velocity_bands(residuals)),
                "The residual over the velocity (positive: the damper is pulled): median and the half of the samples around "
                "it, before the motion passes the middle of its stroke (speeding up) and beyond it (slowing down).",
            ),
            _direction_table(residuals),
            FigureBlock(
                memory([(r.lags, r.autocorrelation) for r in residuals.records], residuals.correlation_time),
                "The autocorrelation of the residual. That of noise would fall to 0 at once; a part that repeats in each "
                "cycle is an error of the model.",
            ),
            FigureBlock(
                residual_sizes(
                    by_input,
                    input_axis(residuals.unit) if residuals.unit in INPUTS else None,
                    colours=case_colours(by_input),
                ),
                "The residual's rms over the standard deviation of the force, one point per record; stroke is peak to peak.",
            ),
        ],
    )


def _direction_table(residuals: Residuals) -> Table:
    groups = groups_of_a_figure(residuals)
    rows: list[list[Cell]] = [
        [side, *(value for group in groups.values() for value in (group.sides[side].mean, group.sides[side].rms))]
        for side in SIDES
    ]
    columns = ["moving", *(f"{what}, {name}" for name in groups for what in ("mean", "rms"))]
    return Table(
        columns,
        rows,
        ("", *["N"] * (len(columns) - 1)),
        ("left", *["right"] * (len(columns) - 1)),
        caption="The residual by direction: out is pulled, in is pushed.",
        digits=3,
    )


def size_table(residuals: Residuals) -> Table:
    """What each record is, and what the fit leaves of it: a row a record."""
    rows: list[list[Cell]] = [
        [r.name, f"{r.input_value:.5g}", 1e3 * r.stroke, r.frequency, r.rms, r.noise, r.correlation_time,
         round(r.effective), 100 * r.repeats, r.misfit]
        for r in residuals.records
    ]  # fmt: skip
    table = Table(
        ("record", "input", "stroke", "freq.", "rms", "noise", "τ", "n eff.", "repeats", "misfit"),
        rows,
        ("", unit_of(residuals.unit), "mm", "Hz", "N", "N", "s", "", "%", ""),
        caption="Rms and noise: of the residual. τ: its correlation time. n eff.: effective sample size. Repeats: the share of "
        "its variance that repeats after one cycle.",
        digits=3,
    )
    return table if residuals.unit in INPUTS else table.without("input")
