"""The campaign's MATLAB files: which variables are read, and what a broken file says."""

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from dampyr.errors import FileError
from dampyr.records import read, write

N = 50


@pytest.fixture
def variables():
    t = 0.01 * np.arange(N)
    dist = 12.0 * np.sin(6 * t)
    force = 110 + 300 * np.cos(6 * t)
    velocity = np.r_[0.0, np.diff(dist)] / 0.01
    x_f = np.column_stack([dist - 5.0, velocity, force - 130.0])  # offsets removed: must not be used
    return {
        "Ts": 0.01,
        "dist": dist[:, None],
        "forc": force[:, None],
        "x_F": x_f,
        "f": 1.5,
        "Tout": t[:, None],
    }


def saved(tmp_path, variables, **changes):
    path = tmp_path / "ensaio.mat"
    savemat(path, {k: v for k, v in (variables | changes).items() if v is not None})
    return path


def test_dist_forc_and_the_recorded_velocity_in_si(tmp_path, variables):
    record = read(saved(tmp_path, variables), voltage=0.8712)
    assert record.displacement == pytest.approx(variables["dist"].ravel() * 1e-3, rel=1e-14)
    assert np.array_equal(record.force, variables["forc"].ravel())
    assert record.velocity == pytest.approx(variables["x_F"][:, 1] * 1e-3, rel=1e-14)
    assert record.time == pytest.approx(0.01 * np.arange(N), abs=1e-15)
    assert (record.voltage, record.name, record.provenance["file"]) == (0.8712, "ensaio", "ensaio.mat")


def nan_at(values, i):
    out = np.array(values, dtype=float)
    out[i] = np.nan
    return out


def test_broken_files(tmp_path, variables):
    backwards = variables["Tout"].copy()
    backwards[30] = 0.1
    cases = {
        r"force\[7\] = nan N is not finite \(1 such of 50\); repair": {"forc": nan_at(variables["forc"], 7)},
        r"the variable forc is missing \(there: Tout, Ts, dist, f, x_F\); export": {"forc": None},
        r"forc has 40 samples and dist has 50; export": {"forc": variables["forc"][:40]},
        r"x_F has 49 samples and dist has 50": {"x_F": variables["x_F"][:-1]},
        r"x_F has the shape \(50, 2\); it must be \(50, 3\)": {"x_F": variables["x_F"][:, :2]},
        r"Tout\[30\] = 0.1 s does not come after 0.29 s; time must strictly increase": {"Tout": backwards},
        r"Tout has 10 samples and dist has 50": {"Tout": variables["Tout"][:10]},
        r"Ts = 0.02 s but Tout steps by 0.01 s": {"Ts": 0.02},
        r"Ts = \[-0.01\] s is not a sampling interval; it must be": {"Ts": -0.01, "Tout": None},
        r"Ts = \[0.01, 0.02\] s is not a sampling interval": {"Ts": [0.01, 0.02]},
        r"the variable dist is not real numbers": {"dist": "abc"},
        r"unknown unit 'furlongs/blink'": {},
    }
    for message, changes in cases.items():
        units = {"displacement": "furlongs/blink"} if not changes else {}
        with pytest.raises(FileError, match=r"ensaio\.mat: " + message) as caught:
            read(saved(tmp_path, variables, **changes), units=units)
        assert "\n" not in str(caught.value)


def test_a_truncated_file(tmp_path, variables):
    path = saved(tmp_path, variables)
    path.write_bytes(path.read_bytes()[:700])
    with pytest.raises(FileError, match=r"is not a readable MATLAB v5 file|is missing"):
        read(path)


def saved_7_3(path, variables):
    """As MATLAB's ``save(..., '-v7.3')``: HDF5 behind 512 bytes, dimensions in the opposite order, each with its class."""
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in variables.items():
            text = isinstance(value, str)
            stored = np.array([[ord(c)] for c in value], dtype="u2") if text else np.atleast_2d(np.asarray(value)).T
            file.create_dataset(name, data=stored).attrs["MATLAB_class"] = np.bytes_("char" if text else "double")
    header = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM"
    path.write_bytes(header.ljust(512, b"\0") + path.read_bytes()[512:])
    return path


