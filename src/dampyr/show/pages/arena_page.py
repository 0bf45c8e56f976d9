"""The page of an arena: who wins, how often each input is the best, each against each, and the ensemble's accuracy."""

from __future__ import annotations

from dampyr.show.pages.blocks import FigureBlock, Section, Text, to_look_at
from dampyr.show.pages.html_page import page
from dampyr.show.structures.arena import against_each_other, figure, standings, verdict
from dampyr.show.structures.ensemble_result import cases_in_words, trust
from dampyr.structures.ensembles.arena import Arena


def html(result: Arena, *, call: str = "") -> str:
    """The page of what `dampyr.structures.arena` gives."""
    dataset = result.result.dataset
    names = ", ".join(str(name) for name in dataset.building_name.values)
    caption = f"How often each input has the smallest {result.criterion}, with the 90 % band."
    return page(
        f"Arena: {names}",
        [
            Section(
                "Who wins",
                [
                    Text(verdict(result)),
                    *to_look_at(result.findings),
                    FigureBlock(figure(result), caption),
                    standings(result),
                ],
            ),
            Section("Each against each", [against_each_other(result)]),
            Section("Accuracy", [Text("\n\n".join(trust(dataset)))]),
        ],
        subtitle=f"{dataset.attrs['cases']} cases: {cases_in_words(dataset)}",
        provenance={"buildings": names, "motions": ", ".join(str(name) for name in dataset.motion_name.values)},
        call=call,
        origin=result.origin,
    )
