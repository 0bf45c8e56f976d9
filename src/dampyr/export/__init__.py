"""Export of dampers to other tools.

Each kind of export is one file of the package ``dampyr.export.kinds``; `export` writes one of them, `available_kinds` lists
them.
"""

from __future__ import annotations

from pathlib import Path

from dampyr.models import Damper
from dampyr.registry import member, names

REGISTRY = "dampyr.export.kinds"

__all__ = ["available_kinds", "export"]


def available_kinds() -> list[str]:
    """The kinds of export."""
    return names(REGISTRY)


def export(
    damper: Damper, to: str, out: str | Path, name: str = "damper", allow_extrapolation: bool = False
) -> list[Path]:
    """Write ``damper`` as ``to`` (one of `available_kinds`) into the folder ``out``; the files written.

    ``name`` is its name there. Inputs outside the calibrated range are refused by what is written, unless
    ``allow_extrapolation``. Raises :class:`~dampyr.errors.InputError` for an unknown kind or a name that the target
    cannot use.
    """
    kind = member(REGISTRY, to)
    folder = Path(out)
    written: list[Path] = kind.write(damper, folder, name, allow_extrapolation)
    return written
