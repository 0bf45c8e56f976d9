"""What the judgement of specimens by criteria shows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from dampyr.campaigns.judgement import JudgedSpecimens, LevelVerdict, SpecimenVerdict
from dampyr.findings import as_dicts
from dampyr.identification.acceptance_tests.device_criteria import Criterion, CriterionVerdict
from dampyr.phrases import counted, listing, sentence
from dampyr.records.cycle_analysis.device_figures import SteadyCycles, loop_between
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures.level_loops import level_loops
from dampyr.show.table import Cell, Kind, Table
from dampyr.to_json import plain
from dampyr.units import for_people

if TYPE_CHECKING:
    from matplotlib.figure import Figure

UNITS = {"largest_force": "N", "energy": "J", "effective_stiffness": "N/m", "characteristic_strength": "N"}
"""SI; what is not in it has none."""
VERDICTS: tuple[Kind, ...] = ("passed", "failed", "not judged")


@describe.register
def describe_judged_specimens(judged: JudgedSpecimens) -> Description:
    """The verdict of all, which specimens and levels came out how, what was not judged, and every cycle beside its limits."""
    specimens = judged.specimens
    rows = [("verdict", judged.verdict), ("specimens", in_short(specimens)), ("criteria", judged.name)]
    worst = max((row for specimen in specimens if (row := specimen.worst)), key=lambda row: row[1].used, default=None)
    if worst:
        rows.append(("worst", worst_words(*worst)))
    reasons = [
        f"{level.words}: {reason}" for specimen in specimens for level in specimen.levels for reason in level.unjudged
    ]
    if reasons:
        rows.append(("not judged", listing(reasons, 1)))
    return Description(
        f"JudgedSpecimens by {judged.name!r}",
        rows,
        verdict=[f"The verdict of all is: {judged.verdict}, by {judged.name}."],
        tables=[
            lambda: specimen_table(specimens),
            lambda: level_table(specimens),
            lambda: unjudged_table(specimens),
            lambda: cycle_table(specimens),
        ],
        figure=lambda: _figure(specimens),
        data=lambda: _numbers(judged),
        frame=lambda: _columns(specimens),
    )


def in_short(specimens: Sequence[SpecimenVerdict]) -> str:
    """How many specimens came out how, such as "2 passed, 1 failed"."""
    counts = {verdict: sum(specimen.verdict == verdict for specimen in specimens) for verdict in VERDICTS}
    return ", ".join(f"{count} {verdict}" for verdict, count in counts.items() if count)


def specimen_table(specimens: Sequence[SpecimenVerdict]) -> Table:
    """How each specimen came out, how many of its levels, and its worst cycle."""
    rows: list[list[Cell]] = []
    for specimen in specimens:
        levels = specimen.levels
        judged, failed = sum(not level.unjudged for level in levels), sum(level.verdict == "failed" for level in levels)
        rows.append(
            [
                specimen.specimen,
                specimen.verdict,
                f"{judged} of {len(levels)}",
                failed,
                *_worst(specimen),
                str(specimen.folder),
            ]
        )
    return Table(
        ("specimen", "verdict", "judged", "failed", "worst", "of limit", "folder"),
        rows,
        ("", "", "levels", "levels", "", "%", ""),
        caption=f"{counted(len(specimens), 'specimen')}: {in_short(specimens)}.",
        notes=[
            "Worst: the cycle that takes most of the way from its reference to its limit; more than 100 % is beyond it."
        ],
        digits=4,
    )


def _worst(specimen: SpecimenVerdict) -> list[Cell]:
    worst = specimen.worst
    return [None, None] if worst is None else [worst_words(*worst), 100.0 * worst[1].used]


def worst_words(level: LevelVerdict, cycle: CriterionVerdict) -> str:
    """A cycle and its limits, such as "energy of cycle 3, sine 4 mm at 2 Hz, 0 V: 0.71 J, at least 0.85 J"."""
    low, high, value, unit = _for_people(cycle)
    limits = [
        f"at {word} {limit:.4g} {unit}".rstrip()
        for word, limit in (("least", low), ("most", high))
        if limit is not None
    ]
    name = quantity(cycle.criterion)
    return f"{name} of cycle {cycle.cycle}, {level.words}: {value:.4g} {unit}".rstrip() + f", {' and '.join(limits)}"


def level_table(specimens: Sequence[SpecimenVerdict]) -> Table:
    """How each level of each specimen came out, and how many of its cycles were asked and run."""
    return Table(
        ("specimen", "level", "verdict", "asked", "run", "outside", "judged", "of limit"),
        [
            [
                specimen.specimen, level.words, level.verdict, level.asked, level.run,
                sum(not cycle.holds for cycle in level.cycles), len(level.cycles),
                max((100.0 * cycle.used for cycle in level.cycles), default=None),
            ]
            for specimen in specimens
            for level in specimen.levels
        ],
        ("", "", "", "cycles", "cycles", "values", "values", "%"),
        caption="The levels.",
        digits=4,
    )  # fmt: skip


def unjudged_table(specimens: Sequence[SpecimenVerdict]) -> Table:
    """Which levels were not judged, and why."""
    return Table(
        ("specimen", "level", "why"),
        [
            [specimen.specimen, level.words, sentence(reason.replace("_", " "))]
            for specimen in specimens
            for level in specimen.levels
            for reason in level.unjudged
        ],
        caption="What was not judged.",
    )


def cycle_table(specimens: Sequence[SpecimenVerdict]) -> Table:
    """Every criterion on every cycle: what is compared with what, the limits, the value and the verdict."""
    rows: list[list[Cell]] = []
    for specimen in specimens:
        for level in specimen.levels:
            for cycle in level.cycles:
                low, high, value, unit = _for_people(cycle)
                criterion, verdict = cycle.criterion, "passed" if cycle.holds else "failed"
                rows.append(
                    [specimen.specimen, level.words, cycle.cycle, quantity(criterion), criterion.reference, low, high,
                     value, unit, verdict, criterion.source]
                )  # fmt: skip
    return Table(
        (
            "specimen",
            "level",
            "cycle",
            "quantity",
            "reference",
            "lower limit",
            "upper limit",
            "value",
            "unit",
            "verdict",
            "source",
        ),
        rows,
        caption="Every cycle.",
        digits=4,
    )


def quantity(criterion: Criterion) -> str:
    """What is compared, in words."""
    return criterion.quantity.replace("_", " ")


def _for_people(cycle: CriterionVerdict) -> tuple[float | None, float | None, float, str]:
    """Lower and upper limit and the value in the unit that people read, and this unit."""
    unit, factor = for_people(UNITS.get(cycle.criterion.quantity, ""))
    low, high = (None if limit is None else factor * limit for limit in (cycle.lower, cycle.upper))
    return low, high, factor * cycle.value, unit


def specimen_loops(specimen: SpecimenVerdict) -> Figure | None:
    """The loops of the judged cycles of each level; None where there are none."""
    loops = {}
    for level in specimen.levels:
        steady = SteadyCycles.of(level.record) if level.record and level.run else None
        if level.record is not None and steady is not None:
            starts = [steady.begin + k * steady.period for k in range(level.run)]
            loops[level.words] = [loop_between(level.record, start, start + steady.period) for start in starts]
    return level_loops(loops) if loops else None


def _figure(specimens: Sequence[SpecimenVerdict]) -> Figure | None:
    """That of the specimen that came out worst."""
    order = ("failed", "not judged", "passed")
    ranked = sorted(specimens, key=lambda specimen: order.index(specimen.verdict))
    return next((figure for figure in map(specimen_loops, ranked) if figure), None)


def _numbers(judged: JudgedSpecimens) -> dict[str, Any]:
    """All for JSON, SI units."""
    return dict(
        plain(
            {
                "criteria": judged.name,
                "origin": judged.origin.as_dict(),
                "verdict": judged.verdict,
                "findings": as_dicts(judged.findings),
                "specimens": [_specimen_numbers(specimen) for specimen in judged.specimens],
            }
        )
    )


def _specimen_numbers(specimen: SpecimenVerdict) -> dict[str, Any]:
    levels = [
        {
            "test": level.test, "words": level.words, "amplitude": level.amplitude, "verdict": level.verdict,
            "asked": level.asked, "run": level.run, "unjudged": level.unjudged,
            "cycles": [_cycle_numbers(cycle) for cycle in level.cycles],
        }
        for level in specimen.levels
    ]  # fmt: skip
    return {
        "specimen": specimen.specimen,
        "folder": str(specimen.folder),
        "verdict": specimen.verdict,
        "worst": {"test": specimen.worst[0].test} | _cycle_numbers(specimen.worst[1]) if specimen.worst else None,
        "levels": levels,
        "beside": specimen.beside,
    }


def _cycle_numbers(cycle: CriterionVerdict) -> dict[str, Any]:
    criterion = cycle.criterion
    return {
        "cycle": cycle.cycle, "quantity": criterion.quantity, "unit": UNITS.get(criterion.quantity, ""),
        "against": criterion.reference, "source": criterion.source, "reference": cycle.reference, "lower": cycle.lower,
        "upper": cycle.upper, "value": cycle.value, "used": cycle.used, "holds": cycle.holds,
    }  # fmt: skip


def _columns(specimens: Sequence[SpecimenVerdict]) -> DataFrameColumns:
    """Every criterion on every cycle, SI units."""
    rows = [
        {"specimen": specimen.specimen, "test": level.test} | _cycle_numbers(cycle)
        for specimen in specimens
        for level in specimen.levels
        for cycle in level.cycles
    ]
    names = (
        "specimen",
        "test",
        "cycle",
        "quantity",
        "unit",
        "against",
        "source",
        "reference",
        "lower",
        "upper",
        "value",
        "holds",
    )
    return DataFrameColumns({name: [row[name] for row in rows] for name in names})
