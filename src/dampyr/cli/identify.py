"""Identify: from records to a damper's card."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

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

MAX_WORKERS = 8  # each process compiles the models of its own trials, which more of them would only repeat

if TYPE_CHECKING:
    from dampyr.identification import Fit, FitOptions
    from dampyr.records import ReadOptions


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
    "--model", help="Parts, such as 'dahl + spring + delay'; without, the model that predicts best is chosen."
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

    --by-specimen takes records of several dampers of one type, each record naming its own; --save writes the card of their
    mean, with the covariance of a new specimen.
    """
    from dampyr.identification import fit, fit_specimens
    from dampyr.identification.model_choice.leaderboard import Cut
    from dampyr.identification.model_choice.parallel import local_processes
    from dampyr.origin import combined

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
    shown = None if details else 1  # tables, and findings
    records = gather(paths, "fit", reading, warn=False)
    with stages() as progress:
        if each:
            fits = []
            for k, record in enumerate(records):
                fits.append(fit(record, model, options))
                progress("identifying", (k + 1) / len(records))
        elif by_specimen:
            assert model is not None
            specimens = fit_specimens(records, model, options, progress=progress)
        else:
            try:
                with findings_below(), local_processes(_cores() if model is None else 1) as executor:
                    result = fit(records, model, options, progress, executor)
            except Cut as cut:
                board = cut.board
                print_json({"leaderboard": board.as_dict()}) if as_json else print_result(board, shown, shown)
                raise
    state_origin(combined(record.origin for record in records))
    if each:
        print_json([one.as_dict() for one in fits]) if as_json else _print_each(fits)
        return
    # Files first, as a reader of the first lines alone closes the pipe; what cannot be written is said after what is printed.
    if by_specimen:
        problem = _problem_of(lambda: specimens.damper().save(save)) if save else None
        print_json(specimens.as_dict()) if as_json else print_result(specimens)
    else:
        problem = _problem_of(lambda: result.save(save)) if save else None
        if report:
            problem = problem or _problem_of(lambda: _write_page(result, report))
        print_json(result.as_dict()) if as_json else _print(result, shown)
    if problem is not None:
        raise problem


def _problem_of(write: Callable[[], object]) -> Exception | None:
    """Why a file cannot be written, or a card not be made; None where it is written."""
    try:
        write()
    except (DampyrError, OSError) as problem:
        return problem
    return None


def _write_page(result: Fit, path: Path) -> None:
    from dampyr.show.pages.fit_page import write_fit_page

    write_fit_page(result, path)


def _cores() -> int:
    """How many processes may share the trials: one for each core, up to `MAX_WORKERS`."""
    available = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(available, MAX_WORKERS)


def _print(result: Fit, shown: int | None) -> None:
    if result.leaderboard:
        print_result(result.leaderboard, shown, shown)
        click.echo()
    print_result(result, shown, shown)


def _print_each(fits: list[Fit]) -> None:
    from dampyr.show.identification.result import fits_by_record

    of_records = (replace(finding, about=(fit.records[0].name,)) for fit in fits for finding in fit.findings)
    print_shown(
        fits_by_record(fits), [finding.sentence for finding in worst_first(of_records) if finding.severity != "note"]
    )
