"""Identify: from records to a damper's card."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dampyr.cli._examples import examples
from dampyr.cli._motion import ratio
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
from dampyr.cli._records import Reading, gather, pairs, reading_options
from dampyr.cli._report import report_options
from dampyr.errors import DampyrError, InputError
from dampyr.findings import worst_first

BUDGET = 480.0  # counted s: that of dampyr.identification.leaderboard, which is imported only when it runs
MAX_WORKERS = 8  # each process compiles the models of its own trials, which more of them would only repeat

if TYPE_CHECKING:
    from dampyr.identification import Fit, Identified


@click.command(
    epilog=examples(
        "dampyr identify tests --model dahl --save damper.toml --report damper.html",
        'dampyr identify tests --model "dahl + spring" --each',
    )
)
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--model", help="Parts, such as 'dahl + spring + delay'; without, the model that predicts best is chosen."
)
@click.option("--try", "tried", multiple=True, metavar="MODEL", help="Without --model: only these instead of all.")
@click.option("--law", "laws", multiple=True, metavar="[NAME=]KIND", help="constant, interpolation, polynomial:DEGREE.")
@click.option("--fix", "fixed", multiple=True, metavar="NAME=VALUE", help="Hold a parameter, in SI units.")
@click.option("--bandwidth", type=float, metavar="HZ", help="Derive the velocity with this bandwidth.")
@click.option(
    "--predict",
    "splits",
    multiple=True,
    metavar="SPLIT",
    help="Cross-validate by record, input, frequency, amplitude, waveform or time.",
)
@click.option(
    "--loss",
    default="squares",
    show_default=True,
    help="squares, huber or l1; the last two are robust against outliers.",
)
@click.option(
    "--weighting",
    default="records",
    show_default=True,
    help="What counts the same in a fit: records or samples.",
)
@click.option(
    "--settling",
    default=2.0,
    show_default=True,
    metavar="S",
    help="s after the motion starts that are not scored.",
)
@click.option("--nuisance", "nuisances", multiple=True, help="gain, temperature: further per-record effects.")
@click.option("--tie", "tied", multiple=True, metavar="NAME=OTHER", help="One parameter takes the law of another.")
@click.option("--starts", default=1, show_default=True, help="Number of starting points of the search.")
@click.option(
    "--budget",
    default=BUDGET,
    show_default=True,
    metavar="S",
    help="Without --model: work that the search may take, counted and not timed: s of one core, about.",
)
@click.option(
    "--seconds", type=float, metavar="S", help="Without --model: end the search after S; what is cut chooses no model."
)
@click.option(
    "--nested", is_flag=True, help="Without --model: repeat the search without a fifth of the records, 5 times."
)
@click.option(
    "--session-prior",
    default="8%",
    show_default=True,
    metavar="SHARE",
    help="How much the force differs from one measurement session to another, where the records do not tell.",
)
@click.option("--each", is_flag=True, help="Fit every record by itself instead of all together.")
@click.option(
    "--by-specimen", is_flag=True, help="Fit every specimen by itself, and give mean and spread over the specimens."
)
@click.option("--mixed-origins", is_flag=True, help="Fit simulated or virtual records together with others.")
@click.option("--save", type=click.Path(path_type=Path), metavar="CARD", help="Write the damper's card, a .toml file.")
@report_options()
@reading_options
@details_option
@as_json_option
def command(
    paths: tuple[Path, ...],
    model: str | None,
    tried: tuple[str, ...],
    laws: tuple[str, ...],
    fixed: tuple[str, ...],
    bandwidth: float | None,
    splits: tuple[str, ...],
    loss: str,
    weighting: str,
    settling: float,
    nuisances: tuple[str, ...],
    tied: tuple[str, ...],
    starts: int,
    budget: float,
    seconds: float | None,
    nested: bool,
    session_prior: str,
    each: bool,
    by_specimen: bool,
    mixed_origins: bool,
    save: Path | None,
    report: Path | None,
    reading: Reading,
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
    from dampyr.identification import IdentifyOptions, identify
    from dampyr.identification.fits.identify import identify_by_specimen, identify_each
    from dampyr.identification.model_choice.leaderboard import Cut
    from dampyr.origin import combined

    if each and (save or report or splits or model is None):
        raise InputError(
            "--each makes one fit of the --model per record and no card; give --model, and leave out --save, --report "
            "and --predict, or leave out --each"
        )
    if by_specimen and (each or report or splits or model is None):
        raise InputError(
            "--by-specimen makes one fit of the --model per specimen; give --model, and leave out --each, --report and "
            "--predict, or leave out --by-specimen"
        )
    options = IdentifyOptions(
        model=model,
        tried=tried,
        laws=_laws(laws),
        fixed=_numbers(fixed),
        bandwidth=bandwidth,
        predict=splits,
        loss=loss,
        nuisances=("offset", "state", *nuisances),
        tied=pairs(tied),
        starts=starts,
        weighting=weighting,
        settling=settling,
        budget=budget,
        seconds=seconds,
        nested=nested,
        session_prior=ratio(session_prior, "session-prior"),
        mixed_origins=mixed_origins,
    )
    shown = None if details else 1  # tables, and findings
    records = gather(paths, "fit", reading, warn=False)
    with stages() as progress:
        if each:
            fits = identify_each(records, options, progress)
        elif by_specimen:
            specimens = identify_by_specimen(records, options, progress)
        else:
            try:
                with findings_below():
                    result = identify(records, options, progress, _cores())
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
        problem = _problem_of(lambda: result.card.save(save)) if save else None
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


def _write_page(result: Identified, path: Path) -> None:
    from dampyr.show.pages.fit_page import write_fit_page

    write_fit_page(result, path)


def _laws(given: tuple[str, ...]) -> str | dict[str, str] | None:
    """One kind for all parameters, kinds by name, or both: ``"*"`` stands for the parameters that are not named."""
    plain = [law for law in given if "=" not in law]
    if len(plain) > 1:
        raise InputError(
            f"--law {plain[0]} and --law {plain[1]} are both for all parameters; leave one out, or write NAME={plain[1]}"
        )
    named = pairs(tuple(law for law in given if "=" in law))
    return {"*": plain[0], **named} if plain and named else plain[0] if plain else named


def _numbers(given: tuple[str, ...]) -> dict[str, float]:
    values = {}
    for name, text in (pairs(given) or {}).items():
        try:
            values[name] = float(text)
        except ValueError:
            raise InputError(f"--fix {name}={text}: {text!r} is not a number in SI units") from None
    return values


def _cores() -> int:
    """How many processes may share the trials: one for each core, up to `MAX_WORKERS`."""
    available = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(available, MAX_WORKERS)


def _print(result: Identified, shown: int | None) -> None:
    if result.board:
        print_result(result.board, shown, shown)
        click.echo()
    print_result(result, shown, shown)


def _print_each(fits: list[Fit]) -> None:
    from dampyr.show.identification.result import fits_by_record

    of_records = (replace(finding, about=(fit.records[0].name,)) for fit in fits for finding in fit.findings)
    print_shown(
        fits_by_record(fits), [finding.sentence for finding in worst_first(of_records) if finding.severity != "note"]
    )
