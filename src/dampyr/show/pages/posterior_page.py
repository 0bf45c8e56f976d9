"""The page of samples of a posterior: intervals beside those of the fit, each number and each pair, the chains."""

from __future__ import annotations

from dampyr.identification.parameter_uncertainty.posterior import Posterior
from dampyr.phrases import counted
from dampyr.show.identification.posterior import chains_table, corner_figures, intervals_table
from dampyr.show.pages.blocks import FigureBlock, Section, Text, to_look_at
from dampyr.show.pages.html_page import page

CAPTION = "samples of each number on the diagonal and of each pair; red: the fit; the line holds 95 % of a normal distribution."


def html(result: Posterior, *, call: str = "") -> str:
    """The page of what `dampyr.identification.sample_posterior` gives."""
    return page(
        f"Posterior: {result.fit.problem.composition}",
        [
            Section("Numbers", [*verdict(result), *to_look_at(result.findings), intervals_table(result)]),
            Section(
                "Pairs", [FigureBlock(made, f"{title}: {CAPTION}") for title, made in corner_figures(result).items()]
            ),
            Section("Chains", [chains_table(result)]),
        ],
        subtitle=f"{counted(result.size, 'draw')} of {counted(len(result.samples), 'number')}, "
        f"{counted(len(result.fit.records), 'record')}",
        provenance={"records": ", ".join(record.name for record in result.fit.records), "seed": str(result.seed)},
        call=call,
        origin=result.origin,
    )


def verdict(result: Posterior) -> list[Text]:
    """That the chains were long enough; where they were not a finding says so."""
    return [Text(f"The chains converged: {result.reason}.")] if result.converged else []
