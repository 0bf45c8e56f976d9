"""A new HDF5 file is written through Python's own files: a write that is refused is an OSError and nothing worse."""

import io
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from dampyr.records.files.new_file import _Output, new_file


def written(path: Path, reserve: int = 0, n: int = 100_000) -> None:
    with new_file(path, reserve) as file:
        file.attrs["format"] = "a test"
        file.create_dataset("a/b", data=np.arange(n))
        file["a/b"].attrs.update({f"attribute {k}": "x" * 100 for k in range(100)})
        file.flush()
        file["c"] = ["text", "text"]


@pytest.mark.parametrize("reserve", [0, 100, 10_000_000])
def test_a_file_is_as_the_library_alone_would_write_it(tmp_path: Path, reserve: int) -> None:
    (tmp_path / "a.h5").write_bytes(b"something else " * 1000)
    written(tmp_path / "a.h5", reserve)
    assert (tmp_path / "a.h5").stat().st_size < 900_000
    with h5py.File(tmp_path / "a.h5", "r") as file:
        np.testing.assert_array_equal(file["a/b"], np.arange(100_000))
        assert len(file["a/b"].attrs) == 100
        assert list(file["c"].asstr()) == ["text", "text"]


def test_whichever_write_is_refused_it_is_raised_when_the_library_has_let_go(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    count, allowed = 0, 10**9

    class Disk(io.FileIO):
        def write(self, data: Any) -> int:
            nonlocal count
            count += 1
            if count > allowed:
                raise OSError(28, "No space left on device")
            return super().write(data)

    class Output(_Output, Disk):
        """Whose writes go to that disk."""

    monkeypatch.setattr("dampyr.records.files.new_file._Output", Output)
    written(tmp_path / "a.h5")
    needed = count
    assert needed > 10
    for allowed in range(needed):  # noqa: B007
        count = 0
        with pytest.raises(OSError, match="No space left on device"):
            written(tmp_path / "a.h5")
        with pytest.raises(OSError, match="No space left on device"):
            written(tmp_path / "a.h5", n=1)  # the library still works, and there is still no room


def test_what_the_body_raises_is_raised(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="mine"), new_file(tmp_path / "a.h5"):
        raise ValueError("mine")
