"""The figures of a page as vector files, on white, and what they draw as tables: for a paper, a thesis or a talk."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dampyr.show.figure_file import save
from dampyr.show.journal_style import JournalStyle

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = (".svg", ".pdf", ".csv")
_wanted: ContextVar[tuple[Path, Sequence[str], Mapping[str, Any]] | None] = ContextVar(
    "where figures go, and their kinds", default=None
)


@contextmanager
def figure_files(folder: str | Path, kinds: Sequence[str] = KINDS, **journal: Any) -> Iterator[None]:
    """Within it, a page that is made leaves its figures in ``folder`` too, each in every one of ``kinds``: as SVG, PDF and CSV.

    ``journal`` says how they look there, as the keywords of `dampyr.show.save` do; the page is as it is without.

    They are named by their place in the page and the section that they stand in, such as ``02-displacements.svg``. Files of
    these names are replaced.
    """
    JournalStyle(**journal)  # what is wrong with it is said before anything is done
    before = _wanted.set((Path(folder), kinds, journal))
    try:
        yield
    finally:
        _wanted.reset(before)


def keep(figure: Figure, number: int, section: str) -> None:
    """Write the figure where `figure_files` says; nothing outside it."""
    if wanted := _wanted.get():
        folder, kinds, journal = wanted
        for kind in kinds:
            save(figure, folder / f"{number:02d}-{section}{kind}", **journal)
