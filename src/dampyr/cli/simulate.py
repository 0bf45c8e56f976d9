"""Simulate: a structure with dampers in an earthquake."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dampyr.cli._control import (
    control_option,
    damper_of,
    inputs_for,
    place_of,
    structure_of,
    structure_option,
    temperature_option,
)
from dampyr.cli._examples import examples
from dampyr.cli._motion import Ground, after_option, motion_options
from dampyr.cli._output import as_json_option, findings_below, print_json, print_table, state_origin
from dampyr.cli._report import report_options
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.findings import Finding
    from dampyr.models import Damper
    from dampyr.structures import Response, Simulated


@click.command(
    epilog=examples(
        "dampyr simulate damper.toml --voltage 0 --voltage 1.98 --report building.html",
        "dampyr simulate --control on_off:low=0,high=1.98",
    )
)
@click.argument("card", required=False, type=click.Path(path_type=Path))
@structure_option
@click.option("--without-damper", is_flag=True, help="The structure alone, without any damper.")
@click.option("--voltage", "voltages", multiple=True, type=float, help="V at the coil; repeat it to compare.")
@click.option("--current", "currents", multiple=True, type=float, help="A, for a card over the current.")
@control_option
@click.option("--storey", type=int, help="Where the damper stands; i joins floors i-1 and i.  [default: 1]")
@click.option("--between", nargs=2, metavar="I J", help="Two floors that the damper joins instead; 0 is the ground.")
@click.option("--brace", type=float, metavar="N/M", help="Stiffness of a brace in series with the damper.")
@click.option(
    "--draws",
    type=int,
    default=0,
    metavar="N",
    help="90 % intervals of the peaks, from N dampers of the card's covariance.",
)
@click.option("--seed", default=1, show_default=True, help="Of the drawn dampers.")
@click.option("--motion", type=click.Path(path_type=Path), help="A ground motion file; without it El Centro 1940.")
@motion_options
@after_option
@temperature_option
@click.option("--without", multiple=True, metavar="PART", help="Leave out a part, such as delay where it is the rig's.")
@click.option("--allow-extrapolation", is_flag=True, help="Take inputs outside the calibrated range.")
@report_options()
@as_json_option
@click.pass_context
def command(
    context: click.Context,
    card: Path | None,
    structure: str | None,
    without_damper: bool,
    voltages: tuple[float, ...],
    currents: tuple[float, ...],
    controls: tuple[str, ...],
    storey: int | None,
    between: tuple[str, str] | None,
    brace: float | None,
    draws: int,
    seed: int,
    motion: Path | None,
    ground: Ground,
    after: float,
    temperature: float | None,
    without: tuple[str, ...],
    allow_extrapolation: bool,
    report: Path | None,
    as_json: bool,
) -> None:
    """Simulate a structure with and without a damper.

    The structure is the two-storey building of Raminelli (2020), or that of --structure.

    CARD is a damper's card or the name of a published damper; without it that of Raminelli (2020) is taken.
    The case without damper always comes first, then one case per --voltage (or --current).
    """
    from dampyr import structures

    building = structure_of(structure)
    if without_damper:
        _refuse_damper(context)
    damper = None if without_damper else damper_of(card, temperature, allow_extrapolation)
    options = structures.SimulateOptions(
        inputs=() if damper is None else inputs_for(damper, voltages, currents, controls),
        laws=controls,
        place=place_of(storey, between),
        brace=brace,
        without=without,
        allow_extrapolation=allow_extrapolation,
        after=after,
        bare=without_damper,
        draws=draws,
        seed=seed,
    )
    with findings_below():
        result = structures.simulate(building, ground.motion(motion), damper, options)
    if report:
        from dampyr.report import write_response_page

        write_response_page(result, report)
    state_origin(result.origin)
    if as_json:
        print_json(result.as_dict())
    else:
        errors = [f"error: {result.error}"] if result.error else []
        notes = [f"the response {result.end}", *([result.note] if result.note else []), *errors]
        _print(f"{result.title}: peaks", result.cases, notes, result.findings)
        if result.intervals:
            _print_intervals(result, damper)


WIDE = 8  # floors that a table has columns for
OF_A_DAMPER = (
    "card",
    "voltages",
    "currents",
    "controls",
    "storey",
    "between",
    "brace",
    "temperature",
    "without",
    "draws",
)


def _refuse_damper(context: click.Context) -> None:
    """Refuse what is of a damper where there is none."""
    for parameter in context.command.params:
        source = context.get_parameter_source(str(parameter.name))
        if parameter.name in OF_A_DAMPER and source is not click.core.ParameterSource.DEFAULT:
            name = parameter.opts[0] if isinstance(parameter, click.Option) else "CARD"
            raise InputError(f"{name} is of a damper, and --without-damper leaves it out; give one of the two")


def _print(title: str, cases: Mapping[str, Response], notes: Sequence[str], findings: Sequence[Finding]) -> None:
    names = list(cases["no damper"].floors)
    many = len(names) > WIDE
    floors = [f"largest of {len(names)} floors"] if many else [f"floor {name}" for name in names]
    rows = [
        [name, *_floors(r, many), 1e3 * max(r.peak_drift), max(r.peak_acceleration), r.peak_base_shear,
         max(r.peak_force, default=None), r.mean_input.mean() if r.mean_input.size else None, r.scheme]
        for name, r in cases.items()
    ]  # fmt: skip
    unit = next((r.input_units[0] for r in cases.values() if r.input_units), "")
    print_table(
        title,
        ["case", *floors, "drift", "acceleration", "base shear", "damper force", "mean input", "scheme"],
        rows,
        ["", *("mm" for _ in floors), "mm", "m/s²", "N", "N", unit, ""],
        digits=5,
        notes=notes,
        findings=findings,
    )


def _floors(response: Response, many: bool) -> list[float]:
    """The floors' peak displacements [mm]; the largest alone where they are many."""
    peaks = 1e3 * response.peak_displacement
    return [float(peaks.max())] if many else peaks.tolist()


def _print_intervals(result: Simulated, damper: Damper | None) -> None:
    """The 90 % intervals of the peaks of each case with a damper."""
    names = list(result.cases["no damper"].floors)
    rows = []
    for name, each in result.intervals.items():
        floors = each["peak_displacement_m"]
        spans = [floors.max(axis=1)] if len(names) > WIDE else list(floors.T)
        more = [
            each["peak_drift_m"].max(axis=1),
            each["peak_acceleration_m_s2"].max(axis=1),
            each["peak_force_N"].max(axis=1),
        ]
        shown = [1e3 * span for span in (*spans, more[0])] + more[1:]
        rows.append([name, *(f"{low:.4g} to {high:.4g}" for low, high in shown)])
    heads = [f"largest of {len(names)} floors"] if len(names) > WIDE else [f"floor {name}" for name in names]
    error = None if damper is None else damper.prediction_error
    source = "" if error is None else f", with levels of records and sessions: {error.session_source}"
    print_table(
        f"90 % intervals of the peaks, {result.draws} drawn dampers",
        ["case", *heads, "drift", "acceleration", "damper force"],
        rows,
        ["", *("mm" for _ in heads), "mm", "m/s²", "N"],
        notes=[
            f"from the covariance of the card{source}"
            if source
            else "from the covariance of the card, without levels of sessions"
        ],
    )
