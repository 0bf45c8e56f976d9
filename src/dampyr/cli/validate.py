"""Validate: how well a card predicts records."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dampyr.cli._examples import examples
from dampyr.cli._options import OptionsCommand
from dampyr.cli._output import as_json_option, print_json, print_result, state_origin
from dampyr.cli._records import READING, gather, role_option
from dampyr.cli._report import report_options

if TYPE_CHECKING:
    from dampyr.identification import ScoreOptions
    from dampyr.records import ReadOptions


@click.command(
    cls=OptionsCommand,
    options={"options": "dampyr.identification:ScoreOptions"} | READING,
    first=1,
    epilog=examples(
        "dampyr validate damper.toml tests --role validation", "dampyr validate damper.toml tests --forces forces"
    ),
)
@click.argument("card", type=click.Path(path_type=Path))
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@role_option()
@click.option(
    "--forces", type=click.Path(path_type=Path), metavar="DIR", help="Write measured and predicted forces as CSV."
)
@report_options()
@as_json_option
def command(
    card: Path,
    paths: tuple[Path, ...],
    role: str | None,
    options: ScoreOptions,
    forces: Path | None,
    report: Path | None,
    reading: ReadOptions,
    as_json: bool,
) -> None:
    """Score a card on records that it predicts.

    CARD is a damper's card, or the name of a published damper. It runs freely along each record of PATHS (files or folders of
    them); only the offset is taken from the record. Records that the card was fitted on are marked. --forces writes NAME.csv
    for each record, with its time, displacement, measured force and predicted force; files that this command wrote before are
    replaced, others never.
    """
    from dampyr.identification import validate
    from dampyr.phrases import counted
    from dampyr.studies import load_damper

    damper = load_damper(card)
    records = gather(paths, role, reading, reference_inputs=damper.range, warn=False)
    result = validate(damper, records, options, card=str(card))
    written = result.write_forces(forces) if forces else []
    if report:
        from dampyr.show.pages.result_page import write_page

        write_page(result, report)
    state_origin(result.origin)
    if as_json:
        print_json(result.as_dict() | {"forces": written})
        return
    print_result(result)
    if written:
        click.echo(f"forces: {counted(len(written), 'file')} in {forces}")
    if report:
        click.echo(f"page: {report}")
