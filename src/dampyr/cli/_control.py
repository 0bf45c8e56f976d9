"""Control laws and constant inputs as the command line names them."""

from __future__ import annotations

from typing import Any

import click

from dampyr.errors import InputError

control_option = click.option(
    "--control",
    "controls",
    multiple=True,
    metavar="LAW",
    help="A control law, such as on_off or on_off:period=0.01,lag=0.005; may be repeated.",
)


def inputs_for(
    damper: Any, voltages: tuple[float, ...], currents: tuple[float, ...], controls: tuple[str, ...]
) -> tuple[str, list[Any]]:
    """The argument that takes the inputs of this damper, "voltage" or "current", and the inputs: numbers, then laws."""
    word, numbers, others = ("voltage", voltages, currents) if damper.input == "V" else ("current", currents, voltages)
    if others or not (numbers or controls):
        raise InputError(
            f"this damper takes a {word}; give --{word} or --control, one or several times, and nothing else"
        )
    return word, [*numbers, *(control(text, damper) for text in controls)]


def control(text: str, damper: Any) -> Any:
    """``on_off:lag=0.01`` as a law over the calibrated range of the damper, or over ``low=`` and ``high=`` where given."""
    from dampyr.structures import control_law

    name, _, rest = text.partition(":")
    low, high = damper.range
    settings: dict[str, Any] = {"low": low, "high": high}
    for part in rest.split(",") if rest else []:
        key, equals, value = part.partition("=")
        if not equals:
            raise InputError(f"--control {text!r}: {part!r} is no setting; write it as in on_off:period=0.01,lag=0.005")
        settings[key.strip()] = value.split("/") if key.strip() == "weights" else _number(key.strip(), value)
    return control_law(name, **settings)


def _number(key: str, value: str) -> Any:
    """A number in SI units, or for a time one with its unit, ``5ms``; what is neither is left to the law to refuse."""
    from dampyr import units

    try:
        return float(value)
    except ValueError:
        return units.parse(value, "s") if key in ("period", "lag") else value
