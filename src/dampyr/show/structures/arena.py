"""What an arena shows: who wins, how often each input is the best, and each against each."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from dampyr.findings import as_dicts
from dampyr.phrases import counted
from dampyr.show.descriptions import Description, describe
from dampyr.show.figures.arena import shares_of_best
from dampyr.show.table import Table
from dampyr.structures.ensembles.arena import Arena
from dampyr.to_json import plain
from dampyr.units import for_people


@describe.register
def describe_arena(arena: Arena) -> Description:
    """The cases, the winner, the standings and each input against each other."""
    return Description(
        "Arena",
        [
            ("criterion", f"the largest peak {arena.criterion} of a case, which is to be small"),
            (
                "cases",
                f"{arena.cases} of each input: {counted(arena.motions, 'motion')}, {counted(arena.dampers, 'damper')}",
            ),
            ("inputs", str(len(arena.names))),
        ],
        verdict=[verdict(arena)],
        tables=[lambda: standings(arena), lambda: against_each_other(arena)],
        figure=lambda: figure(arena),
        data=lambda: _numbers(arena),
    )


def order(arena: Arena) -> list[int]:
    """The inputs from the one that is the best most often."""
    return sorted(range(len(arena.names)), key=lambda k: (-arena.best[k], arena.medians[k]))


def verdict(arena: Arena) -> str:
    """Who wins, or between whom it is open."""
    if arena.reason:
        return f"No winner can be told: {arena.reason}."
    if arena.winner is not None:
        k = arena.names.index(arena.winner)
        others = [j for j in range(len(arena.names)) if j != k]
        least = min(others, key=lambda j: arena.wins_band[0, k, j])
        return (
            f"{arena.winner} has the smaller {arena.criterion} than each other input in more than half of the cases: than "
            f"{arena.names[least]}, which comes nearest, in {_percent(arena.wins[k, least], arena.wins_band[:, k, least])}."
        )
    first, *_ = order(arena)
    open_ = [j for j in range(len(arena.names)) if j != first and not arena.wins_band[0, first, j] > 0.5]
    needed = [
        arena.needed[first, j] for j in open_ if math.isfinite(arena.needed[first, j]) and arena.needed[first, j] > 0
    ]
    more = (
        f" About {max(needed):.0f} motions would tell them apart with a probability of 95 %, where there are {arena.motions}."
        if needed
        else ""
    )
    return (
        f"No input wins: {arena.names[first]} is the best most often, and is not told apart from, or loses to, "
        f"{', '.join(arena.names[j] for j in open_)}.{more}"
    )


def _percent(share: float, band: Any) -> str:
    if not np.all(np.isfinite(band)):
        return f"{100 * share:.0f} %"
    return f"{100 * share:.0f} % ({100 * band[0]:.0f} to {100 * band[1]:.0f} %)"


def standings(arena: Arena) -> Table:
    """Each input with its median and how often it is the best."""
    unit, factor = for_people(arena.unit)
    rows = [
        [arena.names[k], factor * arena.medians[k], _percent(arena.best[k], arena.best_band[:, k])]
        for k in order(arena)
    ]
    return Table(
        ("input", f"median {arena.criterion}", "the best of all"),
        rows,
        ("", unit.replace("^2", "²"), ""),
        caption=f"{arena.cases} cases of each input, the best first.",
        notes=("In brackets the 90 % band of a bootstrap over motions and dampers.",),
        digits=4,
    )


def against_each_other(arena: Arena) -> Table:
    """Each pair: the share of the cases that the first wins, and how many motions would tell the two apart with 95 %."""
    places = order(arena)
    rows = []
    for a, i in enumerate(places):
        for j in places[a + 1 :]:
            needed = arena.needed[i, j]
            told = "told apart" if needed == 0 else f"about {needed:.0f}" if math.isfinite(needed) else "not known"
            rows.append([arena.names[i], arena.names[j], _percent(arena.wins[i, j], arena.wins_band[:, i, j]), told])
    return Table(
        ("input", "against", "wins", "motions needed"),
        rows,
        caption="How often the first has the smaller criterion in the same case.",
        notes=(
            "Equal criteria count one half. A band that holds 50 % tells nobody apart; so many motions would, with a "
            "probability of 95 %, were the share the one that is found.",
        ),
    )


def figure(arena: Arena) -> Any:
    """How often each input is the best."""
    places = order(arena)
    return shares_of_best([arena.names[k] for k in places], arena.best[places], arena.best_band[:, places])


def _numbers(arena: Arena) -> dict[str, Any]:
    names = (
        "names",
        "criterion",
        "unit",
        "cases",
        "motions",
        "dampers",
        "medians",
        "best",
        "best_band",
        "wins",
        "wins_band",
    )
    values = {name: getattr(arena, name) for name in (*names, "needed", "reason", "winner")}
    of_all = {"damper_origin": arena.origin.as_dict(), "findings": as_dicts(arena.findings)}
    return dict(plain(values | of_all))
