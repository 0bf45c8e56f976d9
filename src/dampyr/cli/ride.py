"""Ride: a quarter car over random roads, and how it rides at each input of its damper."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from dampyr.cli._control import control_option, damper_of, inputs_by_kind, temperature_option
from dampyr.cli._examples import examples
from dampyr.cli._output import as_json_option, print_answer
from dampyr.errors import InputError

UNITS = {
    "sprung": "kg",
    "unsprung": "kg",
    "suspension": "N/m",
    "tyre": "N/m",
    "damping": "N s/m",
    "tyre_damping": "N s/m",
}


@click.command(
    epilog=examples(
        "dampyr ride --voltage 0 --voltage 1 --control on_off:high=1 --length 100 --seeds 2",
        "dampyr ride --voltage 0 --voltage 1 --road D --speed '50 km/h' --sprung 400 --seeds 2 --length 100",
    )
)
@click.argument("card", required=False, type=click.Path(path_type=Path))
@click.option("--voltage", "voltages", multiple=True, type=float, help="Voltage at the coil in V; may be repeated.")
@click.option("--current", "currents", multiple=True, type=float, help="Current in A, for a card over the current.")
@control_option
@click.option("--sprung", default="290", metavar="KG", help="Mass of a quarter of the body.  [default: 290]")
@click.option("--unsprung", default="45", metavar="KG", help="Mass of the wheel.  [default: 45]")
@click.option("--suspension", default="18000", metavar="N/M", help="Stiffness of the suspension.  [default: 18000]")
@click.option("--tyre", default="190000", metavar="N/M", help="Stiffness of the tyre.  [default: 190000]")
@click.option("--damping", default="300", metavar="N.S/M", help="Dashpot beside the damper.  [default: 300]")
@click.option("--tyre-damping", default="0", metavar="N.S/M", help="Dashpot of the tyre.  [default: 0]")
@click.option("--road", "road_class", default="C", help="Class of ISO 8608, A to H.  [default: C]")
@click.option("--speed", default="20", metavar="M/S", help="Speed, such as 20 or '72 km/h'.  [default: 20]")
@click.option("--length", default="400", metavar="M", help="Length of each road.  [default: 400]")
@click.option("--seeds", default=5, type=click.IntRange(1), metavar="N", help="Number of roads.  [default: 5]")
@temperature_option
@as_json_option
def command(
    card: Path | None,
    voltages: tuple[float, ...],
    currents: tuple[float, ...],
    controls: tuple[str, ...],
    road_class: str,
    speed: str,
    length: str,
    seeds: int,
    temperature: float | None,
    as_json: bool,
    **car: str,
) -> None:
    """Drive a quarter car over random roads: comfort and tyre load.

    CARD is a damper's card or the name of a published damper; without it that of Raminelli (2020) is taken. It stands
    between wheel and body. Every input runs over the same roads of a class of ISO 8608. Told are the body's acceleration,
    weighted as ISO 2631-1 does for seated people, the travel of the suspension, the change of the tyre's force on the road, and
    the share of the time in which a real wheel would leave it.
    """
    from dampyr import structures

    damper = damper_of(card, temperature)
    numbers: dict[str, Any] = {name: _number(name, text, UNITS[name]) for name, text in car.items()}
    quarter = structures.quarter_car(**numbers)
    found = structures.rides(
        quarter,
        damper,
        **inputs_by_kind(damper, voltages, currents, controls),
        road_class=road_class,
        speed=_number("speed", speed, "m/s"),
        length=_number("length", length, "m"),
        seeds=seeds,
    )
    print_answer(found, as_json)


def _number(name: str, text: str, unit: str) -> float:
    from dampyr import units

    try:
        return units.parse(text, unit)
    except InputError as problem:
        raise InputError(f"--{name.replace('_', '-')}: {problem}") from None
