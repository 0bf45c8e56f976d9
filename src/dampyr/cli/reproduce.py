"""Published studies run again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import as_json_option, print_json, print_table, state_origin
from dampyr.cli._progress import stages
from dampyr.cli._report import figures_option
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.studies.raminelli_2020.study import Study
    from dampyr.studies.vrths_2020.vrths_study import Study as HybridStudy

RAMINELLI, HYBRID = "raminelli_2020", "vrths_2020"
PLANTS = 1000


@click.command(epilog=examples("dampyr reproduce --out reproduce"))
@click.argument("study", type=click.Choice([RAMINELLI, HYBRID]), default=RAMINELLI)
@click.option(
    "--data", type=click.Path(path_type=Path), help="The folder of its data; by default where dampyr finds it."
)
@click.option(
    "--plants",
    type=click.IntRange(0),
    help=f"Of vrths_2020: how many random plants each case is run on.  [default: {PLANTS}]",
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
def command(study: str, data: Path | None, plants: int | None, out: Path, as_json: bool) -> None:
    """Run a published study again, with a verdict on each number.

    STUDY is raminelli_2020, the dissertation with its campaign (the default), or vrths_2020, the benchmark of virtual
    real-time hybrid simulation. The published value stands beside ours.

    Writes a page and its numbers: reproduce.html and reproduce.json, or vrths_2020.html and vrths_2020.json. Without the
    measured files of raminelli_2020 all that needs none is done, and what was left out is said; vrths_2020 needs its motions.
    """
    if study == HYBRID:
        _hybrid(data, PLANTS if plants is None else plants, out, as_json)
        return
    if plants is not None:
        raise InputError(f"--plants is of {HYBRID}; leave it out")
    from dampyr.studies import raminelli_2020

    with stages() as progress:
        done = raminelli_2020.reproduce(data, out, progress=progress)
    if as_json:
        print_json(done.as_dict())
    else:
        _print(done)


def _hybrid(data: Path | None, plants: int, out: Path, as_json: bool) -> None:
    from dampyr.studies import vrths_2020

    with stages() as progress:
        study = vrths_2020.reproduce(data, out, plants, progress)
    state_origin(study.origin)
    if as_json:
        print_json(study.as_dict())
    else:
        _print_hybrid(study)


def _print_hybrid(study: HybridStudy) -> None:
    from dampyr.hybrid import CRITERIA

    rows = [
        [motion, name, case, *(f"{value:.3g}" for value in true)]
        for (motion, name, case), (true, _) in study.criteria.items()
    ]
    notes = ["J1 in ms, the others in %, on the true displacement"]
    for case, batch in study.batches.items():
        worst = ", ".join(
            f"{name} {batch.true[batch.worst(name), CRITERIA.index(name)]:.3g} %" for name in ("J2", "J4")
        )
        notes.append(f"{len(batch.plants)} random plants of case {case}: {batch.unstable} unstable, worst {worst}")
    agree = sum(value.verdict == "agrees" for value in study.compared)
    notes += [f"{agree} of {len(study.compared)} numbers agree", f"page: {study.page}"]
    print_table(
        "The hybrid simulation benchmark of 2020", ["motion", "compensator", "case", *CRITERIA], rows, notes=notes
    )


def _print(study: Study) -> None:
    from dampyr.studies.raminelli_2020.study import OUTCOMES, artefact_summary

    rows = []
    for name, compared in study.artefacts.items():
        counted = artefact_summary(compared)
        rows.append([name, counted["verdict"], *(counted[kind] for kind in OUTCOMES)])
    notes = [*(f"left out: {each}" for each in study.left_out), f"page: {study.page}"]
    print_table("Raminelli (2020), run again", ["artefact", "verdict", *OUTCOMES], rows, notes=notes)
