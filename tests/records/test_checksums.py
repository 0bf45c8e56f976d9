"""Checksums of a record's file: SHA-256 of values in their order, and what differs is named."""

import hashlib
import json
from pathlib import Path

import h5py
import numpy as np
import pytest

from dampyr.errors import FileError
from dampyr.records.files.checksums import ATTRIBUTES, NAME, Checksums, Stored, attributes_of

FORCE = np.array([1.0, -2.5, 3.0])
NOTES = ("eins", "zwei µ")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A file with the checksums of a dataset that was added piece by piece, and of one of texts."""
    place = tmp_path / "a.h5"
    with h5py.File(place, "w") as file:
        file.attrs["name"] = "first"
        file["force"] = FORCE
        file["notes"] = list(NOTES)
        sums = Checksums()
        sums.add("force", FORCE[:2])
        sums.add("force", FORCE[2:].astype(">f8"))  # the bytes of a file do not depend on the machine
        sums.add("notes", NOTES)
        sums.write(file)
    return place


def stored(path: Path) -> Stored:
    with h5py.File(path) as file:
        return Stored(path, attributes_of(file))


def test_they_are_the_sha_256_of_the_little_endian_values_and_of_texts_with_a_zero(path: Path) -> None:
    with h5py.File(path) as file:
        sums = json.loads(file.attrs[NAME])
    assert sums["force"] == hashlib.sha256(FORCE.astype("<f8").tobytes()).hexdigest()
    assert sums["notes"] == hashlib.sha256("eins\0zwei µ\0".encode()).hexdigest()
    assert set(sums) == {"force", "notes", ATTRIBUTES}


def test_what_was_written_passes_and_what_differs_is_named(path: Path) -> None:
    sums = stored(path)
    sums.check("force", FORCE)
    sums.check("notes", NOTES)
    sums.check("somebody's", np.zeros(3))  # has none
    with pytest.raises(FileError, match="/force is not what was written, its SHA-256 differs"):
        sums.check("force", np.nextafter(FORCE, np.inf))


def test_attributes_and_missing_datasets_are_told(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file.attrs["somebody's"] = 7  # not of a record
    stored(path)
    with h5py.File(path, "r+") as file:
        sums = Checksums()
        sums.add("force", FORCE)
        sums.add("velocity", FORCE)
        sums.write(file)
    with pytest.raises(FileError, match="/velocity is missing, or its checksum is damaged"):
        stored(path)
    with h5py.File(path, "r+") as file:
        file.attrs["name"] = "second"
    with pytest.raises(FileError, match="its attributes are not what was written"):
        stored(path)
    with h5py.File(path, "r+") as file:
        file.attrs[NAME] = "{"
    with pytest.raises(FileError, match="its checksums are damaged"):
        stored(path)


def test_a_file_without_any_is_read(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        del file.attrs[NAME]
    stored(path).check("force", np.zeros(3))
