"""What a search over inputs and places shows: the first, how it does where it was not chosen, and what comes after it."""

from __future__ import annotations

from typing import Any

from dampyr.findings import as_dicts
from dampyr.phrases import counted
from dampyr.show.descriptions import Description, describe
from dampyr.show.figures.control_search import ratios
from dampyr.show.table import Table
from dampyr.structures.ensembles.control_search import ControlSearch
from dampyr.to_json import plain
from dampyr.units import for_people

SHOWN = 20  # candidates in the table of all


@describe.register
def describe_control_search(found: ControlSearch) -> Description:
    """The candidates, the first one, and those that were judged beside it."""
    return Description(
        "ControlSearch",
        [
            ("criterion", f"the largest peak {found.criterion} of a case, which is to be small"),
            ("candidates", str(len(found.names))),
            ("chosen by", counted(len(found.chosen_by), "motion")),
            ("judged on", counted(len(found.judged_on), "other motion")),
        ],
        verdict=[verdict(found)],
        tables=[lambda: finalists(found), lambda: candidates(found)],
        figure=lambda: figure(found),
        data=lambda: _numbers(found),
    )


def verdict(found: ControlSearch) -> str:
    """The first, how it compares with the next, and whether the choice holds on other motions."""
    if found.beaten:
        worst = min(range(len(found.ratio)), key=lambda k: found.ratio[k])
        return (
            f"The choice does not hold: {found.best} ranked first, but on the motions that were not used for choosing "
            f"{found.names[worst]} has {_times(found, worst)} of its {found.criterion}. Give more motions."
        )
    open_ = [found.names[k] for k in range(1, len(found.ratio)) if not found.apart[k]]
    end = (
        f"not told apart from it {'is' if len(open_) == 1 else 'are'} {', '.join(open_)}."
        if open_
        else "each of the others that were judged is told apart as worse."
    )
    return (
        f"{found.best} ranked first. On motions that were not used for choosing the next in rank, {found.names[1]}, has "
        f"{_times(found, 1)} of its {found.criterion}, where it had {found.ranked[1] / found.ranked[0]:.3g} times on "
        f"those that were; {end}"
    )


def _times(found: ControlSearch, k: int) -> str:
    low, high = found.ratio_band[:, k]
    return f"{found.ratio[k]:.3g} times ({low:.3g} to {high:.3g})"


def finalists(found: ControlSearch) -> Table:
    """Those that were judged, in their rank."""
    unit, factor = for_people(found.unit)
    rows = [
        [
            found.names[k],
            factor * found.ranked[k],
            factor * found.judged[k],
            "" if k == 0 else _times(found, k),
            "first" if k == 0 else "worse" if found.apart[k] else "better" if found.ratio_band[1, k] < 1 else "open",
        ]
        for k in range(len(found.ratio))
    ]
    unit = unit.replace("^2", "²")
    return Table(
        ("candidate", f"{found.criterion} where chosen", "where judged", "of the first's", "told apart"),
        rows,
        ("", unit, unit, "", ""),
        caption="The first in rank under the motions by which they were chosen, judged under the others.",
        notes=(
            "Geometric means of the largest peak of a case. In brackets the 90 % band of a bootstrap over motions and dampers; "
            "one that holds 1 tells nobody apart.",
        ),
        digits=4,
    )


def candidates(found: ControlSearch) -> Table:
    """All that were ranked, or the first of them."""
    unit, factor = for_people(found.unit)
    more = len(found.names) - SHOWN
    return Table(
        ("rank", "candidate", found.criterion),
        [[k + 1, name, factor * found.ranked[k]] for k, name in enumerate(found.names[:SHOWN])],
        ("", "", unit.replace("^2", "²")),
        caption="All candidates under the motions by which they were chosen.",
        notes=(
            "These numbers are of the choosing, where the first is in part the luckiest.",
            *([f"Left out: {counted(more, 'candidate')}."] if more > 0 else []),
        ),
        digits=4,
    )


def figure(found: ControlSearch) -> Any:
    """How much worse than the first each of the others is, where it was not chosen."""
    return ratios(found.names[: len(found.ratio)], found.ratio, found.ratio_band, found.criterion)


def _numbers(found: ControlSearch) -> dict[str, Any]:
    names = (
        "best", "names", "criterion", "unit", "chosen_by", "judged_on", "ranked", "judged", "ratio", "ratio_band", "apart",
        "beaten",
    )  # fmt: skip
    values = {name: getattr(found, name) for name in names}
    of_all = {"damper_origin": found.origin.as_dict(), "findings": as_dicts(found.findings)}
    return dict(plain(values | of_all))
