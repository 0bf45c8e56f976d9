"""Section on what the records of a fit cannot separate."""

from __future__ import annotations

from dampyr.identification.parameter_uncertainty.identifiability import Identifiability
from dampyr.phrases import sentence
from dampyr.show.pages.blocks import Block, Section, Text
from dampyr.show.table import Table


def identifiability_section(result: Identifiability, has_input: bool = True) -> Section:
    """What cannot be separated, and the test that would, a row each."""
    title = "What these records cannot separate"
    if not result.inseparable:
        and_input = ", and voltage from session" * has_input
        return Section(title, [Text(f"These records separate every number that was fitted{and_input}.")])
    rows = [[sentence(inseparable.words), sentence(inseparable.test)] for inseparable in result.inseparable]
    caption = (
        "Correlations and widths are those of the fitted model. A test is proposed from motions within the stroke, the speed "
        "and the acceleration of these records; it counts as one record more."
    )
    blocks: list[Block] = [Table(("what the records cannot separate", "the test that would"), rows, caption=caption)]
    return Section(title, blocks)
