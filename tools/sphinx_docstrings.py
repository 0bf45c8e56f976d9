"""An extension of sphinx: docstrings as they are written here, for the site.

- An entry of a ``Parameters`` section is ``name : what it is``, or ``name`` and what it is in the lines below.
- The fields of a dataclass have their units and shapes in a comment, or in their annotation; these are listed too.
- A citation, ``[Arias1970]_`` or ``Dahl (1968)``, leads to the bibliography.
- A name, `fit`, leads to the public function or class of that name in the same package, or in the only one that has it.
"""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
import tokenize
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import is_dataclass
from functools import cache
from importlib import import_module
from io import StringIO
from typing import Any

import citations
import make_site
from sphinx.util.inspect import TypeAliasForwardRef

from dampyr.options import Options

ENTRY = re.compile(r"(\*{0,2}\w+(?:, \*{0,2}\w+)*)(?: : (.*))?$")
NAME = re.compile(r"(?<![`:\w])`(\w+)`(?![`_\w])")
SPECIAL = re.compile(r"([\\*`|]|_(?=\W|$))")  # what reStructuredText would read as mark-up
BACKSLASHED = r"\\\1"


def setup(app: Any) -> dict[str, bool]:
    """Called by sphinx. Before napoleon (500), which reads the other sections."""
    app.connect("autodoc-process-docstring", process, priority=400)
    app.connect("autodoc-process-docstring", restore, priority=600)
    TypeAliasForwardRef.__repr__ = lambda alias: alias.name  # type: ignore[method-assign]  # inside of another type too
    return {"parallel_read_safe": True}


def process(app: Any, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """The lines of one docstring, in their place."""
    text = without_list_of_references("\n".join(lines))
    text = citations.linked_in_rst(text, citations.FROM_A_PACKAGE)
    text = NAME.sub(lambda match: referred(match[1], name), text)
    new = list(with_definitions(text.splitlines()))
    if what == "class" and is_dataclass(value):
        documented = {key for line in new if line.startswith("**") for key in re.findall(r"\w+", line)}
        listed = [] if issubclass(value, Options) else commented_fields(value)  # the reference lists them
        fields = [field for field in listed if field[0] not in documented]
        new += ["", *([".. rubric:: Fields", ""] if fields else [])]
        new += [line for field in fields for line in defined(*field)] + [""]
    lines[:] = new
    _before_napoleon[:] = new


_before_napoleon: list[str] = []


def restore(app: Any, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """Of a property napoleon takes what stands before a colon for a type, which no docstring here means."""
    if what in ("property", "attribute", "data"):
        lines[:] = _before_napoleon


def referred(word: str, within: str) -> str:
    """A name in the docstring of ``within``: a link, or code where it is not public or more than one package has it."""
    places = public_places()[word]
    own = [place for place in places if within.startswith(f"{place}.")] or places
    return f":py:obj:`~{own[-1]}.{word}`" if len(own) == 1 else f"``{word}``"


@cache
def public_places() -> defaultdict[str, list[str]]:
    """The packages that have a public name, by the name."""
    places: defaultdict[str, list[str]] = defaultdict(list)
    for page in make_site.pages_of_packages():
        for owner, names in make_site.members(import_module(page)):
            for each in names:
                places[each].append(owner.__name__)
    return places


def without_list_of_references(text: str) -> str:
    """Without ``.. [Key] ...`` at the end: the site has one bibliography."""
    text = re.sub(r"^\.\. \[\w+\] .*(?:\n[ ]+\S.*)*\n?", "", text, flags=re.MULTILINE)
    return re.sub(r"^References\n-+\s*\Z", "", text, flags=re.MULTILINE)


def with_definitions(lines: list[str]) -> Iterator[str]:
    """The lines, the entries of a ``Parameters`` section as definitions; what follows them unindented is text again."""
    at = 0
    while at < len(lines):
        if lines[at].strip() != "Parameters" or not underlined(lines, at):
            yield lines[at]
            at += 1
            continue
        at += 2
        yield from (".. rubric:: Parameters", "")
        while at < len(lines) and not underlined(lines, at):
            entry = ENTRY.match(lines[at])
            if not entry and lines[at].strip() and not lines[at].startswith(" "):
                break
            yield from defined(entry[1], entry[2] or "") if entry else (lines[at],)
            at += 1
        yield ""


def underlined(lines: list[str], at: int) -> bool:
    """Whether a line is the heading of a section."""
    return at + 1 < len(lines) and set(lines[at + 1].strip()) == {"-"}


def defined(names: str, words: str) -> Iterator[str]:
    """The lines of a definition; more of them may follow."""
    yield ", ".join(f"**{SPECIAL.sub(BACKSLASHED, name)}**" for name in names.split(", "))
    if words:
        yield f"    {words}"


def commented_fields(cls: type) -> Iterator[tuple[str, str]]:
    """The public fields of a dataclass that say what they are, in a comment behind them or in their annotation."""
    try:
        source = textwrap.dedent(inspect.getsource(cls))
    except (OSError, TypeError):  # made at run time
        return
    comments = {
        token.start[0]: token.string.lstrip("# ")
        for token in tokenize.generate_tokens(StringIO(source).readline)
        if token.type == tokenize.COMMENT
    }
    for node in ast.parse(source).body[0].body:  # type: ignore[attr-defined]
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and not node.target.id.startswith("_"):
            words = comments.get(node.end_lineno or 0) or annotated(node.annotation)
            if words:
                yield node.target.id, SPECIAL.sub(BACKSLASHED, words)


def annotated(node: ast.expr) -> str:
    """The words in ``Annotated[float, Length, "of the sine"]``."""
    if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Tuple):
        texts = [
            each.value for each in node.slice.elts if isinstance(each, ast.Constant) and isinstance(each.value, str)
        ]
        return texts[-1] if texts else ""
    return ""
