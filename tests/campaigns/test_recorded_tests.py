"""What has become of the files of a campaign's tests: gone, broken, short or of another try, told and recorded again."""

import sqlite3
from contextlib import closing
from pathlib import Path

import h5py
import numpy as np
import pytest
from tests.campaigns.quick_rig import FIRST, SECOND, quick_rig

from dampyr import records
from dampyr.campaigns import perform, read_journal
from dampyr.campaigns.journal import Journal
from dampyr.campaigns.run_folders import run_folder
from dampyr.errors import DampyrWarning, FileError, InputError
from dampyr.records.formats import h5


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*.h5*")}


def set_running(out: Path, name: str) -> None:
    """As a killed host leaves the journal."""
    with closing(sqlite3.connect(out / "journal.sqlite")) as base:
        base.execute("UPDATE tests SET state = 'running' WHERE name = ?", (name,))
        base.commit()


@pytest.mark.parametrize("how", ["gone", "broken"])
def test_a_complete_file_that_cannot_be_read_is_told_and_recorded_again_when_asked(lab: Path, how: str) -> None:
    out, path = lab / "out", lab / "out" / f"{FIRST}.h5"
    if how == "gone":
        path.unlink()
    else:
        path.write_bytes(path.read_bytes()[:3000])
    words = rf"cannot be read: {FIRST} \({how}\); run the same command with --again {FIRST} to record them again"
    opened = quick_rig()
    with pytest.raises(FileError, match=f"out: 1 of 2 tests are complete: files of complete tests {words}"):
        perform(lab / "short.toml", opened, out)
    assert opened.board.simulator.time == 0.0
    about = run_folder(out)
    assert (about.state, about.complete, about.tests) == ("interrupted", 1, 2)
    assert f"{FIRST} ({how})" in about.reason
    perform(lab / "short.toml", quick_rig(), out, again=[FIRST])
    assert {record.name for record in records.read_campaign(out)} == {FIRST, SECOND}
    assert h5.state(out / f"{FIRST}.try2.h5").complete
    assert (out / f"{FIRST}.h5.broken").is_file() == (how == "broken")
    assert [event.what for event in read_journal(out)[1]].count("again") == 1
    perform(lab / "short.toml", quick_rig(), out)  # nothing is missed any more
    assert run_folder(out).complete == 2


def test_what_is_left_is_run_before_a_lost_file_is_an_error(lab: Path) -> None:
    (lab / "out" / f"{FIRST}.h5").unlink()
    with closing(Journal(lab / "out")) as journal:
        journal.repeat(SECOND)
    with (
        pytest.warns(DampyrWarning, match=rf"{FIRST} \(gone\)"),
        pytest.raises(FileError, match=rf"1 of 2 tests are complete.*{FIRST} \(gone\)"),
    ):
        perform(lab / "short.toml", quick_rig(), lab / "out")
    assert h5.state(lab / "out" / f"{SECOND}.try2.h5").complete


def test_a_file_with_a_damaged_dataset_is_recorded_again_when_asked(lab: Path) -> None:
    with h5py.File(lab / "out" / f"{FIRST}.h5", "r+") as file:
        file["calibrated/force"][100] += 1.0
    with pytest.raises(FileError, match=r"/calibrated/force is not what was written.*dampyr run has --again for it"):
        records.read_campaign(lab / "out")
    perform(lab / "short.toml", quick_rig(), lab / "out", again=[FIRST])
    assert len(records.read_campaign(lab / "out", incomplete=True)) == 2
    assert (lab / "out" / f"{FIRST}.h5.broken").is_file()


def test_a_whole_file_is_recorded_again_beside_itself(lab: Path) -> None:
    before = contents(lab / "out")
    perform(lab / "short.toml", quick_rig(), lab / "out", again=[SECOND])
    after = contents(lab / "out")
    assert {name: after[name] for name in before} == before
    assert set(after) - set(before) == {f"{SECOND}.try2.h5"}
    with pytest.raises(
        InputError, match=f"again = 'third' is not a test of this campaign; its tests are {FIRST}, {SECOND}"
    ):
        perform(lab / "short.toml", quick_rig(), lab / "out", again=["third"])


def test_a_truncated_file_of_an_interrupted_test_does_not_stop_the_campaign(lab: Path) -> None:
    path = lab / "out" / f"{SECOND}.h5"
    path.write_bytes(path.read_bytes()[:2000])
    set_running(lab / "out", SECOND)
    perform(lab / "short.toml", quick_rig(), lab / "out")
    assert (lab / "out" / f"{SECOND}.h5.broken").read_bytes() == path.with_name(f"{SECOND}.h5.broken").read_bytes()
    assert len(records.read_campaign(lab / "out", incomplete=True)) == 2
    assert any("its file cannot be read" in event.detail for event in read_journal(lab / "out")[1])


def test_a_lost_journal_and_a_broken_file_have_a_way_out(lab: Path) -> None:
    out = lab / "out"
    (out / "journal.sqlite").unlink()
    (out / f"{FIRST}.h5").write_bytes(b"")
    with pytest.raises(FileError, match=f"record it again with --again {FIRST}, or give another --out"):
        perform(lab / "short.toml", quick_rig(), out)
    with pytest.warns(DampyrWarning, match="from the files of 1 of its 2 tests: 1 complete"):
        perform(lab / "short.toml", quick_rig(), out, again=[FIRST])
    assert len(records.read_campaign(out)) == 2
    assert h5.state(out / f"{FIRST}.try2.h5").complete


def test_parts_of_copies_go_away_whatever_the_journal_says(lab: Path) -> None:
    out = lab / "out"
    for name in (f".{FIRST}.h5.abcd_123.part", f".{SECOND}.try3.h5.abcd1234.part", ".other.h5.abcd1234.part"):
        (out / name).write_bytes(b"half")
    (out / "journal.sqlite").unlink()
    with pytest.warns(DampyrWarning, match="made anew"):
        perform(lab / "short.toml", quick_rig(), out)
    assert [path.name for path in out.glob(".*")] == [".other.h5.abcd1234.part"]


def shortened(path: Path, rows: int) -> None:
    """As a host leaves it that is killed after so many samples."""
    with h5py.File(path, "r+") as file:
        file.attrs["complete"] = np.uint8(0)
        file["rows"] = np.uint64(rows)
        del file.attrs["sha256"]


@pytest.mark.parametrize("rows", [0, 1, 7])
def test_a_try_with_few_samples_does_not_break_its_folder(lab: Path, rows: int) -> None:
    shortened(lab / "out" / f"{SECOND}.h5", rows)
    set_running(lab / "out", SECOND)
    words = rf"left out, too few samples for a record: {SECOND}.h5 \({rows}\)"
    with pytest.warns(DampyrWarning, match=words):
        assert len(records.read_campaign(lab / "out", incomplete=True)) == 1
    perform(lab / "short.toml", quick_rig(), lab / "out")
    assert len(records.read_campaign(lab / "out")) == 2
    with pytest.warns(DampyrWarning, match=words):
        assert len(records.read_campaign(lab / "out", incomplete=True)) == 2
