"""A file that shows what lies in another one is refused before any of it is read."""

import contextlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from dampyr import records
from dampyr.errors import FileError
from dampyr.records import read, read_campaign
from dampyr.records.files.self_contained import check_contained
from dampyr.records.formats import h5
from dampyr.records.record import Label

N = 200
SECRET = 777.25 + np.arange(N)  # looks like a force, and is nowhere in the files that are sent
Plant = Callable[[h5py.File, Path], None]


def external_storage(file: h5py.File, secret: Path) -> None:
    del file["calibrated/force"]
    file.create_dataset("calibrated/force", (N,), "f8", external=[(str(secret / "secret.bin"), 0, 8 * N)])
    file["calibrated/force"].attrs["unit"] = "N"


def linked(name: str, target: str) -> Plant:
    def plant(file: h5py.File, secret: Path) -> None:
        file.pop(name, None)
        file[name] = h5py.ExternalLink(str(secret / "secret.h5"), target)

    return plant


def soft_to_external(file: h5py.File, secret: Path) -> None:
    linked("elsewhere", "/calibrated/force")(file, secret)
    del file["calibrated/force"]
    file["calibrated/force"] = h5py.SoftLink("/elsewhere")


def virtual(file: h5py.File, secret: Path) -> None:
    layout = h5py.VirtualLayout((N,), "f8")
    layout[:] = h5py.VirtualSource(str(secret / "secret.h5"), "calibrated/force", (N,))
    _virtual(file, layout)


def virtual_of_itself(file: h5py.File, secret: Path) -> None:
    file["kept"] = file["calibrated/force"][()]
    layout = h5py.VirtualLayout((N,), "f8")
    layout[:] = h5py.VirtualSource(".", "kept", (N,))
    _virtual(file, layout)


def _virtual(file: h5py.File, layout: h5py.VirtualLayout) -> None:
    del file["calibrated/force"]
    file.create_virtual_dataset("calibrated/force", layout)
    file["calibrated/force"].attrs["unit"] = "N"


def raw_in_external_storage(file: h5py.File, secret: Path) -> None:
    data = file.create_dataset("raw/cell", (N,), "f8", external=[(str(secret / "secret.bin"), 0, 8 * N)])
    data.attrs.update({"unit": "V", "gain": 1.0, "offset": 0.0, "calibrated_unit": "N"})


PLANTS: dict[str, Plant] = {
    "external storage": external_storage,
    "raw in external storage": raw_in_external_storage,
    "virtual": virtual,
    "virtual of itself": virtual_of_itself,
    "soft to external": soft_to_external,
    **{
        f"linked {name}": linked(name, target)
        for name, target in {
            "calibrated": "/calibrated",
            "calibrated/force": "/calibrated/force",
            "raw": "/raw",
            "raw/cell": "/raw/cell",
            "history": "/history",
            "label": "/label",
            "provenance": "/provenance",
            "rows": "/rows",
            "not/read/by/anyone": "/",
        }.items()
    },
}


def plain(path: Path, force: np.ndarray | None = None, word: str = "") -> Path:
    """A record as dampyr writes it."""
    t = np.arange(N) / 100.0
    record = records.Record(
        time=t,
        displacement=0.01 * np.sin(t),
        force=np.cos(t) if force is None else force,
        voltage=0.5,
        name=path.stem,
        label=Label(0.02, 1.0, word),
        provenance={"operator": word},
        history=(word,) if word else (),
    )
    return records.write(record, path, raw={"cell": h5.Raw(record.force / 10, "V", 10.0, 0.0, "N")})


def planted(path: Path, plant: Plant) -> Path:
    """A record with something in it that points to `secret.h5` and `secret.bin` in a folder of their own."""
    secret = path.parent.parent / "secret"
    if not secret.is_dir():
        secret.mkdir()
        (secret / "secret.bin").write_bytes(SECRET.tobytes())
        with h5py.File(plain(secret / "secret.h5", SECRET, "password"), "r+") as file:
            file["rows"] = np.uint64(137)
    with h5py.File(plain(path), "r+") as file:
        if "raw/cell" in file:
            del file["raw/cell"]
        plant(file, secret)
        del file.attrs["sha256"]
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "sent").mkdir()
    return tmp_path / "sent"


