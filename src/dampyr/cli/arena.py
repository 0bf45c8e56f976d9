"""Arena: control laws and constant inputs against one another, and how sure it is which is better."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dampyr.cli._ensemble import (
    CASE_OPTIONS,
    EnsembleCommand,
    case_options,
    cluster_option,
    counting,
    read_option,
    refuse_cases,
    workers_of,
    workers_option,
)
from dampyr.cli._examples import examples
from dampyr.cli._options import OptionsCommand
from dampyr.cli._output import as_json_option, print_answer
from dampyr.cli._report import report_options
from dampyr.cli.ensemble import run_cases
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.structures import ControlSearch, EnsembleOptions


@click.command(
    cls=OptionsCommand,
    options={"options": "dampyr.structures:EnsembleOptions"},
    first=len(CASE_OPTIONS) - 1,  # the first of them is an argument
    epilog=examples(
        "dampyr arena --control on_off --control skyhook --synthetic 4 --duration 4 --criterion acceleration",
        "dampyr arena --search voltage=0:3:1 --search place=1,2 --synthetic 6 --duration 4",
    ),
)
@case_options
@click.option(
    "--criterion",
    default="drift",
    metavar="QUANTITY",
    help="The largest peak that is to be small: drift, displacement, acceleration, force or stroke.  [default: drift]",
)
@click.option(
    "--search",
    "axes",
    multiple=True,
    metavar="AXIS",
    help="Choose the best: voltage=0:3:0.5, clipped_optimal.effort=0.01,0.1 or place=1,2,0-2; may be repeated.",
)
@click.option("--finalists", type=click.IntRange(2), metavar="N", help="Judge the first N of a search.  [default: 5]")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="An .h5 file of the ensemble, continued where it stopped; with --search a folder.",
)
@read_option
@workers_option
@cluster_option
@report_options()
@as_json_option
def command(
    request: EnsembleCommand,
    options: EnsembleOptions,
    criterion: str,
    axes: tuple[str, ...],
    finalists: int | None,
    out: Path | None,
    read: Path | None,
    workers: int | None,
    cluster: str | None,
    report: Path | None,
    as_json: bool,
) -> None:
    """Tell which control law is better, and how sure that is.

    Every input, control laws and constant ones, runs in the same cases: under the same motions and scales, on the same
    drawn dampers with the same noise. Told are the share of the cases in which each is the best, and of each pair how often
    the one beats the other, with 90 % bands and how many motions would tell them apart. The options are those of dampyr
    ensemble; give several motions, or --synthetic N.

    With --search the inputs and places of its axes are candidates. Half of the motions choose, and the first ones are judged
    on the other half, which had no say: how much worse than the first each is there, with its 90 % band.
    """
    from dampyr import structures

    if finalists is not None and not axes:
        raise InputError("--finalists belongs to --search; give an axis, such as --search place=1,2, or leave it out")
    if axes:
        if read is not None:
            raise InputError("--search computes, and --read takes what was computed; leave one of them out")
        found_best = _search(request, options, criterion, axes, finalists or 5, out, workers, cluster)
        if report:
            from dampyr.show.pages.result_page import write_page

            write_page(found_best, report)
        print_answer(found_best, as_json)
        return
    if read is None:
        result = run_cases(request, options, out, workers, cluster)
    else:
        refuse_cases("--read")
        result = structures.read_ensemble(read)
    found = structures.arena(result, criterion, options.seed)
    if report:
        from dampyr.show.pages.result_page import write_page

        write_page(found, report)
    print_answer(found, as_json)


def _search(
    request: EnsembleCommand,
    options: EnsembleOptions,
    criterion: str,
    axes: tuple[str, ...],
    finalists: int,
    out: Path | None,
    workers: int | None,
    cluster: str | None,
) -> ControlSearch:
    from dampyr import structures
    from dampyr.cli._search_axes import searched

    if request.without_damper:
        raise InputError("--without-damper has no input to choose; leave it out of a search")
    what = request.cases(options, any_input=True)
    [placed] = what.pop("dampers")
    [(place, damper)] = placed.items()
    word = "current" if damper.input == "A" else "voltage"
    inputs, places = searched(damper, axes, list(what.pop(word)), request.controls)
    with counting() as progress, workers_of(workers, cluster) as pool:
        return structures.search_control(
            what["buildings"], what["motions"], damper, places=places or [place], scales=what["scales"],
            criterion=criterion, finalists=finalists, executor=pool, options=options, out=out, progress=progress,
            **{word: inputs},
        )  # fmt: skip
