"""Export of dampers to other tools.

Each kind of export is one file of the package ``dampyr.export.kinds``; `export` writes one of them, `available_kinds` lists
them.
"""

from __future__ import annotations

from inspect import signature
from pathlib import Path
from typing import Any

from dampyr.argument_kinds import DAMPER, Argument, check_kinds
from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.registry import member, names

REGISTRY = "dampyr.export.kinds"

__all__ = ["available_kinds", "export"]


def available_kinds() -> list[str]:
    """The kinds of export."""
    return names(REGISTRY)


def export(
    damper: Damper,
    to: str,
    out: str | Path,
    name: str = "damper",
    allow_extrapolation: bool = False,
    **options: Any,
) -> list[Path]:
    """Write ``damper`` as ``to`` (one of `available_kinds`) into the folder ``out``; the files written.

    ``name`` is its name there. Inputs outside the calibrated range are refused by what is written, unless
    ``allow_extrapolation``. ``options`` are those of the kind, the keywords of its ``write``: ``single`` and ``history`` of
    ``c``; ``fmi``, ``drive``, ``model_exchange`` and ``platforms`` of ``fmu``; of both ``inverse``, ``control``, ``structure``
    and ``place``.
    Raises :class:`~dampyr.errors.InputError` for an unknown kind, an option that it does not have, or a name that the target
    cannot use.

    Examples
    --------
    >>> import dampyr as dp
    >>> files = dp.export.export(dp.studies.raminelli_2020.damper(), "c", "controller")
    >>> [path.name for path in files[:2]]
    ['damper.h', 'damper.c']
    """
    check_kinds(
        "export",
        Argument("damper", damper, (Damper,), DAMPER),
        Argument("to", to, (str,), "give a kind of export, such as 'c'"),
    )
    kind = member(REGISTRY, to)
    allowed = [key for key, each in signature(kind.write).parameters.items() if each.kind is each.KEYWORD_ONLY]
    for option in options:
        if option not in allowed:
            its = f"its options are {', '.join(allowed)}" if allowed else "it has no options"
            raise InputError(f"{option} is not an option of the export {to}; {its}")
    anywhere = allow_extrapolation or not damper.needs_input
    written: list[Path] = kind.write(damper, Path(out), name, anywhere, **options)
    return written
