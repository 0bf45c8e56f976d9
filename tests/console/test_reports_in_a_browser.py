"""The pages that the commands write, in a real browser: alone in the world, readable by everyone, on a phone and on paper."""

import hashlib
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from tests.console.printed_pages import page_texts

from dampyr.cli import cli
from dampyr.show.figures.history import history
from dampyr.show.pages.blocks import FigureBlock, Section, Text
from dampyr.show.pages.how_made import made_by
from dampyr.show.pages.html_page import page, write_html
from dampyr.show.table import Table, Verdict
from dampyr.source_digest import full_version

CAMPAIGN = """
name = "sines"
[[step]]
kind = "sine"
amplitude = ["2 mm", "4 mm"]
frequency = ["0.5 Hz", "1 Hz"]
voltage = ["0 V", "0.8712 V"]
"""
ENSEMBLE = ["--voltage", "1.98", "--synthetic", "4", "--duration", "4", "--scale", "0.2:2:0.6", "--without-damper"]
LONG = ("simulate", "ensemble", "demo", "reproduce")
NAMES = ["motion", "run", "identify", "validate", *LONG]


@pytest.fixture(scope="module")
def report(tmp_path_factory, campaign_folder):
    """``report("motion")``: the page that this command wrote."""
    folder = tmp_path_factory.mktemp("reports")
    (folder / "campaign.toml").write_text(CAMPAIGN)
    records = [str(campaign_folder / f"{name}.mat") for name in ("ensaio.A.1", "ensaio.A.4")]
    read = ["--voltage", "3.212"]
    card = str(folder / "card.toml")
    calls = {
        "motion": [],
        "run": [str(folder / "campaign.toml"), "--dry-run"],
        "identify": [*records, *read, "--model", "dahl + spring", "--save", card],
        "validate": [card, *records, *read],
        "simulate": ["--voltage", "1.98", "--control", "on_off"],
        "ensemble": [*ENSEMBLE, "--limit", "12mm"],
        "demo": ["--out", str(folder)],
        "reproduce": ["--data", str(campaign_folder), "--out", str(folder)],
    }
    own = {"demo": "report.html", "reproduce": "reproduce.html"}

    def write(name):
        path = folder / own.get(name, f"{name}.html")
        if not path.exists():
            if name == "validate":
                write("identify")
            arguments = [name, *calls[name], *([] if name in own else ["--report", str(path)])]
            done = CliRunner().invoke(cli, arguments, catch_exceptions=False)
            assert done.exit_code == 0, done.output
        return path

    return write


@pytest.fixture
def show(chromium):
    """``show(path, **settings)``: the page in a browser; it asks for nothing but itself, and complains of nothing."""
    contexts, requested, wrong = [], [], []

    def open_file(path, **settings):
        context = chromium.new_context(**{"viewport": {"width": 1280, "height": 900}} | settings)
        contexts.append(context)
        page = context.new_page()
        page.on("request", lambda request: requested.append(request.url))
        page.on("pageerror", lambda problem: wrong.append(str(problem)))
        page.on("console", lambda message: wrong.append(message.text))
        page.goto(path.as_uri())
        return page

    yield open_file
    for context in contexts:
        context.close()
    assert {url for url in requested if not url.startswith(("file://", "blob:"))} == set()
    assert len([url for url in requested if url.startswith("file://")]) == len(contexts)
    assert wrong == []


@pytest.mark.prove
@pytest.mark.parametrize("name", NAMES)
def test_a_report_is_readable_in_light_and_dark_on_a_desk_and_a_phone(report, show, accessible, name):
    path = report(name)
    for scheme, width in (("light", 1280), ("dark", 390)):
        page = show(path, color_scheme=scheme, viewport={"width": width, "height": 844})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert page.evaluate(FIGURES_CUT) == []
        assert page.evaluate(LETTERS) >= 5.5, "letters of a figure, in pixels"
        accessible(page)


