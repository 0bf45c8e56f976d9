"""The campaign's MATLAB files: which variables are read, and what a broken file says."""

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from dampyr.errors import FileError
from dampyr.records import read

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
        r"Ts = \[-0.01\] s is no sampling interval; it must be": {"Ts": -0.01, "Tout": None},
        r"Ts = \[0.01, 0.02\] s is no sampling interval": {"Ts": [0.01, 0.02]},
        r"the variable dist is not real numbers": {"dist": "abc"},
        r"unknown unit 'furlongs/blink'": {},
    }
    for message, changes in cases.items():
        units = {"displacement": "furlongs/blink"} if not changes else None
        with pytest.raises(FileError, match=r"ensaio\.mat: " + message) as caught:
            read(saved(tmp_path, variables, **changes), units=units)
        assert "\n" not in str(caught.value)


def test_a_truncated_file(tmp_path, variables):
    path = saved(tmp_path, variables)
    path.write_bytes(path.read_bytes()[:700])
    with pytest.raises(FileError, match=r"is no readable MATLAB v5 file|is missing"):
        read(path)


def test_matlab_7_3_says_how_to_save_again(tmp_path):
    import h5py

    path = tmp_path / "new.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["Ts"] = 0.01
    header = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM"
    path.write_bytes(header.ljust(512, b"\0") + path.read_bytes()[512:])
    with pytest.raises(FileError, match=r"is a MATLAB v7.3 file; save it again with save\(..., '-v7'\)"):
        read(path)


def test_the_real_files_hold_what_the_reader_says(campaign_folder):
    for path in sorted(campaign_folder.glob("*.mat")):
        stored = loadmat(path)
        record = read(path)
        assert np.array_equal(record.force, stored["forc"].ravel()), path.name
        assert record.displacement == pytest.approx(stored["dist"].ravel() * 1e-3, rel=1e-14), path.name
        backward = np.diff(record.displacement) / 0.01
        assert np.max(np.abs(record.velocity[1:] - backward)) < 1e-9, path.name
        assert (record.dt, record.n) in ((pytest.approx(0.01), 1501), (pytest.approx(0.01), 3001)), path.name
