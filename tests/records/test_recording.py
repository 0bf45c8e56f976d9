"""A recording: every acknowledged sample is readable whatever happens to its writer."""

import os
import shutil
import signal
import subprocess
import sys
import textwrap
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.endurance import Endurance

from dampyr.campaigns.record_test import margin, refined
from dampyr.errors import FileError, InputError
from dampyr.records import read
from dampyr.records.files.recording import RawChannel, Recording, RecordingHeader
from dampyr.records.formats import h5
from dampyr.rig import RigSettings

HEADER = RecordingHeader(
    "sine",
    "03-sine",
    2,
    ("time", "displacement", "force"),
    {"force": RawChannel("V", 613.0, -1.5, "N"), "position": RawChannel("count", 5e-6, 0.0, "m", "i8")},
    {"voltage": 0.5},
    provenance={"operator": "A"},
)


def block(first: int, n: int = 40) -> dict[str, np.ndarray]:
    at = np.arange(first, first + n)
    return {
        "calibrated/time": at / 1000.0,
        "calibrated/displacement": 5e-6 * at,
        "calibrated/force": 100.0 * np.cos(at),
        "raw/force": (100.0 * np.cos(at) + 1.5) / 613.0,
        "raw/position": at,
    }


def test_what_was_acknowledged_is_read_while_it_goes_on(tmp_path: Path) -> None:
    recording = Recording(tmp_path / "t.h5", 1000, HEADER)
    for k in range(3):
        assert recording.append(block(40 * k)) == 40 * (k + 1)
    shutil.copy(tmp_path / "t.h5", tmp_path / "copy.h5")  # what a kill would leave
    record = read(tmp_path / "copy.h5")
    assert record.n == 120
    assert record.provenance["complete"] == "no"
    assert record.provenance["operator"] == "A"
    np.testing.assert_array_equal(record.force, 100.0 * np.cos(np.arange(120)))
    np.testing.assert_array_equal(h5.read_raw(tmp_path / "copy.h5")["position"].values, np.arange(120))
    assert h5.state(tmp_path / "copy.h5") == h5.FileState(False, "03-sine", 2)
    recording.close()


def test_the_finished_file_is_as_long_as_it_became(tmp_path: Path) -> None:
    recording = Recording(tmp_path / "t.h5", 1000000, HEADER)
    recording.append(block(0))
    recording.finish({"exit_status": "complete", "reason": ""})
    record = read(tmp_path / "t.h5")
    assert record.n == 40
    assert record.voltage == 0.5
    assert record.provenance["exit_status"] == "complete"
    assert "complete" not in record.provenance
    assert h5.state(tmp_path / "t.h5").complete
    assert (tmp_path / "t.h5").stat().st_size < 40000
    assert [path.name for path in tmp_path.iterdir()] == ["t.h5"]