FIGURES_CUT = """() => [...document.querySelectorAll("figure svg")].filter((svg) => {
    const box = svg.getBoundingClientRect();
    return box.width < 200 || box.left < 0 || box.right > innerWidth;
}).map((svg) => svg.getAttribute("aria-label"))"""
LETTERS = """() => Math.min(99, ...[...document.querySelectorAll("figure svg text")].filter((text) => text.textContent.trim())
    .map((text) => parseFloat(getComputedStyle(text).fontSize) * Math.hypot(text.getScreenCTM().c, text.getScreenCTM().d)))"""


PAGES = {"motion": 3, "run": 3, "identify": 5, "validate": 4, "simulate": 3, "ensemble": 3, "demo": 8, "reproduce": 12}
PAPER = {"width": 665, "height": 1002}  # A4 less its margins, in CSS pixels


def on_paper(page):
    """The page as a printer has it, on a dark screen."""
    page.emulate_media(media="print", color_scheme="dark")
    page.set_viewport_size(PAPER)
    return page


def printed(page):
    """The texts of the printed pages, without blanks."""
    return page_texts(page.pdf(format="A4", prefer_css_page_size=True))


def check_layout(page):
    """Nothing is wider than the sheet, small or cut through; the body is larger than captions and tables."""
    on_paper(page)
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert page.evaluate("getComputedStyle(document.body).color") == "rgb(0, 0, 0)"
    assert page.evaluate(WIDE) == []
    sizes = page.evaluate(SIZES)
    assert min(sizes["all"].values()) >= 7.0, sizes["all"]
    assert sizes["body"] == 10.0
    assert max([0.0, *sizes["small"]]) < sizes["body"]
    assert page.evaluate(CUT) == []


WIDE = """() => [...document.querySelectorAll("table, figure svg")].filter((one) =>
    one.getBoundingClientRect().right > document.documentElement.clientWidth + 1)
    .map((one) => one.closest("[aria-label]")?.getAttribute("aria-label"))"""
SIZES = """() => {
    const points = (one) => Math.round(75 * parseFloat(getComputedStyle(one).fontSize)) / 100;
    const scale = (one) => Math.hypot(one.getScreenCTM().c, one.getScreenCTM().d);
    const own = (one) => [...one.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
    const texts = [...document.body.querySelectorAll("*")].filter((one) => own(one) && one.getClientRects().length
        && !one.closest("sub, script, svg"));
    const drawn = [...document.querySelectorAll("figure svg text")].filter(own);
    const name = (one) => `${one.tagName} ${one.textContent.trim().slice(0, 20)}`;
    const all = [...texts.map((one) => [name(one), points(one)]),
        ...drawn.map((one) => [name(one), points(one) * scale(one) + 0.05])];
    const small = [...document.querySelectorAll("caption, figcaption, td, th")].map(points);
    return { all: Object.fromEntries(all), body: points(document.body), small };
}"""
CUT = """() => [...document.querySelectorAll("figure, caption")].filter((one) =>
    getComputedStyle(one).breakInside !== "avoid" || one.getBoundingClientRect().height > innerHeight)
    .map((one) => one.textContent.slice(0, 80))"""


@pytest.mark.prove
@pytest.mark.parametrize("name", NAMES)
def test_a_report_on_paper_is_light_and_cuts_nothing(report, show, name):
    page = show(report(name), color_scheme="dark")
    check_layout(page)
    texts = printed(page)
    assert len(texts) <= PAGES[name]
    for number, text in enumerate(texts, 1):
        assert f"page{number}of{len(texts)}" in text
    date = page.locator("header time").inner_text()
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d[+-]\d\d:\d\d", date)
    assert f"{date}dampyr{full_version()}" in texts[0]
    assert f"commanddampyr{name}" in "".join(texts[-2:])
    for digits in page.locator(".files code").all_text_contents():
        assert re.fullmatch("[0-9a-f]{64}", digits)
        assert digits[:12] in "".join(texts)
        assert digits not in "".join(texts)


