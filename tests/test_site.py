"""The documentation as one site: built without a network and a warning, no link is dead, and every public name is there."""

from __future__ import annotations

import importlib
import shutil
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from html.parser import HTMLParser
from importlib import import_module
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest

pytest.importorskip("furo")

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))
make_site = importlib.import_module("make_site")
sys.path.pop(0)
# A connection to anywhere is an error.
WITHOUT_NETWORK = """
import runpy, socket, sys

def refuse(*args, **options):
    raise OSError("the site is built without a network")

socket.socket.connect = socket.getaddrinfo = socket.create_connection = refuse
sys.path.insert(0, "tools")
sys.argv = ["make_site.py", "--out", sys.argv[1], "--run", "how-to/p[ao]*"]
runpy.run_path("tools/make_site.py", run_name="__main__")
"""


class Page(HTMLParser):
    """What a page links to and loads, and its anchors."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.anchors.update(value for key, value in attrs if key in ("id", "name") and value)
        if tag == "a" and given.get("href"):
            self.links.append(str(given["href"]))
        self.loads += [str(given[key]) for key in ("src", "srcset", "data") if given.get(key)]
        if tag == "link" and given.get("rel") not in ("index", "search", "next", "prev", "canonical"):
            self.loads.append(str(given.get("href")))


def snapshot() -> dict[str, tuple[int, int]]:
    """The files that git knows or would add, with their times and sizes."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    files = [ROOT / name for name in listed.stdout.splitlines()]
    return {str(file): (file.stat().st_mtime_ns, file.stat().st_size) for file in files if file.is_file()}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site; building it has touched no file of the checkout."""
    out = tmp_path_factory.mktemp("built") / "site"
    before = snapshot()
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_NETWORK, str(out)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.strip().endswith("index.html")
    assert snapshot() == before
    return out


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    """The pages of the site."""
    return {file.resolve(): Page(file.read_text(encoding="utf-8")) for file in sorted(site.rglob("*.html"))}


@pytest.mark.prove
def test_what_a_block_printed_drew_and_wrote_is_below_it(site: Path, pages: dict[Path, Page]) -> None:
    """Of the pages that this site has run; that every block of every page runs is tried in tests/test_docs.py."""
    file = site / "how-to" / "passive-dampers.html"
    text = file.read_text(encoding="utf-8")
    assert "none False" in text  # of print(fit.damper.input, fit.damper.needs_input), whose comment is left out
    assert "# none False" not in text
    assert "value ± half of the 95 % interval" in text  # of a command
    assert sum(load.endswith(".svg") and "-page-" in load for load in pages[file].loads) == 2
    assert any(link.endswith("slider.html") for link in pages[file].links)
    not_run = (site / "how-to" / "power.html").read_text(encoding="utf-8")
    assert "Not run when this page was made: reads and writes the fuses of a chip." in not_run


def test_an_excerpt_of_what_is_printed_is_known_and_nothing_else() -> None:
    printed = "dahl, 12 records\n  The search   converged\n"
    assert make_site.is_said("The search converged\ndahl, 12 records\n", printed)
    assert not make_site.is_said("The search stopped\n", printed)
    assert not make_site.is_said("anything\n", "")


@pytest.mark.prove
def test_no_link_of_the_site_is_dead(pages: dict[Path, Page]) -> None:
    dead = []
    for file, page in pages.items():
        for link in page.links:
            if link.startswith(("http://", "https://", "mailto:")):
                continue
            target, _, anchor = unquote(link).partition("#")
            place = (file.parent / target).resolve() if target else file
            if not place.is_file() or (anchor and place in pages and anchor not in pages[place].anchors):
                dead.append((file.name, link))
    assert not dead


@pytest.mark.prove
def test_no_page_loads_anything_from_elsewhere(site: Path, pages: dict[Path, Page]) -> None:
    loads = {(file, load) for file, page in pages.items() for load in page.loads if not load.startswith("data:")}
    assert not [(file.name, load) for file, load in loads if "//" in load]
    assert not [(file.name, load) for file, load in loads if not (file.parent / load.partition("?")[0]).is_file()]
    assert not [file for file in site.rglob("*.css") if "url(http" in file.read_text(encoding="utf-8")]


@pytest.mark.prove
def test_every_page_of_the_documentation_is_in_the_site(site: Path) -> None:
    docs = ROOT / "docs"
    missing = [
        page for page in docs.rglob("*.md") if not (site / page.relative_to(docs)).with_suffix(".html").is_file()
    ]
    assert not missing
    assert (site / "tutorials" / "python.html").is_file()
    assert list(site.rglob("first-damper.ipynb"))
    assert (site / "files" / "CHANGELOG.html").is_file()
    assert (site / "files" / "examples" / "index.html").is_file()


def public() -> Iterator[tuple[str, str]]:
    """Every public name: its page, and its name in full."""
    for name in make_site.pages_of_packages():
        for owner, names in make_site.members(import_module(name)):
            for each in names:
                if not isinstance(getattr(owner, each), type(sys)):
                    yield name, f"{owner.__name__}.{each}"


@pytest.mark.prove
def test_every_public_name_is_on_the_page_of_its_package(site: Path, pages: dict[Path, Page]) -> None:
    names = list(public())
    results = [
        (page, f"{cls.__module__}.{cls.__name__}")
        for page in make_site.pages_of_packages()
        for cls in make_site.results_of(import_module(page))
    ]
    folder = (site / "reference" / "python").resolve()
    assert len(names) > 200
    assert len(results) > 50
    assert not [full for page, full in names + results if full not in pages[folder / f"{page}.html"].anchors]


def test_the_pages_of_the_packages_are_those_of_the_public_face() -> None:
    import dampyr

    short = {"read", "fit", "Damper", "respond"}  # for calls of packages, on whose pages they are
    wanted = {name for name in dir(dampyr) if not name.startswith("_")} - short
    assert wanted <= set(make_site.FACE)
    assert {"dampyr.studies.raminelli_2020", "dampyr.models.published"} <= set(make_site.pages_of_packages())


@pytest.mark.prove
def test_equations_search_and_dark_mode_work_without_a_network(site: Path) -> None:
    sync_playwright = pytest.importorskip("playwright.sync_api").sync_playwright
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("there is no chromium; make chromium installs it")
    requested: list[str] = []
    # the browser of the console's tests may be open in this thread, and has its loop there
    with ThreadPoolExecutor(1) as thread:
        thread.submit(_look_at_the_site, sync_playwright, chromium, site, requested).result()
    assert not [url for url in requested if not url.startswith(("file:", "data:", "blob:"))]


def _look_at_the_site(sync_playwright: Any, chromium: str, site: Path, requested: list[str]) -> None:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page: Any = browser.new_page(color_scheme="dark")
        page.on("request", lambda request: requested.append(request.url))
        page.goto((site / "reference" / "models.html").as_uri())
        page.wait_for_selector("mjx-container")
        drawn = page.evaluate("MathJax.startup.promise.then(() => document.querySelectorAll('mjx-container').length)")
        assert drawn == page.locator(".math").count() > 30
        assert page.locator("mjx-merror").count() == 0
        colour = page.evaluate("getComputedStyle(document.body).backgroundColor")
        assert max(int(part) for part in colour.removeprefix("rgb(").removesuffix(")").split(",")) < 60
        page.goto((site / "search.html").as_uri() + "?q=fragility")
        page.wait_for_selector("#search-results li")
        page.set_viewport_size({"width": 400, "height": 800})
        page.goto((site / "reference" / "python" / "dampyr.structures.html").as_uri())
        assert page.evaluate("document.documentElement.scrollWidth <= document.documentElement.clientWidth")
        browser.close()
