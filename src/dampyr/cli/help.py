"""Help: the pages of the documentation, which come with the package."""

from __future__ import annotations

import difflib
from pathlib import Path

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import as_json_option, print_json, print_table
from dampyr.errors import InputError

SECTIONS = ("tutorials", "how-to", "explanations", "reference")


@click.command(epilog=examples("dampyr help", "dampyr help card", "dampyr help explanations/ensembles"))
@click.argument("topic", required=False)
@as_json_option
def command(topic: str | None, as_json: bool) -> None:
    """Print a page of the documentation.

    TOPIC is the name of a page, such as card; without it the pages are listed.
    """
    pages = list_pages()
    if topic is None:
        rows = [[name, page.parent.name, read_title(page)] for name, page in pages.items()]
        if as_json:
            print_json([dict(zip(("topic", "section", "title"), row, strict=True)) for row in rows])
            return
        print_table("Pages", ["topic", "section", "title"], rows, notes=["dampyr help TOPIC prints one."])
        return
    page = pages.get(topic.removesuffix(".md"))
    if page is None:
        near = difflib.get_close_matches(topic, pages, n=3, cutoff=0.5)
        meant = f"did you mean {', '.join(near)}?" if near else "all are listed by dampyr help"
        raise InputError(f"no page is called {topic!r}; {meant}")
    text = page.read_text("utf-8")
    if as_json:
        print_json({"topic": topic, "title": read_title(page), "text": text})
        return
    click.echo(text.rstrip())


def docs_folder() -> Path:
    """The folder of the pages: in an installed package, or in the checkout that it runs from."""
    package = Path(__file__).resolve().parents[1]
    installed = package / "docs"
    return installed if installed.is_dir() else package.parents[1] / "docs"


def list_pages() -> dict[str, Path]:
    """Each page by its name; of two of one name the later section's is SECTION/NAME."""
    found: dict[str, Path] = {}
    for section in SECTIONS:
        for page in sorted((docs_folder() / section).glob("*.md")):
            found[page.stem if page.stem not in found else f"{section}/{page.stem}"] = page
    return found


def read_title(page: Path) -> str:
    """The heading of a page."""
    first = next((line for line in page.read_text("utf-8").splitlines() if line.startswith("# ")), f"# {page.stem}")
    return first.removeprefix("# ").strip()
