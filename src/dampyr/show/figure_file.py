"""A figure as a file of its own: SVG, PDF or PNG, and what it draws as CSV."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from dampyr.show.figure_data import write_figure_data
from dampyr.show.figures import style
from dampyr.show.figures.symbols import in_law_words
from dampyr.show.journal_style import JournalStyle, in_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_UNDATED = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}  # the same figure gives the same file


def save(fig: Figure, path: str | Path, **journal: Any) -> Path:
    """Write a figure to a file of its own (.svg, .pdf, .png), on white.

    ``journal`` are the fields of `dampyr.show.journal_style.JournalStyle`: ``width="88 mm"``, ``font="DejaVu Serif"``,
    ``grey=True``, ``decimal_comma=True``. The figure itself stays as it is. What it draws is written as a table where the path
    ends in .csv.
    """
    path, look = Path(path), JournalStyle(**journal)
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".csv":
        return write_figure_data(fig, path, look.decimal_comma)
    with style.style(), in_style(fig, look), style.on_white(fig):
        in_law_words(fig).savefig(path, facecolor="white", dpi=200, metadata=_UNDATED.get(path.suffix))
    return path
