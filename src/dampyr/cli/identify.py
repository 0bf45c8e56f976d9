"""Identify: from records to a damper's card."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._options import OptionsCommand
from dampyr.cli._output import (
    as_json_option,
    details_option,
    findings_below,
    print_json,
    print_result,
    print_shown,
    state_origin,
)
from dampyr.cli._progress import stages
from dampyr.cli._records import READING, gather
from dampyr.cli._report import report_options
from dampyr.errors import DampyrError, InputError
from dampyr.findings import worst_first

METHODS = ("least-squares", "limit-cycle", "plastic-region")
MAX_WORKERS = 8  # each process compiles the models of its own trials, which more of them would only repeat

if TYPE_CHECKING:
    from dampyr.identification import Fit, FitOptions
    from dampyr.records import ReadOptions, Record


@click.command(
    cls=OptionsCommand,
    options={"options": "dampyr.identification:FitOptions"} | READING,
    first=1,
    epilog=examples(
        "dampyr identify tests --model dahl --save damper.toml --report damper.html",
        'dampyr identify tests --model "dahl + spring" --each',
    ),
)
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--model",
    help="The model by its parts, such as 'dahl + spring + delay'; by default the one that predicts best is chosen.",
)
@click.option(
    "--method",
    type=click.Choice(METHODS),
    default=METHODS[0],
    show_default=True,
    help="The last two are the dissertation's, for the viscous Dahl model of each record, beside least squares.",
)
@click.option("--each", is_flag=True, help="Fit every record by itself instead of all together.")
@click.option(
    "--by-specimen", is_flag=True, help="Fit every specimen by itself, and give mean and spread over the specimens."
)
@click.option("--save", type=click.Path(path_type=Path), metavar="CARD", help="Write the damper's card, a .toml file.")
@report_options()
@details_option
@as_json_option
def command(
    paths: tuple[Path, ...],
    model: str | None,
    options: FitOptions,
    method: str,
    each: bool,
    by_specimen: bool,
    save: Path | None,
    report: Path | None,
    reading: ReadOptions,
    details: bool,
    as_json: bool,
) -> None:
    """Identify a damper from records by least squares.

    PATHS are record files or campaign folders (of which the records for fitting are taken). All records are fitted
    together, each parameter following the voltage, unless --each is given. Without --model every model of the catalogue is
    tried, bare and with compliance, spring, delay and lag, and the one that best predicts records and voltages that it was
    not fitted on is taken: minutes, not seconds. --predict says how well a model predicts: five random parts of the records,
    one input left out at a time, five parts in the order of frequency or stroke, one kind of motion left out, or the last
    part of every record.

    --method limit-cycle and plastic-region take kx, kw and rho of the viscous Dahl model off the loops of each record, as the
    dissertation does, and show what that costs beside least squares.

    --by-specimen takes records of several dampers of one type, each record naming its own; --save writes the card of their
    mean, with the covariance of a new specimen.
    """
    from dampyr.identification import compare_method, fit_specimens
    from dampyr.origin import combined

    _check_ways(method, each, by_specimen, model, save, report, options)
    shown = None if details else 1  # tables, and findings
    records = gather(paths, "fit", reading, warn=False)
    result: Any
    if method != METHODS[0]:
        with stages() as progress:
            result = compare_method(records, method, options.bandwidth, progress)
    elif each:
        result = _fitted_alone(records, model, options)
    elif by_specimen:
        with stages() as progress:
            result = fit_specimens(records, str(model), options, progress=progress)
    else:
        result = _fitted(records, model, options, as_json, shown)
    # Files first, as a reader of the first lines alone closes the pipe; what cannot be written is said after what is printed.
    problem = None
    if save:
        problem = _problem_of(lambda: result.damper().save(save) if by_specimen else result.save(save))
    if report:
        from dampyr.show.pages.result_page import write_page

        with stages() as progress:
            progress("writing the page", 0.0)
            problem = problem or _problem_of(lambda: write_page(result, report))
    state_origin(combined(record.origin for record in records))
    if as_json:
        print_json([fit.as_dict() for fit in result] if each else result.as_dict())
    elif each:
        _print_each(result)
    else:
        shown = None if method != METHODS[0] or by_specimen else shown
        if board := getattr(result, "leaderboard", None):
            print_result(board, shown, shown)
            click.echo()
        print_result(result, shown, shown)
    if problem is not None:
        raise problem


def _check_ways(
    method: str,
    each: bool,
    by_specimen: bool,
    model: str | None,
    save: Path | None,
    report: Path | None,
    options: FitOptions,
) -> None:
    """Refuse what does not go with a graphical method, with fits of single records or with fits by specimen."""
    if method != METHODS[0] and (each or by_specimen or save or report or model not in (None, "dahl")):
        raise InputError(
            f"--method {method} gives the viscous Dahl model of each record; leave out --model, --each, --by-specimen, "
            "--save and --report"
        )
    if each and (save or report or by_specimen or options.predict or model is None):
        raise InputError(
            "--each makes one fit of the --model per record and no card; give --model, and leave out --save, --report, "
            "--predict and --by-specimen, or leave out --each"
        )
    if by_specimen and (report or options.predict or model is None):
        raise InputError(
            "--by-specimen makes one fit of the --model per specimen; give --model, and leave out --report and --predict, or "
            "leave out --by-specimen"
        )


def _fitted(records: list[Record], model: str | None, options: FitOptions, as_json: bool, shown: int | None) -> Fit:
    """The fit; of a search for a model that was cut, what was finished is printed."""
    from dampyr.identification import fit
    from dampyr.identification.model_choice.leaderboard import SearchTimedOut
    from dampyr.identification.model_choice.parallel import local_processes

    try:
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        workers = min(cores, MAX_WORKERS) if model is None else 1
        with stages() as progress, findings_below(), local_processes(workers) as executor:
            found = fit(records, model, options, progress, executor)
            progress("judging the fit", 0.0)
            _ = found.findings  # which keeps them: of many records it takes seconds
            return found
    except SearchTimedOut as cut:
        board = cut.board
        print_json({"leaderboard": board.as_dict()}) if as_json else print_result(board, shown, shown)
        raise


def _fitted_alone(records: list[Record], model: str | None, options: FitOptions) -> list[Fit]:
    from dampyr.identification import fit

    fits = []
    with stages() as progress:
        for k, record in enumerate(records):
            fits.append(fit(record, model, options))
            progress("identifying", (k + 1) / len(records))
    return fits


def _problem_of(write: Callable[[], object]) -> Exception | None:
    """Why a file cannot be written, or a card not be made; None where it is written."""
    try:
        write()
    except (DampyrError, OSError) as problem:
        return problem
    return None


def _print_each(fits: list[Fit]) -> None:
    from dampyr.show.identification.result import fits_by_record

    of_records = (replace(finding, about=(fit.records[0].name,)) for fit in fits for finding in fit.findings)
    print_shown(
        fits_by_record(fits), [finding.sentence for finding in worst_first(of_records) if finding.severity != "note"]
    )
