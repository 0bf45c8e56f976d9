"""The bibliography and the texts: what is cited is there, what is there is cited, and a DOI leads to its entry."""

from __future__ import annotations

import re
import sys
from importlib import import_module
from pathlib import Path

import pytest

pytest.importorskip("pybtex")

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))
citations = import_module("citations")
sys.path.pop(0)
WEBSITES = {"SteelDamper"}  # cited by key in a docstring, and no works
SOURCES = [*sorted((ROOT / "src").rglob("*.py")), *sorted((ROOT / "src").rglob("*.toml"))]
PAGES = [page for page in sorted((ROOT / "docs").rglob("*.md")) if page.stem != "bibliography"]
# By what a text names a work other than its label: initials first, or a first author alone.
OTHERWISE = {
    "Vargas2022": "Vargas et al., Sensors 2022",
    "Vargas2021": "zenodo.4445334",
    "Ohtori2004": "Y. Ohtori",
    "Silva2020": "C. E. Silva",
    "Wilson1982": "Wilson et al.",
    "Breiman1984": "Breiman et",
    "Huber1967": "(Huber 1967)",
    "Huber1964": "Huber's (1964)",
    "Kaufman1975": "Kaufman's (1975)",
    "CloughPenzien1975": "CloughPenzien1975",
    "Mosqueda2007": "Mosqueda",
    "Chae2013": "Y. Chae",
    "Longman2000": "Longman",
    "Bristow2006": "Bristow",
    "McClamrochGavin1995": "McClamroch",
    "JansenDyke2000": "L. M. Jansen",
    "Leitmann1994": "G. Leitmann",
    "Karnopp1974": "D. Karnopp",
    "Krasnicki1980": "E. J. Krasnicki",
    "Dyke1996": "S. J. Dyke, B. F. Spencer",
    "Guyan1965": "R. J. Guyan",
    "CraigBampton1968": "R. R. Craig",
    "VanLoan1978": "C. F. Van Loan",
    "Muller2016": "J.-M. Muller",
    "AminAng1968": "M. Amin",
}


@pytest.fixture(scope="module")
def texts() -> str:
    """Everything that cites."""
    files = [*SOURCES, *PAGES, ROOT / "README.md"]
    return " ".join(" ".join(file.read_text(encoding="utf-8") for file in files).split())


def test_every_key_in_a_docstring_is_in_the_bibliography(texts: str) -> None:
    keys = {work.key for work in citations.works()}
    assert set(re.findall(r"\[([A-Za-z]+\d{4}|SteelDamper)\]_", texts)) <= keys | WEBSITES


def test_every_work_is_cited_somewhere(texts: str) -> None:
    by_label = {
        work.key
        for work in citations.works()
        if f"[{work.key}]" in texts
        or any(f"{head}{comma} {year}" in texts for head in work.labels for comma in ("", ",") for year in years(work))
    }
    by_other_words = {key for key, words in OTHERWISE.items() if words in texts}
    assert set(OTHERWISE) == by_other_words
    assert not {work.key for work in citations.works()} - by_label - by_other_words


def years(work: object) -> tuple[str, str]:
    """With and without parentheses."""
    year = work.year  # type: ignore[attr-defined]
    return year, f"({year})"


def test_labels_are_different_and_dois_well_formed() -> None:
    works = citations.works()
    assert len({work.anchor for work in works}) == len({work.key for work in works}) == len(works)
    dois = [work.entry.fields["doi"] for work in works if "doi" in work.entry.fields]
    assert len(set(dois)) == len(dois) >= 30
    assert all(re.fullmatch(r"10\.\d{4,9}/\S+", doi) for doi in dois)


def test_a_citation_becomes_a_link_once() -> None:
    once = citations.linked("as Dahl (1968) and Golub and\nPereyra (1973)", "b.md")
    assert once == "as [Dahl (1968)](b.md#dahl-1968) and [Golub and\nPereyra (1973)](b.md#golub-and-pereyra-1973)"
    assert citations.linked_in_rst("[Arias1970]_", "b.html") == "`Arias (1970) <b.html#arias-1970>`__"
    assert citations.linked("El Centro 1940, `Dahl (1968)`", "b.md") == "El Centro 1940, `Dahl (1968)`"
