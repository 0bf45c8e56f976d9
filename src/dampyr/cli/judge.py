"""Judge: whether specimens hold the criteria on every level that their campaigns asked."""

from __future__ import annotations

from pathlib import Path

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import EXIT_CODES, answer, as_json_option
from dampyr.cli._report import report_options


@click.command(
    epilog=examples(
        "dampyr judge specimen-17 --criteria ntc_2018_viscous --design design.toml --report judged.html",
    )
)
@click.argument("folders", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--criteria",
    required=True,
    metavar="NAME|FILE",
    help="Shipped criteria, such as ntc_2018_viscous, or a file of them.",
)
@click.option(
    "--design",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="File with the design's values at each level, for criteria that refer to them.",
)
@report_options()
@as_json_option
def command(folders: tuple[Path, ...], criteria: str, design: Path | None, report: Path | None, as_json: bool) -> int:
    """Judge specimens by criteria on every cycle of every level.

    FOLDERS are those of campaigns that dampyr ran, each of one specimen. The levels are the tests of the campaign, as its
    protocol expands; a level that was not run to its end is not judged. Exits with 0 when every specimen passed, with 1
    when a value lies beyond its limit, with 3 when none does but a level could not be judged.
    """
    from dampyr.campaigns import judge

    result = judge(folders, criteria, design or ())
    answer(result, report, as_json)
    return EXIT_CODES[result.verdict]
