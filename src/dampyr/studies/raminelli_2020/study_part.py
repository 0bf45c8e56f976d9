"""A part of the study: compared, what stands on the page, and slips of the text that it showed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dampyr.show.pages.blocks import Block
from dampyr.show.pages.html_page import number
from dampyr.show.table import Cell, Table, Verdict
from dampyr.studies.raminelli_2020.compared_value import ComparedValue, Erratum


@dataclass(frozen=True)
class StudyPart:
    """What one chapter or artefact gave."""

    title: str
    compared: Sequence[ComparedValue]
    blocks: Sequence[Block]
    errata: Sequence[Erratum] = ()


def compared_table(judged: Sequence[ComparedValue], caption: str = "", digits: int = 6) -> Table:
    """Published beside ours, with the verdict and its reason."""
    rows: list[list[Cell]] = [
        [f.artefact, f.quantity, _shown(f.published), _shown(f.ours), f.unit, Verdict(f.verdict, f.reason)]
        for f in judged
    ]
    columns = ("artefact", "quantity", "published", "ours", "unit", "verdict")
    align = ("left", "left", "right", "right", "left", "left")
    return Table(columns, rows, align=align, caption=caption, digits=digits)


def _shown(value: float | str | None) -> Cell:
    text = getattr(value, "text", None)
    if text is None:
        return value
    digits = len(text.partition("e")[0].replace("-", "").replace(".", "").lstrip("0"))
    return number(float(text), digits) if "e" in text else text.replace("-", "−")
