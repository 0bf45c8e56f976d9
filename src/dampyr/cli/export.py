"""Export: the damper in other people's tools."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from dampyr.cli._control import damper_of, place_of, structure_of, structure_option, temperature_option
from dampyr.cli._examples import examples
from dampyr.cli._output import as_json_option, print_json, print_notice, state_origin
from dampyr.errors import InputError


@click.command(
    epilog=examples(
        "dampyr export damper.toml --to c --out controller",
        "dampyr export damper.toml --to c --control clipped_optimal_lqg --out controller",
        "dampyr export damper.toml --to fmu --name rd8041 --out fmu",
        "dampyr export damper.toml --to fmu --platform win64 --platform linux64",
        "dampyr export damper.toml --to fmu --model-exchange --out fmu",
        "dampyr export damper.toml --to modelica --name rd8041",
    )
)
@click.argument("card", type=click.Path(path_type=Path))
@click.option(
    "--to", "kind", required=True, metavar="KIND", help="What to write: c, fmu, matlab, modelica or opensees."
)
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
    "--model-exchange", is_flag=True, help="Write the differential equation for the master's own solver; for fmu."
)
@click.option(
    "--platform",
    "platforms",
    multiple=True,
    metavar="NAME",
    help="Library for linux64, win64, darwin64, linux-arm64 or all; for fmu.  [default: this machine]",
)
@click.option(
    "--inverse", is_flag=True, help="Write what finds the input that gives a wanted force, too; for c and fmu."
)
@click.option("--control", metavar="LAW", help="Write a control law for the damper, too, such as fuzzy; for c and fmu.")
@structure_option
@click.option("--storey", type=int, help="The storey in which the damper stands; for --control.  [default: 1]")
@click.option("--between", nargs=2, metavar="I J", help="Two floors that the damper joins instead; for --control.")
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
    model_exchange: bool,
    platforms: tuple[str, ...],
    inverse: bool,
    control: str | None,
    structure: str | None,
    storey: int | None,
    between: tuple[str, str] | None,
    temperature: float | None,
    allow_extrapolation: bool,
    as_json: bool,
) -> None:
    """Write a damper for another tool.

    CARD is a damper's card, or the name of a published damper.
    What is written refuses inputs outside the calibrated range (in C: the force is NAN) unless allowed here.
    An FMU is compiled for this machine by its C compiler, or for the platforms that are named (dampyr[fmu]).
    """
    from dampyr.export import export
    from dampyr.findings import OF_DAMPER, as_dicts, handed_on
    from dampyr.structures.control_laws import law_of

    damper = damper_of(card, temperature, allow_extrapolation).without(*without)
    typed = {
        "single": single or None,
        "history": history,
        "fmi": int(fmi) if fmi else None,
        "drive": drive,
        "model_exchange": model_exchange or None,
        "platforms": platforms or None,
        "inverse": inverse or None,
    }
    options: dict[str, Any] = {key: value for key, value in typed.items() if value is not None}
    if control is not None:
        options |= {
            "control": law_of(control, damper),
            "structure": structure_of(structure),
            "place": place_of(storey, between),
        }
    elif structure is not None or storey is not None or between is not None:
        raise InputError(
            "--structure, --storey and --between say where a control law works; give --control LAW, or leave them out"
        )
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
