"""Serve: a damper that another program's simulation talks to while it runs."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import click

from dampyr.cli._control import damper_of, inputs_for, place_of, structure_of, structure_option, temperature_option
from dampyr.cli._examples import examples
from dampyr.cli._motion import component_option
from dampyr.cli._output import as_json_option, print_json, print_notice, state_origin
from dampyr.errors import InputError


@click.command(
    epilog=examples(
        "dampyr serve damper.toml --opensees 8090 --voltage 1.98",
        "dampyr serve damper.toml --opensees 8090 --control clipped_optimal:low=0,high=1.98",
    )
)
@click.argument("card", required=False, type=click.Path(path_type=Path))
@click.option(
    "--opensees",
    "port",
    required=True,
    type=int,
    metavar="PORT",
    help="Answer OpenSees at this port; 0 takes a free one.",
)
@click.option("--host", default="127.0.0.1", show_default=True, help="The address to listen on.")
@click.option("--voltage", type=float, help="Voltage at the coil in V.")
@click.option("--current", type=float, help="Current in A, for a card over the current.")
@click.option("--control", metavar="LAW", help="A control law, such as clipped_optimal or on_off:period=0.005.")
@structure_option
@click.option("--storey", type=int, help="The storey of the structure in which the damper stands.  [default: 1]")
@click.option("--between", nargs=2, metavar="I J", help="Two floors of the structure that the damper joins instead.")
@click.option(
    "--motion", type=click.Path(path_type=Path), help="The ground motion, for a law that senses absolute motion."
)
@click.option("--motion-unit", metavar="UNIT", help="Unit of the acceleration in a plain file, such as g.")
@click.option("--dt", type=float, help="Seconds between samples, for a plain file with one column.")
@component_option
@click.option("--without", multiple=True, metavar="PART", help="Leave out a part, such as delay.")
@temperature_option
@click.option("--allow-extrapolation", is_flag=True, help="Take inputs outside the calibrated range.")
@as_json_option
def command(
    card: Path | None,
    port: int,
    host: str,
    voltage: float | None,
    current: float | None,
    control: str | None,
    structure: str | None,
    storey: int | None,
    between: tuple[str, str] | None,
    motion: Path | None,
    motion_unit: str | None,
    dt: float | None,
    component: str | None,
    without: tuple[str, ...],
    temperature: float | None,
    allow_extrapolation: bool,
    as_json: bool,
) -> None:
    """Answer an OpenSees model with the force of a damper.

    CARD is a damper's card or the name of a published damper. In OpenSees the damper is an element genericClient, with one
    degree of freedom (on the ground) or two; with --structure, or under a control law, with that of every floor, from the
    ground up. One client is answered, from a process of its own; then this ends and prints what it did.
    """
    from dampyr import ground_motions
    from dampyr.export import opensees_server
    from dampyr.findings import OF_DAMPER, as_dicts, handed_on
    from dampyr.structures.control_laws import law_of

    damper = damper_of(card, temperature, allow_extrapolation).without(*without)
    opensees_server.check_live(damper)
    voltages, currents = (() if value is None else (value,) for value in (voltage, current))
    inputs = inputs_for(damper, voltages, currents, (control,) if control else ())
    if damper.has_input and len(inputs) + (control is not None) != 1:
        raise InputError("--control decides the input itself; give one of --control, --voltage and --current")
    if inputs:
        damper.check_input(inputs[0], allow_extrapolation)
    building = structure_of(structure) if structure is not None or control is not None else None
    if building is None and (storey is not None or between is not None):
        raise InputError("--storey and --between are places of a structure; give --structure too")
    law = law_of(control, damper) if control else None
    record = None if motion is None else ground_motions.read(motion, motion_unit, dt, component)
    place = place_of(storey, between)

    def live_damper(n: int) -> opensees_server.LiveDamper:
        u = inputs[0] if inputs else law if law is not None else 0.0
        return opensees_server.live_damper(n, damper, u, law, building, place, record, allow_extrapolation)

    if building is not None:  # what does not fit is said before anything waits
        live_damper(building.n)
    findings = handed_on([damper], OF_DAMPER)
    state_origin(damper.origin)
    print_notice(findings)
    with opensees_server.listen(host, port) as server:
        click.echo(f"listening on {host} port {server.getsockname()[1]}; Ctrl-C ends it", err=as_json)
        connection, _ = server.accept()
        with connection:
            summary = opensees_server.answer(
                connection,
                live_damper,
            )
    if as_json:
        listed = as_dicts(findings)
        print_json({"damper_origin": damper.origin.as_dict(), "findings": listed, **asdict(summary)})
        return
    per_step = f"{summary.trials / summary.steps:.2f} trials a step" if summary.steps else "no step"
    click.echo(
        f"{summary.ended}: {summary.steps} steps to {summary.time:.4g} s, {per_step}, {summary.seconds:.2f} s, "
        f"{summary.computing:.2f} of them in the damper\n"
        f"largest force {summary.force:.4g} N, largest stroke {1e3 * summary.stroke:.4g} mm"
    )
    for words in summary.outside:
        click.echo(f"dampyr: {words}", err=True)
