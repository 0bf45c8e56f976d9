"""Records named on the command line: files, or folders of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.records import Record


@dataclass(frozen=True)
class Reading:
    """What the command line says about files that do not say it themselves."""

    voltage: float | None
    current: float | None
    units: dict[str, str] | None
    columns: dict[str, str] | None


def reading_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options ``--voltage --current --unit --column``; they come as ``reading``, a `Reading`."""

    @click.option("--voltage", type=float, help="V at the coil, for files that do not hold it.")
    @click.option("--current", type=float, help="A, for files that do not hold it.")
    @click.option("--unit", "units", multiple=True, metavar="CHANNEL=UNIT", help="Such as displacement=mm.")
    @click.option("--column", "columns", multiple=True, metavar="CHANNEL=NAME", help="Such as force='Load cell'.")
    @wraps(command)
    def wrapped(
        *rest: Any,
        voltage: float | None,
        current: float | None,
        units: tuple[str, ...],
        columns: tuple[str, ...],
        **options: Any,
    ) -> Any:
        return command(*rest, reading=Reading(voltage, current, pairs(units), pairs(columns)), **options)

    return wrapped


def gather(paths: tuple[Path, ...], role: str | None, reading: Reading) -> list[Record]:
    """The records in files and campaign folders; ``role`` chooses among those of a folder, None takes all."""
    from dampyr import records

    found: list[Record] = []
    for path in paths:
        if path.is_dir():
            found += records.read_campaign(path, role=role)  # type: ignore[arg-type]
        else:
            found.append(records.read(path, **vars(reading)))
    if not found:
        where = ", ".join(map(str, paths))
        raise InputError(f"no records in {where}; name files, or a folder with campaign.csv or .h5 files")
    return found


def pairs(given: tuple[str, ...]) -> dict[str, str] | None:
    """``NAME=VALUE`` options as a dictionary."""
    for pair in given:
        if "=" not in pair:
            raise InputError(f"{pair!r} has no '='; write it as in displacement=mm")
    return dict(pair.split("=", 1) for pair in given) or None
