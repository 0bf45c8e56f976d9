"""The bibliography, docs/references.bib: its page, and links from citations to it.

A work is cited in a text by its label, ``Dahl (1968)``, ``Wereley, Pang and Park (1998)`` or ``Spencer et al. (1997)``, or in a
docstring also by its key, ``[Arias1970]_``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from pybtex.database import Entry, Person, parse_file

FILE = Path(__file__).resolve().parents[1] / "docs" / "references.bib"
FROM_A_PACKAGE = "../bibliography.html"  # the bibliography, as seen from the page of a package in the site
MAX_NAMES = 4  # authors that a label names; of more the first


@dataclass(frozen=True)
class Work:
    """One entry of the bibliography."""

    key: str
    entry: Entry

    @property
    def authors(self) -> list[str]:
        """Surnames."""
        return [surname(person) for person in self.entry.persons["author"]]

    @property
    def year(self) -> str:
        return str(self.entry.fields["year"])

    @property
    def label(self) -> str:
        """As a text names it."""
        names = self.authors
        return f"{joined(names) if len(names) <= MAX_NAMES else f'{names[0]} et al.'} ({self.year})"

    @property
    def anchor(self) -> str:
        """Of its heading, as a repository browser and the site make them."""
        return re.sub(r"[^\w\- ]", "", self.label.lower()).replace(" ", "-")

    @property
    def labels(self) -> list[str]:
        """Every way that a text may name it."""
        names = self.authors
        heads = {joined(names), f"{names[0]} et al."} if len(names) > 1 else {names[0]}
        return sorted(heads, key=len, reverse=True)


def surname(person: Person) -> str:
    """With its particle, without braces."""
    return plain(" ".join([*person.prelast_names, *person.last_names]))


def joined(names: list[str]) -> str:
    """Names in a row."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def plain(text: str) -> str:
    """Without the braces that keep capitals."""
    return re.sub(r"[{}]", "", text).replace("--", "–")


@cache
def works() -> tuple[Work, ...]:
    """All, by label."""
    entries = parse_file(str(FILE), bib_format="bibtex").entries
    return tuple(sorted((Work(key, entry) for key, entry in entries.items()), key=lambda work: work.label.lower()))


def described(work: Work) -> str:
    """The entry in Markdown, its DOI as a link."""
    fields = {key: plain(str(value)) for key, value in work.entry.fields.items()}
    people = ", ".join(name(person) for person in work.entry.persons["author"])
    inside = fields.get("journal") or fields.get("booktitle") or fields.get("school") or fields.get("institution")
    volume = " ".join(
        fields[key] if key == "volume" else f"({fields[key]})" for key in ("volume", "number") if key in fields
    )
    parts = [
        f"{people}.",
        f"{fields['title']}.",
        " ".join(filter(None, [f"*{inside}*" if inside else "", volume.replace(" (", "(")])),
        fields.get("publisher", ""),
        fields.get("note", ""),
        fields.get("pages", ""),
        fields["year"],
    ]
    text = " ".join(parts[:2]) + " " + ", ".join(filter(None, parts[2:])) + "."
    link = f" [doi:{fields['doi']}](https://doi.org/{escaped(fields['doi'])})" if "doi" in fields else ""
    return text + (link or (f" <{fields['url']}>" if "url" in fields else ""))


def name(person: Person) -> str:
    """Initials and surname."""
    return " ".join([*person.first_names, *person.middle_names, surname(person)])


def escaped(doi: str) -> str:
    """For a Markdown link."""
    return doi.replace("(", "%28").replace(")", "%29").replace("<", "%3C").replace(">", "%3E")


def sections() -> str:
    """Every work under a heading of its own, in Markdown."""
    return "\n".join(f"## {work.label}\n\n{described(work)}\n" for work in works())


@cache
def _patterns() -> tuple[tuple[re.Pattern[str], Work], ...]:
    return tuple(
        (re.compile(rf"(?<![\w\[`])({spaced(head)})(,?)\s+(?:\({work.year}\)|{work.year}(?!\w))"), work)
        for work in works()
        for head in work.labels
    )


def spaced(head: str) -> str:
    """A pattern for names that a line break may part."""
    return r"\s+".join(map(re.escape, head.split()))


def linked(text: str, page: str) -> str:
    """A Markdown text, each work that it names by its label a link to ``page``."""
    for pattern, work in _patterns():
        text = pattern.sub(lambda m, w=work: f"[{m[0]}]({page}#{w.anchor})", text)  # type: ignore[misc]
    return text


def linked_in_rst(text: str, page: str) -> str:
    """A docstring, each work that it names by its label or its key a link to ``page``."""
    keys = {work.key: work for work in works()}
    text = re.sub(
        r"\[(\w+)\]_", lambda m: f"`{keys[m[1]].label} <{page}#{keys[m[1]].anchor}>`__" if m[1] in keys else m[0], text
    )
    for pattern, work in _patterns():
        text = pattern.sub(lambda m, w=work: f"`{m[0]} <{page}#{w.anchor}>`__", text)  # type: ignore[misc]
    return text
