"""Cycles: the figures of every cycle of records, and of the device by them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dampyr.cli._examples import examples
from dampyr.cli._options import OptionsCommand
from dampyr.cli._output import as_json_option, details_option, print_json, print_result, state_origin
from dampyr.cli._records import READING, gather, role_option
from dampyr.cli._report import report_options

if TYPE_CHECKING:
    from dampyr.records import CycleOptions, ReadOptions


@click.command(
    cls=OptionsCommand,
    options={"options": "dampyr.records:CycleOptions"} | READING,
    epilog=examples(
        "dampyr cycles tests --report cycles.html --out cycles.xlsx",
        "dampyr cycles test.csv --column 'force=Load cell' --voltage 1.98 --units in-lb --details",
    ),
)
@click.argument("paths", metavar="FILES...", nargs=-1, required=True, type=click.Path(path_type=Path))
@role_option("Which records of a folder in FILES are taken.")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="DIR|FILE.xlsx",
    help="Write the tables: a folder of .csv files, or an Excel workbook.",
)
@report_options()
@details_option
@as_json_option
def command(
    paths: tuple[Path, ...],
    options: CycleOptions,
    role: str | None,
    out: Path | None,
    report: Path | None,
    details: bool,
    reading: ReadOptions,
    as_json: bool,
) -> None:
    """Tell the figures of every cycle, and those of the device.

    FILES are records or folders of them. Of every full cycle: dissipated energy, effective stiffness, equivalent damping,
    loss factor, storage stiffness, characteristic strength, second slope, forces, and how they fade; of tests with rising
    strokes half cycles and the backbone, too. Of the device: force and speed, gas force, asymmetry, force over the input,
    response to steps of the input, complex stiffness. A viscous device and one with an input have no equivalent damping.
    """
    from dampyr import records
    from dampyr.show.records.cycle_figures import named_tables

    result = records.cycles(gather(paths, role, reading, warn=False), options)
    if report:
        from dampyr.show.pages.result_page import write_page

        write_page(result, report)
    written = []
    if out:
        from dampyr.show.table_files import write_tables

        written = write_tables(named_tables(result), out, result.origin, result.findings)
    state_origin(result.origin)
    if as_json:
        print_json(result.as_dict())
        return
    print_result(result, None if details else 2, None if details else 5)
    if report:
        click.echo(f"page: {report}")
    if out:
        click.echo(f"tables: {out}" + (f", {len(written)} files" if len(written) > 1 else ""))
