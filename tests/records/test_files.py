"""What read and write do for every format: dispatch, errors that are one line, input given twice."""

import pytest

from dampyr import catalogue
from dampyr.errors import FileError, InputError, MissingData
from dampyr.records import read, write
from dampyr.records.files import SHELF


def test_the_shelf_is_found_by_file_name():
    assert {"csv", "h5", "mat", "txt"} <= set(catalogue.names(SHELF))
    assert all(callable(module.read) for _, module in catalogue.members(SHELF))


@pytest.mark.parametrize("name", ["test.tdms", "test.xlsx", "test"])
def test_an_unknown_suffix_lists_the_known(tmp_path, name):
    (tmp_path / name).write_text("x")
    with pytest.raises(FileError, match=r"the suffix .* is not known; choose from \.csv, \.h5, \.mat, \.txt") as caught:
        read(tmp_path / name)
    assert str(tmp_path / name) in str(caught.value)


def test_a_suffix_in_capitals_is_the_same(tmp_path):
    (tmp_path / "A.CSV").write_text("t [s],x [m],f [N]\n" + "\n".join(f"{k},{k * k},{k}" for k in range(9)))
    assert read(tmp_path / "A.CSV").n == 9


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(MissingData, match=r"there is no such file; check the path"):
        read(tmp_path / "no.mat")


@pytest.mark.parametrize("argument", ["units", "columns"])
def test_a_word_that_is_no_channel(tmp_path, argument):
    (tmp_path / "a.csv").write_text("t [s],x [m],f [N]\n0,0,0\n")
    with pytest.raises(FileError, match=rf"{argument} names 'stroke', which is no channel; choose from time, "):
        read(tmp_path / "a.csv", **{argument: {"stroke": "mm"}})


def test_input_in_the_file_and_in_the_call(tmp_path, make_sine):
    path = write(make_sine(voltage=1.98), tmp_path / "a.h5")
    assert read(path, voltage=1.98).voltage == 1.98
    with pytest.raises(FileError, match=r"voltage = 2 V was given, but the file says 1.98 V; leave voltage out"):
        read(path, voltage=2.0)
    with pytest.raises(InputError, match="voltage and current are both given"):
        read(path, current=0.4)


def test_only_h5_is_written(tmp_path, make_sine):
    with pytest.raises(FileError, match=r"records are not written as '.csv'; choose from .h5"):
        write(make_sine(), tmp_path / "a.csv")


def test_every_broken_file_is_one_line_naming_it(tmp_path):
    for name in ("a.mat", "a.h5", "a.csv", "a.txt"):
        for content in (b"", b"\x00\x01\x02\xff" * 50, b"nonsense\n" * 3):
            (tmp_path / name).write_bytes(content)
            with pytest.raises(FileError) as caught:
                read(tmp_path / name)
            assert str(caught.value).startswith(str(tmp_path / name))
            assert "\n" not in str(caught.value)
            assert ";" in str(caught.value)  # what is wrong; how to repair it
