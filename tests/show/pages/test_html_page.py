"""Pages: self-contained, escaped, whole or not there."""

import hashlib
import math
import re
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dampyr.errors import InputError
from dampyr.phrases import sentence
from dampyr.show.figures import style
from dampyr.show.figures.loops import loops
from dampyr.show.pages.blocks import FigureBlock, Section, Text
from dampyr.show.pages.how_made import made_by
from dampyr.show.pages.html_page import number, page, write_html
from dampyr.show.table import Table, Verdict

COLOURS = re.compile(r"(:root[^{}]*) \{([^}]*)\}")
VOID = {"meta", "br", "use", "path"}
NASTY = "<script>alert('x')</script> & \"quoted\""


class Reader(HTMLParser):
    """What a browser would find: tags well nested, ids, links, texts."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[tuple[str, str]] = []
        self.feed(html)
        self.close()

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append((self.open[-1] if self.open else "", data))

    def values(self, attribute: str) -> list[str]:
        return [attrs[attribute] or "" for _, attrs in self.tags if attribute in attrs]

    def inside(self, tag: str) -> list[str]:
        return [text for parent, text in self.texts if parent == tag]


@cache
def full_page() -> str:
    x, v, f = [0.0, 0.01, 0.0, -0.01], [0.1, 0.0, -0.1, 0.0], [5.0, 1.0, -5.0, -1.0]
    figures = [FigureBlock(loops(x, v, f, {"Dahl": f}), "Loops & more", f"alt {NASTY}") for _ in range(2)]
    table = Table(
        ["name", "value", "verdict"],
        [["kw", 380.611, Verdict("agrees", "to 1 %")], [NASTY, None, Verdict("differs", NASTY)]],
        units=["", "N", ""],
        caption="Parameters",
    )
    sections = [
        Section("Loops", figures),
        Section(f"Loops {NASTY}", [Text(f"One.\n\nTwo {NASTY}"), table]),
        Section("Loops", [Verdict("cannot be checked", "no data")]),
    ]
    return page(NASTY, sections, NASTY, {"seed": NASTY})


def test_a_page_is_well_formed_and_fetches_nothing() -> None:
    html = full_page()
    reader = Reader(html)
    assert reader.open == []
    assert not {"link", "img", "iframe", "object", "embed", "base"} & {tag for tag, _ in reader.tags}
    targets = reader.values("href") + reader.values("xlink:href") + reader.values("src")
    assert targets
    assert all(target.startswith("#") for target in targets)
    assert not re.search(r"@import|url\((?!#)", html)


def test_nothing_that_is_given_is_taken_for_html() -> None:
    reader = Reader(full_page())
    assert [tag for tag, _ in reader.tags].count("script") == 1
    assert "alert" not in "".join(reader.inside("script"))
    for place in ("title", "h1", "h2", "p", "td", "dd", "a"):
        assert any(NASTY in text for text in reader.inside(place)), place
    assert f"alt {NASTY}" in reader.values("aria-label")


def test_every_id_is_there_once_and_every_link_leads_somewhere() -> None:
    reader = Reader(full_page())
    ids = reader.values("id")
    assert len(ids) == len(set(ids))
    links = [target[1:] for target in reader.values("href") + reader.values("xlink:href")]
    links += re.findall(r"url\(#([^)]*)\)", full_page())
    assert set(links) <= set(ids)
    assert {"loops", "loops-2"} <= set(links)


def test_a_page_is_the_same_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")
    html = full_page.__wrapped__()
    assert html == full_page.__wrapped__()
    assert "2001-09-09T01:46:40+00:00" in html


def test_a_table_shows_numbers_for_people_and_keeps_them_whole_for_sorting() -> None:
    rows = [[380.6114567, "a"], [math.inf, "b"], [math.nan, "c"], [None, "d"], [-1.5e-9, True]]
    reader = Reader(page("t", [Section("s", [Table(["x", "y"], rows, digits=4)])]))
    assert reader.inside("td")[::2] == ["380.6", "∞", "–", "–", "−1.5·10⁻⁹"]
    assert [attrs["data-key"] for tag, attrs in reader.tags if tag == "td"][::2] == [
        "380.6114567",
        "inf",
        "nan",
        "",
        "-1.5e-09",
    ]
    assert [attrs["class"] for tag, attrs in reader.tags if tag == "th"] == ["right", "left"]


@pytest.mark.parametrize(
    ("values", "shown"),
    [
        ([45.53412, 4.37331, None], ["45.534", "4.373", "–"]),
        ([25.120004, 21.96, -3.123], ["25.120", "21.960", "−3.123"]),
        ([0.0, 0.8712, 1.98], ["0", "0.8712", "1.98"]),
        ([1234.5678, 0.001234567], ["1234.6", "0.0012346"]),
        ([123456.7, 23456.71], ["1.2346·10⁵", "23457"]),
    ],
)
def test_numbers_of_a_column_stand_below_their_points(values: list[float], shown: list[str]) -> None:
    reader = Reader(page("t", [Section("s", [Table(["x"], [[value] for value in values])])]))
    assert reader.inside("td") == shown


def test_a_column_of_several_units_has_no_common_decimals() -> None:
    reader = Reader(page("t", [Section("s", [Table(["x", "unit"], [[45.53412, "mm"], [4.37331, "V"]])])]))
    assert reader.inside("td") == ["45.534", "mm", "4.3733", "V"]


def test_light_dark_paper_and_phone_are_provided_for() -> None:
    html = full_page()
    for rule in ("prefers-color-scheme: dark", "@media print", "max-width: 34rem", 'name="viewport"'):
        assert rule in html
    used = set(re.findall(r"var\((--[\w-]+)\)", html))
    blocks = [(where, dict(re.findall(r"(--[\w-]+): ([^;]*);", rules))) for where, rules in COLOURS.findall(html)]
    (_, light), (chosen, dark), (_, system), (_, paper) = [block for block in blocks if block[1]]
    assert 'data-theme="dark"' in chosen
    assert dark == system  # what the reader chose, and what the system says, look alike
    assert used <= set(light)
    assert set(light) - {"--font"} == set(dark) == set(paper)


def test_figures_are_drawn_in_the_colours_of_the_page() -> None:
    _, light = COLOURS.findall(full_page())[0]
    for name in ("ink", "muted", "grid", "blue", "vermillion", "green", "purple", "orange", "sky"):
        assert f"--{name}: {getattr(style, name.upper())};" in light


def test_tables_with_one_caption_are_told_apart_by_those_who_hear_them() -> None:
    table = Table(["a"], [[1]], caption="Peaks")
    reader = Reader(page("t", [Section("One", [table]), Section("Two", [table, table, table, Table(["b"], [])])]))
    names = [attrs["aria-label"] for tag, attrs in reader.tags if attrs.get("role") == "region"]
    assert names == ["Peaks", "Two: Peaks", "Two: Peaks (2)", "Two: Peaks (3)", "Two"]


def test_counts_are_whole_however_large() -> None:
    reader = Reader(page("t", [Section("s", [Table(["n"], [[65721], [-3], [65721.4]], digits=3)])]))
    assert reader.inside("td") == ["65721", "−3", "6.57·10⁴"]


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("the search ended", "The search ended."),
        ("delay.tau @ 1 V stands", "delay.tau @ 1 V stands."),
        ("at 0 V", "At 0 V."),
    ],
)
def test_a_note_becomes_a_sentence(text: str, read: str) -> None:
    assert sentence(text) == read


@given(value=st.floats(allow_nan=False, allow_infinity=False), digits=st.integers(1, 12))
def test_a_number_reads_back(value: float, digits: int) -> None:
    plain = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")
    read = float(number(value, digits).replace("·10", "e").translate(plain))
    assert read == float(f"{value:.{digits}g}")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: page("t", []), "at least one section"),
        (lambda: Verdict("aggrees"), "choose from agrees"),
        (lambda: Table(["a", "b"], [[1.0, 2.0], [1.0]]), "row 2 of a table has 1 cells; its columns are 2"),
        (lambda: Table(["a"], [], units=["N", "m"]), "1 columns has 2 units"),
        (lambda: page("t", [Section("s", ["text"])]), "str is not a block"),
    ],
)
def test_what_cannot_be_shown_is_refused(make: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        make()


def test_a_page_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    path = write_html(tmp_path / "new" / "page.html", "<p>ρ</p>")
    assert path.read_text("utf-8") == "<p>ρ</p>"
    with pytest.raises(UnicodeEncodeError):
        write_html(path, "\ud800")
    assert path.read_text("utf-8") == "<p>ρ</p>"
    assert [p.name for p in path.parent.iterdir()] == ["page.html"]


@pytest.mark.parametrize(("rows", "before"), [(3, "Two"), (40, "One")])
def test_the_contents_stand_below_a_first_section_that_fits_a_screen(rows: int, before: str) -> None:
    table = Table(("x",), [[float(k)] for k in range(rows)])
    html = page("A page", [Section("One", [table]), Section("Two", [Text("More.")])])
    assert html.count("<nav") == 1
    assert html.index(f'<section id="{before.lower()}">') == html.index("<section", html.index("<nav"))
    alone = page("A page", [Section("One", [table])])
    assert "<nav" not in alone


def test_a_table_of_many_columns_is_set_smaller() -> None:
    def of(columns: int) -> str:
        table = Table([f"c{k}" for k in range(columns)], [[1.0] * columns])
        return page("A page", [Section("One", [table])])

    assert '<table class="wide">' in of(9)
    assert '<table class="wide">' not in of(8)


def test_checksums_stand_beside_a_page_for_those_who_check_its_files(tmp_path: Path) -> None:
    data = tmp_path / "a & b.csv"
    data.write_text("t,x\n0,1\n", "utf-8")
    with made_by("dampyr identify", [data]):
        path = write_html(tmp_path / "fit.html", page("A fit", [Section("In short", [Text("It is good.")])]))
    beside = path.with_suffix(".sha256").read_text("utf-8")
    assert beside == f"{hashlib.sha256(data.read_bytes()).hexdigest()}  a & b.csv\n"
    assert not write_html(tmp_path / "b.html", page("B", [Section("A", [Text("B.")])])).with_suffix(".sha256").exists()