def test_a_long_record_is_finished_piece_by_piece_like_a_short_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its end included, which the pieces share with no other; ``refine`` sees beyond the ends of its piece."""
    settings, seen = RigSettings(), []

    def refine(values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        seen.append(len(values["time"]))
        return refined(values, settings)

    for name in ("whole", "pieces"):
        if name == "pieces":
            monkeypatch.setattr("dampyr.records.files.recording.PIECE", 256)
            monkeypatch.setattr("dampyr.records.formats.h5.PIECE", 100)
        delayed = {"position": replace(HEADER.raw["position"], delay=settings.force_delay)}
        recording = Recording(tmp_path / f"{name}.h5", 3000, replace(HEADER, raw=dict(HEADER.raw) | delayed))
        for k in range(50):
            recording.append(block(40 * k))
        recording.finish({"exit_status": "complete"}, ("derived",), refine=refine, margin=margin(settings))
    whole, pieces = (read(tmp_path / f"{name}.h5") for name in ("whole", "pieces"))
    assert seen[0] == whole.n == pieces.n == 2000
    assert len(seen) == 8
    assert max(seen[1:]) < 500
    for channel in ("time", "force"):
        np.testing.assert_array_equal(getattr(pieces, channel), getattr(whole, channel))
    for channel in ("displacement", "velocity"):
        np.testing.assert_allclose(getattr(pieces, channel), getattr(whole, channel), rtol=1e-9, atol=1e-12)
    assert (pieces.voltage, pieces.history, pieces.provenance) == (0.5, whole.history, whole.provenance)
    np.testing.assert_array_equal(h5.read_raw(tmp_path / "pieces.h5")["position"].values, np.arange(2000))


def test_a_clock_that_goes_back_between_pieces_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dampyr.records.files.recording.PIECE", 40)
    recording = Recording(tmp_path / "t.h5", 100, HEADER)
    for _ in range(2):
        recording.append(block(0))
    with pytest.raises(InputError, match=r"sine: time 0 s follows 0\.039 s; it must rise"):
        recording.finish({})
    assert [path.name for path in tmp_path.iterdir()] == ["t.h5"]


def test_an_aborted_test_is_kept_and_not_called_complete(tmp_path: Path) -> None:
    recording = Recording(tmp_path / "t.h5", 1000, HEADER)
    recording.append(block(0))
    recording.finish({"exit_status": "failed", "reason": "force 4600 N passed its limit"}, complete=False)
    assert not h5.state(tmp_path / "t.h5").complete
    assert read(tmp_path / "t.h5").provenance["reason"] == "force 4600 N passed its limit"


def test_more_samples_than_planned_are_refused(tmp_path: Path) -> None:
    recording = Recording(tmp_path / "t.h5", 50, HEADER)
    recording.append(block(0))
    with pytest.raises(FileError, match="room for 50 samples, and 80 came"):
        recording.append(block(40))
    recording.close()
    assert read(tmp_path / "t.h5").n == 40


def full(*_: object) -> None:
    raise OSError(28, "No space left on device")


def test_a_full_disk_is_told_before_the_first_sample(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(FileError, match=r"the disk is full: \d+ bytes are needed, .* and \d+ are free; make room"):
        Recording(tmp_path / "t.h5", 1000, HEADER)
    assert not list(tmp_path.iterdir())


def test_a_file_that_is_there_is_never_written_over(tmp_path: Path) -> None:
    (tmp_path / "t.h5").write_bytes(b"a measurement")
    with pytest.raises(FileError, match="is there already, and nothing is written over it"):
        Recording(tmp_path / "t.h5", 1000, HEADER)
    assert (tmp_path / "t.h5").read_bytes() == b"a measurement"
    assert [path.name for path in tmp_path.iterdir()] == ["t.h5"]


def test_the_room_of_the_finished_file_is_reserved_before_the_first_sample(tmp_path: Path) -> None:
    header = replace(HEADER, derived=("velocity",))
    before = shutil.disk_usage(tmp_path).free
    recording = Recording(tmp_path / "t.h5", 2_000_000, header)
    assert before - shutil.disk_usage(tmp_path).free > 0.9 * 2_000_000 * (5 + 6) * 8
    recording.append(block(0))
    recording.finish({}, refine=lambda values: values | {"velocity": values["force"]})
    assert (tmp_path / "t.h5").stat().st_size < header.file_sizes(40)[1]


def test_a_copy_that_is_refused_leaves_the_samples_where_they_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = Recording(tmp_path / "t.h5", 100_000, HEADER)
    for k in range(2000):
        recording.append(block(40 * k))
    monkeypatch.setattr("dampyr.records.files.new_file.reserve", full)
    with pytest.raises(FileError, match="cannot be finished: the disk is full; make room"):
        recording.finish({})
    assert read(tmp_path / "t.h5").n == 80_000
    assert [path.name for path in tmp_path.iterdir()] == ["t.h5"]


WRITER = textwrap.dedent("""
    import sys
    import numpy as np
    from tests.records.test_recording import HEADER, block
    from dampyr.records.files.recording import Recording
    recording, k = Recording(sys.argv[1], 400_000, HEADER), 0
    while True:
        rows = recording.append(block(40 * k))
        k += 1
        sys.stdout.write(f"{rows}\\n")
        sys.stdout.flush()
""")


def killed(folder: Path, after: float) -> tuple[int, Path]:
    """The last row that a writer acknowledged before it was killed, and its file."""
    path, root = folder / "t.h5", Path(__file__).parents[2]
    with subprocess.Popen(
        [sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, cwd=root, text=True
    ) as writer:
        assert writer.stdout is not None
        first = writer.stdout.readline()
        try:
            writer.wait(after)
        except subprocess.TimeoutExpired:
            os.kill(writer.pid, signal.SIGKILL)
        printed = [line for line in writer.stdout.read().split("\n")[:-1] if line]
    return int(printed[-1] if printed else first), path


def check(acknowledged: int, path: Path) -> None:
    record = read(path)
    assert record.n >= acknowledged
    np.testing.assert_array_equal(record.force, 100.0 * np.cos(np.arange(record.n)))


@pytest.mark.parametrize("after", [pytest.param(0.05, marks=pytest.mark.prove), 0.2])
def test_a_killed_writer_leaves_every_acknowledged_sample(tmp_path: Path, after: float) -> None:
    check(*killed(tmp_path, after))


@pytest.mark.prove
@pytest.mark.endure
def test_kills_inside_flushes_too(tmp_path: Path, endurance: Endurance) -> None:
    """The writer does nothing but write and flush, so that nearly every kill falls inside of it."""
    seed, rows = 20201124, 0
    moments = np.random.default_rng(seed).uniform(0.0, 0.15, endurance.count(400))
    for k, after in enumerate(moments):
        folder = tmp_path / str(k)
        folder.mkdir()
        acknowledged, path = killed(folder, float(after))
        check(acknowledged, path)
        rows += acknowledged
        shutil.rmtree(folder)
    endurance.report(
        "the writer of a record is killed while it does nothing but write",
        seed,
        f"{len(moments)} kills; of {rows} acknowledged samples none is lost",
    )
