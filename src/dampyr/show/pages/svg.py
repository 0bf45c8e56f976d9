"""A figure as inline SVG that follows the page: text as text, colours as CSS variables, no id twice."""

from __future__ import annotations

import io
import re
from html import escape
from typing import TYPE_CHECKING

from dampyr.show.figures import style
from dampyr.show.figures.symbols import in_law_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_VARIABLES = {
    style.INK: "--ink",
    style.MUTED: "--muted",
    style.GRID: "--grid",
    style.BLUE: "--blue",
    style.VERMILLION: "--vermillion",
    style.GREEN: "--green",
    style.PURPLE: "--purple",
    style.ORANGE: "--orange",
    style.SKY: "--sky",
}
_PATH = re.compile(r'(?<=\sd=")[^"]*')
_DECIMALS = re.compile(r"(\.\d\d)\d+")
_ID = re.compile(r'\sid="([^"]*)"')
_REFERENCE = re.compile(r'(?:url\(#|href="#)([^")]*)')
_FONT = re.compile(r"font: (?:(bold|700) )?([\d.]+)px [^;\"]*")


def inline_svg(fig: Figure, alt: str, prefix: str) -> str:
    """The figure as an ``<svg>`` element for a page.

    ``alt`` says in words what it shows; ``prefix`` makes its ids unique in the page.
    """
    buffer = io.StringIO()
    with style.style():
        in_law_words(fig).savefig(buffer, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
    raw = buffer.getvalue()
    svg = re.sub(r"<metadata>.*?</metadata>", "", raw[raw.index("<svg") :], flags=re.DOTALL)
    svg = _PATH.sub(lambda path: " ".join(_DECIMALS.sub(r"\1", path[0]).split()), svg)
    svg = _FONT.sub(lambda font: f"font: {'600 ' if font[1] else ''}{font[2]}px var(--font)", svg)
    # ids that nothing refers to are dropped, before the others stands the prefix
    used = set(_REFERENCE.findall(svg))
    svg = _ID.sub(lambda match: f' id="{prefix}-{match[1]}"' if match[1] in used else "", svg)
    svg = _REFERENCE.sub(lambda match: match[0].replace("#", f"#{prefix}-"), svg)
    for colour, variable in _VARIABLES.items():
        svg = svg.replace(colour, f"var({variable})")
    # without a size of its own it is as wide as the page
    label = escape(alt, quote=True)
    svg = re.sub(r'(<svg[^>]*?)\swidth="[^"]*"', r"\1", svg, count=1)
    svg = re.sub(r'(<svg[^>]*?)\sheight="[^"]*"', r"\1", svg, count=1)
    return svg.replace("<svg", f'<svg role="img" aria-label="{label}"', 1)
