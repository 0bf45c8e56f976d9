"""The page of a search over inputs and places: the first, how it is judged where it was not chosen, all others, accuracy."""

from __future__ import annotations

from dampyr.show.pages.blocks import FigureBlock, Section, Text, to_look_at
from dampyr.show.pages.html_page import page
from dampyr.show.structures.arena import against_each_other
from dampyr.show.structures.control_search import candidates, figure, finalists, verdict
from dampyr.show.structures.ensemble_result import cases_in_words, trust
from dampyr.structures.ensembles.control_search import ControlSearch


def html(result: ControlSearch, *, call: str = "") -> str:
    """The page of what `dampyr.structures.search_control` gives."""
    choosing, judging = result.choosing.dataset, result.arena.result.dataset
    names = ", ".join(str(name) for name in choosing.building_name.values)
    caption = "Over the first's, under the motions that were not used for choosing, with the 90 % band."
    return page(
        f"Search: {names}",
        [
            Section(
                "Which is best",
                [
                    Text(verdict(result)),
                    *to_look_at(result.findings),
                    FigureBlock(figure(result), caption),
                    finalists(result),
                ],
            ),
            Section("All candidates", [candidates(result)]),
            Section("Each against each, where judged", [against_each_other(result.arena)]),
            Section("Accuracy", [Text("\n\n".join(trust(judging)))]),
        ],
        subtitle=f"chosen by {choosing.attrs['cases']} cases: {cases_in_words(choosing)}; judged on {judging.attrs['cases']}",
        provenance={
            "buildings": names,
            "motions to choose by": ", ".join(result.chosen_by),
            "motions to judge on": ", ".join(result.judged_on),
        },
        call=call,
        origin=result.origin,
    )
