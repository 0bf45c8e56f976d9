"""Specimens: the history and the trends of every serial number in folders of tests."""

from __future__ import annotations

from pathlib import Path

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import answer, as_json_option
from dampyr.cli._report import report_options


@click.command(epilog=examples("dampyr specimens lab", "dampyr specimens lab --report specimens.html"))
@click.argument("folders", metavar="FOLDER...", nargs=-1, required=True, type=click.Path(path_type=Path))
@report_options()
@as_json_option
def command(folders: tuple[Path, ...], report: Path | None, as_json: bool) -> None:
    """Tell the history of specimens from the folders of their records.

    Of every serial number in FOLDER, or in folders in it: how many tests, complete or not, their days and operators; cards
    and verdicts (of `dampyr accept --json`) that lie beside them; and how force and energy of equal tests changed. Equal
    names on different rigs are different specimens.
    """
    from dampyr.records import specimens

    result = specimens(*folders)
    answer(result, report, as_json)
