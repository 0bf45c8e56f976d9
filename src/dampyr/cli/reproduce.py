"""Published studies run again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dampyr.cli._output import as_json_option, print_json, print_table
from dampyr.cli._progress import stages
from dampyr.cli._report import figures_option

if TYPE_CHECKING:
    from dampyr.studies.raminelli_2020.study import Study


@click.command()
@click.option(
    "--data", type=click.Path(path_type=Path), help="The campaign's folder; by default where dampyr finds it."
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("dampyr-reproduce"),
    show_default=True,
    help="Where the page goes.",
)
@figures_option
@as_json_option
def command(data: Path | None, out: Path, as_json: bool) -> None:
    """Run Raminelli (2020) again, with a verdict on each number.

    The published value stands beside ours.

    Writes reproduce.html and reproduce.json. Without the measured files all that needs none is done, and what was
    left out is told.
    """
    from dampyr.studies import raminelli_2020

    with stages() as progress:
        study = raminelli_2020.reproduce(data, out, progress=progress)
    if as_json:
        print_json(study.as_dict())
    else:
        _print(study)


def _print(study: Study) -> None:
    from dampyr.studies.raminelli_2020.study import OUTCOMES, artefact_summary

    rows = []
    for name, findings in study.artefacts.items():
        counted = artefact_summary(findings)
        rows.append([name, counted["verdict"], *(counted[kind] for kind in OUTCOMES)])
    notes = [*(f"left out: {each}" for each in study.left_out), f"page: {study.page}"]
    print_table("Raminelli (2020), run again", ["artefact", "verdict", *OUTCOMES], rows, notes=notes)
