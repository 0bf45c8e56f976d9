"""The figures of a page as vector files, on white: for a paper, a thesis or a talk."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING

from dampyr.show.figures.style import save

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = (".svg", ".pdf")
_folder: ContextVar[Path | None] = ContextVar("folder of figures", default=None)


@contextmanager
def figure_files(folder: str | Path) -> Iterator[None]:
    """Within it, a page that is made leaves its figures in ``folder`` too, each as SVG and PDF.

    They are named by their place in the page and the section that they stand in, such as ``02-displacements.svg``. Files of
    these names are replaced.
    """
    before = _folder.set(Path(folder))
    try:
        yield
    finally:
        _folder.reset(before)


def keep(figure: Figure, number: int, section: str) -> None:
    """Write the figure where `figure_files` says; nothing outside it."""
    folder = _folder.get()
    if folder is not None:
        for kind in KINDS:
            save(figure, folder / f"{number:02d}-{section}{kind}")
