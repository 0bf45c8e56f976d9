"""Pages for tests of their texts and tables alone."""

from typing import Any

import pytest
from tools.figure_text import unreadable

from dampyr.show.pages import html_page


@pytest.fixture(autouse=True)
def figures_can_be_read(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    """No text of a figure of a page overlaps, is cut or too small; looked for in proofs, since it doubles their time."""
    if request.node.get_closest_marker("prove") is None:
        return
    keep = html_page.keep

    def checked(figure: Any, number: int, section: str) -> None:
        faults = unreadable(figure)
        assert not faults, (section, faults)
        keep(figure, number, section)

    monkeypatch.setattr(html_page, "keep", checked)


@pytest.fixture
def figures_not_rendered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are made, but stand empty on the page: rendering them is nine tenths of the time that a page takes."""
    monkeypatch.setattr(html_page, "inline_svg", lambda figure, alt, prefix: "<svg></svg>")


@pytest.fixture
def first_figure_rendered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the first figure of a page is rendered."""
    render, prefixes = html_page.inline_svg, []

    def rendered(figure: object, alt: str, prefix: str) -> str:
        prefixes.append(prefix)
        return render(figure, alt, prefix) if len(prefixes) == 1 else "<svg></svg>"  # type: ignore[arg-type]

    monkeypatch.setattr(html_page, "inline_svg", rendered)
