"""The texts on the pages of a PDF that Chromium printed: enough of the format for its own files, and nothing more."""

from __future__ import annotations

import re
import unicodedata
import zlib

OBJECT = re.compile(rb"(?:^|\n)(\d+) 0 obj\n(.*?)\nendobj", re.DOTALL)
SHOWN = re.compile(rb"/(\w+) [\d.]+ Tf|(<[0-9A-Fa-f]*>|\[[^\]]*\]) ?TJ?j?|\b(ET)\b")
DIGITS = re.compile(rb"<([0-9A-Fa-f]*)>")


def page_texts(paper: bytes) -> list[str]:
    """The text of each page, in the order in which it was drawn; blanks are left out, as their places vary."""
    objects = {int(number): body for number, body in OBJECT.findall(paper)}
    return [_text(objects, body) for body in _pages(objects)]


def _pages(objects: dict[int, bytes]) -> list[bytes]:
    """The pages in their order, down the tree from its root."""
    root = next(body for body in objects.values() if b"/Type /Pages" in body and b"/Parent" not in body)

    def below(body: bytes) -> list[bytes]:
        if b"/Type /Pages" not in body:
            return [body]
        children = re.search(rb"/Kids \[(.*?)\]", body, re.DOTALL)
        assert children
        return [page for number in re.findall(rb"(\d+) 0 R", children[1]) for page in below(objects[int(number)])]

    return below(root)


def _text(objects: dict[int, bytes], page: bytes) -> str:
    contents = re.search(rb"/Contents (\d+) 0 R", page)
    assert contents
    fonts = {
        name: _letters(objects, objects[int(number)])
        for name, number in re.findall(rb"/(F\d+) (\d+) 0 R", _resources(objects, page))
    }
    letters: dict[int, str] = {}
    text = []
    for font, shown, _ in SHOWN.findall(_stream(objects[int(contents[1])])):
        if font:
            letters = fonts.get(font, {})
        for digits in DIGITS.findall(shown):
            text += [letters.get(int(digits[k : k + 4], 16), "") for k in range(0, len(digits), 4)]
    return re.sub(r"\s", "", unicodedata.normalize("NFKC", "".join(text)))  # ligatures apart


def _resources(objects: dict[int, bytes], page: bytes) -> bytes:
    elsewhere = re.search(rb"/Resources (\d+) 0 R", page)
    own = objects[int(elsewhere[1])] if elsewhere else page
    fonts = re.search(rb"/Font (\d+) 0 R", own)
    return objects[int(fonts[1])] if fonts else own


def _letters(objects: dict[int, bytes], font: bytes) -> dict[int, str]:
    """Glyph -> letters, from the font's own table."""
    table = re.search(rb"/ToUnicode (\d+) 0 R", font)
    if not table:
        return {}
    letters: dict[int, str] = {}
    stream = _stream(objects[int(table[1])])
    for block in re.findall(rb"beginbfchar(.*?)endbfchar", stream, re.DOTALL):
        for glyph, code in re.findall(rb"<([0-9A-Fa-f]+)> <([0-9A-Fa-f]+)>", block):
            letters[int(glyph, 16)] = _unicode(code)
    for block in re.findall(rb"beginbfrange(.*?)endbfrange", stream, re.DOTALL):
        for first, last, code in re.findall(rb"<([0-9A-Fa-f]+)> <([0-9A-Fa-f]+)> <([0-9A-Fa-f]+)>", block):
            for k in range(int(last, 16) - int(first, 16) + 1):
                letters[int(first, 16) + k] = chr(int(code, 16) + k)
    return letters


def _unicode(code: bytes) -> str:
    return bytes.fromhex(code.decode()).decode("utf-16-be", "replace")


def _stream(body: bytes) -> bytes:
    head, _, rest = body.partition(b"stream\n")
    data = rest.rpartition(b"\nendstream")[0] or rest
    return zlib.decompress(data) if b"/FlateDecode" in head else data
