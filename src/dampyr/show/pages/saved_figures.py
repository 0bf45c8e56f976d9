"""The figures of a page as vector files, on white: for a paper, a thesis or a talk."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING

from dampyr.show.figures.style import save

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = (".svg", ".pdf")
_wanted: ContextVar[tuple[Path, Sequence[str]] | None] = ContextVar("where figures go, and their kinds", default=None)


@contextmanager
def figure_files(folder: str | Path, kinds: Sequence[str] = KINDS) -> Iterator[None]:
    """Within it, a page that is made leaves its figures in ``folder`` too, each in every one of ``kinds``: as SVG and PDF.

    They are named by their place in the page and the section that they stand in, such as ``02-displacements.svg``. Files of
    these names are replaced.
    """
    before = _wanted.set((Path(folder), kinds))
    try:
        yield
    finally:
        _wanted.reset(before)


def keep(figure: Figure, number: int, section: str) -> None:
    """Write the figure where `figure_files` says; nothing outside it."""
    if wanted := _wanted.get():
        folder, kinds = wanted
        for kind in kinds:
            save(figure, folder / f"{number:02d}-{section}{kind}")
