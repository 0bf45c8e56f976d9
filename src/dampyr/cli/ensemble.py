"""Ensemble: many motions, scales, inputs and dampers at once; how likely a limit is exceeded."""

from __future__ import annotations

from dataclasses import replace
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
    shard,
    workers_of,
    workers_option,
)
from dampyr.cli._examples import examples
from dampyr.cli._options import OptionsCommand
from dampyr.cli._output import as_json_option, findings_below, print_answer, print_json
from dampyr.cli._report import report_options
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.structures import EnsembleOptions, EnsembleResult


@click.command(
    cls=OptionsCommand,
    options={"options": "dampyr.structures:EnsembleOptions"},
    first=len(CASE_OPTIONS) - 1,  # the first of them is an argument
    epilog=examples("dampyr ensemble damper.toml --voltage 0 --voltage 1.98 --scale 0.5:1.5:0.5 --limit 12mm"),
)
@case_options
@click.option(
    "--out", type=click.Path(path_type=Path), help="An .h5 file, continued where it stopped; with --shard a folder."
)
@click.option("--shard", "part", metavar="I/N", help="Compute part I of N alone, into the folder --out.")
@click.option(
    "--collect", type=click.Path(path_type=Path), metavar="DIR", help="Put the parts in the folder DIR together."
)
@read_option
@click.option(
    "--demands",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Write the peaks for pelicun and SimCenter's tools, a .csv for each damper and input; needs --height.",
)
@workers_option
@cluster_option
@report_options()
@as_json_option
def command(
    request: EnsembleCommand,
    options: EnsembleOptions,
    out: Path | None,
    part: str | None,
    collect: Path | None,
    read: Path | None,
    demands: Path | None,
    workers: int | None,
    cluster: str | None,
    report: Path | None,
    as_json: bool,
) -> None:
    """Run a structure through many earthquakes: peaks and fragility.

    The structure is the two-storey building of Raminelli (2020), or that of --structure.

    CARD is a damper's card or the name of a published damper; without it that of Raminelli (2020) is taken.
    Every damper runs at every input under every motion at every scale.
    """
    height = options.height
    if demands is not None:
        if height is None:
            raise InputError("--demands writes drifts over the height of a storey; give it, such as --height 3m")
        if not any(text.strip().endswith("%") for text in options.limits):
            options = replace(options, height=None)  # which a limit in per cent alone takes
    options.checked_limits()
    if [part, collect, read].count(None) < 2:
        raise InputError("--shard, --collect and --read exclude each other; give one of them")
    if part is not None:
        if options.limits or report or demands:
            raise InputError("a part alone has no results yet; give --limit, --report and --demands with --collect")
        _write_part(request, options, part, out, workers, cluster, as_json)
        return
    if collect is None and read is None:
        result = run_cases(request, options, out, workers, cluster)
    else:
        result = _read(options, out, collect, read)
    if demands:
        from dampyr.structures import write_demands

        assert height is not None
        *_, about = write_demands(result.dataset, height, demands)
        click.echo(f"dampyr: {demands} written\n{about.read_text('utf-8').rstrip()}", err=True)
    if report:
        from dampyr.show.pages.result_page import write_page

        write_page(result, report)
    print_answer(result, as_json)


def _write_part(
    request: EnsembleCommand,
    options: EnsembleOptions,
    text: str,
    out: Path | None,
    workers: int | None,
    cluster: str | None,
    as_json: bool,
) -> None:
    from dampyr.structures import ensemble_cases, write_part

    if out is None:
        raise InputError("--shard writes its part into a folder; name it with --out")
    cases = ensemble_cases(**request.cases(options))
    with counting() as progress, workers_of(workers, cluster) as pool:
        path = write_part(cases, *shard(text), out, pool, progress)
    if as_json:
        print_json({"part": path})
    else:
        click.echo(str(path))


def _read(options: EnsembleOptions, out: Path | None, collect: Path | None, read: Path | None) -> EnsembleResult:
    from dampyr import structures

    if collect is not None:
        refuse_cases("--collect")
        result = structures.collect(collect, out)
    else:
        assert read is not None
        refuse_cases("--read")
        if out is not None:
            raise InputError("--read takes a finished file and --out writes one; give one of the two")
        result = structures.read_ensemble(read)
    return result.evaluated(options.limits, options.height, options.intensity, options.seed)


def run_cases(
    request: EnsembleCommand,
    options: EnsembleOptions,
    out: Path | None,
    workers: int | None,
    cluster: str | None = None,
) -> EnsembleResult:
    """The ensemble of the command line's cases, with its progress told; a file ``out`` is continued where it stopped."""
    from dampyr.structures import ensemble, ensemble_cases
    from dampyr.structures.ensembles.store import progress_of

    cases = request.cases(options)
    done, shards = progress_of(out) if out is not None else (0, 0)
    before = 0
    if done:
        click.echo(f"{out}: {done} of {shards} shards are there; going on with the others", err=True)
        before = ensemble_cases(**cases).size * done // shards
    with counting(before) as progress, findings_below(), workers_of(workers, cluster) as pool:
        return ensemble(**cases, executor=pool, out=out, progress=progress)
