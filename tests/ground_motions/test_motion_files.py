"""Files of ground motions: the format by the suffix, and no file."""

import pytest

from dampyr import ground_motions
from dampyr.errors import FileError, MissingData
from dampyr.ground_motions import read


def text(folder, content, name="motion.txt"):
    path = folder / name
    path.write_text(content)
    return path


def test_no_file_and_no_format(tmp_path):
    with pytest.raises(MissingData, match="no such file"):
        read(tmp_path / "nothing.at2")
    with pytest.raises(FileError, match=r"'.docx' is not a ground motion's; dampyr reads .*\.at2"):
        read(text(tmp_path, "", "motion.docx"))


def test_every_format_on_the_shelf_says_its_suffixes():
    formats = ground_motions.available_formats()
    assert {"at2", "columns", "mat"} <= set(formats)
    suffixes = [suffix for each in formats.values() for suffix in each]
    assert len(set(suffixes)) == len(suffixes)
