"""The page of the figures of cycles: in short, loops over one another, every cycle, and what is known of the device."""

from __future__ import annotations

from dataclasses import replace

from dampyr.records.cycle_analysis.cycle_figures import DEVICES, CycleFigures
from dampyr.show.pages.blocks import Block, FigureBlock, Section, Text, to_look_at
from dampyr.show.pages.html_page import page
from dampyr.show.records.cycle_figures import (
    backbone_figure,
    energy_figure,
    in_short,
    named_tables,
    overlay,
    speed_figure,
)
from dampyr.show.table import Table

SECTIONS = (
    ("Loops", (), (overlay,), "The third cycle of each level, or its last one."),
    ("Every cycle", ("cycles", "forces", "records"), (energy_figure,), "The energy of each full cycle."),
    ("Half cycles and backbone", ("backbone", "half-cycles"), (backbone_figure,), "The backbone."),
    (
        "Force and speed",
        ("speeds", "standard-speeds"),
        (speed_figure,),
        "The force at peak velocity in both directions.",
    ),
    ("Complex stiffness", ("complex-stiffness",), (), ""),
    ("Force and input", ("inputs", "steps"), (), ""),
)
"""Heading, tables, figures and the caption of the figure."""


def html(result: CycleFigures, *, call: str = "") -> str:
    """The page of what `dampyr.records.cycles` gives."""
    tables = named_tables(result)
    short: list[Block] = [Text(_short(result)), *to_look_at(result.findings)]
    sections = [Section("In short", [*short, *(tables[name] for name in ("levels",) if name in tables)])]
    for title, names, figures, caption in SECTIONS:
        drawn = [figure for draw in figures if (figure := draw(result))]
        blocks: list[Block] = [FigureBlock(figure, caption) for figure in drawn]
        blocks += [_titled(tables[name], title) for name in names if name in tables]
        if blocks:
            sections.append(Section(title, blocks))
    return page(
        "Figures of cycles",
        sections,
        subtitle=in_short(result),
        provenance={"records": ", ".join(figures.record.name for figures in result)},
        call=call,
        origin=result.origin,
    )


def _short(result: CycleFigures) -> str:
    kinds = dict.fromkeys(figures.device for figures in result)
    meanings = "; ".join(f"{kind} ({DEVICES[kind]})" for kind in kinds)
    missing = "" if kinds.keys() == {"displacement"} else (
        " Equivalent damping, loss factor and second slope are figures of displacement-dependent devices only: the "
        "stiffness of the others may go to zero, and the damping with it to infinity."
    )  # fmt: skip
    return f"Kind of the device: {meanings}.{missing}"


def _titled(table: Table, title: str) -> Table:
    """The table without a caption that only repeats the heading."""
    return replace(table, caption="") if table.caption.removesuffix(".") == title else table
