"""Records named on the command line: files, or folders of them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.errors import DampyrWarning

if TYPE_CHECKING:
    from dampyr.records import ReadOptions, Record


def role_option(
    what: str = "Which records of a folder are taken.",
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """``--role``, which comes as ``role``: None takes all."""
    chosen = click.Choice(["fit", "validation", "all"])
    return click.option("--role", type=chosen, default="all", callback=_role, help=what)


def _role(context: click.Context, parameter: click.Parameter, chosen: str) -> str | None:
    return None if chosen == "all" else chosen


READING = {"reading": "dampyr.records:ReadOptions"}
"""What a command that reads records takes: its `OptionsCommand` gets it among its ``options``."""


def gather(
    paths: tuple[Path, ...],
    role: str | None,
    reading: ReadOptions,
    reference_inputs: Sequence[float] = (),
    warn: bool = True,
    short: list[str] | None = None,
) -> list[Record]:
    """The records in files and folders, measured inputs that are constant but for noise as constants.

    ``role`` chooses among those of a folder, None takes all; measured inputs close to ``reference_inputs`` count as these.
    A line on stderr lists what was joined, and with ``warn`` another one the records that create energy.
    ``short``, where it is given, takes the sentence of each file that has too few samples for a record, and none is an error.
    """
    from dampyr import records

    measured = records.read_records(paths, role, reading, short)  # type: ignore[arg-type]
    nominal = records.nominal_inputs(measured, reference_inputs)
    tell_inputs(measured, nominal)
    if warn:
        warn_of_signs(nominal)
    return nominal


def tell_inputs(measured: Sequence[Record], nominal: Sequence[Record]) -> None:
    """Say on stderr, in one line, which measured inputs count as which."""
    joined: dict[float, list[float]] = {}
    units = set()
    for before, after in zip(measured, nominal, strict=True):
        if before is not after and before.input_value is not None and after.input_value is not None:
            joined.setdefault(after.input_value, []).append(before.input_value)
            units.add("voltage" if after.input == "V" else "current")
    unit = "V" if units == {"voltage"} else "A"
    summaries = [_joined(u, sorted(values), unit) for u, values in sorted(joined.items())]
    if any(summaries):
        click.echo(
            f"dampyr: {units.pop()} as measured, constant but for noise: {'; '.join(filter(None, summaries))}", err=True
        )


def _joined(nominal: float, values: list[float], unit: str) -> str:
    """What counts as ``nominal``; empty where that says nothing."""
    low, high, counts = f"{values[0]:.4g}", f"{values[-1]:.4g}", f"{nominal:.4g}"
    if low == high == counts:
        return ""
    seen = low if low == high else f"{low} to {high}"
    times = f" in {len(values)} records" if len(values) > 1 else ""
    return f"{seen} {unit}{times} counts as {counts} {unit}"


def warn_of_signs(record_list: Sequence[Record]) -> None:
    """Warn of records whose loops create energy, in one line."""
    from dampyr.phrases import listing
    from dampyr.records.checks.label_checks import creates_energy

    wrong = [record.name for record in record_list if creates_energy(record)]
    if wrong:
        warnings.warn(
            f"{len(wrong)} of {len(record_list)} records create energy where a damper dissipates ({listing(wrong, 3)}); force "
            "sign inverted?",
            DampyrWarning,
            stacklevel=3,
        )
