"""One self-contained HTML page without network access, for paper and phone, light and dark."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from itertools import chain, count
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.errors import InputError
from dampyr.origin import NOT_STATED, Origin
from dampyr.show.figures import style
from dampyr.show.pages.blocks import Block, FigureBlock, Section, Text
from dampyr.show.pages.how_made import how_made, moment
from dampyr.show.pages.saved_figures import keep
from dampyr.show.pages.svg import inline_svg
from dampyr.show.pages.typography import as_html, raised, with_powers
from dampyr.show.table import Cell, Table, Verdict
from dampyr.source_digest import full_version
from dampyr.source_file import SHOWN_DIGITS, SourceFile

DASH = "–"
STYLES = ("look.css", "page.css")
FEW_ROWS = 16  # of the tables in a section that fits a screen
LONG, ENDLESS = 8, 45  # rows of a table, beyond which its print is smaller, and of one that no page holds
WIDE, CROWDED = 8, 12  # columns, beyond which they stand closer, and closer still
PROSE = 60  # letters of a cell that is read as a sentence
MAX_PLACES = 6  # decimals of a column; smaller numbers have powers of ten
MARGIN = 64  # letters of the title at the foot of a printed page
_SHARES = {style.THIRD: "third", style.HALF: "half", style.TWO_THIRDS: "two-thirds", 1.0: ""}
_MARKS = {
    "agrees": "✓", "differs": "≠", "cannot be checked": "?",
    "passed": "✓", "failed": "✗", "not judged": "?",
}  # fmt: skip


@dataclass(frozen=True)
class _Shown:
    """A cell as the template needs it: what is read, and what is sorted by."""

    text: str
    key: str
    verdict: Verdict | None = None


class PageText(str):
    """The text of a page, and the data files that it names."""

    files: tuple[SourceFile, ...]

    def __new__(cls, text: str, files: Iterable[SourceFile]) -> PageText:
        """``text`` and ``files``."""
        self = super().__new__(cls, text)
        self.files = tuple(files)
        return self


def page(
    title: str,
    sections: Sequence[Section],
    subtitle: str = "",
    provenance: str | Mapping[str, str] = "",
    *,
    facts: Mapping[str, str] | None = None,
    call: str = "",
    origin: Origin = NOT_STATED,
) -> PageText:
    """The page as a string of HTML. All text is escaped: none of it is taken for HTML.

    Parameters
    ----------
    title
        The heading of the page.
    sections
        One or more, in the order in which they are read.
    subtitle
        Stands under the title, and below it the date, the version and the facts of the origin.
    provenance
        Where the numbers came from, at the foot: a sentence, or name -> value.
    facts
        More facts under the title, name -> value.
    call
        The call that made the page, at the foot, where no command did (`made_by`).
    origin
        Of what is shown; where it is simulated or virtual, the first line and every figure say so, and the checksums of its
        files stand at the foot.

    Raises
    ------
    InputError
        Without a section.

    Examples
    --------
    >>> from dampyr import show
    >>> html = show.page("A damper", [show.Section("In short", [show.Text("It damps.")])])
    >>> html.startswith("<!doctype html>")
    True
    """
    if not sections:
        raise InputError("a page needs at least one section")
    for figure in (block.figure for section in sections for block in section.blocks if isinstance(block, FigureBlock)):
        origin.stamp(figure)
    ids = _anchors([section.title for section in sections])
    template, labels, counted = _template(), _table_names(sections), count(1)
    ready = [
        {
            "id": anchor,
            "title": section.title,
            "blocks": [_block(b, f"f{next(counted)}", labels) for b in section.blocks],
        }
        for anchor, section in zip(ids, sections, strict=True)
    ]
    figures = [
        (anchor, block.figure)
        for anchor, section in zip(ids, sections, strict=True)
        for block in section.blocks
        if isinstance(block, FigureBlock)
    ]
    for number, (anchor, figure) in enumerate(figures, 1):
        keep(figure, number, anchor)
    stated = {"": provenance} if isinstance(provenance, str) else dict(provenance)
    source, date = how_made(call), moment()
    read = sorted({*origin.sources, *source.files})
    short_title = title if len(title) <= MARGIN else title[: MARGIN - 1].rstrip() + "…"
    return PageText(
        template.render(
            title=title,
            notice=origin.notice,
            subtitle=subtitle,
            sections=ready,
            contents_before=_contents_before(sections),
            provenance=stated if provenance else {},
            marks=_MARKS,
            date=date,
            version=full_version(),
            facts=origin.facts() | dict(facts or {}),
            command=source.command,
            files=read,
            digits=SHOWN_DIGITS,
            margin=_css_string(f"{short_title} · {date}"),
        ),
        read,
    )


def _contents_before(sections: Sequence[Section]) -> int:
    """The number of the section that the list of contents stands before: the second, as the first answers what a reader came
    for; the first where that one has long tables; none (0) on a page of one section."""
    rows = sum(len(block.rows) for block in sections[0].blocks if isinstance(block, Table))
    return 0 if len(sections) == 1 else 2 if rows <= FEW_ROWS else 1


def _css_string(text: str) -> Any:
    """A string of CSS: whatever is no plain letter is written by its number, so that none of it is taken for CSS."""
    from markupsafe import Markup

    return Markup('"' + "".join(c if c.isascii() and c.isalnum() else f"\\{ord(c):06x}" for c in text) + '"')


def _table_names(sections: Sequence[Section]) -> Iterator[str]:
    """One name per table, for those who hear it: its caption, with its section and a count where that is there twice."""
    used_names: set[str] = set()
    for section in sections:
        for table in (block for block in section.blocks if isinstance(block, Table)):
            name = with_powers(table.caption or section.title)
            numbered = (f"{section.title}: {name} ({number})" for number in count(2))
            label = next(text for text in chain((name, f"{section.title}: {name}"), numbered) if text not in used_names)
            used_names.add(label)
            yield label


def write_html(path: str | Path, html: str) -> Path:
    """Write a page whole or not at all: a reader never sees half of it.

    Beside it stand the checksums of its data files, which ``sha256sum --check`` reads in their folder: NAME.sha256.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, html)
    if isinstance(html, PageText) and html.files:
        write_whole(path.with_suffix(".sha256"), "".join(f"{file}\n" for file in html.files))
    return path


