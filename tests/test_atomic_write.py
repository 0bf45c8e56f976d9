"""A file is there whole or not at all."""

import os
from pathlib import Path

import pytest

from dampyr.atomic_write import whole_file, write_whole
from dampyr.errors import FileError


def broken_off(path: Path) -> None:
    with whole_file(path) as temporary:
        temporary.write_text("half")
        raise KeyboardInterrupt


def test_what_breaks_off_leaves_the_old_file_and_nothing_beside_it(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    write_whole(path, "old\n")
    with pytest.raises(KeyboardInterrupt):
        broken_off(path)
    assert path.read_bytes() == b"old\n"
    assert list(tmp_path.iterdir()) == [path]


def test_others_may_read_what_was_written(tmp_path: Path) -> None:
    write_whole(tmp_path / "a.txt", "new")
    assert (tmp_path / "a.txt").stat().st_mode & 0o444 == 0o444


def test_a_new_file_takes_the_place_of_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.txt"
    with whole_file(path, new=True) as temporary:
        temporary.write_text("mine")
    assert list(tmp_path.iterdir()) == [path]

    def again() -> None:
        with whole_file(path, new=True) as temporary:
            temporary.write_text("other")

    def without_links(*_: object) -> None:
        raise PermissionError

    for links in (os.link, without_links):
        monkeypatch.setattr(os, "link", links)
        with pytest.raises(FileError, match="is there already, and nothing is written over it"):
            again()
    assert path.read_text() == "mine"
    assert list(tmp_path.iterdir()) == [path]
    path.unlink()
    again()
    assert path.read_text() == "other"


def test_a_missing_folder_is_said(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="choose a folder that exists"):
        write_whole(tmp_path / "none" / "a.txt", "new")
