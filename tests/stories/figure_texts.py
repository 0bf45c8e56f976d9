"""The texts of figures instead of their pictures, for tests of what stands on a page: rendering is nine tenths of its time."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from html import escape
from pathlib import Path

import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

from dampyr.show import notebook
from dampyr.show.pages import html_page, saved_figures


def texts_as_svg(figure: Figure, *_: str) -> str:
    """An SVG that holds nothing but the texts of the figure: titles, legends, names of axes, the mark of its origin."""
    artists: list[Text] = [*figure.texts]
    for legend in (*figure.legends, *(panel.get_legend() for panel in figure.axes)):
        artists += legend.get_texts() if legend else []
    for panel in figure.axes:
        artists += [*panel.texts, panel.xaxis.label, panel.yaxis.label]
    names = [artist.get_text() for artist in artists] + [panel.get_title(loc="left") for panel in figure.axes]
    texts = [escape(name) for name in names if name]
    return f"<svg>{''.join(f'<text>{text}</text>' for text in texts)}</svg>"


@contextmanager
def texts_alone() -> Iterator[None]:
    """Within it, figures of pages, of notebooks and of files hold their texts alone."""

    def save(figure: Figure, path: Path, **journal: object) -> Path:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(texts_as_svg(figure), encoding="utf-8")
        return path

    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(html_page, "inline_svg", texts_as_svg)
        monkeypatch.setattr(notebook, "as_svg", texts_as_svg)
        monkeypatch.setattr(saved_figures, "save", save)
        yield


PICTURES = [texts_alone, pytest.param(nullcontext, marks=pytest.mark.prove)]  # their texts alone, and as they are
