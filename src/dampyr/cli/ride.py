"""Ride: a quarter or a half car over random roads, and how it rides at each input of its dampers."""

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
        "dampyr ride --voltage 0 --voltage 1 --wheelbase 2.6 --suspension 18000,22000 --length 100",
    )
)
@click.argument("card", required=False, type=click.Path(path_type=Path))
@click.option("--voltage", "voltages", multiple=True, type=float, help="Voltage at the coil in V; may be repeated.")
@click.option("--current", "currents", multiple=True, type=float, help="Current in A, for a card over the current.")
@control_option
@click.option("--sprung", default="290", metavar="KG", help="Mass of a quarter of the body.  [default: 290]")
@click.option(
    "--unsprung",
    default="45",
    metavar="KG",
    help="Mass of the wheel; this and the next may be front,rear.  [default: 45]",
)
@click.option("--suspension", default="18000", metavar="N/M", help="Stiffness of the suspension.  [default: 18000]")
@click.option("--tyre", default="190000", metavar="N/M", help="Stiffness of the tyre.  [default: 190000]")
@click.option("--damping", default="300", metavar="N.S/M", help="Dashpot beside the damper.  [default: 300]")
@click.option("--tyre-damping", default="0", metavar="N.S/M", help="Dashpot of the tyre.  [default: 0]")
@click.option("--wheelbase", metavar="M", help="Distance of the axles: a half car, of twice the --sprung mass.")
@click.option(
    "--centre", metavar="M", help="Centre of mass of the half car behind its front axle.  [default: half the wheelbase]"
)
@click.option(
    "--inertia",
    metavar="KG.M2",
    help="Of its body in pitch.  [default: mass x distances of both axles from the centre]",
)
@click.option(
    "--seat", metavar="M", help="Where its acceleration is felt, behind the front axle.  [default: the centre of mass]"
)
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
    wheelbase: str | None,
    centre: str | None,
    inertia: str | None,
    seat: str | None,
    **car: str,
) -> None:
    """Drive a car over random roads: comfort and tyre load.

    CARD is a damper's card or the name of a published damper; without it that of Raminelli (2020) is taken. It stands
    between wheel and body of a quarter car, or with --wheelbase at both axles of a half car. Every input runs over the same
    roads of a class of ISO 8608. Told are the body's acceleration, weighted as ISO 2631-1 does for seated people, the travel
    of the suspension, the change of the tyre's force on the road, and the share of the time in which a real wheel would leave
    it. Of a half car the travel is that of the axle with the larger one, and the tyre that whose force changes by the larger
    share of its weight; JSON has both axles.
    """
    from dampyr import structures

    damper = damper_of(card, temperature)
    numbers: dict[str, Any] = {
        name: _numbers(name, text, UNITS[name], wheelbase is not None) for name, text in car.items()
    }
    if wheelbase is None:
        of_half = {"--centre": centre, "--inertia": inertia, "--seat": seat}
        if typed := [flag for flag, text in of_half.items() if text is not None]:
            raise InputError(f"{typed[0]} is of a half car; give --wheelbase, too, or leave it out")
        vehicle: Any = structures.quarter_car(**{name: values[0] for name, values in numbers.items()})
    else:
        vehicle = _half_car(numbers, _number("wheelbase", wheelbase, "m"), centre, inertia)
    found = structures.rides(
        vehicle,
        damper,
        **inputs_by_kind(damper, voltages, currents, controls),
        road_class=road_class,
        speed=_number("speed", speed, "m/s"),
        length=_number("length", length, "m"),
        seeds=seeds,
        position=None if seat is None else _number("seat", seat, "m"),
    )
    print_answer(found, as_json)


def _half_car(numbers: dict[str, Any], wheelbase: float, centre: str | None, inertia: str | None) -> Any:
    """The half car of the options: its body is two quarters."""
    from dampyr import structures

    front = wheelbase / 2.0 if centre is None else _number("centre", centre, "m")
    if not 0.0 < front < wheelbase:
        raise InputError(f"--centre {front:g} is not allowed; it must be between the axles, 0 to {wheelbase:g} m")
    if len(numbers["sprung"]) > 1:
        raise InputError("--sprung is a quarter of the body, one number; --centre says how it lies on the axles")
    body, rear = 2.0 * numbers.pop("sprung")[0], wheelbase - front
    about = body * front * rear if inertia is None else _number("inertia", inertia, "kg m^2")
    return structures.half_car(body, about, front, rear, **numbers)


def _numbers(name: str, text: str, unit: str, pairs: bool) -> list[float]:
    """A number, or where ``pairs`` are allowed that of the front axle and that of the rear one."""
    parts = text.split(",")
    if len(parts) > (2 if pairs else 1):
        of_both = (
            "or front and rear as in 18000,22000" if pairs else "as a quarter car has one axle; --wheelbase makes two"
        )
        raise InputError(f"--{name.replace('_', '-')} {text}: give one number, {of_both}")
    return [_number(name, part, unit) for part in parts]


def _number(name: str, text: str, unit: str) -> float:
    from dampyr import units

    try:
        return units.parse(text, unit)
    except InputError as problem:
        raise InputError(f"--{name.replace('_', '-')}: {problem}") from None
