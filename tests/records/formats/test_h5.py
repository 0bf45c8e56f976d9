"""dampyr's own file: an exact round trip, readable by others, whole or not there."""

import hashlib
import json
import shutil
import subprocess
from dataclasses import fields

import h5py
import numpy as np
import pytest
import xarray

from dampyr.errors import FileError, InputError
from dampyr.records import Record, read, write
from dampyr.records.files import checksums
from dampyr.records.formats import h5
from dampyr.records.record import Label


def same(a: Record, b: Record) -> bool:
    def equal(x, y):
        return np.array_equal(x, y) if isinstance(x, np.ndarray) else x == y

    of_file = ("source_file", "origin")  # which says the file, too
    return a.origin.kind == b.origin.kind and all(
        equal(getattr(a, f.name), getattr(b, f.name)) for f in fields(Record) if f.name not in of_file
    )


@pytest.fixture
def full(make_sine):
    record = make_sine(
        duration=3.0,
        rest=0.5,
        name="ação 1",
        role="validation",
        label=Label(0.02, 0.9, "4.2", 3),
        provenance={"file": "a.mat", "test": "sine 3", "try": "2"},
        history=("read", "offset of −3 N removed"),
    )
    n = record.n
    more = {
        "velocity": np.gradient(record.displacement),
        "current": np.linspace(0, 1, n) / 3,
        "temperature": np.full(n, 21.3),
    }
    return record.replace(note="more", **more)


def test_round_trip_is_exact(tmp_path, full, make_sine):
    bare = make_sine(voltage=1 / 3)
    for record in (full, bare):
        assert same(record, read(write(record, tmp_path / "r.h5")))
    assert bare.history == ()
    assert isinstance(read(tmp_path / "r.h5").voltage, float)


def test_the_layout_is_the_documented_one(tmp_path, full):
    with h5py.File(write(full, tmp_path / "r.h5"), "r") as file:
        assert (file.attrs["format"], file.attrs["schema"], file.attrs["complete"]) == ("dampyr record", 3, 1)
        force = file["calibrated/force"]
        assert (force.attrs["unit"], force.dtype, force.shape) == ("N", np.float64, (full.n,))
        assert file["calibrated/displacement"].attrs["unit"] == "m"
        assert list(file["raw"]) == []
        assert file["label"].attrs["row"] == 3
    assert h5.state(tmp_path / "r.h5") == h5.FileState(True, "sine 3", 2)


def test_the_time_is_the_dimension_scale_of_the_channels_and_no_checksum_is_over_it(tmp_path, full):
    with h5py.File(write(full, tmp_path / "r.h5"), "r") as file:
        group, sums = file["calibrated"], json.loads(file.attrs["sha256"])
        assert group["time"].is_scale
        for name, data in group.items():
            assert data.attrs["units"] == data.attrs["unit"]
            assert name == "time" or [scale.name for scale in data.dims[0].values()] == ["/calibrated/time"]
        assert sums["calibrated/force"] == hashlib.sha256(full.force.tobytes()).hexdigest()
    with h5py.File(tmp_path / "r.h5", "r+") as file:  # as dampyr 0.3.0 wrote it, but for the number of the schema
        for data in file["calibrated"].values():
            for name in checksums.INTERCHANGE:
                data.attrs.pop(name, None)
    assert same(full, read(tmp_path / "r.h5"))


@pytest.mark.parametrize("engine", ["h5netcdf", pytest.param("netcdf4", marks=pytest.mark.by_hand)])
def test_xarray_opens_it(tmp_path, full, engine):
    if engine == "netcdf4":
        pytest.importorskip("netCDF4", reason="netCDF4, a reader of others, is not installed")
    more = {"phony_dims": "sort"} if engine == "h5netcdf" else {}  # of the history and of raw readings
    constant = full.replace(note="", current=None, voltage=1 / 3)
    for record in (full, constant):
        path = write(record, tmp_path / "r.h5")
        with xarray.open_dataset(path, group="calibrated", engine=engine, **more) as data:
            assert (data["force"].dims, data["force"].attrs["units"]) == (("time",), "N")
            for name in ("time", "displacement", "force", "velocity", "voltage" if record is constant else "current"):
                assert np.array_equal(data[name], getattr(record, name))


@pytest.mark.prove
@pytest.mark.skipif(shutil.which("octave-cli") is None, reason="GNU Octave is missing")
def test_octave_loads_it(tmp_path, full):
    path = write(full, tmp_path / "r.h5")
    script = f"s = load('{path}'); printf('%.17g\\n', s.calibrated.force)"
    done = subprocess.run(["octave-cli", "--quiet", "--no-init-file", "--eval", script], capture_output=True, text=True)
    assert np.array_equal(np.array(done.stdout.split(), dtype=float), full.force), done.stderr


def test_raw_readings_stay_beside_what_was_made_of_them(tmp_path, full):
    volts = h5.Raw(full.force / 445.0, "V", 445.0, 0.0, "N")
    path = write(full, tmp_path / "r.h5", raw={"load_cell": volts})
    load_cell = h5.read_raw(path)["load_cell"]
    assert np.array_equal(load_cell.values, volts.values)
    assert load_cell.gain * load_cell.values + load_cell.offset == pytest.approx(full.force)
    assert (load_cell.unit, load_cell.calibrated_unit) == ("V", "N")


