"""One self-contained HTML page without network access, for paper and phone, light and dark."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from itertools import chain, count
from pathlib import Path
from typing import Any

from dampyr.atomic_write import write_whole
from dampyr.errors import InputError
from dampyr.report.blocks import Block, Cell, FigureBlock, Section, Table, Text, Verdict
from dampyr.report.figure_files import keep
from dampyr.report.svg import inline_svg

DASH = "–"
STYLES = ("look.css", "page.css")
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


def page(
    title: str,
    sections: Sequence[Section],
    subtitle: str = "",
    provenance: str | Mapping[str, str] = "",
) -> str:
    """The page as a string of HTML.

    ``subtitle`` stands under the title; ``provenance`` (a sentence, or name -> value) at the foot says where
    the numbers came from. All text is escaped: none of it is taken for HTML.
    """
    if not sections:
        raise InputError("a page needs at least one section")
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
    facts = {"": provenance} if isinstance(provenance, str) else dict(provenance)
    return str(
        template.render(
            title=title,
            subtitle=subtitle,
            sections=ready,
            provenance=facts if provenance else {},
            marks=_MARKS,
        )
    )


def _table_names(sections: Sequence[Section]) -> Iterator[str]:
    """One name per table, for those who hear it: its caption, with its section and a count where that is there twice."""
    used_names: set[str] = set()
    for section in sections:
        for table in (block for block in section.blocks if isinstance(block, Table)):
            name = table.caption or section.title
            numbered = (f"{section.title}: {name} ({number})" for number in count(2))
            label = next(each for each in chain((name, f"{section.title}: {name}"), numbered) if each not in used_names)
            used_names.add(label)
            yield label


def write_page(path: str | Path, html: str) -> Path:
    """Write a page whole or not at all: a reader never sees half of it."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, html)
    return path


@lru_cache(maxsize=1)
def _template() -> Any:
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=PackageLoader("dampyr.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    folder = files("dampyr.report") / "templates"
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
            svg = inline_svg(block.figure, block.alt or block.caption, prefix)
            return {"kind": "figure", "svg": Markup(svg), "caption": block.caption}
        case Table():
            return _table(block) | {"label": next(labels)}
    raise InputError(f"{type(block).__name__} is no block; use Text, Table, FigureBlock or Verdict")


def _table(table: Table) -> dict[str, Any]:
    sides = list(table.align) or [_side([row[k] for row in table.rows]) for k in range(len(table.columns))]
    units = list(table.units) or [""] * len(table.columns)
    return {
        "kind": "table",
        "caption": table.caption,
        "columns": [{"name": n, "unit": u, "side": s} for n, u, s in zip(table.columns, units, sides, strict=True)],
        "rows": [[_shown(cell, table.digits) for cell in row] for row in table.rows],
    }


def _side(cells: Sequence[Cell]) -> str:
    filled = [cell for cell in cells if cell is not None]
    numbers = [cell for cell in filled if _is_number(cell)]
    return "right" if numbers and len(numbers) == len(filled) else "left"


def _is_number(cell: object) -> bool:
    return hasattr(cell, "__float__") and not isinstance(cell, bool)


def _shown(cell: Any, digits: int) -> _Shown:
    if cell is None:
        return _Shown(DASH, "")
    if isinstance(cell, Verdict):
        return _Shown(cell.text, cell.kind, cell)
    if isinstance(cell, bool):
        return _Shown("yes" if cell else "no", str(int(cell)))
    if isinstance(cell, int):
        return _Shown(str(cell).replace("-", "−"), str(cell))
    if _is_number(cell):
        return _Shown(number(float(cell), digits), repr(float(cell)))
    return _Shown(str(cell), str(cell))


def number(value: float, digits: int = 5) -> str:
    """A number for a person: ``digits`` significant digits, a true minus, powers of ten written out."""
    if not math.isfinite(value):
        return DASH if math.isnan(value) else ("∞" if value > 0 else "−∞")
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    power = f"·10{str(int(exponent)).translate(_SUPERSCRIPT)}" if exponent else ""
    return mantissa.replace("-", "−") + power


_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
