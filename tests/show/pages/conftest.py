"""Pages for tests of their texts and tables alone."""

import pytest

from dampyr.show.pages import html_page


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
