"""Section on the residuals of a fit."""

from __future__ import annotations

from dampyr.figures.autocorrelation import memory
from dampyr.figures.residual_sizes import residual_sizes
from dampyr.figures.residual_velocity import residual_velocity
from dampyr.figures.style import CURRENT, VOLTAGE
from dampyr.identification import Residuals, findings, warnings_of
from dampyr.identification.residuals import MISFIT_INTERVALS, MISFIT_NOISE, SIDES, Group
from dampyr.report.blocks import Block, Cell, FigureBlock, Section, Table, Text, sentence

MAX_PANELS = 6  # inputs: more panels cannot be read on a page


def residual_section(residuals: Residuals) -> Section:
    """The analysis in words, figures and tables."""
    words, groups = _words(residuals), _groups(residuals)
    directions, sizes = _direction_table(groups), _size_table(residuals)
    curves = {
        name: {branch: (c.velocity, c.lower, c.median, c.upper) for branch, c in group.curves.items()}
        for name, group in groups.items()
    }
    relative = {}
    for group in residuals.groups:
        members = [r for r in residuals.records if r.name in group.records]
        columns = zip(*((r.input_value, r.stroke, r.frequency, r.relative) for r in members), strict=True)
        relative[f"{group.input_value:.5g} {residuals.unit}"] = tuple(columns)
    return Section(
        "Residuals",
        [
            *words,
            FigureBlock(
                residual_velocity(curves),
                "The residual over the velocity (positive: the damper is pulled): median and the half of the samples around "
                "it, before the motion passes the middle of its stroke (speeding up) and beyond it (slowing down).",
            ),
            directions,
            FigureBlock(
                memory([(r.lags, r.autocorrelation) for r in residuals.records], residuals.correlation_time),
                "The autocorrelation of the residual. That of noise would fall to 0 at once; a part that repeats in each "
                "cycle is an error of the model.",
            ),
            FigureBlock(
                residual_sizes(relative, VOLTAGE if residuals.unit == "V" else CURRENT),  # type: ignore[arg-type]
                "The residual's rms over the standard deviation of the force, one point per record; stroke is peak to peak.",
            ),
            sizes,
        ],
    )


def _words(residuals: Residuals) -> list[Block]:
    warning_texts = warnings_of(residuals)
    blocks: list[Block] = [
        Text(
            "The residual is the measured minus the modelled force, over every sample that was fitted. A complete model leaves "
            "only noise: equal in both directions, uncorrelated in time, and of one size everywhere.\n\n"
            + " ".join(sentence(text) for text in findings(residuals))
        )
    ]
    if warning_texts:
        blocks.append(Text("\n\n".join(f"Warning: {text}." for text in warning_texts)))
    criterion = (
        f"A record counts as misfit where its residual's correlation time exceeds {MISFIT_INTERVALS:g} sampling intervals, or "
        f"its rms exceeds {MISFIT_NOISE:g} times the noise, that is the rms of the differences of successive residuals over √2."
    )
    return [*blocks, Text(criterion)]


def _groups(residuals: Residuals) -> dict[str, Group]:
    """By input while a page can hold that, else all records as one."""
    if len(residuals.groups) > MAX_PANELS:
        return {"all records": residuals.whole}
    return {f"{group.input_value:.5g} {residuals.unit}": group for group in residuals.groups}


def _direction_table(groups: dict[str, Group]) -> Table:
    rows: list[list[Cell]] = [
        [name, side, group.sides[side].mean, group.sides[side].rms, group.sides[side].samples]
        for name, group in groups.items()
        for side in SIDES
    ]
    return Table(
        ("input", "moving", "mean", "rms", "samples"),
        rows,
        ("", "", "N", "N", ""),
        ("left", "left", "right", "right", "right"),
        caption="The residual by direction: out is pulled, in is pushed.",
        digits=3,
    )


def _size_table(residuals: Residuals) -> Table:
    rows: list[list[Cell]] = [
        [r.name, f"{r.input_value:.5g}", 1e3 * r.stroke, r.frequency, r.rms, 100 * r.relative, r.noise, r.correlation_time,
         round(r.effective), 100 * r.repeats, r.misfit]
        for r in residuals.records
    ]  # fmt: skip
    return Table(
        ("record", "input", "stroke", "freq.", "rms", "rel.", "noise", "τ", "n eff.", "repeats", "misfit"),
        rows,
        ("", residuals.unit, "mm", "Hz", "N", "%", "N", "s", "", "%", ""),
        caption="The residual of each record. Rel.: rms over the force's spread. τ: correlation time. n eff.: effective "
        "sample size. Repeats: the share of its variance that repeats after one cycle.",
        digits=3,
    )
