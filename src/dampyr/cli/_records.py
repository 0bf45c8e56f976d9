"""Records named on the command line: files, or folders of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.records import Record


def gather(
    paths: tuple[Path, ...],
    role: str | None = "fit",
    voltage: float | None = None,
    current: float | None = None,
    units: tuple[str, ...] = (),
    columns: tuple[str, ...] = (),
) -> list[Record]:
    """The records in files and campaign folders; ``role`` chooses among those of a folder."""
    from dampyr import records

    found: list[Record] = []
    for path in paths:
        if path.is_dir():
            found += records.read_campaign(path, role=role)  # type: ignore[arg-type]
        else:
            found.append(
                records.read(path, voltage=voltage, current=current, units=pairs(units), columns=pairs(columns))
            )
    if not found:
        raise InputError(
            f"no records in {', '.join(map(str, paths))}; name files, or a folder with campaign.csv or .h5 files"
        )
    return found


def pairs(given: tuple[str, ...]) -> dict[str, str] | None:
    """``NAME=VALUE`` options as a dictionary."""
    for pair in given:
        if "=" not in pair:
            raise InputError(f"{pair!r} has no '='; write it as in displacement=mm")
    return dict(pair.split("=", 1) for pair in given) or None
