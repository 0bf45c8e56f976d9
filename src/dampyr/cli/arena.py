"""Arena: control laws and constant inputs against one another, and how sure it is which is better."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dampyr.cli._ensemble import (
    CASE_OPTIONS,
    EnsembleCommand,
    case_options,
    read_option,
    refuse_cases,
    workers_option,
)
from dampyr.cli._examples import examples
from dampyr.cli._options import OptionsCommand
from dampyr.cli._output import as_json_option, print_answer
from dampyr.cli._report import report_options
from dampyr.cli.ensemble import run_cases

if TYPE_CHECKING:
    from dampyr.structures import EnsembleOptions


@click.command(
    cls=OptionsCommand,
    options={"options": "dampyr.structures:EnsembleOptions"},
    first=len(CASE_OPTIONS) - 1,  # the first of them is an argument
    epilog=examples(
        "dampyr arena --control on_off --control skyhook --synthetic 4 --duration 4 --criterion acceleration"
    ),
)
@case_options
@click.option(
    "--criterion",
    default="drift",
    metavar="QUANTITY",
    help="The largest peak that is to be small: drift, displacement, acceleration, force or stroke.  [default: drift]",
)
@click.option("--out", type=click.Path(path_type=Path), help="An .h5 file of the ensemble, continued where it stopped.")
@read_option
@workers_option
@report_options()
@as_json_option
@click.pass_context
def command(
    context: click.Context,
    request: EnsembleCommand,
    options: EnsembleOptions,
    criterion: str,
    out: Path | None,
    read: Path | None,
    workers: int | None,
    report: Path | None,
    as_json: bool,
) -> None:
    """Tell which control law is better, and how sure that is.

    Every input, control laws and constant ones, runs in the same cases: under the same motions and scales, on the same
    drawn dampers with the same noise. Told are the share of the cases in which each is the best, and of each pair how often
    the one beats the other, with 90 % bands and how many motions would tell them apart. The options are those of dampyr
    ensemble; give several motions, or --synthetic N.
    """
    from dampyr import structures

    if read is None:
        result = run_cases(request, options, out, workers)
    else:
        refuse_cases(context, "--read")
        result = structures.read_ensemble(read)
    found = structures.arena(result, criterion, options.seed)
    if report:
        from dampyr.show.pages.result_page import write_page

        write_page(found, report)
    print_answer(found, as_json)
