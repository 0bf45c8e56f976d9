"""Options of a damper in a building: its card, its place, its inputs and its control laws."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.models import Damper

control_option = click.option(
    "--control",
    "controls",
    multiple=True,
    metavar="LAW",
    help="A control law, such as on_off or on_off:period=0.01,lag=0.005; may be repeated.",
)


def inputs_for(
    damper: Damper, voltages: tuple[float, ...], currents: tuple[float, ...], controls: tuple[str, ...]
) -> tuple[float, ...]:
    """The numbers that are inputs of this damper; refuses those of the other kind, and a request without any input."""
    word, numbers, others = ("voltage", voltages, currents) if damper.input == "V" else ("current", currents, voltages)
    if others or not (numbers or controls):
        raise InputError(
            f"this damper takes a {word}; give --{word} or --control, one or several times, and nothing else"
        )
    return numbers


def damper_of(card: Path | None) -> Damper:
    """The damper of a card, a published one by its name, or that of Raminelli (2020) without either."""
    from dampyr import studies

    return studies.load_damper(studies.THESIS if card is None else card)


def place_of(storey: int | None, between: tuple[str, str] | None) -> Any:
    """Where the damper stands: a storey, the first without any option, or a pair of floors."""
    if storey is not None and between is not None:
        raise InputError("both --storey and --between say where the damper stands; give one of the two")
    return between or (1 if storey is None else storey)