def test_a_truncated_file(tmp_path, full):
    path = write(full, tmp_path / "r.h5")
    content = path.read_bytes()
    for size in (len(content) // 2, len(content) - 200, 100):
        path.write_bytes(content[:size])
        with pytest.raises(
            FileError, match=r"r\.h5: is a truncated or broken HDF5 file \(.*\); record or copy"
        ) as caught:
            read(path)
        assert "\n" not in str(caught.value)


def changed(path, change):
    """As by somebody who means it: without the checksums."""
    with h5py.File(path, "r+") as file:
        change(file)
        del file.attrs["sha256"]
    return path


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda f: f.attrs.update({"schema": 4}),
            r"has the schema 4, this dampyr knows schema 3; upgrade dampyr",
        ),
        (
            lambda f: f.attrs.update({"format": "other"}),
            r"is HDF5 but not a dampyr record: its format is 'other'",
        ),
        (lambda f: f.__delitem__("calibrated/force"), r"/calibrated/force is missing"),
        (
            lambda f: f["calibrated/force"].attrs.update({"unit": "stone"}),
            r"the unit 'stone' does not measure",
        ),
        (lambda f: f["calibrated/force"].attrs.update({"unit": "blorp"}), r"unknown unit 'blorp'"),
        (
            lambda f: f["calibrated/force"].attrs.__delitem__("unit"),
            r"/calibrated/force has no unit; declare units=",
        ),
        (lambda f: f["calibrated/force"].__setitem__(4, np.nan), r"force\[4\] = nan N is not finite"),
        (lambda f: f["calibrated/time"].__setitem__(4, 0.0), r"time\[4\] = 0 s does not come after"),
        (lambda f: f.attrs.update({"role": "spare"}), r"role = 'spare' is not known"),
        (lambda f: f.attrs.__delitem__("name"), r"broken HDF5 file"),
    ],
)
def test_a_file_that_lies(tmp_path, full, change, message):
    path = changed(write(full, tmp_path / "r.h5"), change)
    with pytest.raises(FileError, match=r"r\.h5: .*" + message) as caught:
        read(path)
    assert "\n" not in str(caught.value)


def test_other_units_are_converted(tmp_path, full):
    def in_mm(file):
        file["calibrated/displacement"][:] = 1e3 * full.displacement
        file["calibrated/displacement"].attrs["unit"] = "mm"

    record = read(changed(write(full, tmp_path / "r.h5"), in_mm))
    assert record.displacement == pytest.approx(full.displacement, abs=1e-15)


def test_an_incomplete_file_says_so_and_stays_so(tmp_path, full):
    path = changed(write(full, tmp_path / "r.h5"), lambda f: f.attrs.update({"complete": np.uint8(0)}))
    record = read(path)
    assert record.provenance["complete"] == "no"
    assert "not completed" in record.history[-1]
    assert not h5.state(write(record, tmp_path / "again.h5")).complete
    assert same(record, read(tmp_path / "again.h5"))


