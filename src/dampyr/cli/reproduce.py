"""Published studies run again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import as_json_option, print_json, print_result, state_origin
from dampyr.cli._progress import stages
from dampyr.cli._report import figures_option
from dampyr.errors import InputError

RAMINELLI, HYBRID = "raminelli_2020", "vrths_2020"
PLANTS = 1000


@click.command(epilog=examples("dampyr reproduce --out reproduce"))
@click.argument("study", type=click.Choice([RAMINELLI, HYBRID]), default=RAMINELLI)
@click.option(
    "--data", type=click.Path(path_type=Path), help="The folder of the study's data; by default where dampyr finds it."
)
@click.option(
    "--plants",
    type=click.IntRange(0),
    help=f"For vrths_2020: number of random plants that each case is run on.  [default: {PLANTS}]",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("dampyr-reproduce"),
    show_default=True,
    help="The folder for the page and its numbers.",
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
    result: Any
    if study == HYBRID:
        from dampyr.studies import vrths_2020

        with stages() as progress:
            result = vrths_2020.reproduce(data, out, PLANTS if plants is None else plants, progress)
        state_origin(result.origin)
    else:
        if plants is not None:
            raise InputError(f"--plants is of {HYBRID}; leave it out")
        from dampyr.studies import raminelli_2020

        with stages() as progress:
            result = raminelli_2020.reproduce(data, out, progress=progress)
    if as_json:
        print_json(result.as_dict())
    else:
        print_result(result)
        click.echo(f"page: {result.page}")