@pytest.mark.parametrize("name", PLANTS)
def test_what_points_out_of_a_file_is_refused(folder: Path, name: str) -> None:
    path = planted(folder / "test.h5", PLANTS[name])
    calls: list[Callable[[], Any]] = [
        lambda: read(path),
        lambda: h5.read_raw(path),
        lambda: h5.state(path),
        lambda: h5.provenance(path),
        lambda: read_campaign(folder),
        lambda: read_campaign(folder, incomplete=True),
    ]
    for call in calls:
        with pytest.raises(FileError) as caught:
            call()
        words = str(caught.value).replace(str(folder.parent), "")  # whose name may hold any number
        assert "a file is read only where it holds all of its data; copy it with h5repack" in words
        assert not any(secret in words for secret in ("777", "password", "137"))


def test_a_link_of_a_kind_that_a_user_defined_is_refused(folder: Path) -> None:
    path = planted(folder / "test.h5", linked("calibrated/force", "/calibrated/force"))
    data = path.read_bytes()
    for kind in (b"A", b"\xfe"):  # the kind of an external link, 64, is "@"
        begin = data.index(b"\x40\x05force")
        path.write_bytes(data[:begin] + kind + data[begin + 1 :])
        with pytest.raises(FileError, match=r"calibrated/force is a link out of the file|broken HDF5 file"):
            read(path)


def test_what_stays_in_the_file_is_read(folder: Path) -> None:
    path = plain(folder / "test.h5")
    with h5py.File(path, "r+") as file:
        file.move("calibrated/force", "elsewhere")
        file["calibrated/force"] = h5py.SoftLink("/elsewhere")
        file["calibrated/dangling"] = h5py.SoftLink("/nowhere")
        file["calibrated/round"] = file["/"]
        file["a type"] = np.dtype("f8")
        file.attrs["an object"] = file["elsewhere"].ref
        file["provenance"].attrs["an object"] = file["elsewhere"].ref
        file["provenance"].attrs["a region"] = file["elsewhere"].regionref[2:5]
        del file.attrs["sha256"]
    record = read(path)
    np.testing.assert_array_equal(record.force, np.cos(np.arange(N) / 100.0))
    assert "object" in record.provenance["an object"].lower()
    assert "region" in record.provenance["a region"].lower()


@pytest.mark.parametrize("name", ["format", "schema", "complete", "name", "role", "test", "try"])
def test_an_attribute_that_refers_to_an_object_does_no_harm(folder: Path, name: str) -> None:
    path = plain(folder / "test.h5")
    with h5py.File(path, "r+") as file:
        file.attrs[name] = file["calibrated/force"].ref
    for call in (read, h5.state):
        with contextlib.suppress(FileError):
            call(path)


def test_a_file_without_end_is_not_looked_through(folder: Path) -> None:
    path = plain(folder / "test.h5")
    with h5py.File(path, "r+") as file:
        for k in range(10_001):
            file[f"many/{k}"] = h5py.SoftLink("/")
    with pytest.raises(FileError, match="has more than 10000 links"):
        read(path)


def test_the_check_reads_no_data(folder: Path) -> None:
    """A target that is a pipe would hold up whoever opens it."""
    path = planted(folder / "test.h5", external_storage)
    secret = folder.parent / "secret" / "secret.bin"
    secret.unlink()
    os.mkfifo(secret)
    with h5py.File(path, "r") as file, pytest.raises(FileError, match="has its values in another file"):
        check_contained(path, file)


def test_a_file_of_deep_groups_is_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "deep.h5"
    with h5py.File(path, "w") as file:
        group = file
        for _ in range(400):
            group = group.create_group("g")
    with pytest.raises(FileError, match="groups more than 16 deep"), h5py.File(path) as file:
        check_contained(path, file)
