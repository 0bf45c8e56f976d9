"""Simulate: a building with dampers in an earthquake."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._control import control_option, inputs_for
from dampyr.cli._motion import Ground, motion_options
from dampyr.cli._output import as_json_option, print_json, print_table
from dampyr.cli._report import report_options
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.structures import Response


@click.command()
@click.argument("card", required=False, type=click.Path(path_type=Path))
@click.option("--voltage", "voltages", multiple=True, type=float, help="V at the coil; repeat it to compare.")
@click.option("--current", "currents", multiple=True, type=float, help="A, for a card over the current.")
@control_option
@click.option("--storey", type=int, help="Where the damper stands; i joins floors i-1 and i.  [default: 1]")
@click.option("--between", nargs=2, metavar="I J", help="Two floors that the damper joins instead; 0 is the ground.")
@click.option("--brace", type=float, metavar="N/M", help="Stiffness of a brace in series with the damper.")
@click.option("--motion", type=click.Path(path_type=Path), help="A ground motion file; without it El Centro 1940.")
@motion_options
@click.option("--without", multiple=True, metavar="PART", help="Leave out a part, such as delay where it is the rig's.")
@click.option("--allow-extrapolation", is_flag=True, help="Take inputs outside the calibrated range.")
@report_options()
@as_json_option
def command(
    card: Path | None,
    voltages: tuple[float, ...],
    currents: tuple[float, ...],
    controls: tuple[str, ...],
    storey: int | None,
    between: tuple[str, str] | None,
    brace: float | None,
    motion: Path | None,
    ground: Ground,
    without: tuple[str, ...],
    allow_extrapolation: bool,
    report: Path | None,
    as_json: bool,
) -> None:
    """Shake the two-storey building with and without a damper.

    CARD is a damper's card; without it the published damper of Raminelli (2020) is taken. The case without damper always
    comes first, then one case per --voltage (or --current).
    """
    from dampyr import structures
    from dampyr.structures import respond

    damper = _damper(card).without(*without)
    damper = damper if brace is None else damper.on_brace(brace)
    place = _place(storey, between)
    shaking = ground.motion(motion)
    building = structures.two_storey()
    word, inputs = inputs_for(damper, voltages, currents, controls)
    cases = {"no damper": respond(building, shaking)}
    for u in inputs:
        given: dict[str, Any] = {word: u, "allow_extrapolation": allow_extrapolation}
        response = respond(building, shaking, {place: damper}, **given)
        cases[response.laws[0] or f"{u:g} {damper.input}"] = response
    if report:
        from dampyr.report.response_page import write_response_page

        write_response_page(cases, report)
    if as_json:
        print_json({name: _as_dict(r) for name, r in cases.items()})
        return
    _print(f"{building.name}, {shaking.name}: peaks", cases)


def _print(title: str, cases: dict[str, Response]) -> None:
    rows = [
        [name, *(1e3 * r.peak_displacement), 1e3 * max(r.peak_drift), max(r.peak_acceleration), r.peak_base_shear,
         max(r.peak_force, default=None), r.input.mean() if r.input.size else None, r.scheme]
        for name, r in cases.items()
    ]  # fmt: skip
    unit = next((r.input_units[0] for r in cases.values() if r.input_units), "")
    floors = [f"floor {k + 1}" for k in range(len(cases["no damper"].peak_displacement))]
    print_table(
        title,
        ["case", *floors, "drift", "acceleration", "base shear", "damper force", "mean input", "scheme"],
        rows,
        ["", *("mm" for _ in floors), "mm", "m/s²", "N", "N", unit, ""],
        digits=5,
    )


def _place(storey: int | None, between: tuple[str, str] | None) -> Any:
    if storey is not None and between is not None:
        raise InputError("both --storey and --between say where the damper stands; give one of the two")
    return between or (1 if storey is None else storey)


def _damper(card: Path | None) -> Any:
    if card is not None:
        from dampyr.models import Damper

        return Damper.load(card)
    from dampyr.studies import raminelli_2020

    return raminelli_2020.damper()


def _as_dict(response: Response) -> dict[str, Any]:
    return {
        "peak_displacement_m": response.peak_displacement,
        "peak_drift_m": response.peak_drift,
        "peak_acceleration_m_s2": response.peak_acceleration,
        "peak_base_shear_N": response.peak_base_shear,
        "peak_force_N": response.peak_force,
        "sites": response.sites,
        "laws": response.laws,
        "mean_input": response.input.mean(axis=1),
        "scheme": response.scheme,
        "step_s": response.step,
        "error_estimate": response.error_estimate,
        "converged": response.converged,
    }