def test_version_7_3_is_read_as_version_5_is(tmp_path, variables):
    old = read(saved(tmp_path, variables), voltage=1.0)
    new = read(saved_7_3(tmp_path / "new.mat", variables), voltage=1.0)
    for channel in ("time", "displacement", "force", "velocity"):
        assert np.array_equal(getattr(new, channel), getattr(old, channel)), channel
    assert (old.provenance["format"], new.provenance["format"]) == ("MATLAB v5", "MATLAB v7.3")


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_any_matrix_by_its_columns(tmp_path, variables, version):
    matrix = np.column_stack([variables["forc"].ravel() / 1e3, np.zeros(N), variables["dist"].ravel()])
    path, contents = tmp_path / "any.mat", {"run": matrix, "specimen": "no. 7", "note": "x"}
    saved_7_3(path, contents) if version == "7.3" else savemat(path, contents)
    units = {"force": "kN", "displacement": "mm"}
    record = read(path, variable="run", columns={"force": 0, "displacement": "2"}, units=units, dt="10 ms")
    assert record.force == pytest.approx(variables["forc"].ravel())
    assert record.displacement == pytest.approx(1e-3 * variables["dist"].ravel())
    assert np.array_equal(record.time, 0.01 * np.arange(N))
    assert record.specimen == "no. 7"
    for said, words in (
        ({"variable": "rum"}, r"there is no variable 'rum'; choose from note, run, specimen"),
        ({"variable": "note"}, r"the variable note is not real numbers"),
        ({}, r"columns by number \(force = 0\) are those of a matrix; declare which, --variable NAME"),
        ({"variable": "run", "columns": {"force": 3}}, r"columns\['force'\] = 3 is not a column; .* from 0 to 2"),
        ({"variable": "run", "columns": {"force": 0, "displacement": 2}}, r"any\.mat: .*have no unit"),
        (
            {"variable": "run", "columns": {"force": 0}, "units": units},
            r"no column is the displacement \(there: 3 columns",
        ),
        (
            {"variable": "run", "columns": {"force": 0, "displacement": 2}, "units": units, "dt": None},
            r"or give the sampling",
        ),
        ({"header": 1}, r"header = 1 was given, but a MATLAB file has none; leave it out"),
    ):
        with pytest.raises(FileError, match=words):
            read(path, **({"columns": {"force": 0}, "dt": 0.01} | said))


def test_a_matrix_that_lies_on_its_side(tmp_path):
    savemat(tmp_path / "a.mat", {"run": np.zeros((2, 30))})
    with pytest.raises(
        FileError, match=r"run has the shape \(2, 30\); its rows must be the samples, so save its transpose"
    ):
        read(tmp_path / "a.mat", variable="run", columns={"force": 0}, dt=0.01)


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_a_variable_for_each_channel(tmp_path, variables, version):
    path, contents = tmp_path / "each.mat", {"X": variables["dist"], "x": variables["forc"], "clock": variables["Tout"]}
    saved_7_3(path, contents) if version == "7.3" else savemat(path, contents)
    columns = {"time": "clock", "displacement": "X", "force": "x"}
    record = read(path, columns=columns, units={"time": "s", "displacement": "mm", "force": "N"})
    assert np.array_equal(record.force, variables["forc"].ravel())
    assert record.displacement == pytest.approx(1e-3 * variables["dist"].ravel())
    with pytest.raises(
        FileError,
        match=r"dt = 0.02 s was given, but the column 'clock' is the time and steps by 0.01 s on average; correct dt",
    ):
        read(path, columns=columns, units={"time": "s", "displacement": "mm", "force": "N"}, dt=0.02)


def test_a_file_of_version_7_3_that_points_out_of_itself_is_refused(tmp_path, variables):
    import h5py

    path = saved_7_3(tmp_path / "out.mat", {"run": np.zeros((30, 2))})
    with h5py.File(path, "r+") as file:
        file["secret"] = h5py.ExternalLink("/etc/passwd", "/")
    with pytest.raises(
        FileError, match=r"/secret is a link out of the file, and a file is read only where it holds all"
    ):
        read(path, variable="run", columns={"force": 0, "displacement": 1}, dt=0.01)


def test_session_and_specimen_go_through_a_file(tmp_path, variables):
    record = read(saved(tmp_path, variables), voltage=1.0, measurement_session=" day 1 ", specimen="no. 7")
    again = read(write(record, tmp_path / "again.mat"), voltage=1.0)
    assert (again.measurement_session, again.specimen) == ("day 1", "no. 7")


def test_the_real_files_hold_what_the_reader_says(campaign_folder):
    for path in sorted(campaign_folder.glob("*.mat")):
        stored = loadmat(path)
        record = read(path)
        assert np.array_equal(record.force, stored["forc"].ravel()), path.name
        assert record.displacement == pytest.approx(stored["dist"].ravel() * 1e-3, rel=1e-14), path.name
        backward = np.diff(record.displacement) / 0.01
        assert np.max(np.abs(record.velocity[1:] - backward)) < 1e-9, path.name
        assert (record.dt, record.n) in ((pytest.approx(0.01), 1501), (pytest.approx(0.01), 3001)), path.name