def test_writing_is_all_or_nothing(tmp_path, full, monkeypatch):
    path = write(full, tmp_path / "r.h5")
    before = path.read_bytes()
    monkeypatch.setattr(h5, "_fill_raw", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        write(full.replace(note="next", force=2 * full.force), path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["r.h5"]


def test_a_folder_that_is_not_there(tmp_path, full):
    with pytest.raises(FileError, match=r"cannot be written \(No such file or directory\); choose a folder"):
        write(full, tmp_path / "no" / "r.h5")


def test_numbers_that_are_not_real_are_refused(tmp_path, full):
    path = write(full, tmp_path / "r.h5")
    with h5py.File(path, "r+") as file:
        del file["calibrated/force"]
        file["calibrated/force"] = full.force + 1j
        file["calibrated/force"].attrs["unit"] = "N"
        del file.attrs["sha256"]
    with pytest.raises(FileError, match="/calibrated/force holds complex128, not real numbers"):
        read(path)


def test_more_data_than_the_memory_holds_are_told(tmp_path, full):
    path = write(full, tmp_path / "r.h5")
    with h5py.File(path, "r+") as file:
        del file["calibrated/force"]
        file.create_dataset("calibrated/force", (10**15,), "f8", chunks=(10**6,)).attrs["unit"] = "N"
    with pytest.raises(FileError, match="tells of more data than the memory holds"):
        read(path)


@pytest.fixture
def recorded(tmp_path, make_sine):
    """A record with raw readings, the position read later than the force, as a rig writes it."""
    record = make_sine(duration=4.0, rest=0.5, voltage=0.5, history=("read",))
    counts = np.round(record.displacement / 5e-6)
    x = np.interp(record.time - 2e-4, record.time, 5e-6 * counts)
    record = record.replace(note="moved", displacement=x, marks=("the force stood still",))
    raw = {
        "force": h5.Raw((record.force + 3.0) / 613.0, "V", 613.0, -3.0, "N"),
        "position": h5.Raw(counts.astype("i8"), "count", 5e-6, 0.0, "m", 2e-4),
    }
    return record, write(record, tmp_path / "recorded.h5", raw=raw)


def test_marks_are_part_of_a_record(recorded):
    record, path = recorded
    assert same(record, read(path))
    assert read(path).marks == ("the force stood still",)
    assert "the force stood still" in repr(record)
    with pytest.raises(InputError, match="marks = 'one' is one text; give a tuple of texts"):
        record.replace(note="x", marks="one")


@pytest.mark.parametrize(
    "name",
    ["calibrated/time", "calibrated/displacement", "calibrated/force", "calibrated/voltage", "history", "marks"],
)
def test_a_dataset_that_was_damaged_is_named(recorded, name):
    path = recorded[1]
    with h5py.File(path, "r+") as file:
        data = file[name]
        if data.dtype.kind == "O":
            data[0] = "other"
        elif data.shape:
            data[7] = np.nextafter(data[7], 1.0)
        else:
            data[()] = np.nextafter(data[()], 9.0)
    with pytest.raises(
        FileError, match=rf"/{name} is not what was written, its SHA-256 differs; record or copy the test"
    ):
        read(path)


def test_a_raw_reading_that_was_damaged_is_named(recorded):
    with h5py.File(recorded[1], "r+") as file:
        file["raw/position"][7] += 1
    with pytest.raises(FileError, match="/raw/position is not what was written"):
        h5.read_raw(recorded[1])
    with pytest.raises(
        FileError, match=r"/calibrated/displacement is not gain\*raw \+ offset of /raw/position: they are"
    ):
        read(recorded[1])


def test_an_attribute_that_was_damaged_is_told(recorded):
    for name, value in (("complete", np.uint8(3)), ("role", "validation")):
        with h5py.File(recorded[1], "r+") as file:
            before, file.attrs[name] = file.attrs[name], value
        with pytest.raises(FileError, match="its attributes are not what was written"):
            read(recorded[1])
        with h5py.File(recorded[1], "r+") as file:
            file.attrs[name] = before
    read(recorded[1])


def test_no_bit_of_a_file_changes_its_data_in_silence(recorded):
    record, path = recorded
    whole, draw = path.read_bytes(), np.random.default_rng(20261123)
    refused = 0
    for bit in draw.integers(0, 8 * len(whole), 120):
        flipped = bytearray(whole)
        flipped[bit // 8] ^= 1 << (bit % 8)
        path.write_bytes(flipped)
        try:
            assert same(record, read(path)), bit
        except FileError:
            refused += 1
    assert refused > 50


def test_channels_are_held_against_their_raw_readings_without_checksums_too(recorded):
    record, path = recorded

    def at_three(file):
        file["calibrated/force"][300] += 12.5

    with pytest.raises(
        FileError, match=rf"/raw/force: they are 12.5 N apart at {record.time[300]:.4g} s; record or copy"
    ):
        read(changed(path, at_three))


def test_an_interrupted_test_says_what_differs_from_its_raw_reading(recorded):
    def interrupted(file):
        file["calibrated/force"][300] += 12.5
        file.attrs["complete"] = np.uint8(0)

    assert "/raw/force: they are 12.5 N apart" in read(changed(recorded[1], interrupted)).marks[-1]


def test_an_interrupted_file_of_before_says_a_delay_that_it_does_not_have(recorded):
    record, path = recorded

    def undelayed(file):
        file["calibrated/displacement"][:] = 5e-6 * file["raw/position"][:]
        file.attrs["complete"] = np.uint8(0)

    assert read(changed(path, undelayed)).marks == record.marks


def test_raw_readings_of_another_record_are_refused(tmp_path, make_sine):
    record = make_sine()
    with pytest.raises(
        InputError, match=r"not gain\*raw \+ offset of /raw/force.*; give the readings and the calibration"
    ):
        write(record, tmp_path / "r.h5", raw={"force": h5.Raw(record.force, "V", 2.0, 0.0, "N")})
    assert not list(tmp_path.iterdir())


def test_a_test_that_ended_before_it_was_a_record_is_told_as_such(recorded):
    def shortened(file):
        for name in ("time", "displacement", "force"):
            values = file[f"calibrated/{name}"][:3]
            del file[f"calibrated/{name}"]
            file[f"calibrated/{name}"] = values
        file.attrs["complete"] = np.uint8(0)
        file["provenance"].attrs["reason"] = "interrupted"

    with pytest.raises(h5.FewSamples, match=r"holds 3 samples of a test that did not come to its end \(interrupted\)"):
        read(changed(recorded[1], shortened))


def test_a_file_that_may_not_be_read_is_not_called_broken(recorded, monkeypatch):
    def refused(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.open", refused)
    with pytest.raises(FileError, match=r"cannot be read \(Permission denied\); check the file") as caught:
        h5.state(recorded[1])
    assert not isinstance(caught.value, h5.BrokenFile)
