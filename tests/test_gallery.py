"""The gallery: at most ten lines of public names each, every script runs, and all text of its figure can be read.

The loops of the parts too, which the pages of the models show.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from tools.figure_text import unreadable
from tools.gallery import FOLDER, MOST_LINES, SECTIONS, Entry, entries
from tools.part_loops import figure_of

from dampyr.models import available_parts
from dampyr.models.part import part

DOCS = FOLDER.parent
OTHERS = ("numpy", "tempfile")  # what a script may use besides dampyr
LONGEST = 116  # characters of a line
SLOW = (  # of a second and more with its kernels compiled: proofs
    "dampers/pendulum", "identification/leaderboard", "identification/posterior", "structures/arena", "structures/control_laws",
    "structures/fragility", "rig/hybrid", "rig/next_tests", "rig/records", "identification/acceptance",
)  # fmt: skip


@pytest.fixture
def pyplot() -> Iterator[Any]:
    from matplotlib import pyplot

    before = pyplot.get_backend()
    pyplot.switch_backend("agg")
    yield pyplot
    pyplot.close("all")
    pyplot.switch_backend(before)


def test_there_are_thirty_and_each_has_its_title_and_its_words() -> None:
    found = entries()
    assert len(found) >= 30
    assert not [entry.name for entry in found if not all(entry.words)]
    titles = Counter(entry.words[0] for entry in found)
    assert max(titles.values()) == 1
    files = set(FOLDER.rglob("*.py"))
    assert files == {entry.path for entry in found}, f"a script lies in one of {', '.join(SECTIONS)}"


@pytest.mark.parametrize("entry", entries(), ids=lambda entry: entry.name)
def test_a_script_is_ten_lines_of_public_names(entry: Entry) -> None:
    assert entry.lines <= MOST_LINES
    assert max(map(len, entry.code.splitlines())) <= LONGEST
    for node in ast.walk(ast.parse(entry.text)):
        if isinstance(node, ast.Import):
            assert {alias.name for alias in node.names} <= {"dampyr", *OTHERS}
        if isinstance(node, ast.ImportFrom):
            module = node.module or ""
            assert module == "dampyr" or module.startswith("dampyr.show.figures")
            assert not [alias.name for alias in node.names if alias.name.startswith("_")]
        assert not (isinstance(node, ast.Attribute) and node.attr.startswith("_"))


@pytest.mark.parametrize(
    "entry",
    [pytest.param(entry, marks=[pytest.mark.prove] * (entry.name in SLOW), id=entry.name) for entry in entries()],
)
def test_a_script_draws_a_figure_that_can_be_read(entry: Entry, pyplot: Any) -> None:
    assert not unreadable(entry.draw())


def test_a_script_that_draws_nothing_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tools.gallery.FOLDER", tmp_path)
    (tmp_path / "nothing.py").write_text('"""A title\n\nWords.\n"""\n\nx = 1\n', encoding="utf-8")
    with pytest.raises(SystemExit, match="draws a figure"):
        Entry(tmp_path / "nothing.py").draw()


@pytest.mark.prove
@pytest.mark.parametrize("name", available_parts())
def test_every_part_has_numbers_for_its_picture_which_can_be_read(name: str) -> None:
    assert set(part(name).module.EXAMPLE) == set(part(name).parameters)
    assert not unreadable(figure_of(name))


def test_the_page_of_the_loops_shows_every_part_once() -> None:
    """A part that nobody has placed among them stands at their end (`make docs`)."""
    text = (DOCS / "how-to" / "which-model.md").read_text(encoding="utf-8")
    shown = [name for names in re.findall(r"<!-- loops: ([\w ]+) -->", text) for name in names.split()]
    assert sorted(shown) == sorted(available_parts())
    assert not [name for name in available_parts() if f"`{name}`" not in text]


def test_pages_show_pictures_that_there_are() -> None:
    names = {entry.name for entry in entries()}
    for page in DOCS.rglob("*.md"):
        for found in re.findall(r"<!-- gallery: ([\w/ ]+) -->", page.read_text(encoding="utf-8")):
            assert set(found.split()) <= names, page


def test_a_script_uses_a_module_of_figures_that_is_there() -> None:
    for entry in entries():
        for module in re.findall(r"^from (dampyr\.show\.figures\.\w+)", entry.code, re.MULTILINE):
            import_module(module)
