"""What read and write do for every format: dispatch, errors that are one line, input given twice."""

import numpy as np
import pytest

from dampyr import registry
from dampyr.errors import FileError, InputError, MissingData
from dampyr.records import read, with_velocity, write
from dampyr.records.files.record_files import REGISTRY


def test_the_shelf_is_found_by_file_name():
    assert {"csv", "h5", "mat", "txt"} <= set(registry.names(REGISTRY))
    assert all(callable(module.read) for _, module in registry.members(REGISTRY))


@pytest.mark.parametrize("name", ["test.docx", "test.pvp", "test"])
def test_an_unknown_suffix_lists_the_known(tmp_path, name):
    (tmp_path / name).write_text("x")
    listed = ", ".join(rf"\.{name}" for name in registry.names(REGISTRY))
    with pytest.raises(FileError, match=f"the suffix .* is not known; choose from {listed}$") as caught:
        read(tmp_path / name)
    assert str(tmp_path / name) in str(caught.value)


def test_a_suffix_in_capitals_is_the_same(tmp_path):
    (tmp_path / "A.CSV").write_text("t [s],x [m],f [N]\n" + "\n".join(f"{k},{k * k},{k}" for k in range(9)))
    assert read(tmp_path / "A.CSV").n == 9


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(MissingData, match=r"there is no such file; check the path"):
        read(tmp_path / "no.mat")


def test_input_in_the_file_and_in_the_call(tmp_path, make_sine):
    path = write(make_sine(voltage=1.98), tmp_path / "a.h5")
    assert read(path, voltage=1.98).voltage == 1.98
    with pytest.raises(FileError, match=r"voltage = 2 V was given, but the file says 1.98 V; leave voltage out"):
        read(path, voltage=2.0)
    with pytest.raises(InputError, match="voltage and current are both given"):
        read(path, current=0.4)


def test_only_formats_with_a_writer_are_written(tmp_path, make_sine):
    writers = [f".{name}" for name, module in registry.members(REGISTRY) if hasattr(module, "write")]
    with pytest.raises(FileError, match=f"records are not written as '.txt'; choose from {', '.join(writers)}$"):
        write(make_sine(), tmp_path / "a.txt")


@pytest.mark.parametrize("suffix", [".csv", ".mat", ".h5"])
def test_what_is_written_is_read_back(tmp_path, make_sine, suffix):
    record = with_velocity(make_sine(voltage=1.98))
    back = read(write(record, tmp_path / f"a{suffix}"), voltage=1.98)
    for channel in ("time", "displacement", "velocity", "force"):
        np.testing.assert_allclose(getattr(back, channel), getattr(record, channel), rtol=1e-12, atol=1e-15)
    assert back.voltage == 1.98


def test_the_campaigns_format_says_what_it_cannot_hold(tmp_path, make_sine):
    record = make_sine()
    with pytest.raises(FileError, match="needs a velocity"):
        write(record.replace(note="none", velocity=None), tmp_path / "a.mat")
    uneven = record.time.copy()
    uneven[10] += 0.4 * record.dt
    with pytest.raises(FileError, match="one sampling interval"):
        write(with_velocity(record).replace(note="uneven", time=uneven), tmp_path / "a.mat")


def test_every_broken_file_is_one_line_naming_it(tmp_path):
    for name in ("a.mat", "a.h5", "a.csv", "a.txt"):
        for content in (b"", b"\x00\x01\x02\xff" * 50, b"nonsense\n" * 3):
            (tmp_path / name).write_bytes(content)
            with pytest.raises(FileError) as caught:
                read(tmp_path / name)
            assert str(caught.value).startswith(str(tmp_path / name))
            assert "\n" not in str(caught.value)
            assert ";" in str(caught.value)  # what is wrong; how to repair it
