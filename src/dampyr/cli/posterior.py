"""Posterior: samples of a fit's numbers, where errors are asymmetric or near a limit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dampyr.cli._examples import examples
from dampyr.cli._options import OptionsCommand
from dampyr.cli._output import answer, as_json_option, findings_below
from dampyr.cli._progress import stages
from dampyr.cli._records import READING, gather
from dampyr.cli._report import report_options

if TYPE_CHECKING:
    from dampyr.identification import FitOptions
    from dampyr.records import ReadOptions

OF_A_CHOICE = ("predict", "folds", "budget", "models", "add_ons", "finalists", "nested", "yardstick")
TAILS = ("t", "normal")


@click.command(
    cls=OptionsCommand,
    options={"options": "dampyr.identification:FitOptions"} | READING,
    leave_out=OF_A_CHOICE,
    first=4,
    epilog=examples("dampyr posterior tests --model dahl --lengths 20 --report posterior.html"),
)
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--model", required=True, help="The model by its parts, such as 'dahl + spring + delay'.")
@click.option(
    "--lengths", type=click.FloatRange(0.0, min_open=True), default=50.0, show_default=True, metavar="N",
    help="Autocorrelation times of a chain.",
)  # fmt: skip
@click.option(
    "--chain-steps", type=click.IntRange(100), default=6000, show_default=True, metavar="N",
    help="Steps of each walker at most.",
)  # fmt: skip
@click.option(
    "--tails", type=click.Choice(TAILS), default="t", help="Density: as the fit's intervals, or normal.  [default: t]"
)
@report_options()
@as_json_option
def command(
    paths: tuple[Path, ...],
    model: str,
    lengths: float,
    chain_steps: int,
    tails: str,
    options: FitOptions,
    report: Path | None,
    reading: ReadOptions,
    as_json: bool,
) -> None:
    """Sample which dampers are as likely as the best one.

    The model is fitted to the records of PATHS, and its numbers are sampled around the best ones: for errors that are not
    symmetric, or that end at a limit. --seed is that of the samples, too. Needs the extra bayes. The exit code is 0 also where
    the chains were not long enough, which the answer says.
    """
    from dampyr.identification import fit, sample_posterior

    records = gather(paths, "fit", reading)
    with stages() as progress, findings_below():
        found = fit(records, model, replace(options, predict=()), progress)
        samples = sample_posterior(found, lengths, chain_steps, tails, options.seed, progress)
    answer(samples, report, as_json)
