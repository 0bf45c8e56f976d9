"""Export: the damper in other people's tools."""

from __future__ import annotations

from pathlib import Path

import click

from dampyr.cli._control import damper_of, temperature_option
from dampyr.cli._output import as_json_option, print_json


@click.command()
@click.argument("card", type=click.Path(path_type=Path))
@click.option("--to", "kind", required=True, metavar="KIND", help="What to write, such as c: C99 without dependencies.")
@click.option("--out", default=".", type=click.Path(path_type=Path), help="The folder to write into.")
@click.option("--name", default="damper", show_default=True, help="What the damper is called there.")
@click.option(
    "--without", multiple=True, metavar="PART", help="Leave out a part, such as lag where C filters the command."
)
@temperature_option
@click.option("--allow-extrapolation", is_flag=True, help="Let it run outside the calibrated range of its input.")
@as_json_option
def command(
    card: Path,
    kind: str,
    out: Path,
    name: str,
    without: tuple[str, ...],
    temperature: float | None,
    allow_extrapolation: bool,
    as_json: bool,
) -> None:
    """Write a damper for another tool.

    CARD is a damper's card, or the name of a published damper.
    What is written refuses inputs outside the calibrated range (in C: the force is NAN) unless allowed here.
    """
    from dampyr.export import export

    damper = damper_of(card, temperature, allow_extrapolation).without(*without)
    written = export(damper, kind, out, name, allow_extrapolation)
    if as_json:
        print_json({"written": written})
        return
    for path in written:
        click.echo(str(path))