@pytest.fixture
def long_page(tmp_path):
    """A page with a table over several sheets, figures, and a title that means something to CSS."""
    rows = [[f"test {k}", 1.5 * k, Verdict("passed" if k % 2 else "failed")] for k in range(120)]
    t = np.linspace(0.0, 6.0, 200)
    figures = [FigureBlock(history(t, np.sin(k * t)), f"Figure {k}.") for k in range(1, 5)]
    table = Table(("test", "peak speed", "verdict"), rows, ("", "mm/s", ""), caption="Every test.")
    sections = [Section("Tests", [Text("A paragraph."), table]), Section("Figures", figures)]
    (tmp_path / "card.toml").write_text("x")
    with made_by("dampyr validate 'my card.toml' a.h5", [tmp_path / "card.toml"]):
        html = page('Judged by "a\\b" </style>', sections, facts={"specimen": "no. 7"})
    return write_html(tmp_path / "long.html", html)


def test_headings_stand_on_every_page_of_a_table_and_every_page_has_its_number(long_page, show):
    shown = show(long_page)
    texts = printed(shown)
    assert 4 <= len(texts) <= 6
    for number, text in enumerate(texts, 1):
        assert f"page{number}of{len(texts)}" in text
        assert 'Judgedby"a\\b"</style>·' in text
    for text in texts[:2]:
        assert "testpeakspeedmm/sverdict" in text
        assert text.count("test") > 20


def test_a_printed_page_says_where_it_comes_from(long_page, show):
    texts = printed(show(long_page))
    digits = hashlib.sha256(b"x").hexdigest()
    assert f"dampyr{full_version()}specimenno.7" in texts[0]
    assert "commanddampyrvalidate'mycard.toml'a.h5" in texts[-1]
    assert f"card.toml{digits[:12]}" in texts[-1]
    assert digits not in texts[-1]
    assert show(long_page).locator(".files code").text_content() == digits


def test_sizes_on_paper_and_the_page_on_a_phone(long_page, show, accessible):
    check_layout(show(long_page, color_scheme="dark"))
    for scheme in ("light", "dark"):
        phone = show(long_page, color_scheme=scheme, viewport={"width": 390, "height": 844})
        assert phone.evaluate("document.documentElement.scrollWidth") <= 390
        accessible(phone)


def test_a_table_is_sorted_from_the_keyboard(report, show):
    page = show(report("run"))
    table = page.get_by_role("table").first
    head = table.get_by_role("button", name=re.compile("peak speed"))
    for _ in range(60):
        page.keyboard.press("Tab")
        if head.evaluate("button => button === document.activeElement"):
            break
    column = head.evaluate("button => button.parentElement.cellIndex")
    shown = f"rows => rows.map((row) => Number(row.cells[{column}].dataset.key))"
    for key, falling in (("Enter", False), ("Space", True)):
        page.keyboard.press(key)
        values = table.locator("tbody tr").evaluate_all(shown)
        assert values == sorted(values, reverse=falling)
        assert len(set(values)) > 1
    assert head.evaluate("button => button.parentElement.ariaSort") == "descending"


def test_a_figure_is_saved_from_the_page(report, show, tmp_path):
    page = show(report("motion"), color_scheme="dark", accept_downloads=True)
    with page.expect_download() as taken:
        page.get_by_role("button", name="Save as SVG: figure 1").press("Enter")
    target = tmp_path / taken.value.suggested_filename
    taken.value.save_as(target)
    assert re.fullmatch(r"01-[a-z-]+\.svg", target.name)
    text = target.read_text("utf-8")
    assert "var(" not in text
    assert "#1b2026" in text  # the ink of light paper, though the page was dark
    drawn = show(target)
    assert drawn.evaluate("document.documentElement.getBBox().width") > 300
    assert page.evaluate("document.documentElement.dataset.theme") is None


def test_what_a_page_embeds_is_what_the_console_serves(client):
    own = Path(__file__).parents[2] / "src" / "dampyr" / "show" / "pages" / "templates" / "look.css"
    answer = client.get("/static/look.css")
    assert answer.text == own.read_text("utf-8")
    assert answer.headers["content-type"].startswith("text/css")
    assert ":root" not in client.get("/static/console.css").text  # no second list of colours
