r"""How numbers and symbols of plain texts are set: 1·10⁻⁸ for 1e-8, and :math:`k_x` in italics for dahl.kx."""

from __future__ import annotations

import re
from functools import lru_cache
from html import escape

from dampyr.show.figures.symbols import symbol, with_law_words

POWERS = str.maketrans("-+0123456789", "⁻⁺⁰¹²³⁴⁵⁶⁷⁸⁹")
_POWER = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)e([+-])0*(\d+)(?![\w])")

# letters of the literature that are not words, and stand alone in prose; not those inside of a tag that is set already
_BARE = re.compile(r"(?<![\w./\"-])(?:kx|kw|k0|c0|rho)(?![\w\"]|\.\w)")


def with_powers(text: str) -> str:
    """``text`` with powers of ten written out: 9e-08 becomes 9·10⁻⁸; words and names with an e in them stay."""
    return _POWER.sub(lambda match: f"{match[1]}·10{raised(match[2] + match[3])}", text)


def raised(exponent: str) -> str:
    """An exponent in raised digits, without a plus."""
    return exponent.removeprefix("+").translate(POWERS)


def as_html(text: str) -> str:
    """``text`` escaped, powers of ten written out, names of parameters such as dahl.kx and kx as symbols, laws in words."""
    named = _names().sub(_set, escape(with_powers(with_law_words(text)), quote=True))
    return _BARE.sub(lambda match: _symbol(match[0], match[0]), named)


def as_words(text: str) -> str:
    """``text`` as `as_html` has it, in characters alone: dahl k_x at 1.98 V for ``dahl.kx @ 1.98 V``."""

    def plain(match: re.Match[str]) -> str:
        return f"{match[1].replace('_', ' ')} {_written(match[2])}{' at ' if match[3] else ''}"

    return _BARE.sub(lambda match: _written(match[0]), _names().sub(plain, with_law_words(text)))


def _written(name: str) -> str:
    letter_and_index = symbol(name)
    return name if letter_and_index is None else "_".join(filter(None, letter_and_index))


def _set(match: re.Match[str]) -> str:
    at = " at " if match[3] else ""
    return f"{match[1].replace('_', ' ')} {_symbol(match[2], f'{match[1]}.{match[2]}')}{at}"


def _symbol(name: str, title: str) -> str:
    letter_and_index = symbol(name)
    if letter_and_index is None:
        return name
    letter, index = letter_and_index
    below = f"<sub>{index}</sub>" if index else ""
    return f'<var title="{title}">{letter}{below}</var>'


@lru_cache(maxsize=1)
def _names() -> re.Pattern[str]:
    """Every parameter of the catalogue after its part, as laws are called; a part that is there twice has a number."""
    from dampyr.models import available_parts
    from dampyr.models.part import part

    pairs = "|".join(f"(?:{name}_?\\d*)\\.(?:{'|'.join(part(name).parameters)})" for name in available_parts())
    return re.compile(rf"(?<![\w./])(?=(?:{pairs})(?!\.?\w))(\w+)\.(\w+)( @ )?")