@lru_cache(maxsize=1)
def _template() -> Any:
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=PackageLoader("dampyr.show.pages"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    folder = files("dampyr.show.pages") / "templates"
    environment.filters["typeset"] = lambda text: Markup(as_html(str(text)))
    environment.globals["css"] = Markup("\n".join((folder / name).read_text("utf-8") for name in STYLES))
    environment.globals["js"] = Markup((folder / "page.js").read_text("utf-8"))
    return environment.get_template("page.html")


def _anchors(titles: Sequence[str]) -> list[str]:
    """One id per title, readable in an address and never twice."""
    anchors: list[str] = []
    for title in titles:
        plain = unicodedata.normalize("NFKD", title).encode("ascii", "ignore").decode().lower()
        anchor = base = re.sub(r"[^a-z0-9]+", "-", plain).strip("-") or "section"
        number = 2
        while anchor in anchors:
            anchor, number = f"{base}-{number}", number + 1
        anchors.append(anchor)
    return anchors


def _block(block: Block, prefix: str, labels: Iterator[str]) -> dict[str, Any]:
    """A block as the template needs it; ``labels`` gives the name of the next table."""
    from markupsafe import Markup

    match block:
        case Text():
            return {"kind": "text", "paragraphs": block.paragraphs}
        case Verdict():
            return {"kind": "verdict", "verdict": block}
        case FigureBlock():
            svg = inline_svg(block.figure, with_powers(block.alt or block.caption), prefix)
            return {"kind": "figure", "svg": Markup(svg), "caption": block.caption, "share": _share(block)}
        case Table():
            return _table(block) | {"label": next(labels)}
    raise InputError(f"{type(block).__name__} is not a block; use Text, Table, FigureBlock or Verdict")


def _share(block: FigureBlock) -> str:
    """The class of a figure that is narrower than the page, so that its neighbour may stand beside it; "" of one as wide."""
    share = float(block.figure.get_figwidth()) / style.WIDTH
    nearest = min(_SHARES, key=lambda known: abs(known - share))
    return _SHARES[nearest]


def _table(table: Table) -> dict[str, Any]:
    sides = list(table.align) or [_side([row[k] for row in table.rows]) for k in range(len(table.columns))]
    units = list(table.units) or [""] * len(table.columns)
    mixed = "unit" in table.columns  # a column of mm and V has no common decimals
    places = [
        None if mixed else _places([row[k] for row in table.rows], table.digits) for k in range(len(table.columns))
    ]
    return {
        "kind": "table",
        "kinds": " ".join(_kinds(table)),
        "caption": " ".join(filter(None, (table.caption, *table.notes))),
        "columns": [{"name": n, "unit": u, "side": s} for n, u, s in zip(table.columns, units, sides, strict=True)],
        "rows": [
            [_shown(cell, table.digits, place) for cell, place in zip(row, places, strict=True)] for row in table.rows
        ],
    }


def _kinds(table: Table) -> Iterator[str]:
    """What the style of a table depends on: its columns, its rows, and whether its cells hold sentences."""
    texts = (cell.text if isinstance(cell, Verdict) else cell for row in table.rows for cell in row)
    prose = any(isinstance(text, str) and len(text) > PROSE for text in texts)
    rows = len(table.rows)
    if len(table.columns) > WIDE:
        yield "wide"
    if len(table.columns) > CROWDED:
        yield "crowded"
    if rows > LONG:
        yield "long"
    if rows > ENDLESS or (prose and rows > 2):
        yield "endless"
    if prose and rows > 2:
        yield "prose"


def _side(cells: Sequence[Cell]) -> str:
    filled = [cell for cell in cells if cell is not None]
    numbers = [cell for cell in filled if _is_number(cell)]
    return "right" if numbers and len(numbers) == len(filled) else "left"


def _places(cells: Sequence[Cell], digits: int) -> int | None:
    """How many decimals the numbers of a column have, so that their points stand below one another.

    The largest has ``digits`` significant digits, less zeros that all would end with; None where the smallest would lose all
    but one of its own, or a number has none at all.
    """
    sizes = [abs(float(cell)) for cell in cells if isinstance(cell, float | np.floating)]
    sizes = [size for size in sizes if size > 0.0]
    if not sizes or not all(map(math.isfinite, sizes)):
        return None
    if all(float(f"{size:.{digits}g}") == size for size in sizes):
        return None  # as they were chosen, such as 0.8712 and 1.98 V: to be read as they are elsewhere
    places = digits - 1 - math.floor(math.log10(max(sizes)))
    if not 0 <= places <= MAX_PLACES or math.floor(math.log10(min(sizes))) + places < 1:
        return None
    return max(len(f"{size:.{places}f}".rstrip("0").partition(".")[2]) for size in sizes)


def _is_number(cell: object) -> bool:
    return hasattr(cell, "__float__") and not isinstance(cell, bool)


def _shown(cell: Any, digits: int, places: int | None = None) -> _Shown:
    if cell is None:
        return _Shown(DASH, "")
    if isinstance(cell, Verdict):
        return _Shown(cell.text, cell.kind, cell)
    if isinstance(cell, bool):
        return _Shown("yes" if cell else "no", str(int(cell)))
    if isinstance(cell, int):
        return _Shown(str(cell).replace("-", "−"), str(cell))
    if _is_number(cell):
        value = float(cell)
        if places is not None and math.isfinite(value):
            return _Shown(f"{value:.{places}f}".replace("-", "−"), repr(value))
        return _Shown(number(value, digits), repr(value))
    return _Shown(str(cell), str(cell))


def number(value: float, digits: int = 5) -> str:
    """A number for a person: ``digits`` significant digits, a true minus, powers of ten written out."""
    if not math.isfinite(value):
        return DASH if math.isnan(value) else ("∞" if value > 0 else "−∞")
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    power = f"·10{raised(str(int(exponent)))}" if exponent else ""
    return mantissa.replace("-", "−") + power
