"""A file is there whole or not at all."""

from pathlib import Path

import pytest

from dampyr.errors import FileError
from dampyr.whole import whole_file, write_whole


def broken_off(path: Path) -> None:
    with whole_file(path) as beside:
        beside.write_text("half")
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


def test_a_missing_folder_is_said(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="choose a folder that exists"):
        write_whole(tmp_path / "none" / "a.txt", "new")
