"""A folder is a catalogue: a file is a member, and nothing else lists it."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from dampyr import registry
from dampyr.errors import InputError

PACKAGE = "planted_shelf"


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A shelf of two members and one private file."""
    folder = tmp_path / PACKAGE
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    for name in ("viscous_dahl", "bouc_wen", "_private"):
        (folder / f"{name}.py").write_text(f"title = {name!r}\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield folder
    for name in [n for n in sys.modules if n.split(".")[0] == PACKAGE]:
        del sys.modules[name]


def test_members_are_the_public_files(package: Path) -> None:
    assert registry.names(PACKAGE) == ["bouc_wen", "viscous_dahl"]


def test_adding_a_member_is_adding_a_file(package: Path) -> None:
    (package / "lugre.py").write_text("title = 'LuGre'\n")
    assert registry.names(PACKAGE) == ["bouc_wen", "lugre", "viscous_dahl"]


def test_names_are_known_without_loading_the_members(package: Path) -> None:
    registry.names(PACKAGE)
    assert f"{PACKAGE}.bouc_wen" not in sys.modules


def test_a_member_is_its_module(package: Path) -> None:
    assert registry.member(PACKAGE, "bouc_wen").title == "bouc_wen"
    assert {name: module.title for name, module in registry.members(PACKAGE)} == {
        "bouc_wen": "bouc_wen",
        "viscous_dahl": "viscous_dahl",
    }


def test_lists_say_what_the_docstring_begins_with(package: Path) -> None:
    (package / "lugre.py").write_text('"""LuGre: bristles\nthat bend.\n\nMore."""\n')
    module = registry.member(PACKAGE, "lugre")
    assert registry.summary(module) == "LuGre: bristles that bend"
    assert registry.title(module) == "LuGre"


def test_a_slip_of_the_pen_is_answered_with_the_nearest_name(package: Path) -> None:
    with pytest.raises(InputError) as caught:
        registry.member(PACKAGE, "bouc_when")
    assert str(caught.value) == (
        "'bouc_when' is not among the planted shelf; did you mean 'bouc_wen'? choose from bouc_wen, viscous_dahl"
    )


@pytest.mark.parametrize("name", ["", "quark", "_private", "os.path"])
def test_what_is_not_there_lists_what_is(package: Path, name: str) -> None:
    with pytest.raises(InputError, match="choose from bouc_wen, viscous_dahl"):
        registry.member(PACKAGE, name)
