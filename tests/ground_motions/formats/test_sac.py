"""SAC, in files made after the layout of IRIS (words of 4 bytes), and SAC and miniSEED as ObsPy writes them."""

import struct
from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import FileError
from dampyr.ground_motions import available_formats, el_centro, read

VALUES = np.sin(0.1 * np.arange(300)).astype("f4")


def sac(path: Path, order: str = "<", **words: float) -> Path:
    """A file with these words of the header, by their number: f0 is DELTA, i76 NVHDR, i79 NPTS, i85 IFTYPE, i86 IDEP."""
    header = bytearray(struct.pack(f"{order}110f", *[-12345.0] * 110) + b"-12345  " * 24)
    usual = {"f0": 0.01, "f1": VALUES.min(), "f2": VALUES.max(), "i76": 6, "i79": 300, "i85": 1, "i86": 8, "i105": 1}
    for word, value in (usual | words).items():
        struct.pack_into(order + word[0], header, 4 * int(word[1:]), value)
    header[440:448], header[600:608], header[608:616] = b"ABC     ", b"HNE     ", b"XX      "
    path.write_bytes(bytes(header) + VALUES.astype(f"{order}f4").tobytes())
    return path


@pytest.mark.parametrize("order", ["<", ">"])
def test_the_header_gives_the_step_and_a_person_the_unit(tmp_path: Path, order: str) -> None:
    path = sac(tmp_path / "a.sac", order)
    motion = read(path, units="g")
    assert (motion.dt, motion.n, motion.source, motion.history) == (0.01, 300, "SAC, XX.ABC.HNE", ())
    np.testing.assert_allclose(motion.acceleration, 9.80665 * VALUES.astype(float), rtol=1e-12)
    counts = read(path, factors={"acceleration": "2e-3 m/s^2"})
    np.testing.assert_allclose(counts.acceleration, 2e-3 * VALUES.astype(float), rtol=1e-12)
    assert counts.history == ("acceleration is 2e-3 m/s^2 times 'acceleration' in the file, as declared",)


@pytest.mark.parametrize(
    ("words", "match"),
    [
        ({"i76": 3}, "is not a binary SAC file"),
        ({"i79": 301}, "header says NPTS = 301 and 300 samples follow; the file was cut"),
        ({"f2": 1.2}, r"header says DEPMAX = 1\.2 and the samples have"),
        ({"i86": 7}, r"holds a velocity \(IDEP = 7\); give its acceleration"),
        ({"i85": 2}, "is no series of even time steps"),
        ({"i105": 0}, "is no series of even time steps"),
        ({"f0": -1.0}, "DELTA is -1 s; it must be greater than 0"),
    ],
)
def test_a_header_that_contradicts_the_samples_is_refused(tmp_path: Path, words: dict[str, float], match: str) -> None:
    with pytest.raises(FileError, match=match):
        read(sac(tmp_path / "a.sac", **words), units="g")


def test_what_a_person_has_to_say(tmp_path: Path) -> None:
    path = sac(tmp_path / "a.sac")
    with pytest.raises(
        FileError, match=r"names no unit .* --motion-unit m/s\^2 .* --factor acceleration='2\.1e-6 m/s\^2'"
    ):
        read(path)
    with pytest.raises(FileError, match=r"dt = 0\.02 s contradicts its header's DELTA = 0\.01 s; leave dt out"):
        read(path, units="g", dt=0.02)
    with pytest.raises(FileError, match="header = 1 was given, but the samples are no columns"):
        read(path, units="g", header=1)
    assert available_formats()["sac"] == (".sac",)


@pytest.mark.by_hand
def test_files_of_obspy(tmp_path: Path) -> None:
    obspy = pytest.importorskip("obspy", reason="ObsPy, the extra seismology, is not installed")
    motion = el_centro()
    trace = obspy.Trace(motion.acceleration.astype("f4"), {"delta": motion.dt, "station": "ABC", "channel": "HNE"})
    for order in "<>":
        trace.write(str(tmp_path / "a.sac"), format="SAC", byteorder=order)
        back = read(tmp_path / "a.sac", units="m/s^2")
        assert back.dt == motion.dt
        np.testing.assert_allclose(back.acceleration, motion.acceleration, rtol=0, atol=1e-7 * motion.pga)
    trace.data = np.round(1e6 * motion.acceleration).astype("i4")
    trace.write(str(tmp_path / "a.mseed"), format="MSEED")
    back = read(tmp_path / "a.mseed", factors={"acceleration": "1e-6 m/s^2"})
    np.testing.assert_allclose(back.acceleration, motion.acceleration, rtol=0, atol=0.6e-6)
    later = trace.copy()
    later.stats.starttime += 100
    obspy.Stream([trace, later]).write(str(tmp_path / "a.mseed"), format="MSEED")
    with pytest.raises(FileError, match=r"\.ABC\.\.HNE has a gap"):
        read(tmp_path / "a.mseed", units="g")
    later.stats.channel = "HNN"
    obspy.Stream([trace, later]).write(str(tmp_path / "a.mseed"), format="MSEED")
    with pytest.raises(FileError, match=r"holds 2 channels \(.*HNE, .*HNN\); write each into a file"):
        read(tmp_path / "a.mseed", units="g")
