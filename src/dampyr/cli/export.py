"""Export: the damper in other people's tools."""

from __future__ import annotations

from pathlib import Path

import click

from dampyr.cli._control import damper_of, temperature_option
from dampyr.cli._examples import examples
from dampyr.cli._output import as_json_option, print_json, print_notice, state_origin


@click.command(
    epilog=examples(
        "dampyr export damper.toml --to c --out controller",
        "dampyr export damper.toml --to fmu --name rd8041 --out fmu",
    )
)
@click.argument("card", type=click.Path(path_type=Path))
@click.option("--to", "kind", required=True, metavar="KIND", help="What to write: c, fmu, matlab or opensees.")
@click.option("--out", default=".", type=click.Path(path_type=Path), help="The folder to write into.")
@click.option("--name", default="damper", show_default=True, help="The name of the damper in the files.")
@click.option(
    "--without", multiple=True, metavar="PART", help="Leave out a part, such as lag where C filters the command."
)
@click.option("--float", "single", is_flag=True, help="Write single precision; for c.")
@click.option("--history", type=int, metavar="N", help="Samples that a delay looks back over; for c.  [default: 4096]")
@click.option("--fmi", type=click.Choice(["2", "3"]), help="Version of the FMI standard; for fmu.  [default: 2]")
@click.option(
    "--drive",
    type=click.Choice(["both", "displacement", "velocity"]),
    help="The input of the damper; for fmu. The other one is derived.  [default: both]",
)
@click.option(
    "--inverse", is_flag=True, help="Write what finds the input that gives a wanted force, too; for c and fmu."
)
@temperature_option
@click.option(
    "--allow-extrapolation", is_flag=True, help="Let the damper run outside the calibrated range of its input."
)
@as_json_option
def command(
    card: Path,
    kind: str,
    out: Path,
    name: str,
    without: tuple[str, ...],
    single: bool,
    history: int | None,
    fmi: str | None,
    drive: str | None,
    inverse: bool,
    temperature: float | None,
    allow_extrapolation: bool,
    as_json: bool,
) -> None:
    """Write a damper for another tool.

    CARD is a damper's card, or the name of a published damper.
    What is written refuses inputs outside the calibrated range (in C: the force is NAN) unless allowed here.
    An FMU is compiled on this machine, and needs a C compiler.
    """
    from dampyr.export import export
    from dampyr.findings import OF_DAMPER, as_dicts, handed_on

    damper = damper_of(card, temperature, allow_extrapolation).without(*without)
    typed = {
        "single": single or None,
        "history": history,
        "fmi": int(fmi) if fmi else None,
        "drive": drive,
        "inverse": inverse or None,
    }
    options = {key: value for key, value in typed.items() if value is not None}
    written = export(damper, kind, out, name, allow_extrapolation, **options)
    state_origin(damper.origin)
    findings = handed_on([damper], OF_DAMPER)
    if as_json:
        listed = as_dicts(findings)
        print_json({"damper_origin": damper.origin.as_dict(), "findings": listed, "written": written})
        return
    print_notice(findings)
    for path in written:
        click.echo(str(path))
