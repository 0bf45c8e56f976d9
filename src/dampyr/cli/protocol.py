"""Protocol: the figures of a protocol that was run, and whether they lie within limits."""

from __future__ import annotations

from pathlib import Path

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import EXIT_CODES, answer, as_json_option, findings_below
from dampyr.cli._report import report_options


@click.command(
    epilog=examples(
        "dampyr protocol response --limits limits.csv",
        "dampyr protocol response --limits limits.csv --report response.html",
    ),
)
@click.argument("folder", type=click.Path(path_type=Path))
@click.option(
    "--limits",
    type=click.Path(path_type=Path),
    metavar="CSV",
    help="Judge by this sheet: columns quantity, low and high, and conditions such as 'speed [mm/s]' or direction.",
)
@report_options("Write a page with criteria, values and verdicts.")
@as_json_option
def command(folder: Path, limits: Path | None, report: Path | None, as_json: bool) -> int:
    """Show the figures of a protocol that was run, and judge them.

    FOLDER is that of a campaign with a [protocol]. Exits with 0 when every limit has covered a figure and every
    figure lies within, with 1 when one lies outside, with 3 when something could not be judged, such as a figure
    without a value or a test without a record, or when there are no limits.
    """
    from dampyr.campaigns import judge_protocol

    with findings_below():
        result = judge_protocol(folder, limits or ())
        answer(result, report, as_json)
    return EXIT_CODES[result.verdict]
