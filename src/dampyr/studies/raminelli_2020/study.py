"""The run: all parts in the order of the text, the page and the numbers for machines."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from dampyr.errors import MissingData
from dampyr.phrases import sentence
from dampyr.records import locate
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.table import Cell, Table
from dampyr.shown import Shown
from dampyr.studies._compared_value import ComparedValue, Erratum, overall
from dampyr.studies._study_run import OUTCOMES
from dampyr.studies.raminelli_2020.appendix_a import rig
from dampyr.studies.raminelli_2020.campaign_records import Progress, load
from dampyr.studies.raminelli_2020.chapter_2 import chapter_2
from dampyr.studies.raminelli_2020.chapter_4_loops import figures_4
from dampyr.studies.raminelli_2020.chapter_4_tables import table_4_1, tables
from dampyr.studies.raminelli_2020.chapter_5 import chapter_5
from dampyr.studies.raminelli_2020.cubics import equations
from dampyr.studies.raminelli_2020.prediction import errors
from dampyr.studies.raminelli_2020.published import Published
from dampyr.studies.raminelli_2020.study_part import StudyPart


@dataclass(frozen=True, repr=False)
class Study(Shown):
    """Everything that was compared; ``left_out`` says what was not done for lack of data, and how to get them."""

    parts: tuple[StudyPart, ...]
    data: Path | None
    left_out: tuple[str, ...]
    page: Path | None = None

    @property
    def compared(self) -> list[ComparedValue]:
        """All comparisons, in the order of the page."""
        return [value for part in self.parts for value in part.compared]

    @property
    def errata(self) -> list[Erratum]:
        """Slips of the text."""
        return [erratum for part in self.parts for erratum in part.errata]

    @property
    def artefacts(self) -> dict[str, list[ComparedValue]]:
        """The comparisons of each table, equation, error and figure."""
        judged: dict[str, list[ComparedValue]] = {}
        for value in self.compared:
            judged.setdefault(value.artefact, []).append(value)
        return judged


@describe.register
def describe_study(study: Study) -> Description:
    """How many numbers have which verdict, errata and what was left out; the artefacts in a table."""
    verdicts = Counter(value.verdict for value in study.compared)
    rows = [
        ("compared", ", ".join(f"{verdicts[outcome]} {outcome}" for outcome in OUTCOMES if verdicts[outcome])),
        ("errata", str(len(study.errata))),
        ("left out", "; ".join(study.left_out) or "nothing"),
        ("page", "" if study.page is None else study.page.name),
    ]
    return Description(
        "Study of Raminelli (2020)",
        [row for row in rows if row[1]],
        verdict=[sentence(f"left out: {omission}") for omission in study.left_out],
        tables=[lambda: artefacts_table(study)],
        data=lambda: _numbers(study),
        frame=lambda: _columns(study),
    )


def artefacts_table(study: Study) -> Table:
    """Each table, equation, error and figure: how many of its numbers have which verdict, and its own."""
    summaries = {name: artefact_summary(judged) for name, judged in study.artefacts.items()}
    rows: list[list[Cell]] = [
        [name, len(study.artefacts[name]), *(summary[kind] for kind in OUTCOMES), summary["verdict"]]
        for name, summary in summaries.items()
    ]
    return Table(("artefact", "numbers", *OUTCOMES, "verdict"), rows, caption="Raminelli (2020), run again.")


def _columns(study: Study) -> DataFrameColumns:
    """The comparisons: published values and ours in the printed units, and the verdict."""
    names = ("artefact", "quantity", "published", "ours", "unit", "verdict", "reason")
    return DataFrameColumns({name: [getattr(value, name) for value in study.compared] for name in names})


def _numbers(study: Study) -> dict[str, Any]:
    """For JSON: plain numbers in the printed units."""
    return {
        "study": "Raminelli (2020)",
        "data": None if study.data is None else str(study.data),
        "left_out": list(study.left_out),
        "artefacts": {name: artefact_summary(judged) for name, judged in study.artefacts.items()},
        "compared": [asdict(value) for value in study.compared],
        "errata": [asdict(erratum) for erratum in study.errata],
        "page": None if study.page is None else str(study.page),
    }


def artefact_summary(judged: Sequence[ComparedValue]) -> dict[str, Any]:
    """The verdict on an artefact, and how many of its numbers have which."""
    return {"verdict": overall(judged), **{kind: sum(f.verdict == kind for f in judged) for kind in OUTCOMES}}


def run(data: str | Path | None, published: Published, progress: Progress | None) -> Study:
    """See `dampyr.studies.raminelli_2020.reproduce`."""
    report = progress or (lambda stage, done: None)
    folder, left_out = find_data(data)
    campaign = load(folder, report) if folder else None
    steps: list[tuple[str, Callable[[], StudyPart | list[StudyPart]]]] = [
        ("chapter 2", partial(chapter_2, published)),
        ("table 4.1", partial(table_4_1, published)),
        ("tables 4.2 to 4.5", partial(tables, published, campaign)),
        ("equations (4.6) to (4.8)", partial(equations, published)),
        ("the published errors", partial(errors, published, campaign)),
        ("figures 4.1 to 4.4", partial(figures_4, published, campaign)),
        ("chapter 5", partial(chapter_5, published, folder)),
        ("the rig", partial(rig, published, campaign)),
    ]
    parts: list[StudyPart] = []
    for k, (stage, make) in enumerate(steps):
        report(f"comparing: {stage}", k / len(steps))
        result = make()
        parts += result if isinstance(result, list) else [result]
    absent = campaign.absent if campaign else ()
    left_out = (*left_out, *(f"table {row.table}, row {row.row}: no file in the folder" for row in absent))
    return Study(tuple(parts), folder, left_out)


def find_data(data: str | Path | None) -> tuple[Path | None, tuple[str, ...]]:
    """The campaign's folder, or None and what is left out; a folder that was given must hold it."""
    if data is not None:
        return locate("labcontrol", root=data), ()
    try:
        return locate("labcontrol"), ()
    except MissingData as problem:
        omission = (
            "everything that needs the measured files (Tables 4.2 to 4.5, both errors, Figures 4.1 to 4.4, Table A.2)"
        )
        return None, (f"{omission}: {problem}",)
