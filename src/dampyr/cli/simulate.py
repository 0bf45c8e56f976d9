"""Simulate: a structure with dampers in an earthquake, or under loads on its floors."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._control import (
    control_option,
    damper_of,
    inputs_by_kind,
    placed,
    storeys_option,
    structure_of,
    structure_option,
    temperature_option,
)
from dampyr.cli._examples import examples
from dampyr.cli._motion import Ground, motion_options
from dampyr.cli._options import OptionsCommand, refuse_typed
from dampyr.cli._output import as_json_option, details_option, findings_below, print_answer
from dampyr.cli._report import report_options
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.ground_motions import MotionReadOptions
    from dampyr.structures import RespondOptions


@click.command(
    cls=OptionsCommand,
    options={
        "options": "dampyr.structures:RespondOptions",
        "reading": "dampyr.ground_motions:MotionReadOptions",
    },
    first=7,
    epilog=examples(
        "dampyr simulate damper.toml --voltage 0 --voltage 1.98 --report building.html",
        "dampyr simulate --control on_off:low=0,high=1.98",
        "dampyr simulate --voltage 0 --voltage 1.98 --loads wind.csv",
        "dampyr simulate --structure bridge.toml --without-damper --supports piers.toml",
    ),
)
@click.argument("card", required=False, type=click.Path(path_type=Path))
@structure_option
@click.option("--without-damper", is_flag=True, help="Simulate the structure alone, without any damper.")
@click.option(
    "--voltage", "voltages", multiple=True, type=float, help="Voltage at the coil in V; repeat it to compare."
)
@click.option("--current", "currents", multiple=True, type=float, help="Current in A, for a card over the current.")
@control_option
@storeys_option
@click.option("--between", nargs=2, metavar="I J", help="Two floors that the damper joins instead; 0 is the ground.")
@click.option(
    "--motion",
    type=click.Path(path_type=Path),
    help="A ground motion file; without it El Centro 1940, or none where there are --loads.",
)
@click.option(
    "--supports",
    "supports_file",
    type=click.Path(path_type=Path),
    help="A TOML file of the motions of several supports, a table for each.",
)
@click.option(
    "--loads",
    "loads_file",
    type=click.Path(path_type=Path),
    help="A table of forces on floors, such as: time [s],floor 1 [kN],floor 2 [kN].",
)
@click.option(
    "--load-unit", metavar="UNIT", help="Unit of the forces in --loads where its header has none, such as kN."
)
@motion_options
@temperature_option
@report_options()
@details_option
@as_json_option
def command(
    card: Path | None,
    structure: str | None,
    without_damper: bool,
    voltages: tuple[float, ...],
    currents: tuple[float, ...],
    controls: tuple[str, ...],
    storeys: tuple[int, ...],
    between: tuple[str, str] | None,
    options: RespondOptions,
    reading: MotionReadOptions,
    motion: Path | None,
    supports_file: Path | None,
    loads_file: Path | None,
    load_unit: str | None,
    ground: Ground,
    temperature: float | None,
    report: Path | None,
    details: bool,
    as_json: bool,
) -> None:
    """Simulate a structure with and without a damper.

    The structure is the two-storey building of Raminelli (2020), or that of --structure.

    CARD is a damper's card or the name of a published damper; without it that of Raminelli (2020) is taken.
    The case without damper always comes first, then one case per --voltage (or --current). With --loads, a table of forces on
    floors, the ground rests unless --motion is given, too. A structure on several supports has --supports in its place.
    """
    from dampyr.options import command_words
    from dampyr.structures import read_loads, read_supports, respond
    from dampyr.structures.supports import SupportedBuilding

    building = structure_of(structure)
    if without_damper:
        refuse_typed(OF_A_DAMPER, "is of a damper, and --without-damper leaves it out; give one of the two")
    damper = None if without_damper else damper_of(card, temperature, options.allow_extrapolation)
    dampers = None if damper is None else placed(damper, storeys, between)
    inputs: dict[str, Any] = {"voltage": []} if damper is None else inputs_by_kind(damper, voltages, currents, controls)
    if load_unit is not None and loads_file is None:
        raise InputError("--load-unit is of the table of --loads; give that, or leave the unit out")
    loads = None if loads_file is None else read_loads(loads_file, load_unit)
    shaking: Any = None
    if supports_file is not None:
        if typed := [*(["--motion"] if motion is not None else []), *ground.typed(), *command_words(reading)]:
            raise InputError(f"{typed[0]} is of one ground motion, and --supports has its own; write it in that file")
        if not isinstance(building, SupportedBuilding):
            raise InputError(
                f"--supports is of a structure on several supports, and {building.name} stands on one ground"
            )
        shaking = read_supports(supports_file)
    elif motion is not None or loads is None:
        if isinstance(building, SupportedBuilding):
            raise InputError(
                f"{building.name} stands on several supports ({', '.join(building.supports)}); give their motions with "
                "--supports"
            )
        shaking = ground.motion(motion, options=reading)
    if shaking is None and (flags := [*ground.typed(), *command_words(reading)]):
        raise InputError(
            f"{flags[0]} is of a ground motion, and the loads act alone; give --motion, too, or leave it out"
        )
    with findings_below():
        result = respond(building, shaking, dampers, **inputs, options=options, loads=loads)
    if report:
        from dampyr.show.pages.result_page import write_page

        write_page(result, report)
    print_answer(result, as_json, None if details else 1 + bool(result.intervals))
    if result.intervals and not as_json:
        error = None if damper is None else damper.prediction_error
        source = None if error is None else error.session_source
        levels = f"with levels of records and sessions: {source}" if source else "without levels of sessions"
        click.echo(f"\nThe intervals are {levels}.")


OF_A_DAMPER = (
    "card",
    "voltages",
    "currents",
    "controls",
    "storeys",
    "between",
    "brace",
    "temperature",
    "without",
    "draws",
)
