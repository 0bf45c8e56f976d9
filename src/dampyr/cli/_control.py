"""Options of a damper in a building: its card, its place, its inputs and its control laws."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.models import Damper
    from dampyr.structures import Building

control_option = click.option(
    "--control",
    "controls",
    multiple=True,
    metavar="LAW",
    help="A control law, such as on_off or on_off:period=0.01,lag=0.005; may be repeated.",
)


temperature_option = click.option(
    "--temperature",
    type=float,
    metavar="DEGC",
    help="Temperature of the damper in degC, for a card whose laws depend on it.",
)


structure_option = click.option(
    "--structure", metavar="FILE", help="A structure's TOML file or published name.  [default: raminelli_2020]"
)


def structure_of(name: str | None) -> Building:
    """The structure of a file or a published name; the two-storey building of Raminelli (2020) without one."""
    from dampyr import studies

    return studies.load_structure(studies.THESIS if name is None else name)


def inputs_for(
    damper: Damper, voltages: tuple[float, ...], currents: tuple[float, ...], controls: tuple[str, ...]
) -> tuple[float, ...]:
    """The numbers that are inputs of this damper; refuses those of the other kind, and a request without any input."""
    if not damper.has_input:
        typed = [
            name
            for name, values in (("--voltage", voltages), ("--current", currents), ("--control", controls))
            if values
        ]
        if typed:
            raise InputError(f"this damper has no input, and {typed[0]} is given; leave it out")
        return ()
    word, numbers, others = ("voltage", voltages, currents) if damper.input == "V" else ("current", currents, voltages)
    if others or not (numbers or controls):
        raise InputError(
            f"this damper takes a {word}; give --{word} or --control, one or several times, and nothing else"
        )
    return numbers


def inputs_by_kind(
    damper: Damper, voltages: tuple[float, ...], currents: tuple[float, ...], controls: tuple[str, ...]
) -> dict[str, Any]:
    """The argument ``voltage`` or ``current`` of a response: the numbers, then the control laws; None as the only one for a
    damper without an input."""
    from dampyr.structures.control_laws import law_of

    numbers = inputs_for(damper, voltages, currents, controls)
    if not damper.has_input:
        return {"voltage": [None]}
    laws = [law_of(text, damper) for text in controls]
    return {"voltage" if damper.input == "V" else "current": [*numbers, *laws]}


def damper_of(card: Path | None, temperature: float | None = None, allow_extrapolation: bool = False) -> Damper:
    """The damper of a card, a published one by its name, or that of Raminelli (2020) without either.

    At a temperature in degC where its laws depend on it: :class:`InputError` without one, and where none of them does.
    """
    from dampyr import studies

    damper = studies.load_damper(studies.THESIS if card is None else card)
    if temperature is None:
        if damper.temperatures is not None:
            low, high = damper.temperatures
            raise InputError(
                f"this damper's parameters depend on its temperature; give --temperature from {low:.4g} to {high:.4g}, in °C"
            )
        return damper
    if damper.temperatures is None:
        raise InputError("no parameter of this damper depends on its temperature; leave out --temperature")
    return damper.at_temperature(temperature, allow_extrapolation)


storeys_option = click.option(
    "--storey",
    "storeys",
    multiple=True,
    type=int,
    metavar="I",
    help="The storey of the damper, between floors I-1 and I; repeat it for one each.  [default: 1]",
)


def placed(damper: Damper, storeys: tuple[int, ...], between: tuple[str, str] | None) -> dict[Any, Damper]:
    """The damper at each place where one stands: storeys, the first without any option, or a pair of floors."""
    from dampyr.structures.sites import one_in_each

    if between is not None or not storeys:
        return {place_of(next(iter(storeys), None), between): damper}
    return one_in_each(damper, storeys)


def place_of(storey: int | None, between: tuple[str, str] | None) -> Any:
    """Where the damper stands: a storey, the first without any option, or a pair of floors."""
    if storey is not None and between is not None:
        raise InputError("both --storey and --between say where the damper stands; give one of the two")
    return between or (1 if storey is None else storey)
